"""Stability boundaries of a loop under changes of gain, phase or delay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from compensator_theory.errors import InputError
from rcac_numeric.analysis._opened_loop import OpenedLoop
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._values import Result

# A root this close to the real axis may be a double root split by rounding.
SPLIT = 1e-6
# A function of points on the circle that is zero at a crossover, with its slope over omega.
Gap = Callable[[ComplexArray], tuple[Array, Array]]
# The value of a gap from that of L, without its slope.
ValueOf = Callable[[ComplexArray], Array]
# Tolerances of a crossover relative to the size of L: the first for a well conditioned L; next to
# a multiple pole the rounding of L, at most the second.
REACHED, REACHED_AT_WORST = 1e-8, 1e-3
# Distances from 0 and from pi at which signs are compared: cos omega is flat there, and of a loop
# that is sampled fast, all of whose poles are near 1, its polynomial keeps no correct digit.
FROM_THE_ENDS = np.geomspace(1e-13, 0.5, 128)
# The same about every pole, in widths of its resonance.
ABOUT_A_POLE = np.array([-10.0, -3.0, -1.0, -0.3, 0.0, 0.3, 1.0, 3.0, 10.0])


def gain_crossovers(loop: OpenedLoop) -> Array:
    """Return all omega in [0, pi] with abs(L(e^{j omega})) = 1, ascending, rad/sample.

    With L = N / D, abs(N)^2 - abs(D)^2 on the unit circle is a polynomial of degree n in
    x = cos omega. Its coefficients in Chebyshev polynomials come from n + 1 values, and its real
    roots in [-1, 1] from a colleague matrix. Next to the ends and to the poles, where rounding may
    hide a root of it, changes of sign of log abs(L) are candidates too. Each is then polished on L
    itself.
    """
    n = len(loop.A)
    omega, N, D = _on_the_circle(loop, n + 1)
    excess = np.abs(N) ** 2 - np.abs(D) ** 2
    sizes = np.abs(N) ** 2 + np.abs(D) ** 2
    if np.all(np.abs(excess) <= 1e-12 * sizes):
        raise InputError(
            "abs(L) = 1 at every frequency, so that every frequency is a gain crossover and phase "
            "and delay have no single margin. Change the gain of the loop a little, or use "
            "compensator_theory.stability_margins, which returns is_all_pass."
        )
    frequencies = _frequencies(excess, omega)

    def gap(z: ComplexArray) -> tuple[Array, Array]:
        L = loop.at(z)
        # log abs(L) and its slope along the circle, whatever the size of L nearby
        return np.log(np.abs(L)), np.real(loop.slope(z) / L * 1j * z)

    return _crossovers(loop, frequencies, gap, lambda L: np.log(np.abs(L)))


def phase_crossovers(loop: OpenedLoop) -> Array:
    """Return all omega in [0, pi] with L(e^{j omega}) real and negative, ascending, rad/sample.

    The imaginary part of N conj(D) is sin(omega) times a polynomial of degree n - 1 in
    cos omega; the ends 0 and pi are always candidates, and changes of sign as for the gain.
    """
    n = len(loop.A)

    def gap(z: ComplexArray) -> tuple[Array, Array]:
        L = loop.at(z)
        return np.imag(L) / np.abs(L), np.imag(loop.slope(z) * 1j * z) / np.abs(L)

    candidates = [np.zeros(0)]
    if n:
        omega, N, D = _on_the_circle(loop, n)
        across = np.imag(N * np.conj(D)) / np.sin(omega)
        if np.any(np.abs(across) > 1e-14 * np.abs(N * D).max(initial=0.0)):
            candidates.append(_frequencies(across, omega))
    inner = _crossovers(loop, np.concatenate(candidates), gap, lambda L: np.imag(L) / np.abs(L))
    inner = inner[(inner > 0) & (inner < np.pi)]
    every = np.concatenate([[0.0], inner, [np.pi]])
    values = loop.response(every)
    with np.errstate(over="ignore", invalid="ignore"):  # scaled to avoid overflow
        share = np.maximum(1e-6, _rounding(loop, every))
        is_real = np.abs(values.imag) < share * np.abs(values)
    negative = np.isfinite(values) & (values.real < 0) & is_real
    return np.asarray(every[negative], dtype=np.float64)


def _on_the_circle(loop: OpenedLoop, count: int) -> tuple[Array, ComplexArray, ComplexArray]:
    """Return N and D of L = N / D at the Chebyshev nodes cos((i + 1/2) pi / count)."""
    for more in range(len(loop.open_poles) + 2):  # each pole can sit on a node
        omega = np.asarray((np.arange(count + more) + 0.5) * np.pi / (count + more))
        z = np.exp(1j * omega)
        # N and D may share any positive factor; these keep large poles and gains from overflowing.
        sizes = np.maximum(np.abs(loop.open_poles), 1.0)
        D = np.prod((z[:, None] - loop.open_poles) / sizes, axis=1)
        N = loop.at(z) * D
        if np.all(np.isfinite(N)):
            largest = max(np.abs(N).max(), np.abs(D).max())
            factor = np.exp2(-np.round(np.log2(largest))) if largest else 1.0
            return omega, N * factor, D * factor
    raise InputError(
        "the loop transfer function overflows float64 on the unit circle; scale the signals of the "
        "loop, or its states."
    )


def _frequencies(values: Array, omega: Array) -> Array:
    """Return the zeros in [0, pi] of the polynomial in cos omega with these nodal values."""
    count = len(values)
    scaled = values / np.abs(values).max()
    T = np.cos(np.outer(np.arange(count), omega))
    coefficients = 2.0 / count * (T @ scaled)
    coefficients[0] /= 2
    coefficients = chebyshev.chebtrim(coefficients, 1e-15)
    roots = chebyshev.chebroots(coefficients)
    x = roots.real[(np.abs(roots.imag) <= SPLIT) & (np.abs(roots.real) <= 1 + SPLIT)]
    return np.arccos(np.clip(x, -1, 1))


def _crossovers(loop: OpenedLoop, roots: Array, gap: Gap, value_of: ValueOf) -> Array:
    """Return the crossovers among the roots, and those from changes of sign."""
    roots = roots[_rounding(loop, roots) < 1e-6]  # above it, only changes of sign count
    changes = _changes_of_sign(loop, value_of)
    tolerance = np.clip(_rounding(loop, changes), REACHED, REACHED_AT_WORST)
    crossings = np.sort(
        np.concatenate([_polished(roots, gap, REACHED), _polished(changes, gap, tolerance)])
    )
    is_new = np.diff(crossings, prepend=-1.0) > 1e-12 + 1e-9 * np.minimum(
        crossings, np.pi - crossings
    )
    return np.asarray(crossings[is_new])


def _changes_of_sign(loop: OpenedLoop, value_of: ValueOf) -> Array:
    """Return the sign changes of the gap next to the ends and the poles, to seven digits.

    Values below the rounding error have no sign.
    """
    modes = np.concatenate([loop.open_poles, loop.closed_poles()])
    modes = modes[np.isfinite(modes)]
    widths = np.maximum(np.abs(1 - np.abs(modes)), 1e-12)
    about = np.abs(np.angle(modes))[:, None] + widths[:, None] * ABOUT_A_POLE
    points = np.concatenate([FROM_THE_ENDS, np.pi - FROM_THE_ENDS, about.ravel()])
    omega = np.unique(points[(points > 0) & (points < np.pi)])
    with np.errstate(all="ignore"):
        value = value_of(loop.at(np.exp(1j * omega)))
        decided = _above_rounding(omega, value, lambda points: _rounding(loop, points))
        omega, value = omega[decided], value[decided]
        changes = np.flatnonzero(np.sign(value[:-1]) * np.sign(value[1:]) < 0)
        low, high, below = omega[changes], omega[changes + 1], np.sign(value[changes])
        for _ in range(24 if len(changes) else 0):
            middle = (low + high) / 2
            same = np.sign(value_of(loop.at(np.exp(1j * middle)))) == below
            low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray((low + high) / 2)


def _above_rounding(omega: Array, value: Array, rounding: Callable[[Array], Array]) -> Array:
    """Return the first and the last value above rounding of each run of one sign.

    The rounding error is computed from the ends of a run inwards, until a value exceeds it.
    """
    edges = [0, *(1 + np.flatnonzero(np.sign(value[1:]) != np.sign(value[:-1]))), len(value)]
    runs = [np.arange(low, high) for low, high in pairwise(edges) if high > low]
    waiting = [ends for run in runs for ends in (run, run[::-1])]
    unresolved = []
    for width in (1, 8, len(value)):
        if not waiting:
            break
        indices = np.unique(np.concatenate([run[:width] for run in waiting]))
        resolved = indices[np.abs(value[indices]) > rounding(omega[indices])]
        firsts = [run[:width][np.isin(run[:width], resolved)] for run in waiting]
        unresolved += [first[0] for first in firsts if len(first)]
        waiting = [
            run[width:]
            for run, first in zip(waiting, firsts, strict=True)
            if not len(first) and len(run) > width
        ]
    return np.unique(np.array(unresolved, dtype=np.intp))


def _polished(omega: Array, gap: Gap, tolerance: Array | float) -> Array:
    """Refine candidates by Newton steps on L; drop those that do not converge to a crossover."""
    with np.errstate(all="ignore"):
        best = omega.copy()
        smallest = np.abs(gap(np.exp(1j * best))[0])
        for end in (0.0, np.pi):  # where a real L is exactly real, cos omega resolves omega poorly
            size = np.abs(gap(np.exp(1j * np.array([end])))[0])[0]
            # not so where L differs half-way to the end: then there are two crossovers
            between = np.abs(gap(np.exp(0.5j * (best + end)))[0])
            near = (np.abs(best - end) < 1e-3) & (size <= 1e-14) & (between <= 1e-12)
            best[near], smallest[near] = end, size
        for _ in range(30):
            value, slope = gap(np.exp(1j * best))
            step = np.real(value / slope)
            moved = np.clip(best - np.clip(np.nan_to_num(step), -1e-3, 1e-3), 0, np.pi)
            size = np.abs(gap(np.exp(1j * moved))[0])
            better = size < smallest
            if not better.any():
                break
            best[better], smallest[better] = moved[better], size[better]
    return np.asarray(best[smallest <= tolerance])


def _rounding(loop: OpenedLoop, omega: Array) -> Array:
    """Return the relative rounding error of L; large next to a multiple pole."""
    if not (len(loop.A) and len(omega)):
        return np.full(len(omega), 1e-14)
    size, nearness = loop.nearness(np.exp(1j * omega))
    with np.errstate(over="ignore"):  # infinite: L has no correct digit
        return np.asarray(10 * np.finfo(float).eps * size * nearness)


# Relative distance of the perturbed loops to a boundary.
BESIDE = 1e-3
# Factor beyond the largest crossover gain, to detect a loss of stability without a crossover.
FAR = 1e6
# Gains beyond this, or below its inverse, count as infinite, or as 0.
MOST_GAIN = 1e100
# Open-loop poles this close count as one multiple pole.
CLUSTER = 1e-4
# Largest number of delay steps that are tried if no crossover decides.
MOST_STEPS = 500


@dataclass(frozen=True, eq=False)
class StabilityBoundary(Result):
    """The smallest one-parameter change of the loop that puts a pole on the unit circle.

    Attributes
    ----------
    value : float
        A factor, degrees, or steps; infinite, or 0 for a decreasing gain, where there is none.
    frequency : float
        Of that pole, rad/sample; NaN where there is none.
    radius_before, radius_at, radius_after : float
        Pole radius a thousandth of the margin before it, at it, and after it: the spectral radius
        for gain and phase, for a delay the modulus of the one pole that crosses. A pole that
        only touches the circle leaves radius_after below 1. NaN where there is no boundary.
    jumps : bool
        Only for a delay: the loop is stable one whole step before and unstable at `value`, with
        no pole on the circle in between; the radii are then those of these two loops.
    """

    value: float
    frequency: float
    radius_before: float
    radius_at: float
    radius_after: float
    jumps: bool = False

    @property
    def is_reached(self) -> bool:
        """Whether the boundary exists."""
        return bool(np.isfinite(self.frequency))


def nowhere(value: float) -> StabilityBoundary:
    """Return a boundary at infinity, or at 0."""
    return StabilityBoundary(value, np.nan, np.nan, np.nan, np.nan)


def gain_boundary(loop: OpenedLoop, crossovers: Array, *, up: bool) -> StabilityBoundary:
    """Return the nearest gain factor above (or below) 1 at which the loop becomes unstable.

    A crossover of L = -1/k puts a pole on the circle at the gain k. If rounding lost a crossing,
    the loop is unstable between two gains without one, and bisection
    on the poles finds the crossing.
    """
    values = loop.response(crossovers).real
    with np.errstate(over="ignore"):  # beyond float64: no boundary
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
        boundary = StabilityBoundary(
            k, omega, loop.radius(k - beside), loop.radius(k), loop.radius(after)
        )
        touches = abs(boundary.radius_at - 1) <= 1e-9
        if boundary.radius_after >= 1 or touches:
            return boundary
        previous = k  # a crossing caused by rounding
    end = previous * FAR if up else 0.0
    if loop.radius(end) > 1 if up else np.abs(_open_poles(loop)[0]).max(initial=0.0) > 1 + 1e-10:
        return _bisected(loop, previous, end)
    return nowhere(np.inf if up else 0.0)


def _open_poles(loop: OpenedLoop) -> tuple[ComplexArray, Array]:
    """Return the open-loop poles, clusters by their mean, and the error of each.

    Rounding moves each of d equal poles by the d-th root of itself, their mean by itself only.
    """
    poles = loop.open_poles
    close = np.abs(poles[:, None] - poles) < CLUSTER
    means = np.array([poles[row].mean() for row in close], poles.dtype)
    multiplicity = np.maximum(close.sum(axis=1), 1)
    return means, 1e-12 + 10 * np.finfo(float).eps ** (1 / multiplicity) * (multiplicity > 1)


def _at_open_poles(loop: OpenedLoop, omega: Array) -> Array:
    """Return the points of the circle that coincide with an open-loop pole up to rounding."""
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
    """Return the lag in [0, 2 pi) that rotates L to the negative real axis, the PM of Table 5.1."""
    return np.asarray(np.mod(np.pi + np.angle(loop.response(omega)), 2 * np.pi))


def phase_boundary(loop: OpenedLoop, crossovers: Array, *, lead: bool) -> StabilityBoundary:
    """Return the least phase change of L that puts a pole on the unit circle, in degrees."""
    if not len(crossovers):
        return nowhere(np.inf)
    lags = lag_at(loop, crossovers)
    turns = 2 * np.pi - lags if lead else lags
    i = int(np.argmin(turns))
    turn, omega = float(turns[i]), float(crossovers[i])
    other = lags if lead else 2 * np.pi - lags

    def radius(angle: float) -> float:
        # A complex gain rotates negative frequencies the other way, so the spectral radius
        # describes this boundary only if it is the nearer of lag and lead.
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
    """Return the least additional delay that makes the loop unstable, in steps.

    At omega = 0 a delay has no effect; at pi one step rotates L by 180 degrees.

    Where abs(L(-1)) > 1, a fractional delay is undefined:
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
        crossing = _crossing(loop, float(delay), float(omega))
        if crossing.radius_before < 1:
            return crossing
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
    """Return the modulus of the root of 1 + L(z) z^{-delay} = 0 near e^{j omega}, by Newton steps.

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
