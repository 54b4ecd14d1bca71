"""What is said of an experiment, the checks that decide it, and the verdict that they give."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import instance_of, one_of
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.exact.checks import ExactCheck, ExactResult

REPRODUCED = "reproduced"
CORRECTED = "reproduced with a correction"
NOT_REPRODUCED = "not reproduced"
ILL_POSED = "ill-posed"
VERDICTS = (REPRODUCED, CORRECTED, NOT_REPRODUCED, ILL_POSED)
STATISTICS = ("each", "median")


@dataclass(frozen=True, eq=False)
class Check(Value):
    """A measure of one run and the interval in which it must lie.

    Attributes
    ----------
    measure, arguments
        A name of `measures.MEASURES` and its keyword arguments.
    run, relative_to : names of runs
        With `relative_to` the measure is divided by that of the other run, repetition by
        repetition.
    at_least, at_most : float
        At least one of them is finite: a check without a bound could not fail.
    statistic : {"each", "median"}
        Whether every repetition must lie in the interval, or the median.
    """

    measure: str
    run: str
    at_least: float = -np.inf
    at_most: float = np.inf
    relative_to: str = ""
    statistic: str = "each"
    arguments: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("measure", "run", "relative_to", "statistic"):
            instance_of(getattr(self, name), name, str)
        one_of(self.statistic, "statistic", STATISTICS)
        object.__setattr__(self, "arguments", dict(self.arguments))
        if not (self.at_least > -np.inf or self.at_most < np.inf):
            raise InputError(
                f"the check of {self.measure!r} needs at_least, at_most or both: a check without "
                "a bound cannot fail."
            )
        if self.at_least > self.at_most:
            raise InputError(
                f"the check of {self.measure!r} asks for at least {self.at_least} and at most "
                f"{self.at_most}, which no number is."
            )


@dataclass(frozen=True, eq=False)
class Claim(Value):
    """Something said of an experiment, with the checks that decide whether it holds.

    Attributes
    ----------
    text, claimed : str
        What is said, and the number or behaviour that is claimed.
    correction : str
        What had to be read differently from the source for the checks to be the right ones.
    recorded : str
        The verdict of record; a run that computes another one has changed.
    """

    text: str
    claimed: str
    checks: tuple[Check | ExactCheck, ...]
    correction: str = ""
    recorded: str = ""


@dataclass(frozen=True, eq=False)
class CheckResult(Value):
    """The values of a check, one for each repetition."""

    check: Check
    values: tuple[float, ...]

    @property
    def holds(self) -> bool | None:
        """Whether the check holds; None where it hangs on the last bits of the input."""
        judged = (
            [float(np.median(self.values))] if self.check.statistic == "median" else self.values
        )
        inside = [self._inside(value) for value in judged]
        return True if all(inside) else None if any(inside) else False

    def __str__(self) -> str:
        name = self.check.measure.replace("_", " ")
        ratio = f" / that of {self.check.relative_to}" if self.check.relative_to else ""
        value = self._words(float(np.median(self.values)))
        if len(self.values) > 1:
            low, high = self._words(min(self.values)), self._words(max(self.values))
            value = f"median {value} [{low}, {high}] of {len(self.values)}"
        return f"{name}{ratio} ({self.check.run}): {value}"

    def _inside(self, value: float) -> bool:
        return self.check.at_least <= value <= self.check.at_most

    def _words(self, value: float) -> str:
        """Three digits, or as many more as it takes to stand on its side of the bounds."""
        for digits in range(3, 17):
            words = f"{value:.{digits}g}"
            if self._inside(float(words)) == self._inside(value):
                break
        return words


@dataclass(frozen=True, eq=False)
class Verdict(Value):
    """A claim, what was measured, and whether it holds."""

    claim: Claim
    results: tuple[CheckResult | ExactResult, ...]

    @property
    def verdict(self) -> str:
        """One of `VERDICTS`.

        A claim holds where all its checks do; it is ill-posed where repetitions that differ by
        rounding only disagree.
        """
        outcomes = [result.holds for result in self.results]
        if any(outcome is False for outcome in outcomes):
            return NOT_REPRODUCED
        if any(outcome is None for outcome in outcomes):
            return ILL_POSED
        return CORRECTED if self.claim.correction else REPRODUCED

    @property
    def has_changed(self) -> bool:
        """Whether the verdict differs from the one of record."""
        return bool(self.claim.recorded) and self.claim.recorded != self.verdict

    @property
    def measured(self) -> str:
        """The measured values in words."""
        return "; ".join(map(str, self.results))
