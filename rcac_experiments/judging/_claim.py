"""Claims about an experiment, their sources, and the verdicts of their checks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Annotated, Any, Literal, Protocol

import attrs
import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.format._parts import PartialCall
from rcac_experiments.format._values import Integer
from rcac_numeric.arrays._validation import number
from rcac_numeric.arrays._values import Value

# The outcomes of a claim on one completion of its source.
HOLDS, FAILS = "holds", "does not hold"
UNDETERMINED, NO_ANSWER = "undetermined", "no answer"
OUTCOMES = {
    HOLDS: "all of its checks hold",
    FAILS: "one of its checks fails on measured values",
    UNDETERMINED: "repetitions that differ only in their last digits disagree",
    NO_ANSWER: "not evaluated: the run ended, no coefficient adapted, or a measure is refused",
}

# The verdicts on a sentence of a source.
REPRODUCED, DEPENDS, NOT_REPRODUCED = "reproduced", "depends", "not reproduced"
MISPRINT = "misprint"
VERDICTS = {
    REPRODUCED: "the sentence holds for the settings of the source, and for every simulated value "
    "of "
    "the settings that it leaves open",
    DEPENDS: "the sentence holds for some values of the open settings and fails for others; the "
    "table "
    "lists them",
    NOT_REPRODUCED: "the sentence holds for none of the simulated values, although the same "
    "checks hold "
    "on a control run; the verdict applies to these runs, which may differ from those of the "
    "author",
    MISPRINT: "the sentence holds after the correction of an evident misprint, which is named",
    UNDETERMINED: "rounding or chance decides, or no value was measured",
}
RECORDS = (*dict.fromkeys((*VERDICTS, *OUTCOMES)),)

TEXT, READING, OURS = "the text", "a reading", "ours"
CLASSES = {
    TEXT: "a quoted sentence of the source",
    READING: "a quoted sentence that needs an interpretation; the favourable interpretation is "
    "given",
    OURS: "an additional check, without a verdict on the source",
}


class Measured(Protocol):
    """The results of a run that checks read."""

    @property
    def over_seeds(self) -> bool:
        """Whether the repetitions use different noise."""

    def missing_reason(self, measure: str) -> str:
        """The reason why a completed run has no value of a measure, or an empty text."""

    @property
    def may_end(self) -> bool:
        """Whether divergence is expected, so that missing values are a result."""

    def values(
        self, measure: str, arguments: Mapping[str, Any], until: int | None
    ) -> tuple[float, ...]:
        """Return a measure of each repetition; NaN if the run ended before the first value."""


class Answer(Protocol):
    """The result of a check."""

    @property
    def holds(self) -> bool | None:
        """Whether the check holds; None if undetermined."""

    @property
    def missing_reason(self) -> str:
        """The reason why the check was not evaluated, or an empty text."""


class AnyCheck(Protocol):
    """A check of a loop, of an estimator, or of something exact."""

    @property
    def runs(self) -> tuple[str, ...]:
        """The names of the required runs."""

    def evaluate(self, results: Mapping[str, Measured]) -> Answer:
        """Evaluate the check."""

    def moved(self, moves: Mapping[str, str]) -> AnyCheck:
        """Return the same check for other runs."""


@dataclass(frozen=True, eq=False)
class Refused(Value):
    """A check that was not evaluated, with its reason; it affects only its own claim."""

    check: AnyCheck
    missing_reason: str
    holds: bool | None = None

    def __str__(self) -> str:
        return f"not evaluated: {self.missing_reason}"


@attrs.frozen(eq=False)
class OpenItem(Value):
    """Something that the source leaves open."""

    what: Annotated[str, "Its name; claims refer to it."]
    chosen: Annotated[str, "What the runs have, in words."]
    reason: Annotated[str, "What the source says of it, and why this was chosen."] = ""
    values: Annotated[
        Sequence[Any],
        "The others of the set that a reader would try: each has a name and the tables that it "
        "changes, as a run has. They run with `rcac verify --completions`.",
    ] = ()

    @property
    def completions(self) -> tuple[str, ...]:
        """The names of its values."""
        return tuple(value.name for value in self.values)


QUOTE = (
    "The words of a source, and where they stand. A claim without them is your own: it has an "
    "outcome and no verdict."
)


@attrs.frozen(eq=False)
class Claim(Value):
    """A statement about the case."""

    text: Annotated[
        str, "What the checks decide, in words of your own; the quote where it is left out."
    ] = ""
    checks: Annotated[Sequence[AnyCheck], "What decides it: it holds where all of them do."] = ()
    quote: Annotated[str, QUOTE] = ""
    place: Annotated[str, QUOTE] = ""
    reading: Annotated[str, "How words that leave room are read."] = ""
    misprint: Annotated[
        str, "The slip of the print that is corrected for the checks to be the right ones."
    ] = ""
    completion: Annotated[str, "What was chosen where the source is silent."] = ""
    run: Annotated[
        str,
        "The run whose claim it is: checks that name none are of it. The main one where it is "
        "left out.",
    ] = ""
    reason: Annotated[
        str, "Where it does not hold, or depends on something: why, in a sentence."
    ] = ""
    recorded: Annotated[
        str, "The verdict of record; exit status 1 says that a run gave another."
    ] = ""
    verdicts: Annotated[
        Mapping[str, str] | None,
        "In place of run and verdict, for several variants of a claim of your own: from the name "
        "of each run to the outcome of record.",
    ] = None
    open: Annotated[
        Sequence[str],
        "The items of [[open]] that it is judged over, every combination of their values.",
    ] = ()
    over: Annotated[
        Mapping[str, str],
        "The map of record: from each outcome to the completions that have it, by the names of "
        'other runs and of the values of [[open]], several joined by "; ". "the rest" are all '
        "that are not named.",
    ] = attrs.field(factory=dict)
    control: Annotated[
        str, "A run on which the same checks must succeed; without that a failure shows nothing."
    ] = ""
    standard: Annotated[
        str,
        "In place of text and checks: the name of a claim that every case with a target model can "
        "make of a run that keeps theta at steps 10^3, 10^4 and 10^5.",
    ] = ""

    def __attrs_post_init__(self) -> None:
        text = self.text or self.quote or self.standard
        if bool(self.quote) != bool(self.place):
            raise InputError(f"the claim {text!r} needs quote and place, or neither.")
        for name in ("reading", "misprint"):
            if getattr(self, name) and not self.quote:
                raise InputError(f"the claim {text!r} has {name} without a quote.")
        allowed = VERDICTS if self.quote else OUTCOMES
        if self.recorded and self.recorded not in allowed:
            raise InputError(
                f"the claim {text!r} has verdict = {self.recorded!r}; one that "
                f"{'quotes' if self.quote else 'is our own, without a quote,'} has one of "
                f"{', '.join(allowed)}."
            )

    @property
    def owner(self) -> str:
        """A key of `CLASSES`."""
        return OURS if not self.quote else READING if self.reading else TEXT

    def moved(self, to: str) -> tuple[AnyCheck, ...]:
        """The checks of the claim, for another run in place of its own.

        Where that completes its own run, "run; value", those of other runs are of their
        completions by the same values.
        """
        runs = {run for check in self.checks for run in check.runs}
        suffix = to.removeprefix(f"{self.run}; ") if to.startswith(f"{self.run}; ") else ""
        moves = {run: f"{run}; {suffix}" for run in runs} if suffix else {self.run: to}
        return tuple(check.moved(moves) for check in self.checks)


@dataclass(frozen=True, eq=False)
class Verdict(Value):
    """A claim, its measured values and its verdict.

    Attributes
    ----------
    claim : Claim
    results : tuple
        The outcome on the run of the claim.
    others : mapping from names of completions
        The outcome on other runs; of those that did not run the outcome of record counts.
    control : tuple
        The outcome on the control run, where they must succeed.
    is_reduced : bool
        Whether fewer repetitions were made than the verdict of record has.
    """

    claim: Claim
    results: tuple[Answer, ...]
    others: Mapping[str, tuple[Answer, ...]] = field(default_factory=dict)
    control: tuple[Answer, ...] = ()
    is_reduced: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "others", dict(self.others))

    @property
    def outcome(self) -> str:
        """A key of `OUTCOMES`: the outcome on the run of the claim."""
        return outcome_of(self.results)

    @property
    def outcomes(self) -> dict[str, str]:
        """The outcome on each completion, the run of the claim first."""
        computed = {name: outcome_of(results) for name, results in self.others.items()}
        record = {name: outcome for name, outcome in self.claim.over.items() if outcome}
        return {self.claim.run: self.outcome, **record, **computed}

    @property
    def verdict(self) -> str:
        """A key of `VERDICTS`; the outcome for a claim without a quote."""
        if not self.claim.quote:
            return self.outcome
        verdicts = set(self.outcomes.values())
        if verdicts == {HOLDS}:
            return MISPRINT if self.claim.misprint else REPRODUCED
        if HOLDS in verdicts:
            return DEPENDS
        if self.control and outcome_of(self.control) != HOLDS:
            return UNDETERMINED  # a check that fails on the control run proves nothing
        return NOT_REPRODUCED if verdicts == {FAILS} else UNDETERMINED

    @property
    def words(self) -> str:
        """The verdict, and the open settings on which it depends."""
        on = f" on {', '.join(self.claim.open)}" if self.claim.open else ""
        return self.verdict + (on if self.verdict == DEPENDS else "")

    @property
    def has_changed(self) -> bool:
        """Whether the verdict, or an outcome of its map, differs from the one of record.

        Fewer repetitions than it was recorded with change no verdict.
        """
        if self.is_reduced or not self.claim.recorded:
            return False
        return self.claim.recorded != self.verdict or bool(self.changed_completions)

    @property
    def changed_completions(self) -> tuple[str, ...]:
        """The completions with an outcome that differs from the recorded one."""
        outcomes = self.outcomes
        return tuple(
            name for name, outcome in self.claim.over.items() if outcomes.get(name, "") != outcome
        )

    @property
    def measured(self) -> str:
        """The measured values in words."""
        return "; ".join(map(str, self.results))


def outcome_of(results: tuple[Answer, ...]) -> str:
    """Return the joint outcome of several checks, a key of `OUTCOMES`."""
    if any(result.holds is False and not result.missing_reason for result in results):
        return FAILS
    if any(result.missing_reason for result in results):
        return NO_ANSWER
    return HOLDS if all(result.holds for result in results) else UNDETERMINED


def judged(claim: Claim, results: Mapping[str, Measured], reduced: frozenset[str]) -> Verdict:
    """Return the verdict of a claim from the results of its runs."""

    def answers(checks: Sequence[AnyCheck]) -> Iterator[Answer]:
        for check in checks:
            try:
                yield check.evaluate(results)
            except CompensatorError as error:
                yield Refused(check, str(error))

    others = {name: tuple(answers(claim.moved(name))) for name in claim.over if name in results}
    control = tuple(answers(claim.moved(claim.control))) if claim.control else ()
    needed = {run for check in claim.checks for run in check.runs} | {claim.control, *others}
    words = tuple(answers(claim.checks))
    return Verdict(claim, words, others, control, is_reduced=bool(needed & reduced))


CONFIDENCE = 0.95


INTERVAL = "The interval; one of them is needed, or `quoted`."


@attrs.frozen(eq=False)
class Check(Value):
    """A measure of one run and the interval in which it must lie."""

    measure: Annotated[str, "What is measured."]
    run: Annotated[
        str, "Of which run; that of the claim, or the main one, where it is left out."
    ] = ""
    relative_to: Annotated[
        str, "Another run, whose measure it is divided by, repetition by repetition."
    ] = ""
    statistic: Annotated[
        Literal["each", "median"],
        "Whether every seed or repetition must lie in the interval, or the median.",
    ] = "each"
    share: Annotated[
        float, 'With "each": the least share of them that must lie in the interval.'
    ] = 1.0
    until: Annotated[
        int | None,
        Integer(1),
        "A step at which theta is kept: the run is cut off before it, so that its controller is "
        "the one that is then in force and its plant that of the step before.",
    ] = None
    at_least: Annotated[float | None, INTERVAL] = None
    at_most: Annotated[float | None, INTERVAL] = None
    quoted: Annotated[
        str,
        "In place of them: a number as the source prints it. The interval is half a unit of its "
        "last digit on both sides; where the measure has the key `value`, which is that number "
        "then, the measure may be as large as that half unit.",
    ] = ""
    within: Annotated[float | None, "With `quoted`: how far from it, as a share of it."] = None
    arguments: Mapping[str, Any] = attrs.field(factory=dict)

    def __attrs_post_init__(self) -> None:
        if isinstance(self.measure, PartialCall):  # as a file's table is read
            object.__setattr__(self, "arguments", self.measure.arguments)
            object.__setattr__(self, "measure", self.measure.make.__name__)
        if not 0 < number(self.share, "share") <= 1:
            raise InputError(f"share = {self.share} must be above 0 and at most 1.")
        if self.share < 1 and self.statistic != "each":
            raise InputError(f"share = {self.share} is for statistic = 'each'; leave it out.")
        low, high = self.interval
        if not (low > -np.inf or high < np.inf):
            raise InputError(
                f"the check of {self.measure!r} needs at_least, at_most or both: a check without "
                "a bound cannot fail."
            )
        if low > high:
            raise InputError(
                f"the check of {self.measure!r} requires at least {low} and at most {high}, which "
                "no number is."
            )

    @property
    def interval(self) -> tuple[float, float]:
        """The interval in which the measure must lie."""
        if not self.quoted:
            if self.within is not None:
                raise InputError(
                    f"within = {self.within} is a distance from quoted; give quoted too."
                )
            low = -np.inf if self.at_least is None else self.at_least
            return low, np.inf if self.at_most is None else self.at_most
        if self.at_least is not None or self.at_most is not None:
            raise InputError(
                f"quoted = {self.quoted!r} is the interval; leave at_least and at_most out."
            )
        low, high = quoted_interval(self.quoted, self.within)
        value = self.arguments.get("value")
        if value is None:
            return low, high
        if value != float(self.quoted):
            raise InputError(f"value = {value} is not the quoted {self.quoted}.")
        return -np.inf, (high - low) / 2

    @property
    def runs(self) -> tuple[str, ...]:
        """The names of the required runs."""
        return tuple(name for name in (self.run, self.relative_to) if name)

    def moved(self, moves: Mapping[str, str]) -> Check:
        """Return the same check for other runs."""
        other = moves.get(self.relative_to, self.relative_to) if self.relative_to else ""
        return attrs.evolve(self, run=moves.get(self.run, self.run), relative_to=other)

    def evaluate(self, results: Mapping[str, Measured]) -> CheckResult:
        """Measure it."""
        result = results[self.run]
        values = result.values(self.measure, self.arguments, self.until)
        reason = result.missing_reason(self.measure)
        if self.relative_to:
            other = results[self.relative_to]
            divisors = other.values(self.measure, self.arguments, self.until)
            with np.errstate(divide="ignore", invalid="ignore"):
                values = tuple(
                    float(np.divide(a, b)) for a, b in zip(values, divisors, strict=True)
                )
            reason = reason or other.missing_reason(self.measure)
        if not reason and not result.may_end and np.isnan(values).all():
            reason = "the run ended before the first value"
        return CheckResult(self, values, result.over_seeds, reason)


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
    missing_reason : str
        Why the values answer nothing; empty where they do.
    """

    check: Check
    values: tuple[float, ...]
    over_seeds: bool = False
    missing_reason: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the check holds; None where it hangs on the last digits of the input."""
        if self.missing_reason:
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

        interval = binomtest(self.inside, len(self.values)).proportion_ci(CONFIDENCE)
        return float(interval.low), float(interval.high)

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
        reason = f" (not evaluated: {self.missing_reason})" if self.missing_reason else ""
        return f"{name}{step}{ratio} ({self.check.run}): {value}{reason}"

    def _inside(self, value: float) -> bool:
        low, high = self.check.interval
        return low <= value <= high

    def _words(self, value: float) -> str:
        """Five digits, or as many more as it takes to stand on its side of the bounds."""
        for digits in range(5, 17):
            words = f"{value:.{digits}g}"
            if self._inside(float(words)) == self._inside(value):
                break
        return words


def quoted_interval(quoted: str, within: float | None) -> tuple[float, float]:
    """The interval of a printed number: half a unit of its last digit, or a fraction."""
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
