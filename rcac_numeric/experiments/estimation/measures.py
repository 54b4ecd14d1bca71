"""What claims of estimation examples measure: each a number of one run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.experiments.estimation.runs import EstimatedRun


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
    """Of RCMR: the share of the initial estimate that is left, 1 where the data say nothing."""
    return r.left


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
        raise InputError(f"no step of the run lies between start = {start} and stop = {stop}.")
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
