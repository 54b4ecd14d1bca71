"""One estimator on one true system over its seeds, and what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import integer
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.estimation.measures import MEASURES, OF_ESTIMATES
from rcac_numeric.experiments.estimation.runs import EstimatedRun, Estimation
from rcac_numeric.experiments.estimation.true_systems import TrueSystem


@dataclass(frozen=True, eq=False)
class EstimationStudy(Value):
    """An estimator, its true system and its seeds; they determine every number.

    Attributes
    ----------
    name : str
    system : TrueSystem
    estimator : Estimation
    steps, seed, seeds : int
        Length, first seed, and how many seeds there are from it on.
    correction : str
        What this run reads differently from the source.
    """

    name: str
    system: TrueSystem
    estimator: Estimation
    steps: int
    seed: int = 0
    seeds: int = 1
    correction: str = ""

    def __post_init__(self) -> None:
        for name, least in (("steps", 1), ("seed", 0), ("seeds", 1)):
            integer(getattr(self, name), name, at_least=least)

    @property
    def course_end(self) -> float:
        """The true parameter at the last step."""
        return float(self.system.course(self.steps)[-1])

    def execute(self) -> StudyResult:
        """Run it for each seed."""
        seeds = range(self.seed, self.seed + self.seeds)
        return StudyResult(
            self, tuple(self.estimator.execute(self.system, self.steps, seed) for seed in seeds)
        )


@dataclass(frozen=True, eq=False)
class StudyResult(Value):
    """What a study produced, one run for each seed."""

    study: EstimationStudy
    repetitions: tuple[EstimatedRun, ...]

    @property
    def over_seeds(self) -> bool:
        """Whether its repetitions are other draws."""
        return self.study.seeds > 1

    def silence(self, measure: str) -> str:
        """Why it answers nothing: an estimate that never leaves where it began."""
        if measure not in OF_ESTIMATES:
            return ""
        still = all(np.ptp(run.estimate) == 0 for run in self.repetitions if len(run.estimate))
        return "the estimate never moves" if still else ""

    @property
    def may_end(self) -> bool:
        """That an estimator diverges is an answer."""
        return True

    def values(
        self, measure: str, arguments: Mapping[str, object], until: int | None = None
    ) -> tuple[float, ...]:
        """A measure of each run; NaN where a run diverged before what is measured."""
        if until is not None:
            raise InputError(f"until = {until} is for runs of loops; leave it out.")
        return tuple(_value(run, measure, arguments) for run in self.repetitions)


def _value(run: EstimatedRun, measure: str, arguments: Mapping[str, object]) -> float:
    try:
        return MEASURES[measure](run, **arguments)
    except InputError:
        if run.outcome == "completed":
            raise
        return float("nan")
