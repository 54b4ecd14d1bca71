"""What a run ends with that is no result, and what is kept of an error."""

from __future__ import annotations

from compensator_theory.errors import CompensatorError
from rcac_numeric.arrays.wording import printable, shortened

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
    >>> from rcac_numeric.sweeps.chunks.failures import storable
    >>> storable("a\0b\udcff"), len(storable("x" * 10**6))
    ('a\\x00b\\udcff', 2000)
    """
    return shortened(printable(shortened(text, LONGEST_TEXT)), LONGEST_TEXT)
