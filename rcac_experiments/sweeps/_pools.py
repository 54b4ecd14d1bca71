"""The default executor: processes that end with their parent process.

A thread sends each worker one task at a time. If a worker dies or exceeds its time limit, only its
task is lost, and the worker is replaced.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from multiprocessing import connection
from pathlib import Path
from typing import Any, TypeVar

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.sweeps._chunk import (
    TIMED_OUT,
    WORKER_DIED,
    TimeLimitReached,
    error_text,
)

T = TypeVar("T")
# How often a worker is started that a signal ends before it is ready, and seconds between two
# words of a worker on its progress.
STARTS, PAUSE = 5, 0.05
_CONTEXT = multiprocessing.get_context("spawn")


class WorkerLost(Exception):
    """A task has lost its worker; `outcome` is the reason."""

    def __init__(self, outcome: str, words: str) -> None:
        super().__init__(words)
        self.outcome = outcome


class WorkerPool(Executor):
    """A pool of new processes, which end with their parent.

    A submitted function receives the keyword `progress`, a function to call after each run.
    """

    def __init__(self, workers: int, time_limit: float | None = None) -> None:
        self.time_limit = time_limit
        self._jobs: queue.SimpleQueue[tuple[Future[Any], Any, Any] | None] = queue.SimpleQueue()
        self._reader, self._alive = _CONTEXT.Pipe(duplex=False)
        self._lock, self._is_closed, self._broken = threading.Lock(), False, ""
        self._workers: set[_Worker] = set()
        self._keepers = [threading.Thread(target=self._keep, daemon=True) for _ in range(workers)]
        for keeper in self._keepers:
            keeper.start()

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Submit a task; its future raises `WorkerLost` if its worker is lost."""
        if self._broken or self._is_closed:
            raise BrokenExecutor(self._broken)
        future: Future[T] = Future()
        self._jobs.put((future, fn, args))
        return future

    def leave(self) -> None:
        """Kill the workers."""
        with self._lock:
            self._is_closed = True
            for worker in self._workers:
                worker.process.kill()
        self.shutdown(wait=False)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the workers; with `wait` after their submitted tasks."""
        for _ in self._keepers:
            self._jobs.put(None)
        if wait:
            for keeper in self._keepers:
                keeper.join()
        self._alive.close()

    def _keep(self) -> None:
        """Run one worker and its successors, in a separate thread."""
        worker: _Worker | None = None
        while (job := self._jobs.get()) is not None:
            future, fn, args = job
            if self._is_closed or not future.set_running_or_notify_cancel():
                continue
            try:
                worker = worker or self._started()
                future.set_result(worker.call(fn, args, self.time_limit))
            except WorkerLost as lost:
                if worker is not None:
                    self._forget(worker)
                    worker = None
                future.set_exception(lost)
            except BaseException as error:
                future.set_exception(error)
        if worker is not None:
            worker.end()
            self._forget(worker)

    def _started(self) -> _Worker:
        """Start a worker; start another one if a signal ends it before it is ready."""
        for _ in range(STARTS):
            with self._lock:
                if self._is_closed or self._broken:
                    break
                worker = _Worker(self._reader)
                self._workers.add(worker)
            code = worker.wait_until_ready()
            if code is None:
                return worker
            self._forget(worker)
            if code >= 0:  # it ended by itself, and every other one will
                self._broken = f"they end with status {code} before they are ready.{_guard()}"
                break
            why = f"signal {-code}"
            with contextlib.suppress(ValueError):
                why = signal.Signals(-code).name
        else:
            self._broken = f"{STARTS} in a row were ended by {why} before they were ready."
        raise BrokenExecutor(self._broken)

    def _forget(self, worker: _Worker) -> None:
        worker.process.kill()
        worker.process.join()
        worker.pipe.close()
        with self._lock:
            self._workers.discard(worker)


class _Worker:
    """A process and the parent's end of its pipe."""

    def __init__(self, alive: connection.Connection) -> None:
        self.pipe, other = _CONTEXT.Pipe()
        self.process = _CONTEXT.Process(target=_serve, args=(other, alive))
        self.process.start()
        other.close()

    def wait_until_ready(self) -> int | None:
        """Return None when the process is ready, or its exit status."""
        try:
            self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            return self.process.exitcode or 0
        return None

    def call(self, fn: Callable[..., Any], args: tuple[Any, ...], time_limit: float | None) -> Any:
        """Return the result of the function in the process; raise its error, or `WorkerLost`."""
        begun = False
        try:
            self.pipe.send((fn, args))
            while True:
                if begun and time_limit is not None and not self.pipe.poll(time_limit):
                    raise WorkerLost(TIMED_OUT, f"it took longer than {time_limit:g} s")
                kind, value = self.pipe.recv()
                if kind == "done":
                    return value
                if kind == "raised":
                    raise value
                begun = True
        except (EOFError, OSError):
            self.process.join()
            code = self.process.exitcode or 0
            ended = f"signal {-code}" if code < 0 else f"status {code}"
            raise WorkerLost(WORKER_DIED, f"the process that ran it ended with {ended}") from None

    def end(self) -> None:
        """End the process after its task."""
        with contextlib.suppress(OSError):
            self.pipe.send(None)
            self.process.join(5)


