"""One BLAS thread for many small matrices: several threads would wait for each other."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any

_is_limited = Lock()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit BLAS to one thread.

    The number is one of the process: the outermost or first of several uses sets it and, when it
    ends, sets it back, in the same thread, since OpenBLAS ignores a larger number from another.
    """
    controller = _controller()
    if controller is None or not _is_limited.acquire(blocking=False):
        yield
        return
    try:
        with controller.limit(limits=1, user_api="blas"):
            yield
    finally:
        _is_limited.release()


@cache
def _controller() -> Any:
    """The libraries of BLAS in this process; None where there are no threads."""
    if sys.platform == "emscripten":
        return None
    from threadpoolctl import ThreadpoolController  # SciPy's libraries are loaded by now

    return ThreadpoolController()
