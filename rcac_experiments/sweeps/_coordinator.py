"""Submit chunks to an executor, a window at a time, and store their results."""

from __future__ import annotations

import os
import time
from collections import Counter, deque
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass, field
from secrets import SystemRandom

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.sweeps._chunk import (
    TIMED_OUT,
    WORKER_DIED,
    ChunkResult,
    ChunkTask,
    RunRecord,
    failure,
)
from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._pools import InProcess, WorkerLost, WorkerPool
from rcac_experiments.sweeps._problems import StoreError
from rcac_experiments.sweeps._progress import Meter, Progress
from rcac_experiments.sweeps._worker import run_chunk

ALONE = 2  # losses of a single run, after which it counts as failed
# Seconds between checks for Ctrl-C, and seconds until an external executor must answer after a
# loss.
PATIENCE, ANSWER = 0.25, 60.0


class Pool:
    """The executor of a study: the default pool, one of the user, or one from a function."""

    def __init__(
        self, executor: Executor | Callable[[], Executor] | None, workers: int,
        time_limit: float | None = None,
    ) -> None:  # fmt: skip
        if executor is not None and not isinstance(executor, Executor) and not callable(executor):
            raise InputError(f"executor = {executor!r} is no concurrent.futures.Executor.")
        self._source, self._workers, self._limit = executor, workers, time_limit
        # In the default pools each task has a separate worker.
        self.is_ours = executor is None or isinstance(executor, WorkerPool | InProcess)
        self.renewable = executor is not None and not isinstance(executor, Executor)
        self._executor: Executor | None = None

    @property
    def executor(self) -> Executor:
        """The executor, created for the first run."""
        if self._executor is None:
            if isinstance(self._source, Executor):
                self._executor = self._source
            elif self._source is not None:
                self._executor = self._source()
            elif self._workers:
                self._executor = WorkerPool(self._workers, self._limit)
            else:
                self._executor = InProcess(self._limit)
        return self._executor

    def renew(self) -> None:
        """Discard a broken executor; the next one is created on demand."""
        self.leave()
        self._executor = None

    def end(self) -> None:
        """Shut down the executor, unless it is the user's."""
        if self._executor is not None and self._executor is not self._source:
            self._executor.shutdown()

    def leave(self) -> None:
        """Stop the executor at once."""
        executor = self._executor
        if executor is None or executor is self._source:
            return
        if isinstance(executor, WorkerPool):
            executor.leave()
            return
        try:
            executor.shutdown(wait=False, cancel_futures=True)
        except TypeError:  # loky has no cancel_futures
            executor.shutdown(wait=False)


class _Gone(Exception):
    """The executor accepts no more tasks; the text is the type of its error."""


@dataclass(eq=False)
class Work:
    """A chunk in progress, with its results so far."""

    number: int
    missing: set[int]
    records: list[RunRecord] = field(default_factory=list)
    # Losses and failures of single runs.
    alone: Counter[int] = field(default_factory=Counter)
    failed: Counter[int] = field(default_factory=Counter)


@dataclass(frozen=True)
class ChunkPart:
    """Some runs of a chunk; with `by_itself` no other task runs at the same time."""

    work: Work
    task: ChunkTask
    by_itself: bool = False

    def only(self, numbers: Collection[int]) -> ChunkPart:
        """Return the part with some of its runs."""
        return ChunkPart(self.work, self.task.only(numbers), self.by_itself)


