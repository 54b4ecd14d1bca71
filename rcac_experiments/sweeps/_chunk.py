"""What is sent to a worker, and what comes back: results, and failures, which are none."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

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
    FUNCTION_FAILED,
    MEASURE_FAILED,
    "plant failed",
    "weight failed",
    "reducer failed",
    OUT_OF_MEMORY,
    TIMED_OUT,
    WORKER_DIED,
)
LONGEST_TEXT = 2000  # characters of an error that are stored


class TimeLimitReached(BaseException):
    """Raised in a run of this process that takes too long; no `except Exception` stops it."""


def error_text(error: BaseException) -> str:
    """What an exception says, as it is stored."""
    try:
        words = str(error)
    except Exception:
        words = "its text cannot be made"
    kind = "" if isinstance(error, CompensatorError) else f"{type(error).__name__}: "
    return storable(kind + words)


def storable(text: str) -> str:
    r"""Any text as SQLite and a terminal take it: bounded, control characters written out.

    Examples
    --------
    >>> from rcac_experiments.sweeps._chunk import storable
    >>> storable("a\0b\udcff"), len(storable("x" * 10**6))
    ('a\\x00b\\udcff', 2000)
    """
    return shortened(printable(shortened(text, LONGEST_TEXT)), LONGEST_TEXT)


@dataclass(frozen=True, eq=False)
class ChunkTask(Value):
    """Some runs of a study.

    Attributes
    ----------
    study : bytes
        The study, pickled by who runs it; a worker reads it once.
    fingerprint : str
        What the worker knows it by.
    instruction_set : str
        The instructions that all runs of the study use; empty for whatever there are.
    runs : list of (coordinates, list of (run, repetition))
        Cell by cell.
    at_once : int
        Runs in memory at a time.
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
        """The same with some of its runs."""
        runs = [
            (coordinates, [pair for pair in some if pair[0] in numbers])
            for coordinates, some in self.runs
        ]
        return ChunkTask(
            self.study,
            self.fingerprint,
            self.instruction_set,
            [(coordinates, some) for coordinates, some in runs if some],
            self.at_once,
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
        One for each measure, NaN where a result has none; none at all where the run failed.
    signals : dict from names to arrays
        Those that were asked for.
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
    """The record of a run of which nothing is known but what went wrong."""
    if isinstance(error, MemoryError):
        outcome = OUT_OF_MEMORY
    elif isinstance(error, TimeLimitReached):
        outcome = TIMED_OUT
    return RunRecord(
        run, outcome, storable(error) if isinstance(error, str) else error_text(error), [], {}
    )
