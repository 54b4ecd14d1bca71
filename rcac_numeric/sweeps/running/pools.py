"""The default executor: processes that end when who started them ends, however that happens."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from multiprocessing import connection
from typing import Any, TypeVar

from compensator_theory.errors import InputError

T = TypeVar("T")


class WorkerPool(ProcessPoolExecutor):
    """A pool of fresh processes, none of which outlives its parent.

    Parameters
    ----------
    workers : int
    """

    def __init__(self, workers: int) -> None:
        context = multiprocessing.get_context("spawn")
        reader, self._alive = context.Pipe(duplex=False)
        super().__init__(workers, mp_context=context, initializer=_start_worker, initargs=(reader,))

    def leave(self) -> None:
        """End the workers now, whatever they are doing."""
        self._alive.close()
        self.shutdown(wait=False, cancel_futures=True)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let the workers end; with `wait` when they have done what they were given."""
        super().shutdown(wait=wait, cancel_futures=cancel_futures)
        if wait:
            self._alive.close()


def ready(executor: Executor) -> None:
    """Wait until workers of our own were seen to start; of other executors nothing is asked.

    Raises
    ------
    InputError
        Where they end before they have begun.
    """
    if isinstance(executor, WorkerPool):
        try:
            executor.submit(os.getpid).result()
        except BrokenExecutor:
            executor.leave()
            raise InputError(
                "worker processes cannot be started. A script that starts some must do so under "
                '`if __name__ == "__main__":`, since each of them reads it again; workers=0 does '
                "all in one process."
            ) from None


class InProcess(Executor):
    """An executor that does everything here and now: one process, one thread."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Call it; Ctrl-C leaves at once."""
        future: Future[T] = Future()
        future.set_running_or_notify_cancel()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def _start_worker(reader: connection.Connection) -> None:
    """What a worker does first: it leaves Ctrl-C to its parent, and watches for its end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # NumPy is not read yet: workers share the processors
    threading.Thread(target=_end_with_parent, args=(reader,), daemon=True).start()


def _end_with_parent(reader: connection.Connection) -> None:
    parent = multiprocessing.parent_process()
    sentinels: list[Any] = [reader] if parent is None else [reader, parent.sentinel]
    with contextlib.suppress(OSError):
        connection.wait(sentinels)  # nothing is ever sent: it ends when the other side does
    os._exit(1)
