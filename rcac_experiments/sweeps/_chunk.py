"""Tasks of a worker, and their returns: results and failures."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from compensator_theory.errors import CompensatorError
from rcac_experiments.sweeps._study import Coordinates
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Value
from rcac_numeric.arrays._wording import printable, shortened

# A result beside the outcomes of the engine: these values make no run, and never will.
REFUSED = "refused"
# What may pass: of such a run nothing is known, and it can be tried again.
FUNCTION_FAILED, MEASURE_FAILED = "function failed", "measure failed"
OUT_OF_MEMORY, TIMED_OUT, WORKER_DIED = "out of memory", "timed out", "worker died"
FAILED = (
    FUNCTION_FAILED, MEASURE_FAILED, "plant failed", "weight failed", "reducer failed",
    OUT_OF_MEMORY, TIMED_OUT, WORKER_DIED,
)  # fmt: skip
LONGEST_TEXT = 2000  # characters of an error that are stored


class TimeLimitReached(BaseException):
    """Raised in a run of this process that takes too long; no `except Exception` stops it."""


def error_text(error: BaseException) -> str:
    """Return the text of an exception, as it is stored."""
    try:
        words = str(error)
    except Exception:
        words = "its text cannot be made"
    kind = "" if isinstance(error, CompensatorError) else f"{type(error).__name__}: "
    return storable(kind + words)


def storable(text: str) -> str:
    """Any text as a file and a terminal take it: bounded, control characters written out."""
    return shortened(printable(shortened(text, LONGEST_TEXT)), LONGEST_TEXT)


@dataclass(frozen=True, eq=False)
class ChunkTask(Value):
    """Some runs of a study, as (coordinates, list of (run, repetition)) cell by cell.

    The study is pickled by who runs it, and a worker knows it by its fingerprint; `instruction_set`
    is empty for whatever there is, and `at_once` how many runs are in memory at a time.
    """

    study: bytes
    fingerprint: str
    instruction_set: str
    runs: list[tuple[Coordinates, list[tuple[int, int]]]]
    at_once: int = 256

    @property
    def numbers(self) -> list[int]:
        """The numbers of the runs, in their order."""
        return [run for _, some in self.runs for run, _ in some]

    def only(self, numbers: Collection[int]) -> ChunkTask:
        """Return the task with these of its runs only."""
        runs = [(where, [pair for pair in some if pair[0] in numbers]) for where, some in self.runs]
        return replace(self, runs=[(where, some) for where, some in runs if some])


@dataclass(frozen=True, eq=False)
class RunRecord(Value):
    """The stored row of one run: a value for each measure, NaN without one; empty if it failed.

    `signals` are the requested ones, by name.
    """

    run: int
    outcome: str
    error: str
    values: list[float]
    signals: dict[str, Array]

    @property
    def failed(self) -> bool:
        """Whether it is no result."""
        return self.outcome in FAILED


@dataclass(frozen=True, eq=False)
class ChunkResult(Value):
    """The records of a chunk by increasing run, and how long it took in seconds."""

    records: list[RunRecord]
    seconds: float


def failure(run: int, outcome: str, error: BaseException | str) -> RunRecord:
    """Return the record of a failed run, with its error alone."""
    if isinstance(error, MemoryError):
        outcome = OUT_OF_MEMORY
    elif isinstance(error, TimeLimitReached):
        outcome = TIMED_OUT
    return RunRecord(
        run, outcome, storable(error) if isinstance(error, str) else error_text(error), [], {}
    )