class Coordinator:
    """Submit the missing chunks of a folder, and store their results.

    The order is random, so that two coordinators of one folder rarely compute the same chunk; both
    skip chunks that the other has stored.
    """

    def __init__(
        self,
        folder: Folder,
        pool: Pool,
        task_of: Callable[[int], ChunkTask],
        window: int,
        retries: int,
        meter: Meter,
        progress: Callable[[Progress], None],
    ) -> None:
        self.folder, self.pool, self.task_of = folder, pool, task_of
        self.window, self.retries = window, retries
        self.meter, self.progress = meter, progress
        self.in_flight: dict[Future[ChunkResult], tuple[ChunkPart, Executor]] = {}
        self.waiting: deque[ChunkPart] = deque()  # parts to submit again
        self.todo: list[int] = []
        self._absent: set[int] = set()
        self._suspects: list[Work] = []  # chunks with a loss in an external executor
        self._ended = time.monotonic()  # time of the last completed task

    def run(self, absent: Iterable[int], again: Iterable[int] = ()) -> None:
        """Compute and store these chunks: the missing ones, and those to be replaced."""
        self._absent = set(absent)
        self.todo = [*self._absent, *again]
        SystemRandom().shuffle(self.todo)
        try:
            self._work()
        except _Gone as gone:
            raise self._store_error(str(gone)) from None

    def leave(self) -> None:
        """Let go of the executor at once."""
        for future in self.in_flight:
            future.cancel()
        self.pool.leave()

    def _work(self) -> None:
        while True:
            self._fill()
            if not self.in_flight:
                return
            done, _ = wait(self.in_flight, timeout=PATIENCE, return_when=FIRST_COMPLETED)
            for future in done:
                self._end(future)
            self._require_alive(bool(done))
            self.progress(self.meter.now())

    def _fill(self) -> None:
        """Submit chunks up to the window."""
        while len(self.in_flight) < self.window:
            if any(part.by_itself for part, _ in self.in_flight.values()):
                return
            if self.waiting:
                if self.waiting[0].by_itself:
                    if self.in_flight:
                        return
                    self._require_answer()  # dask gives up workers that are lost while they start
                part = self.waiting.popleft()
            elif (number := self._next()) is not None:
                task = self.task_of(number)
                part = ChunkPart(Work(number, set(task.numbers)), task)
            else:
                return
            self._submit(part)
            if isinstance(self.pool.executor, InProcess):
                return

    def _next(self) -> int | None:
        """Return a chunk that is not stored, or None."""
        while self.todo:
            number = self.todo.pop()
            stored = self.folder.read([number], guarded=False) if number in self._absent else ()
            for chunk in stored:
                if not chunk.fault:  # stored by another coordinator
                    self._count(list(chunk.columns["outcome"]), chunk.failed)
                    break
            else:
                return number
        return None

    def _submit(self, part: ChunkPart) -> None:
        for last in (not self.pool.renewable, True):
            executor = self.pool.executor
            try:
                self.in_flight[executor.submit(run_chunk, part.task)] = part, executor
                return
            except Exception as error:
                if last:
                    raise self._broken(error) from None
                self.pool.renew()

    def _end(self, future: Future[ChunkResult]) -> None:
        part, executor = self.in_flight.pop(future)
        try:
            result = future.result()
        except BrokenExecutor as error:
            if not self.pool.renewable:
                parts = [part, *(one for one, _ in self.in_flight.values())]
                self._suspects += [one.work for one in parts]
                raise self._broken(error) from None
            if executor is self.pool.executor:
                self.pool.renew()
            self._lose(part, WORKER_DIED, f"its worker was lost ({type(error).__name__})")
        except CompensatorError:  # this worker, and so every worker, cannot run the study
            raise
        except WorkerLost as lost:
            self._lose(part, lost.outcome, str(lost))
        except Exception as error:  # what an executor of others says of a worker that was lost
            self._lose(part, WORKER_DIED, f"its worker was lost ({type(error).__name__})")
        else:
            self._keep(part, result.records)

    def _lose(self, part: ChunkPart, outcome: str, words: str) -> None:
        """Repeat a lost part in pieces; a single run finally counts as failed.

        A worker of the default pool runs one task, so its runs are repeated one by one. An external
        worker may run other tasks: the part is repeated by itself, and is then halved.
        """
        work, numbers, shared = part.work, part.task.numbers, not self.pool.is_ours
        if shared:
            self._suspects.append(work)
        if len(numbers) == 1 and (part.by_itself or not shared):
            (number,) = numbers
            work.alone[number] += 1
            if outcome == TIMED_OUT or work.alone[number] >= ALONE:
                if shared:
                    self._require_answer()
                self._keep(part, [failure(number, outcome, words)])
                return
        size = len(numbers)
        if not shared:
            size = 1
        elif part.by_itself:
            size = (size + 1) // 2
        self.waiting.extend(
            ChunkPart(work, part.task.only(numbers[i : i + size]), shared)
            for i in range(0, len(numbers), size)
        )

    def _require_answer(self) -> None:
        """Wait for an answer of the executor; raise an error if it is dead."""
        try:
            future, end = self.pool.executor.submit(os.getpid), time.monotonic() + ANSWER
            while not wait([future], timeout=PATIENCE).done:
                if time.monotonic() > end:
                    raise TimeoutError
            future.result()
        except Exception as error:
            raise self._broken(error) from None

    def _require_alive(self, progressed: bool) -> None:
        """Test an external executor that completes no task for a long time.

        After the loss of its scheduler it may drop tasks, and report this only to a new one.
        """
        now = time.monotonic()
        if progressed or self.pool.is_ours:
            self._ended = now
        elif now - self._ended > ANSWER:
            self._ended = now
            try:
                self.pool.executor.submit(os.getpid).cancel()
            except Exception as error:
                raise self._broken(error) from None

    def _broken(self, error: Exception) -> Exception:
        if not self.pool.is_ours:
            return _Gone(type(error).__name__)
        return InputError(
            f"worker processes cannot be started: {error} Use workers=0 for one process."
        )

    def _store_error(self, why: str) -> StoreError:
        """Return the error for a broken external executor, with the run that ended its workers.

        A local process repeats the lost runs, the last first, until it identifies the run.
        """
        self.pool.leave()
        self.pool, self.in_flight, self.todo = Pool(None, 1), {}, []
        words = "Continue with a new executor."
        for work in dict.fromkeys(reversed(self._suspects)):
            task = self.task_of(work.number)
            if work.missing:
                self.waiting = deque([ChunkPart(work, task.only(work.missing))])
                self._work()
            if died := [one.run for one in work.records if one.outcome == WORKER_DIED]:
                where = next(at for at, some in task.runs if died[0] in dict(some))
                named = ", ".join(f"{name} = {value}" for name, value in where.items())
                words = (
                    f"Run {died[0]} ({named}) ends every worker, and is stored as failed: continue "
                    "with a new executor. With workers=2 only that run is lost; a function such "
                    "as executor=lambda: ProcessPoolExecutor(2) makes a new executor itself."
                )
                break
        self.pool.end()
        return StoreError(
            f"the executor broke and accepts no more tasks ({why}). Completed runs are stored. "
            f"{words}"
        )

    def _keep(self, part: ChunkPart, records: list[RunRecord]) -> None:
        work = part.work
        again: Collection[int] = {
            r.run for r in records if r.failed and work.failed[r.run] < self.retries
        }
        work.failed.update(again)
        if again:
            self.waiting.append(part.only(again))
        intact = [record for record in records if record.run not in again]
        work.records += intact
        work.missing -= {record.run for record in intact}
        if not work.missing:
            self.folder.put(work.number, work.records)
            outcomes = [record.outcome for record in work.records]
            self._count(outcomes, sum(record.failed for record in work.records))

    def _count(self, outcomes: list[str], failed: int) -> None:
        meter = self.meter
        meter.done += len(outcomes)
        meter.failed += failed
        meter.diverged += sum(outcome != "completed" for outcome in outcomes) - failed
