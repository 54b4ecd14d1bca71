"""Checks of what ran: a measure of a loop or an estimator, and the interval for it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import instance_of, integer, number, one_of
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.judging.claim import Measured

STATISTICS = ("each", "median")
CONFIDENCE = 0.95


@dataclass(frozen=True, eq=False)
class Check(Value):
    """A measure of one run and the interval in which it must lie."""

    measure: str
    run: str
    at_least: float = -np.inf
    at_most: float = np.inf
    relative_to: str = ""
    statistic: str = "each"
    arguments: Mapping[str, object] = field(default_factory=dict)
    share: float = 1.0
    until: int | None = None
    quoted: str = ""

    def __post_init__(self) -> None:
        for name in ("measure", "run", "relative_to", "statistic", "quoted"):
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

    @property
    def runs(self) -> tuple[str, ...]:
        """The runs that it needs."""
        return tuple(name for name in (self.run, self.relative_to) if name)

    def moved(self, moves: Mapping[str, str]) -> Check:
        """The same check of other runs."""
        other = moves.get(self.relative_to, self.relative_to) if self.relative_to else ""
        return replace(self, run=moves.get(self.run, self.run), relative_to=other)

    def evaluate(self, results: Mapping[str, Measured]) -> CheckResult:
        """Measure it."""
        result = results[self.run]
        values = result.values(self.measure, self.arguments, self.until)
        silence = result.silence(self.measure)
        if self.relative_to:
            other = results[self.relative_to]
            divisors = other.values(self.measure, self.arguments, self.until)
            with np.errstate(divide="ignore", invalid="ignore"):
                values = tuple(
                    float(np.divide(a, b)) for a, b in zip(values, divisors, strict=True)
                )
            silence = silence or other.silence(self.measure)
        if not silence and not result.may_end and np.isnan(values).all():
            silence = "the run ended before there was anything to measure"
        return CheckResult(self, values, result.over_seeds, silence)


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
    silence : str
        Why the values answer nothing; empty where they do.
    """

    check: Check
    values: tuple[float, ...]
    over_seeds: bool = False
    silence: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the check holds; None where it hangs on the last digits of the input."""
        if self.silence:
            return None
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

    @property
    def proportion(self) -> tuple[float, float]:
        """The interval of the share of draws that lie in it, at 95 %, Clopper and Pearson's."""
        from scipy.stats import binomtest  # a third of a second, paid only for many draws

        found = binomtest(self.inside, len(self.values)).proportion_ci(CONFIDENCE)
        return float(found.low), float(found.high)

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
            if self.over_seeds and self.check.statistic == "each":
                low, high = self.proportion
                value += f", a share between {low:.2f} and {high:.2f}"
        silence = f" (no answer: {self.silence})" if self.silence else ""
        return f"{name}{step}{ratio} ({self.check.run}): {value}{silence}"

    def _inside(self, value: float) -> bool:
        return self.check.at_least <= value <= self.check.at_most

    def _words(self, value: float) -> str:
        """Five digits, or as many more as it takes to stand on its side of the bounds."""
        for digits in range(5, 17):
            words = f"{value:.{digits}g}"
            if self._inside(float(words)) == self._inside(value):
                break
        return words


def quoted_interval(quoted: str, within: float | None) -> tuple[float, float]:
    """What a printed number stands for: half a unit of its last digit, or so much of itself."""
    try:
        value = Decimal(quoted)
        digits = value.as_tuple().exponent
    except ArithmeticError:
        digits = None
    if not isinstance(digits, int):
        raise InputError(f"quoted = {quoted!r} must be a number as the source prints it.")
    half = Decimal(5).scaleb(digits - 1)
    if within is not None:
        if not 0 < within < np.inf:
            raise InputError(f"within = {within} must be above 0: a share of the quoted number.")
        half = abs(value) * Decimal(repr(within))
    return float(value - half), float(value + half)
