"""The quantities that claims are checked by: a run in, a number out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.closed_loop import ClosedLoop
from rcac_numeric.experiment import Repetition

Measure = Callable[..., float]
MEASURES: dict[str, Measure] = {}


def measure(function: Measure) -> Measure:
    """Make a function available to claims under its own name."""
    MEASURES[function.__name__] = function
    return function


@measure
def worst_pole_distance(r: Repetition) -> float:
    """Largest distance between a pole of G_f and the closed-loop pole assigned to it."""
    return r.comparison.worst_distance


@measure
def worst_spectrum_distance(r: Repetition) -> float:
    """The same over all poles, those too that G_f leaves to the zeros of G_zu and to zero."""
    return r.comparison.spectrum_distance


@measure
def worst_match(r: Repetition) -> float:
    """Largest relative distance of the intercalated transfer function to G_f over frequency."""
    return r.match.worst


@measure
def spectral_radius(r: Repetition) -> float:
    """Largest modulus of a closed-loop pole with the final controller."""
    return r.loop.spectral_radius


@measure
def controller_spectral_radius(r: Repetition) -> float:
    """Largest modulus of a pole of the final controller."""
    return float(np.abs(r.run.compensator.poles()).max())


@measure
def controller_pole_distance(r: Repetition, omega: float = 0.0, k: int | None = None) -> float:
    """Distance from exp(j omega) to the nearest controller pole, at step k or at the end."""
    compensator = r.run.compensator if k is None else r.run.compensator_at(k)
    return float(np.abs(compensator.poles() - np.exp(1j * omega)).min())


@measure
def settling_step(r: Repetition, band: float = 0.02) -> float:
    """First step from which the size of z stays within the band to the end of the run."""
    outside = np.flatnonzero(np.abs(r.run.z).max(axis=1) > band)
    return float(outside[-1] + 1) if outside.size else 0.0


@measure
def peak(r: Repetition, start: int = 0, stop: int | None = None) -> float:
    """Largest size of z over start <= k < stop."""
    return float(np.abs(_window(r, start, stop)).max())


@measure
def rms(r: Repetition, start: int = 0, stop: int | None = None) -> float:
    """Root mean square of z over start <= k < stop."""
    return float(np.sqrt(np.mean(np.sum(_window(r, start, stop) ** 2, axis=1))))


@measure
def unstable_fraction(r: Repetition, stop: int | None = None) -> float:
    """Fraction of the steps below `stop` at which the loop, frozen at theta(k), is unstable."""
    return float(np.mean(_unstable(r, stop)))


@measure
def last_unstable_step(r: Repetition) -> float:
    """Last step at which the loop, frozen at theta(k), is unstable; -1 if there is none."""
    steps = np.flatnonzero(_unstable(r, None))
    return float(steps[-1] * r.run.stride) if steps.size else -1.0


@measure
def first_unstable_controller(r: Repetition) -> float:
    """First step at which theta(k) describes an unstable controller; -1 if there is none."""
    run = r.run
    for row, theta in enumerate(run.theta):
        if np.abs(run.settings.compensator(theta).poles()).max() > 1:
            return float(row * run.stride)
    return -1.0


@measure
def theta_drift(r: Repetition, start: int) -> float:
    """Largest change of a controller coefficient after step `start`, relative to the largest."""
    late = r.run.theta[-(-start // r.run.stride) :]
    return float(np.abs(late - r.run.theta_final).max() / np.abs(r.run.theta_final).max())


@measure
def closed_loop_zero_distance(r: Repetition, channel: str, omega: float = 0.0) -> float:
    """Distance from exp(j omega) to the nearest closed-loop zero from a channel of w."""
    zeros = r.comparison.zeros
    if channel not in zeros:
        raise InputError(f"w has no channel {channel!r}; the channels are {', '.join(zeros)}.")
    return float(np.abs(zeros[channel] - np.exp(1j * omega)).min())


@measure
def guard_count(r: Repetition) -> float:
    """Number of updates that rounding decided."""
    return float(r.run.guard_count)


def _window(r: Repetition, start: int, stop: int | None) -> np.ndarray:
    window = r.run.z[start:stop]
    if not len(window):
        raise InputError(f"the run of {r.run.steps} steps has no step in [{start}, {stop}).")
    return window


def _unstable(r: Repetition, stop: int | None) -> np.ndarray:
    run = r.run
    rows = run.theta if stop is None else run.theta[: -(-stop // run.stride)]
    settings, plant = run.settings, run.plant
    return np.array(
        [not ClosedLoop(plant, settings.compensator(theta)).is_stable for theta in rows]
    )
