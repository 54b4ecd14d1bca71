"""Driving jobs to their end, so that Ctrl-C is answered and loses nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rcac_numeric.engine import _kernel
from rcac_numeric.engine.jobs import PreparedRun
from rcac_numeric.engine.runs import Run

# Seconds that the kernel runs before Python may look at a key that was pressed.
CHUNK = 0.05


class RunInterrupted(KeyboardInterrupt):
    """Ctrl-C while something ran; whoever catches KeyboardInterrupt catches this too.

    Attributes
    ----------
    runs : tuple of Run
        What had been computed, in the order of the cases. Those that were stopped have the
        outcome "interrupted"; `simulate` goes on from their `state`, where they have one.
    """

    def __init__(self, runs: Sequence[Run]) -> None:
        self.runs = tuple(runs)
        steps = ", ".join(str(run.steps) for run in self.runs[:3])
        more = f" and {len(self.runs) - 3} more" if len(self.runs) > 3 else ""
        super().__init__(f"interrupted after {steps}{more} steps; they are in the attribute runs")

    @property
    def run(self) -> Run:
        """The first run; the only one of `simulate`."""
        return self.runs[0]


def run_to_end(prepared: Sequence[PreparedRun], threads: int = 1, lanes: bool = False) -> None:
    """Run every job to its end."""
    for _ in in_slices(prepared, threads, lanes):
        pass


def in_slices(
    prepared: Sequence[PreparedRun], threads: int = 1, lanes: bool = False, keep: bool = True
) -> Iterator[None]:
    """Run every job to its end; hands over after each slice of time, and once at the end."""
    jobs = [one.job for one in prepared]
    go_on = True
    for one in prepared:
        one.proceed()
    while go_on:
        try:
            go_on = _kernel.run_jobs(jobs, threads, CHUNK, lanes)
            go_on = sum(one.proceed() for one in prepared) > 0 or go_on  # each of them proceeds
        except KeyboardInterrupt:
            if not keep:
                raise
            raise RunInterrupted([one.result(interrupted=True) for one in prepared]) from None
        yield
