"""What is sent to a worker, and what comes back."""

from __future__ import annotations

from dataclasses import dataclass

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.values import Value
from rcac_numeric.sweeps.study.study import Coordinates

# What a study knows beside the outcomes of the engine: values that make no run, a function of the
# study that raised, and a run that took its worker with it.
REFUSED, FUNCTION_FAILED, WORKER_DIED = "refused", "function failed", "worker died"


@dataclass(frozen=True, eq=False)
class ChunkTask(Value):
    """Some runs of a study.

    Attributes
    ----------
    study : bytes
        The study, pickled; a worker reads it once.
    fingerprint : str
        What the worker knows it by.
    instruction_set : str
        The instructions that all runs of the study use.
    runs : list of (coordinates, list of (run, repetition))
        Cell by cell.
    """

    study: bytes
    fingerprint: str
    instruction_set: str
    runs: list[tuple[Coordinates, list[tuple[int, int]]]]

    @property
    def numbers(self) -> list[int]:
        """The numbers of the runs, in their order."""
        return [run for _, some in self.runs for run, _ in some]

    def only(self, number: int) -> ChunkTask:
        """The same with one of its runs."""
        runs = [
            (coordinates, [pair for pair in some if pair[0] == number])
            for coordinates, some in self.runs
        ]
        return ChunkTask(
            self.study,
            self.fingerprint,
            self.instruction_set,
            [(coordinates, some) for coordinates, some in runs if some],
        )


@dataclass(frozen=True, eq=False)
class RunRecord(Value):
    """What is kept of one run.

    Attributes
    ----------
    run : int
        Its number in the store.
    outcome, error : str
    values : list of float
        One for each measure; NaN where there is none.
    signals : dict from names to arrays
        Those that were asked for.
    """

    run: int
    outcome: str
    error: str
    values: list[float]
    signals: dict[str, Array]


@dataclass(frozen=True, eq=False)
class ChunkResult(Value):
    """The records of a chunk by increasing run, and how long it took in seconds."""

    records: list[RunRecord]
    seconds: float
