"""The progress of a study, for a program, a terminal or a notebook."""

from __future__ import annotations

import sys
import time
from collections import deque
from dataclasses import dataclass, field
from typing import TextIO

# Seconds over which the rate is taken, and between two lines.
MEMORY, PAUSE = 30.0, 0.25


@dataclass(frozen=True)
class Progress:
    """The progress of a study.

    Attributes
    ----------
    done, total : int
        Stored runs, of all processes, and runs of the study.
    rate : float
        Recent runs per second; 0 if unknown.
    diverged : int
        Runs of this process that did not complete.
    failed : int
        Runs with an error and no result; `retry_failed` repeats them.
    """

    done: int
    total: int
    rate: float
    diverged: int = 0
    failed: int = 0

    @property
    def seconds_left(self) -> float:
        """Estimated remaining time; infinite if unknown."""
        return (self.total - self.done) / self.rate if self.rate else float("inf")

    def __str__(self) -> str:
        share = 100 * self.done / self.total if self.total else 100.0
        words = f"{self.done} of {self.total} runs ({share:.0f} %)"
        if self.failed:
            words += f", {self.failed} failed"
        if self.rate and self.done < self.total:
            words += f", {self.rate:.3g} a second, {_duration(self.seconds_left)} left"
        if self.diverged:
            words += f", {self.diverged} did not complete"
        return words


@dataclass
class Meter:
    """Count completed runs and their rate."""

    total: int
    done: int
    diverged: int = 0
    failed: int = 0
    _history: deque[tuple[float, int]] = field(default_factory=deque)

    def now(self) -> Progress:
        """Return the present progress."""
        moment = time.monotonic()
        self._history.append((moment, self.done))
        while moment - self._history[0][0] > MEMORY:
            self._history.popleft()
        since, count = self._history[0]
        elapsed = moment - since
        rate = (self.done - count) / elapsed if elapsed > 0.05 else 0.0
        return Progress(self.done, self.total, rate, self.diverged, self.failed)


class ProgressLine:
    """Print the progress of a study on one line of a terminal or a notebook.

    Examples
    --------
    >>> import io
    >>> from rcac_experiments.sweeps._progress import Progress, ProgressLine
    >>> out = io.StringIO()
    >>> line = ProgressLine(out)
    >>> line(Progress(50, 100, rate=10.0))
    >>> out.getvalue().strip()
    '50 of 100 runs (50 %), 10 a second, 5 s left'
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream, self._last, self._length = stream or sys.stderr, 0.0, 0

    def __call__(self, progress: Progress) -> None:
        """Print the progress, at a limited rate."""
        moment = time.monotonic()
        if moment - self._last < PAUSE and progress.done < progress.total:
            return
        text = str(progress)
        self._stream.write("\r" + text.ljust(self._length))
        self._stream.flush()
        self._last, self._length = moment, len(text)

    def end(self) -> None:
        """End the line."""
        if self._length:
            self._stream.write("\n")
            self._stream.flush()


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"
