"""Chunks on their way over any executor, never more than a window of them, until each is stored."""

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

ALONE = 2  # times that a run that is by itself is lost before it is given up
# Seconds between looks at Ctrl-C, and those that an executor of others has to answer at all after
# it lost a run.
PATIENCE, ANSWER = 0.25, 60.0


class Pool:
    """The executor of a study: one of ours, one of others, or what a function makes again."""

    def __init__(self, make: Callable[[], Executor], *, own: bool, renewable: bool) -> None:
        self._make, self._own, self.renewable = make, own, renewable
        self._executor: Executor | None = None

    @property
    def executor(self) -> Executor:
        """Made when the first run is to be run."""
        if self._executor is None:
            self._executor = self._make()
        return self._executor

    def renew(self) -> None:
        """Let go of one that broke; the next is made when it is needed."""
        if self._executor is not None:
            _cancel(self._executor)
        self._executor = None

    def end(self) -> None:
        """Let it end; what somebody else made, somebody else ends."""
        if self._own and self._executor is not None:
            self._executor.shutdown()

    def leave(self) -> None:
        """Let go of it at once."""
        if isinstance(self._executor, WorkerPool) and self._own:
            self._executor.leave()
        elif self._own and self._executor is not None:
            _cancel(self._executor)


def _cancel(executor: Executor) -> None:
    try:
        executor.shutdown(wait=False, cancel_futures=True)
    except TypeError:  # loky's does not know it
        executor.shutdown(wait=False)


@dataclass
class Work:
    """A chunk that is being run, and what there is of it so far."""

    number: int
    missing: set[int]
    records: list[RunRecord] = field(default_factory=list)
    # How often runs were lost with a worker that surely was theirs, by themselves, or failed.
    lost: Counter[int] = field(default_factory=Counter)
    alone: Counter[int] = field(default_factory=Counter)
    failed: Counter[int] = field(default_factory=Counter)


@dataclass(frozen=True)
class ChunkPart:
    """Some runs of a chunk; where one of them may end its worker, nothing goes beside them."""

    work: Work
    task: ChunkTask
    by_itself: bool = False

    @property
    def is_alone(self) -> bool:
        """Whether it is one run."""
        return len(self.task.numbers) == 1

    def only(self, numbers: Collection[int]) -> ChunkPart:
        """The same with some of its runs."""
        return ChunkPart(self.work, self.task.only(numbers), self.by_itself)


