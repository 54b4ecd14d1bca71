"""One thread of BLAS for many small matrices: more of them wait for each other."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any

_lock, _users = Lock(), [0]
_limiter: list[Any] = []


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit BLAS to one thread; the number of threads returns with the last of those inside.

    The number is one of the process, so that nested and concurrent uses are counted.
    """
    controller = _controller()
    with _lock:
        _users[0] += 1
        if _users[0] == 1 and controller is not None:
            _limiter.append(controller.limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _lock:
            _users[0] -= 1
            if not _users[0] and _limiter:
                _limiter.pop().restore_original_limits()


@cache
def _controller() -> Any:
    """The libraries of BLAS in this process; None where there are no threads."""
    if sys.platform == "emscripten":
        return None
    from threadpoolctl import ThreadpoolController  # SciPy's libraries are loaded by now

    return ThreadpoolController()
