"""The nearest boundary of stability for a change of gain, phase or delay, shown by the poles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array, ComplexArray
from rcac_numeric.arrays.values import Value
from rcac_numeric.margins.opened_loop import OpenedLoop

# The perturbed loops beside a boundary are this share of the margin away from it.
BESIDE = 1e-3
# Further out than any gain a crossover asks for, to look for a loss of stability without one.
FAR = 1e6
# Gains beyond this, or below its inverse, count as infinite, or as 0.
MOST_GAIN = 1e100
# Open-loop poles this close are taken as one multiple pole.
CLUSTER = 1e-4
# Whole steps of delay that are tried where no crossover can tell.
MOST_STEPS = 500


@dataclass(frozen=True, eq=False)
class StabilityBoundary(Value):
    """Where a one-parameter change of the loop first puts a pole on the unit circle.

    Attributes
    ----------
    value : float
        A factor, degrees, or steps; infinite, or 0 for a decreasing gain, where there is none.
    omega : float
        The frequency of that pole, rad/sample; NaN where there is none.
    radius_before, radius_at, radius_after : float
        Pole radius a thousandth of the margin before it, at it, and after it: the spectral radius
        for gain and phase, for a delay the modulus of the one pole that crosses. A pole that
        only touches the circle leaves radius_after below 1. NaN where there is no boundary.
    jumps : bool
        Only for a delay: the loop is stable one whole step before and unstable at `value`, with
        no pole on the circle in between; the radii are then those of these two loops.
    """

    value: float
    omega: float
    radius_before: float
    radius_at: float
    radius_after: float
    jumps: bool = False

    @property
    def is_reached(self) -> bool:
        """Whether there is a boundary at all."""
        return bool(np.isfinite(self.omega))


def nowhere(value: float) -> StabilityBoundary:
    """No boundary in this direction."""
    return StabilityBoundary(value, np.nan, np.nan, np.nan, np.nan)


def gain_boundary(loop: OpenedLoop, crossovers: Array, *, up: bool) -> StabilityBoundary:
    """The nearest factor above (or below) 1 at which the loop stops being stable.

    A crossover of L = -1/k puts a pole on the circle at the gain k. Should a loop be unstable
    between two gains without one, a crossing was lost to rounding, and bisection on the poles
    finds it.
    """
    values = loop.response(crossovers).real
    with np.errstate(over="ignore"):  # beyond float64 is no boundary
        inverses = -1.0 / values
    at_a_pole = _at_open_poles(loop, crossovers)  # the crossing is at the gain 0, not above it
    gains = [
        (float(v), float(w))
        for v, w, hidden in zip(inverses, crossovers, at_a_pole, strict=True)
        if not hidden
    ]
    low, high = (1.0, MOST_GAIN) if up else (1 / MOST_GAIN, 1.0)
    pairs = sorted(((k, w) for k, w in gains if low < k < high), reverse=not up)
    direct = loop.D[0, 0]
    if not len(loop.A) and direct and (-1 / direct > 1) == up and direct < 0:
        k = -1 / direct  # a constant loop: 1 + k D = 0, not well posed
        return StabilityBoundary(k, 0.0, 0.0, 1.0, 0.0)
    previous = 1.0
    for i, (k, omega) in enumerate(pairs):
        inside = np.sqrt(previous * k)
        if loop.radius(inside) >= 1:
            return _bisected(loop, previous, inside)
        following = pairs[i + 1][0] if i + 1 < len(pairs) else (2 * k if up else k / 2)
        beside = (k - 1) * BESIDE
        after = k + (beside if abs(beside) < abs(following - k) / 2 else (following - k) / 2)
        found = StabilityBoundary(
            k, omega, loop.radius(k - beside), loop.radius(k), loop.radius(after)
        )
        touches = abs(found.radius_at - 1) <= 1e-9
        if found.radius_after >= 1 or touches:
            return found
        previous = k  # a crossing that rounding made up
    end = previous * FAR if up else 0.0
    if loop.radius(end) > 1 if up else np.abs(_open_poles(loop)[0]).max(initial=0.0) > 1 + 1e-10:
        return _bisected(loop, previous, end)
    return nowhere(np.inf if up else 0.0)


def _open_poles(loop: OpenedLoop) -> tuple[ComplexArray, Array]:
    """The open-loop poles, multiple ones at the mean of their cluster, and how well each is known.

    Rounding moves each of d equal poles by the d-th root of itself, their mean by itself only.
    """
    poles = loop.open_poles
    close = np.abs(poles[:, None] - poles) < CLUSTER
    means = np.array([poles[row].mean() for row in close], poles.dtype)
    multiplicity = np.maximum(close.sum(axis=1), 1)
    return means, 1e-12 + 10 * np.finfo(float).eps ** (1 / multiplicity) * (multiplicity > 1)


def _at_open_poles(loop: OpenedLoop, omega: Array) -> Array:
    """Which points of the circle rounding cannot tell from an open-loop pole on it."""
    means, known = _open_poles(loop)
    on_it = np.abs(np.abs(means) - 1) < 1e-10
    distances = np.abs(np.exp(1j * omega)[:, None] - means[on_it])
    return np.asarray(np.any(distances <= known[on_it], axis=1))


def _bisected(loop: OpenedLoop, inside: float, outside: float) -> StabilityBoundary:
    from scipy.optimize import brentq

    k = brentq(lambda g: loop.radius(g) - 1, inside, outside, xtol=1e-300, rtol=1e-15)
    poles = loop.closed_poles(k)
    omega = abs(np.angle(poles[np.argmax(np.abs(poles))]))
    beside = (k - 1) * BESIDE
    return StabilityBoundary(
        k, omega, loop.radius(k - beside), loop.radius(k), loop.radius(k + beside)
    )


def lag_at(loop: OpenedLoop, omega: Array) -> Array:
    """The lag in [0, 2 pi) that turns L to the negative real axis: Table 5.1's PM, in radians."""
    return np.asarray(np.mod(np.pi + np.angle(loop.response(omega)), 2 * np.pi))


