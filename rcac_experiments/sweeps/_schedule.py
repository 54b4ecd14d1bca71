"""Chunks on their way: never more than a window of them, each until it is stored."""

from __future__ import annotations

import os
import time
from collections import Counter, deque
from collections.abc import Callable, Collection
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass, field

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.sweeps._chunk import (
    TIMED_OUT,
    WORKER_DIED,
    ChunkResult,
    ChunkTask,
    RunRecord,
    failure,
)
from rcac_experiments.sweeps._claims import Claim, Claims
from rcac_experiments.sweeps._pools import InProcess, WorkerLost, WorkerPool
from rcac_experiments.sweeps._problems import StoreError
from rcac_experiments.sweeps._progress import Meter, Progress
from rcac_experiments.sweeps._worker import run_chunk

# A chunk that was lost so often is taken apart, to find the run that ends its worker; and a run
# that is by itself is given up when it was lost so often.
TRIES, ALONE = 3, 2
# Seconds between looks at what others do, and at Ctrl-C; and those that an executor of others has
# to answer at all after it lost a run.
PATIENCE, ANSWER = 0.25, 60.0


@dataclass
class Work:
    """A chunk that is being run, and what there is of it so far."""

    claim: Claim
    missing: set[int]
    records: list[RunRecord] = field(default_factory=list)
    seconds: float = 0.0
    lost: Counter[int] = field(default_factory=Counter)  # how often, by the number of the run
    failed: Counter[int] = field(default_factory=Counter)


class Schedule:
    """Submits what the store has free, and stores what comes back."""

    def __init__(
        self,
        claims: Claims,
        executor: Executor,
        task_of: Callable[[Claim], ChunkTask],
        window: int,
        retries: int,
        meter: Meter,
        progress: Callable[[Progress], None],
    ) -> None:
        self.claims, self.executor, self.task_of = claims, executor, task_of
        self.window, self.retries = window, retries
        self.meter, self.progress = meter, progress
        self.in_flight: dict[Future[ChunkResult], tuple[Work, ChunkTask]] = {}
        self.waiting: deque[tuple[Work, ChunkTask]] = deque()  # what goes once more
        # Workers of others may share a fate: there what is suspected runs alone.
        self.shared = not isinstance(executor, WorkerPool | InProcess)
        self._ended = time.monotonic()  # when something ended last

    def run(self) -> None:
        """Until the store has nothing left to do."""
        while True:
            again = self._fill()
            if not self.in_flight:
                if not again:
                    return
                time.sleep(PATIENCE)  # another process is at work; it may yet be lost
                self._look()
                continue
            done, _ = wait(self.in_flight, timeout=PATIENCE, return_when=FIRST_COMPLETED)
            for future in done:
                self._end(future)
            self._require_alive(bool(done))
            self.progress(self.meter.now())

    def leave(self) -> None:
        """Let go of the executor at once."""
        for future in self.in_flight:
            future.cancel()

    def _fill(self) -> bool:
        """Submit what may be; whether there is something to wait for."""
        while len(self.in_flight) < self.window:
            if self.shared and any(_is_alone(task) and work.lost
                                   for work, task in self.in_flight.values()):  # fmt: skip
                return True
            if self.waiting:
                work, task = self.waiting[0]
                if self.shared and _is_alone(task) and work.lost and self.in_flight:
                    return True
                self.waiting.popleft()
                self._submit(work, task)
            else:
                claim = self.claims.take()
                if claim is None and self.claims.take_over():
                    continue
                if claim is None:
                    return bool(self.in_flight) or self.claims.others
                task = self.task_of(claim)
                work = Work(claim, set(task.numbers))
                if claim.tries >= TRIES:  # it has taken workers with it before
                    work.lost.update(task.numbers)
                    self._again(work, task, apart=True)
                    continue
                self._submit(work, task)
            if isinstance(self.executor, InProcess):
                return True
        return True

    def _submit(self, work: Work, task: ChunkTask) -> None:
        try:
            self.in_flight[self.executor.submit(run_chunk, task)] = work, task
        except Exception as error:
            raise self._broken(error) from None

    def _broken(self, error: Exception) -> Exception:
        if isinstance(self.executor, WorkerPool):
            return InputError(
                f"worker processes cannot be started: {error} workers=0 does all in one process."
            )
        return StoreError(
            f"the executor broke: it takes nothing more ({type(error).__name__}). What had ended "
            "is kept; go on with a new one."
        )

    def _end(self, future: Future[ChunkResult]) -> None:
        work, task = self.in_flight.pop(future)
        try:
            result = future.result()
        except BrokenExecutor as error:
            raise self._broken(error) from None
        except CompensatorError:  # this worker, and so every worker, cannot run the study
            raise
        except WorkerLost as lost:
            self._lose(work, task, lost.outcome, str(lost))
        except Exception as error:  # what an executor of others says of a worker that was lost
            self._lose(work, task, WORKER_DIED, f"its worker was lost ({type(error).__name__})")
        else:
            work.seconds += result.seconds
            self._keep(work, task, result.records)

    def _lose(self, work: Work, task: ChunkTask, outcome: str, words: str) -> None:
        """Run it again; a run by itself is given up, with what was said of its end."""
        work.lost.update(task.numbers)
        if not _is_alone(task):
            work.claim = self.claims.failed(work.claim)
            self._again(work, task, apart=outcome == TIMED_OUT or work.claim.tries >= TRIES)
            return
        (number,) = task.numbers
        if outcome != TIMED_OUT and work.lost[number] < ALONE:
            self._again(work, task)
            return
        if self.shared:
            self._require_answer()
        self._keep(work, task, [failure(number, outcome, words)])

    def _again(self, work: Work, task: ChunkTask, apart: bool = False) -> None:
        tasks = [task.only([number]) for number in task.numbers] if apart else [task]
        self.waiting.extend((work, one) for one in tasks)

    def _require_answer(self) -> None:
        """Refuse to call a run deadly where the executor as a whole is dead."""
        try:
            future, end = self.executor.submit(os.getpid), time.monotonic() + ANSWER
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
        if progressed or not self.shared:
            self._ended = now
        elif now - self._ended > ANSWER:
            self._ended = now
            try:
                self.executor.submit(os.getpid).cancel()
            except Exception as error:
                raise self._broken(error) from None

    def _keep(self, work: Work, task: ChunkTask, records: list[RunRecord]) -> None:
        self.claims.progressed()
        again: Collection[int] = {
            r.run for r in records if r.failed and work.failed[r.run] < self.retries
        }
        work.failed.update(again)
        if again:
            self._again(work, task.only(again))
        kept = [record for record in records if record.run not in again]
        work.records += kept
        work.missing -= {record.run for record in kept}
        if work.missing or not self.claims.finish(work.claim, work.records, work.seconds):
            return  # or another process was quicker
        meter = self.meter
        meter.done += len(work.records)
        meter.failed += sum(record.failed for record in work.records)
        meter.diverged += sum(
            record.outcome != "completed" and not record.failed for record in work.records
        )

    def _look(self) -> None:
        self.meter.done, self.meter.total, self.meter.failed = self.claims.store.counts()
        self.progress(self.meter.now())


def _is_alone(task: ChunkTask) -> bool:
    return len(task.numbers) == 1
