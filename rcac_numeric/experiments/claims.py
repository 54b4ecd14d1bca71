"""What is said of an experiment, the checks that decide it, and the verdict that they give."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import instance_of, integer, number, one_of
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
    share : float
        With "each": the least share of the repetitions that must lie in the interval.
    until : int, optional
        The step at which the run is cut off before it is measured: its controller is then theta
        of that step, its plant that of the step before, its signals end there.
    """

    measure: str
    run: str
    at_least: float = -np.inf
    at_most: float = np.inf
    relative_to: str = ""
    statistic: str = "each"
    arguments: Mapping[str, object] = field(default_factory=dict)
    share: float = 1.0
    until: int | None = None

    def __post_init__(self) -> None:
        for name in ("measure", "run", "relative_to", "statistic"):
            instance_of(getattr(self, name), name, str)
        one_of(self.statistic, "statistic", STATISTICS)
        object.__setattr__(self, "arguments", dict(self.arguments))
        if not 0 < number(self.share, "share") <= 1:
            raise InputError(f"share = {self.share} must be above 0 and at most 1.")
        if self.share < 1 and self.statistic != "each":
            raise InputError(f"share = {self.share} is for statistic = 'each'; leave it out.")
        if self.until is not None:
            integer(self.until, "until", at_least=1)
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
    run : str
        The variant that the claim is judged on; empty where its checks are of several.
    reason : str
        Why it does not hold as it is said, from what was measured.
    """

    text: str
    claimed: str
    checks: tuple[Check | ExactCheck, ...]
    correction: str = ""
    recorded: str = ""
    run: str = ""
    reason: str = ""


@dataclass(frozen=True, eq=False)
class CheckResult(Value):
    """The values of a check, one for each repetition.

    Attributes
    ----------
    check : Check
    values : tuple of float
    over_seeds : bool
        Whether the repetitions are other draws of the noise; otherwise they have the same data
        but for their last digits.
    """

    check: Check
    values: tuple[float, ...]
    over_seeds: bool = False

    @property
    def holds(self) -> bool | None:
        """Whether the check holds; None where it hangs on the last digits of the input."""
        if self.check.statistic == "median":
            return self._inside(float(np.median(self.values)))
        if self.inside / len(self.values) >= self.check.share:
            return True
        is_open = self.inside and self.check.share == 1 and not self.over_seeds
        return None if is_open else False

    @property
    def inside(self) -> int:
        """How many repetitions lie in the interval."""
        return sum(map(self._inside, self.values))

    def __str__(self) -> str:
        name = self.check.measure.replace("_", " ")
        ratio = f" / that of {self.check.relative_to}" if self.check.relative_to else ""
        step = "" if self.check.until is None else f" at step {self.check.until}"
        known = [number for number in self.values if not np.isnan(number)] or [np.nan]
        value = self._words(float(np.median(known)))
        if len(self.values) > 1:
            kind = "seeds" if self.over_seeds else "repetitions"
            value = f"median {value} [{self._words(min(known))}, {self._words(max(known))}] of "
            value += f"{len(self.values)} {kind}"
            if missing := int(np.isnan(self.values).sum()):
                value += f", {missing} without a value"
            if self.check.statistic == "each" and self.inside < len(self.values):
                value += f", {self.inside} in the interval"
        return f"{name}{step}{ratio} ({self.check.run}): {value}"

    def _inside(self, value: float) -> bool:
        return self.check.at_least <= value <= self.check.at_most

    def _words(self, value: float) -> str:
        """Five digits, or as many more as it takes to stand on its side of the bounds."""
        for digits in range(5, 17):
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
