"""One estimator on one true system over its seeds: results, and measures for claims."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_experiments.experiments._true_systems import TrueSystem
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer
from rcac_numeric.arrays._values import Value


@dataclass(frozen=True, eq=False)
class EstimatedRun(Value):
    """An estimate over the steps of one seed.

    Attributes
    ----------
    estimate, truth : arrays, shape (steps,)
    z : array, shape (steps, l_z)
        C x^ - y of RCMR, the innovation of a filter, r - C_r x of a loop.
    left : float
        Of RCMR: the share of the initial estimate that is left in theta at the end, 1 where the
        data say nothing, 0 where they say all.
    outcome : {"completed", "diverged"}
        A run that diverged holds what came before.
    """

    estimate: Array
    truth: Array
    z: Array
    initial_share: float = math.nan
    outcome: str = "completed"


class Estimation(Value, ABC):
    """An estimator with its settings, as an experiment has it."""

    @property
    @abstractmethod
    def words(self) -> str:
        """The kind, in a word or two."""

    @abstractmethod
    def execute(self, system: TrueSystem, steps: int, seed: int) -> EstimatedRun:
        """Estimate with the record, or in the loop, of one seed."""


def mean_error(r: EstimatedRun, start: int = 0, stop: int | None = None) -> float:
    """Mean absolute error of the estimate.

    Parameters
    ----------
    start, stop : int
        First step that counts, and the first that does not count any more.
    """
    return float(np.abs(_error(r, start, stop)).mean())


def median_error(r: EstimatedRun, start: int = 0, stop: int | None = None) -> float:
    """Median absolute error of the estimate."""
    return float(np.median(np.abs(_error(r, start, stop))))


def mean_deviation(r: EstimatedRun, start: int = 0, stop: int | None = None) -> float:
    """Mean of estimate - truth, with its sign: negative where the estimate lags behind."""
    return float(_error(r, start, stop).mean())


def final_estimate(r: EstimatedRun) -> float:
    """The estimate at the last step."""
    return float(r.estimate[-1])


def initial_estimate_left(r: EstimatedRun) -> float:
    """The remaining share of the initial estimate of RCMR, 1 without information in the data."""
    return r.initial_share


def largest_z(r: EstimatedRun, start: int = 0, stop: int | None = None) -> float:
    """Largest absolute z: of a loop the error of the command following, else that of the output."""
    return float(np.abs(r.z[_window(r, start, stop)]).max())


def completed(r: EstimatedRun) -> float:
    """1 where the run reached its last step, 0 where it diverged before."""
    return float(r.outcome == "completed")


def _error(r: EstimatedRun, start: int, stop: int | None) -> Array:
    window = _window(r, start, stop)
    return np.asarray(r.estimate[window] - r.truth[window])


def _window(r: EstimatedRun, start: int, stop: int | None) -> slice:
    end = len(r.estimate) if stop is None else min(stop, len(r.estimate))
    if start >= end:
        raise InputError(f"the run has no step between start = {start} and stop = {stop}.")
    return slice(start, end)


OF_ESTIMATES = ("mean_error", "median_error", "mean_deviation", "final_estimate")
MEASURES: dict[str, Callable[..., float]] = {
    function.__name__: function
    for function in (
        mean_error,
        median_error,
        mean_deviation,
        final_estimate,
        initial_estimate_left,
        largest_z,
        completed,
    )
}


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
        The differences of this run from the source.
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
    def final_parameter(self) -> float:
        """The true parameter at the last step."""
        return float(self.system.parameter_trajectory(self.steps)[-1])

    def execute(self) -> StudyResult:
        """Run the estimator for each seed."""
        seeds = range(self.seed, self.seed + self.seeds)
        return StudyResult(
            self, tuple(self.estimator.execute(self.system, self.steps, seed) for seed in seeds)
        )


@dataclass(frozen=True, eq=False)
class StudyResult(Value):
    """The results of a study, one run for each seed."""

    study: EstimationStudy
    repetitions: tuple[EstimatedRun, ...]

    @property
    def over_seeds(self) -> bool:
        """Whether the repetitions use different noise."""
        return self.study.seeds > 1

    def missing_reason(self, measure: str) -> str:
        """The reason why a measure has no value: the estimate never changed."""
        if measure not in OF_ESTIMATES:
            return ""
        still = all(np.ptp(run.estimate) == 0 for run in self.repetitions if len(run.estimate))
        return "the estimate never moves" if still else ""

    @property
    def may_end(self) -> bool:
        """True: divergence of an estimator is a result."""
        return True

    def values(
        self, measure: str, arguments: Mapping[str, object], until: int | None = None
    ) -> tuple[float, ...]:
        """Return a measure of each run; NaN if the run diverged before the measured steps."""
        if until is not None:
            raise InputError(f"until = {until} applies to runs of loops; remove until.")
        return tuple(_value(run, measure, arguments) for run in self.repetitions)


def _value(run: EstimatedRun, measure: str, arguments: Mapping[str, object]) -> float:
    try:
        return MEASURES[measure](run, **arguments)
    except InputError:
        if run.outcome == "completed":
            raise
        return float("nan")
