"""Processes that make cases, and end with the one that started them."""

from __future__ import annotations

import multiprocessing as mp
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

INTERRUPTED = 130
PATIENCE = 0.2  # seconds between two looks at whether we are still wanted


@contextmanager
def case_workers(count: int) -> Iterator[Executor | None]:
    """An executor with so many processes; None for one, which is this process itself.

    Whatever ends the block ends the processes with what they are at, and so does the death of
    this process.
    """
    if count <= 1:
        yield None
        return
    context = mp.get_context("spawn")
    stop = context.Event()
    executor = ProcessPoolExecutor(count, mp_context=context, initializer=_watch, initargs=(stop,))
    try:
        yield executor
    finally:
        stop.set()
        executor.shutdown(wait=True, cancel_futures=True)


def _watch(stop: Any) -> None:
    """Leave Ctrl-C to the parent, and end when it is done or gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = mp.parent_process()

    def look() -> None:
        while not stop.wait(PATIENCE):
            if parent is not None and not parent.is_alive():
                break
        os._exit(INTERRUPTED)

    threading.Thread(target=look, daemon=True).start()
