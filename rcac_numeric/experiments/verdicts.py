"""From claims and runs to verdicts: computed, never typed in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.experiments.analysed_run import AnalysedRun
from rcac_numeric.experiments.experiment import Check, Claim, Experiment, RunResult
from rcac_numeric.experiments.measures import MEASURES

REPRODUCED = "reproduced"
CORRECTED = "reproduced with a correction"
NOT_REPRODUCED = "not reproduced"
ILL_POSED = "ill-posed"
VERDICTS = (REPRODUCED, CORRECTED, NOT_REPRODUCED, ILL_POSED)


@dataclass(frozen=True, eq=False)
class CheckResult:
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
class Verdict:
    """A claim, what was measured, and whether it holds."""

    claim: Claim
    results: tuple[CheckResult, ...]

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


@dataclass(frozen=True, eq=False)
class Verification:
    """An experiment after its runs: results and verdicts.

    Examples
    --------
    >>> from rcac_numeric import load_example, verify
    >>> verification = verify(load_example("4.7"))
    >>> [v.verdict for v in verification.verdicts][0]
    'reproduced'
    >>> verification.main.first.comparison.worst_distance < 1e-5
    True
    """

    experiment: Experiment
    results: Mapping[str, RunResult]
    verdicts: tuple[Verdict, ...]

    @property
    def main(self) -> RunResult:
        """The result of the experiment's main run."""
        return next(iter(self.results.values()))

    @property
    def diverged(self) -> list[str]:
        """Names of the runs that diverged."""
        return [name for name, result in self.results.items() if result.diverged]

    @property
    def surprising(self) -> list[str]:
        """Names of the runs that did not end as their specification says."""
        return [name for name, result in self.results.items() if not result.as_expected]

    @property
    def exit_status(self) -> int:
        """0: done; 1: a verdict of record has changed; 3: a loop diverged unexpectedly.

        3 goes before 1. A run that was expected to diverge and did not is a changed verdict, 1.
        """
        if any(self.results[name].diverged for name in self.surprising):
            return 3
        return 1 if self.surprising or any(v.has_changed for v in self.verdicts) else 0


def verify(
    experiment: Experiment, progress: Callable[[str], None] = lambda name: None
) -> Verification:
    """Run every run of an experiment and judge every claim.

    Parameters
    ----------
    experiment : Experiment
        From `load_example` or `load_experiment`.
    progress : callable
        Called with the name of each run before it starts.

    Raises
    ------
    InputError
        Where a claim names a measure or a run that does not exist.

    Examples
    --------
    >>> from rcac_numeric import load_example, verify
    >>> verify(load_example("2.2")).exit_status
    0
    """
    for claim in experiment.claims:
        for check in claim.checks:
            _known(check, experiment)
    results = {}
    for name, specification in experiment.runs.items():
        progress(name)
        results[name] = specification.execute()
    verdicts = tuple(
        Verdict(claim, tuple(_evaluate(check, results) for check in claim.checks))
        for claim in experiment.claims
    )
    return Verification(experiment, results, verdicts)


def _evaluate(check: Check, results: Mapping[str, RunResult]) -> CheckResult:
    values = _values(check, results[check.run])
    if check.relative_to:
        others = _values(check, results[check.relative_to])
        with np.errstate(divide="ignore", invalid="ignore"):
            values = tuple(float(np.divide(a, b)) for a, b in zip(values, others, strict=True))
    return CheckResult(check, values)


def _values(check: Check, result: RunResult) -> tuple[float, ...]:
    def value(repetition: AnalysedRun) -> float:
        try:
            return MEASURES[check.measure](repetition, **check.arguments)
        except CompensatorError:
            if repetition.run.outcome != "completed":
                return float("nan")  # nothing to measure at the end; the check fails
            raise
        except TypeError as error:
            raise InputError(f"the check {check.measure!r} of a claim: {error}.") from None

    return tuple(value(repetition) for repetition in result.repetitions)


def _known(check: Check, experiment: Experiment) -> None:
    if check.measure not in MEASURES:
        raise InputError(
            f"a claim asks for the measure {check.measure!r}; known are {', '.join(MEASURES)}."
        )
    for name in (check.run, check.relative_to):
        if name and name not in experiment.runs:
            raise InputError(
                f"a claim refers to the run {name!r}; the runs are {', '.join(experiment.runs)}."
            )
