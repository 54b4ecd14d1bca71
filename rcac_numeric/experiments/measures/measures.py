"""The quantities that claims are checked by: a run in, a number out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.analysis.closed_loop import frozen_loop
from rcac_numeric.arrays.validation import integer
from rcac_numeric.experiments.measures import (
    cost_measures,
    margin_measures,
    match_measures,
    plant_measures,
    signal_measures,
)
from rcac_numeric.experiments.measures.loop_analysis import LoopAnalysis

Measure = Callable[..., float]
MEASURES: dict[str, Measure] = {}


def measure(function: Measure) -> Measure:
    """Make a function available to claims under its own name."""
    MEASURES[function.__name__] = function
    return function


for _function in (
    *cost_measures.COST_MEASURES,
    *signal_measures.SIGNAL_MEASURES,
    *margin_measures.MARGIN_MEASURES,
    *match_measures.MATCH_MEASURES,
    *plant_measures.PLANT_MEASURES,
):
    measure(_function)


# What is so of a plant, whatever the controller does.
OF_PLANT = frozenset(
    function.__name__
    for function in (
        *plant_measures.PLANT_MEASURES,
        cost_measures.high_authority_cost,
        cost_measures.high_authority_exists,
        cost_measures.high_authority_pole_distance,
    )
)


@measure
def worst_pole_distance(r: LoopAnalysis) -> float:
    """Largest distance between a pole of G_f and the closed-loop pole assigned to it."""
    return r.comparison.worst_distance


@measure
def worst_spectrum_distance(r: LoopAnalysis) -> float:
    """The same over all poles, those too that G_f leaves to the zeros of G_zu and to zero."""
    return r.comparison.spectrum_distance


@measure
def polynomial_distance(r: LoopAnalysis) -> float:
    """Largest difference between a closed-loop coefficient, reached and asked for, both exact."""
    c = r.comparison
    if c.asked is None:
        raise InputError(f"there is no characteristic polynomial to compare with: {c.obstacle}")
    return float(max(map(abs, (c.reached - c.asked).all_coeffs())))


@measure
def spectral_radius(r: LoopAnalysis) -> float:
    """Largest modulus of a closed-loop pole with the final controller."""
    return r.loop.spectral_radius


@measure
def controller_spectral_radius(r: LoopAnalysis) -> float:
    """Largest modulus of a pole of the final controller."""
    return float(np.abs(r.run.compensator.poles()).max())


@measure
def controller_pole_distance(r: LoopAnalysis, omega: float = 0.0, k: int | None = None) -> float:
    """Distance from exp(j omega) to the nearest controller pole, at step k or at the end.

    Parameters
    ----------
    omega : float
        A frequency in rad/sample.
    k : int, optional
        A step; theta(k) must have been kept.
    """
    compensator = r.run.compensator if k is None else r.run.compensator_at(k)
    return float(np.abs(compensator.poles() - np.exp(1j * omega)).min())


@measure
def completed(r: LoopAnalysis) -> float:
    """1 where the run reached its last step, 0 where it diverged or failed before."""
    return float(r.run.outcome == "completed")


@measure
def steps(r: LoopAnalysis) -> float:
    """Number of completed steps."""
    return float(r.run.steps)


@measure
def coefficient(r: LoopAnalysis, index: int, k: int | None = None) -> float:
    """One entry of theta, from 0 on: of theta(k), or of the last theta.

    For structure = "pid" the entries are the gains in the order of the terms.

    Parameters
    ----------
    index : int
        Which entry, from 0 on.
    """
    run = r.run
    if k is None:
        theta = run.theta_final
    else:
        row, rest = divmod(integer(k, "k"), run.stride)
        if rest or row >= len(run.theta):
            raise InputError(
                f"theta({k}) was not kept; it is kept at multiples of {run.stride} below "
                f"{run.steps}."
            )
        theta = run.theta[row]
    return float(theta[integer(index, "index", at_most=len(theta) - 1)])


@measure
def updates_at_bounds(r: LoopAnalysis) -> float:
    """Updates after which theta was moved to its bounds."""
    return float(r.run.bounded)


@measure
def reflections(r: LoopAnalysis) -> float:
    """Number of updates after which controller poles were reflected (6.2.2)."""
    return float(r.run.reflections)


@measure
def resets(r: LoopAnalysis) -> float:
    """Number of covariance resets."""
    return float(r.run.resets)


@measure
def unstable_fraction(r: LoopAnalysis, stop: int | None = None) -> float:
    """Fraction of the steps below `stop` at which the loop, frozen at theta(k), is unstable."""
    return float(np.mean(_unstable(r, stop)))


@measure
def last_unstable_step(r: LoopAnalysis) -> float:
    """Last step at which the loop, frozen at theta(k), is unstable; -1 if there is none."""
    steps = np.flatnonzero(_unstable(r, None))
    return float(steps[-1] * r.run.stride) if steps.size else -1.0


@measure
def first_unstable_controller(r: LoopAnalysis) -> float:
    """First step at which theta(k) describes an unstable controller; -1 if there is none."""
    run = r.run
    for row, theta in enumerate(run.theta):
        if np.abs(run.settings.compensator_of(theta).poles()).max() > 1:
            return float(row * run.stride)
    return -1.0


@measure
def theta_drift(r: LoopAnalysis, start: int) -> float:
    """Largest change of a controller coefficient after step `start`, relative to the largest."""
    late = r.run.theta[-(-start // r.run.stride) :]
    return float(np.abs(late - r.run.theta_final).max() / np.abs(r.run.theta_final).max())


@measure
def closed_loop_zero_distance(r: LoopAnalysis, channel: str, omega: float = 0.0) -> float:
    """Distance from exp(j omega) to the nearest closed-loop zero from a channel of w to z."""
    zeros = r.zeros
    if channel not in zeros:
        raise InputError(f"w has no channel {channel!r}; the channels are {', '.join(zeros)}.")
    return float(np.abs(zeros[channel] - np.exp(1j * omega)).min())


@measure
def guard_count(r: LoopAnalysis) -> float:
    """Number of updates that rounding decided."""
    return float(r.run.guard_count)


def _unstable(r: LoopAnalysis, stop: int | None) -> np.ndarray:
    run = r.run
    rows = run.theta if stop is None else run.theta[: -(-stop // run.stride)]
    return np.array(
        [
            not frozen_loop(
                run.plant, run.settings.compensator_of(theta), row * run.stride
            ).is_stable
            for row, theta in enumerate(rows)
        ]
    )