class Coordinator:
    """Submits the chunks that a folder has not, and writes what comes back.

    They go in random order: so two coordinators of one folder meet in few of them only, and both
    leave out what the other has written.
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
        self.waiting: deque[ChunkPart] = deque()  # what goes once more
        self.todo: list[int] = []
        self._absent: set[int] = set()
        self._ended = time.monotonic()  # when something ended last

    def run(self, absent: Iterable[int], again: Iterable[int] = ()) -> None:
        """Until all of these are stored: chunks without a file, and those that are written anew."""
        self._absent = set(absent)
        self.todo = [*self._absent, *again]
        SystemRandom().shuffle(self.todo)
        while True:
            self._fill()
            if not self.in_flight:
                return
            done, _ = wait(self.in_flight, timeout=PATIENCE, return_when=FIRST_COMPLETED)
            for future in done:
                self._end(future)
            self._require_alive(bool(done))
            self.progress(self.meter.now())

    def leave(self) -> None:
        """Let go of the executor at once."""
        for future in self.in_flight:
            future.cancel()
        self.pool.leave()

    @property
    def _shared(self) -> bool:
        """Whether workers may share a fate: there what is suspected runs by itself."""
        return not isinstance(self.pool.executor, WorkerPool | InProcess)

    def _fill(self) -> None:
        """Submit what may be."""
        while len(self.in_flight) < self.window:
            if any(part.by_itself for part, _ in self.in_flight.values()):
                return
            if self.waiting:
                if self.waiting[0].by_itself and self.in_flight:
                    return
                part = self.waiting.popleft()
                if part.by_itself:  # dask gives up workers that are lost while they start
                    self._require_answer()
            elif (number := self._next()) is not None:
                task = self.task_of(number)
                part = ChunkPart(Work(number, set(task.numbers)), task)
            else:
                return
            self._submit(part)
            if isinstance(self.pool.executor, InProcess):
                return

    def _next(self) -> int | None:
        """A chunk that nobody has stored; None where there is none."""
        while self.todo:
            number = self.todo.pop()
            stored = self.folder.read([number], guarded=False) if number in self._absent else ()
            for chunk in stored:
                if not chunk.fault:  # another coordinator's
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

    def _broken(self, error: Exception) -> Exception:
        if isinstance(self.pool.executor, WorkerPool):
            return InputError(
                f"worker processes cannot be started: {error} workers=0 does all in one process."
            )
        return StoreError(
            f"the executor broke: it takes nothing more ({type(error).__name__}). What had ended "
            "is kept; go on with a new one. Where a run ends its worker, processes of our own "
            "(workers=2) find it, or a function that makes the executor, executor=lambda: "
            "ProcessPoolExecutor(2) for instance: then it is made again."
        )

    def _end(self, future: Future[ChunkResult]) -> None:
        part, executor = self.in_flight.pop(future)
        try:
            result = future.result()
        except BrokenExecutor as error:
            if not self.pool.renewable:
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
        """Run it again, in halves if it was lost before; a run by itself is given up at last."""
        work, numbers, shared = part.work, part.task.numbers, self._shared
        surely = part.by_itself or not shared
        work.lost.update(numbers if surely else ())
        if part.is_alone and surely:
            (number,) = numbers
            work.alone[number] += 1
            if outcome == TIMED_OUT or work.alone[number] >= ALONE:
                if shared:
                    self._require_answer()
                self._keep(part, [failure(number, outcome, words)])
                return
        half = len(numbers)
        if outcome == TIMED_OUT:
            half = 1
        elif surely and (shared or work.lost[numbers[0]] > 1):  # once it may have been killed
            half = (half + 1) // 2
        self.waiting.extend(
            ChunkPart(work, part.task.only(numbers[i : i + half]), shared)
            for i in range(0, len(numbers), half)
        )

    def _require_answer(self) -> None:
        """Wait until the executor does something, and refuse to go on where it is dead."""
        try:
            future, end = self.pool.executor.submit(os.getpid), time.monotonic() + ANSWER
            while not wait([future], timeout=PATIENCE).done:
                if time.monotonic() > end:
                    raise TimeoutError
            future.result()
        except Exception as error:
            raise self._broken(error) from None

    def _require_alive(self, progressed: bool) -> None:
        """Ask an executor of others in which nothing ends for long whether it takes anything.

        One that lost its scheduler may forget what it was given, and say so only then.
        """
        now = time.monotonic()
        if progressed or not self._shared:
            self._ended = now
        elif now - self._ended > ANSWER:
            self._ended = now
            try:
                self.pool.executor.submit(os.getpid).cancel()
            except Exception as error:
                raise self._broken(error) from None

    def _keep(self, part: ChunkPart, records: list[RunRecord]) -> None:
        work = part.work
        again: Collection[int] = {
            r.run for r in records if r.failed and work.failed[r.run] < self.retries
        }
        work.failed.update(again)
        if again:
            self.waiting.append(part.only(again))
        kept = [record for record in records if record.run not in again]
        work.records += kept
        work.missing -= {record.run for record in kept}
        if not work.missing:
            self.folder.put(work.number, work.records)
            outcomes = [record.outcome for record in work.records]
            self._count(outcomes, sum(record.failed for record in work.records))

    def _count(self, outcomes: list[str], failed: int) -> None:
        meter = self.meter
        meter.done += len(outcomes)
        meter.failed += failed
        meter.diverged += sum(outcome != "completed" for outcome in outcomes) - failed