def phase_boundary(loop: OpenedLoop, crossovers: Array, *, lead: bool) -> StabilityBoundary:
    """The least turn of L that puts a pole on the unit circle, in degrees."""
    if not len(crossovers):
        return nowhere(np.inf)
    lags = lag_at(loop, crossovers)
    turns = 2 * np.pi - lags if lead else lags
    i = int(np.argmin(turns))
    turn, omega = float(turns[i]), float(crossovers[i])
    other = lags if lead else 2 * np.pi - lags

    def radius(angle: float) -> float:
        # A complex gain turns the frequencies below zero the other way. What it does to the
        # spectral radius is about this boundary only as long as it is the nearer of lag and lead.
        gain = np.exp((1j if lead else -1j) * angle)
        if turn <= other.min():
            return loop.radius(gain)
        return _nearest(loop.closed_poles(gain), np.exp(1j * omega))

    beside = turn * BESIDE
    degrees = float(np.degrees(turn))
    return StabilityBoundary(
        degrees, omega, radius(turn - beside), radius(turn), radius(turn + beside)
    )


def _nearest(poles: ComplexArray, point: complex) -> float:
    return float(np.abs(poles[np.argmin(np.abs(poles - point))]))


def delay_boundary(loop: OpenedLoop, crossovers: Array) -> StabilityBoundary:
    """The least additional delay that makes the loop unstable, in steps.

    At omega = 0 a delay turns nothing; at pi one step turns half a circle.

    Where abs(L(-1)) > 1, a delay between two whole numbers of steps has no meaning of its own:
    e^{-j omega delay} does not close at omega = pi, and poles pass through that gap. There the
    loop's poles with 1, 2, 3, ... whole steps decide, and a crossover counts only if it lies in
    the step in which stability is lost.
    """
    moving = crossovers[crossovers > 0]
    if abs(loop.response(np.pi)[0]) <= 1:
        if not len(moving):
            return nowhere(np.inf)
        delays = lag_at(loop, moving) / moving
        i = int(np.argmin(delays))
        return _crossing(loop, float(delays[i]), float(moving[i]))
    steps, before = 1, loop.radius()
    while (radius := loop.delayed(steps).radius()) < 1:
        steps, before = steps + 1, radius
        if steps > MOST_STEPS:
            raise InputError(
                f"abs(L(-1)) > 1 and the loop is still stable with {MOST_STEPS} steps of delay; "
                "no larger delay is tried."
            )
    turns = np.arange(steps + 1) * 2 * np.pi
    delays = (lag_at(loop, moving)[:, None] + turns) / moving[:, None]
    in_that_step = np.argwhere((delays > steps - 1) & (delays <= steps))
    for delay, omega in sorted((delays[i, j], moving[i]) for i, j in in_that_step):
        found = _crossing(loop, float(delay), float(omega))
        if found.radius_before < 1:
            return found
    poles = loop.delayed(steps).closed_poles()
    omega = abs(float(np.angle(poles[np.argmax(np.abs(poles))])))
    return StabilityBoundary(float(steps), omega, before, radius, radius, jumps=True)


def _crossing(loop: OpenedLoop, steps: float, omega: float) -> StabilityBoundary:
    beside = steps * BESIDE
    before, at, after = (
        _followed(loop, delay, omega) for delay in (steps - beside, steps, steps + beside)
    )
    return StabilityBoundary(steps, omega, before, at, after)


def _followed(loop: OpenedLoop, delay: float, omega: float) -> float:
    """The modulus of the root of 1 + L(z) z^{-delay} = 0 near e^{j omega}, by Newton's method.

    The power is continued from the circle: z^{-delay} = exp(-delay log z) with the branch of log
    that is j omega there, so that a delay that is no whole number of steps has a meaning.
    """
    log_z = 1j * omega
    for _ in range(50):
        z = np.array([np.exp(log_z)])
        L, slope = loop.at(z)[0], loop.slope(z)[0]
        # f = log(-L) - delay log z, zero modulo 2 pi j
        value = np.log(-L * np.exp(-delay * log_z))
        step = value / (slope * z[0] / L - delay)
        log_z -= step
        if abs(step) < 1e-15:
            break
    return float(np.exp(np.real(log_z)))