class InProcess(Executor):
    """An executor that calls each function at once, in this process and thread."""

    def __init__(self, time_limit: float | None = None) -> None:
        if time_limit is not None and not (
            hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
        ):
            raise InputError(
                "time_limit with workers=0 needs the main thread of a POSIX system, which SIGALRM "
                "interrupts: use workers=1, whose process can be ended."
            )
        self.time_limit = time_limit

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Call the function; Ctrl-C interrupts it."""
        future: Future[T] = Future()
        future.set_running_or_notify_cancel()
        try:
            with self._clock() as progress:
                future.set_result(fn(*args, progress=progress))
        except Exception as error:
            future.set_exception(error)
        return future

    @contextlib.contextmanager
    def _clock(self) -> Iterator[Callable[[], None]]:
        limit = self.time_limit

        def progress() -> None:
            if limit is not None:
                signal.setitimer(signal.ITIMER_REAL, limit)

        def too_long(number: int, frame: Any) -> None:
            raise TimeLimitReached(f"it took longer than {limit:g} s")

        if limit is None:
            yield progress
            return
        before = signal.signal(signal.SIGALRM, too_long)
        try:
            yield progress
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)


def _guard() -> str:
    """Return advice for a script without the guard that workers need."""
    try:
        file = getattr(sys.modules.get("__main__"), "__file__", None)
        guarded = file is None or "__name__" in Path(file).read_text(errors="replace")
    except OSError:
        guarded = True
    if guarded:
        return ""
    return (
        ' A script must start workers under `if __name__ == "__main__":`, since each worker '
        "imports "
        "the script."
    )


def _serve(pipe: connection.Connection, alive: connection.Connection) -> None:
    """Run a worker: ignore Ctrl-C, end with the parent, and execute the tasks of the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # NumPy is not read yet: workers share the processors
    threading.Thread(target=_end_with_parent, args=(alive,), daemon=True).start()
    pipe.send("ready")
    reported = 0.0

    def progress() -> None:
        nonlocal reported
        if time.monotonic() - reported > PAUSE:
            pipe.send(("progress", None))
            reported = time.monotonic()

    while (job := pipe.recv()) is not None:
        fn, args = job
        reported = 0.0
        try:
            answer = ("done", fn(*args, progress=progress))
        except CompensatorError as error:
            answer = ("raised", error)
        except BaseException as error:
            answer = ("raised", RuntimeError(error_text(error)))
        pipe.send(answer)


def _end_with_parent(reader: connection.Connection) -> None:
    parent = multiprocessing.parent_process()
    sentinels: list[Any] = [reader] if parent is None else [reader, parent.sentinel]
    with contextlib.suppress(OSError):
        connection.wait(sentinels)  # nothing is ever sent: it ends when the other side does
    os._exit(1)
