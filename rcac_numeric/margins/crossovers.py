"""Every frequency at which a loop's gain is one, or its phase is half a turn."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array, ComplexArray
from rcac_numeric.margins.opened_loop import OpenedLoop

# A root off the real axis by no more than this may be a double root that rounding has split.
SPLIT = 1e-6
# A function of points on the circle that is zero at a crossover, with its slope over omega.
Gap = Callable[[ComplexArray], tuple[Array, Array]]
# The value of a gap from that of L, where no slope is needed.
ValueOf = Callable[[ComplexArray], Array]
# What a candidate must reach, relative to the size of L, to count as a crossover: the first where
# L is well conditioned, and next to a multiple pole what rounding leaves of it, up to the second.
REACHED, REACHED_AT_WORST = 1e-8, 1e-3
# Distances from 0 and from pi at which signs are compared: cos omega is flat there, and of a loop
# that is sampled fast, all of whose poles are near 1, its polynomial keeps no correct digit.
FROM_THE_ENDS = np.geomspace(1e-13, 0.5, 128)
# The same about every pole, in widths of its resonance.
ABOUT_A_POLE = np.array([-10.0, -3.0, -1.0, -0.3, 0.0, 0.3, 1.0, 3.0, 10.0])


def gain_crossovers(loop: OpenedLoop) -> Array:
    """All omega in [0, pi] with abs(L(e^{j omega})) = 1, ascending, rad/sample.

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
            "and delay have no single margin. PlantChange the gain of the loop a little."
        )
    found = _frequencies(excess, omega)

    def gap(z: ComplexArray) -> tuple[Array, Array]:
        L = loop.at(z)
        # log abs(L) and its slope along the circle, whatever the size of L nearby
        return np.log(np.abs(L)), np.real(loop.slope(z) / L * 1j * z)

    return _crossovers(loop, found, gap, lambda L: np.log(np.abs(L)))


def phase_crossovers(loop: OpenedLoop) -> Array:
    """All omega in [0, pi] with L(e^{j omega}) real and negative, ascending, rad/sample.

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
    is_real = np.abs(values.imag) < np.maximum(1e-6, _rounding(loop, every)) * np.abs(values)
    negative = np.isfinite(values) & (values.real < 0) & is_real
    return np.asarray(every[negative], dtype=np.float64)


def _on_the_circle(loop: OpenedLoop, count: int) -> tuple[Array, ComplexArray, ComplexArray]:
    """N and D of L = N / D at the angles of the Chebyshev nodes cos((i + 1/2) pi / count)."""
    while True:
        omega = np.asarray((np.arange(count) + 0.5) * np.pi / count)
        z = np.exp(1j * omega)
        # N and D may share any positive factor; this one keeps large poles from overflowing.
        sizes = np.maximum(np.abs(loop.open_poles), 1.0)
        D = np.prod((z[:, None] - loop.open_poles) / sizes, axis=1)
        L = loop.at(z)
        if np.all(np.isfinite(L)):
            return omega, L * D, D
        count += 1  # an open-loop pole sits on a node


def _frequencies(values: Array, omega: Array) -> Array:
    """The zeros in [0, pi] of the polynomial in cos omega that has these values at the nodes."""
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
    """Those of the roots that are crossovers, and those that changes of sign find besides."""
    roots = roots[_rounding(loop, roots) < 1e-6]  # where it is more, only changes of sign count
    changes = _changes_of_sign(loop, value_of)
    tolerance = np.clip(_rounding(loop, changes), REACHED, REACHED_AT_WORST)
    found = np.sort(
        np.concatenate([_polished(roots, gap, REACHED), _polished(changes, gap, tolerance)])
    )
    is_new = np.diff(found, prepend=-1.0) > 1e-12 + 1e-9 * np.minimum(found, np.pi - found)
    return np.asarray(found[is_new])


def _changes_of_sign(loop: OpenedLoop, value_of: ValueOf) -> Array:
    """Where the gap changes its sign next to the ends and to the poles, to seven digits.

    Values that rounding may have made have no sign.
    """
    modes = np.concatenate([loop.open_poles, loop.closed_poles()])
    modes = modes[np.isfinite(modes)]
    widths = np.maximum(np.abs(1 - np.abs(modes)), 1e-12)
    about = np.abs(np.angle(modes))[:, None] + widths[:, None] * ABOUT_A_POLE
    points = np.concatenate([FROM_THE_ENDS, np.pi - FROM_THE_ENDS, about.ravel()])
    omega = np.unique(points[(points > 0) & (points < np.pi)])
    with np.errstate(all="ignore"):
        value = value_of(loop.at(np.exp(1j * omega)))
        omega, value = (part[np.abs(value) > _rounding(loop, omega)] for part in (omega, value))
        changes = np.flatnonzero(np.sign(value[:-1]) * np.sign(value[1:]) < 0)
        low, high, below = omega[changes], omega[changes + 1], np.sign(value[changes])
        for _ in range(24 if len(changes) else 0):
            middle = (low + high) / 2
            same = np.sign(value_of(loop.at(np.exp(1j * middle)))) == below
            low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray((low + high) / 2)


def _polished(omega: Array, gap: Gap, tolerance: Array | float) -> Array:
    """Newton steps on L itself; candidates that do not reach a crossover are dropped."""
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
    """What share of L is rounding at these frequencies: much next to a multiple pole."""
    if not (len(loop.A) and len(omega)):
        return np.full(len(omega), 1e-14)
    pencils = np.exp(1j * omega)[:, None, None] * np.eye(len(loop.A)) - loop.A
    size = 1 + np.linalg.norm(loop.A, 1)
    try:
        nearness = np.linalg.norm(np.linalg.inv(pencils), 1, axis=(1, 2))
    except np.linalg.LinAlgError:  # a pole among the points
        nearness = np.array([1 / max(np.linalg.svd(p)[1][-1], 1e-300) for p in pencils])
    rounding = 10 * np.finfo(float).eps * size * nearness
    return np.asarray(rounding)
