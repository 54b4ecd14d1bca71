"""Chunks on their way: never more than a window of them, each until it is stored."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait

from compensator_theory.errors import CompensatorError
from rcac_numeric.sweeps.chunks.chunk import WORKER_DIED, ChunkResult, ChunkTask, RunRecord
from rcac_numeric.sweeps.chunks.worker import run_chunk
from rcac_numeric.sweeps.running.pools import InProcess, WorkerPool, ready
from rcac_numeric.sweeps.running.progress import Meter, Progress
from rcac_numeric.sweeps.store.claims import Claim, Claims
from rcac_numeric.sweeps.store.problems import StoreError

# A chunk that was lost so often is taken apart, to find the run that ends its worker.
TRIES = 3
# Seconds between looks at what others do, and at Ctrl-C.
PATIENCE = 0.25
InFlight = dict[Future[ChunkResult], tuple[Claim, ChunkTask]]


class Schedule:
    """Submits what the store has free, and stores what comes back.

    Parameters
    ----------
    claims : Claims
    task_of : callable
        What is sent to a worker for a claim.
    make : callable
        Makes an executor; again where one broke.
    window : int
        Chunks under way at a time.
    meter, progress
        What counts, and who is told.
    """

    def __init__(
        self,
        claims: Claims,
        task_of: Callable[[Claim], ChunkTask],
        make: Callable[[], Executor],
        window: int,
        meter: Meter,
        progress: Callable[[Progress], None],
    ) -> None:
        self.claims, self.task_of, self.make = claims, task_of, make
        self.window, self.meter, self.progress = window, meter, progress
        self.executor: Executor = InProcess()  # until there is something to run
        self.in_flight: InFlight = {}
        self.lost: list[Claim] = []

    def run(self) -> None:
        """Until the store has nothing left to do."""
        self.executor = self.make()
        ready(self.executor)
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
            self.progress(self.meter.now())

    def leave(self) -> None:
        """Let go of the executor at once."""
        for future in self.in_flight:
            future.cancel()
        if isinstance(self.executor, WorkerPool):
            self.executor.leave()

    def _fill(self) -> bool:
        """Submit what may be; whether there is something to wait for."""
        while len(self.in_flight) < self.window:
            suspects = [claim for claim in self.lost if claim.tries >= TRIES]
            if suspects:
                if self.in_flight:  # what is suspected runs alone
                    return True
                self.lost.remove(suspects[0])
                self._take_apart(suspects[0])
                continue
            claim = self.lost.pop() if self.lost else self.claims.take()
            if claim is None and self.claims.take_over():
                continue
            if claim is None:
                return bool(self.in_flight) or self.claims.others
            self._submit(claim)
            if isinstance(self.executor, InProcess):
                return True
        return True

    def _submit(self, claim: Claim) -> None:
        task = self.task_of(claim)
        try:
            self.in_flight[self.executor.submit(run_chunk, task)] = (claim, task)
        except BrokenExecutor:
            self._lose(claim)
            self._renew()

    def _end(self, future: Future[ChunkResult]) -> None:
        if future not in self.in_flight:
            return
        claim, _ = self.in_flight.pop(future)
        try:
            result = future.result()
        except BrokenExecutor:
            self._lose(claim)
            for other in list(self.in_flight):  # they were lost with it, or have just ended
                if not (other.done() and other.exception() is None):
                    self._lose(self.in_flight.pop(other)[0])
            self._renew()
        except CompensatorError:  # this worker, and so every worker, cannot run the study
            raise
        except Exception:  # what the executor says of a worker that was lost
            self._lose(claim)
        else:
            self._store(claim, result)

    def _lose(self, claim: Claim) -> None:
        self.lost.append(self.claims.failed(claim))

    def _renew(self) -> None:
        if not isinstance(self.executor, WorkerPool):
            raise StoreError(
                "the executor broke: a worker died, and it takes nothing more. What had ended is "
                "kept; go on with a new one."
            )
        self.executor.leave()
        self.executor = self.make()
        ready(self.executor)

    def _take_apart(self, claim: Claim) -> None:
        """Run the runs of a chunk one by one; who ends its worker twice is recorded as such."""
        whole, records, seconds = self.task_of(claim), [], 0.0
        for number in whole.numbers:
            result = self._alone(whole.only(number))
            if result is None:
                result = self._alone(whole.only(number))
            if result is None:
                nothing = [math.nan] * self._width(whole)
                why = "the process that ran it ended without a word, each time it was tried"
                records.append(RunRecord(number, WORKER_DIED, why, nothing, {}))
            else:
                records += result.records
                seconds += result.seconds
        self._store(claim, ChunkResult(records, seconds))

    def _alone(self, task: ChunkTask) -> ChunkResult | None:
        try:
            future = self.executor.submit(run_chunk, task)
            while not future.done():
                wait([future], timeout=PATIENCE)
            return future.result()
        except BrokenExecutor:
            self._renew()
        except CompensatorError:
            raise
        except Exception:
            return None
        return None

    def _width(self, task: ChunkTask) -> int:
        return len(self.claims.store.study.resolved["keep"])

    def _store(self, claim: Claim, result: ChunkResult) -> None:
        if not self.claims.finish(claim, result.records, result.seconds):
            return  # it took so long that another process was given the chunk
        meter = self.meter
        meter.done += len(result.records)
        meter.diverged += sum(record.outcome != "completed" for record in result.records)
        meter.failed += sum(bool(record.error) for record in result.records)

    def _look(self) -> None:
        self.meter.done, self.meter.total = self.claims.store.counts()
        self.progress(self.meter.now())
