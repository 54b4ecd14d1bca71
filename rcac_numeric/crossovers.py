"""Every frequency at which a loop's gain is one, or its phase is half a turn: no grid is used."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev

from compensator_theory.errors import InputError
from rcac_numeric.broken_loops import BrokenLoop, ComplexArray
from rcac_numeric.validation import Array

# A root off the real axis by no more than this may be a double root that rounding has split.
SPLIT = 1e-6
# A function of points on the circle that is zero at a crossover, with its slope over omega.
Gap = Callable[[ComplexArray], tuple[Array, Array]]
# What a candidate must reach, relative to the size of L, to count as a crossover.
REACHED = 1e-8


def gain_crossovers(loop: BrokenLoop) -> Array:
    """All omega in [0, pi] with abs(L(e^{j omega})) = 1, ascending, rad/sample.

    With L = N / D, abs(N)^2 - abs(D)^2 on the unit circle is a polynomial of degree n in
    x = cos omega. Its coefficients in Chebyshev polynomials come from n + 1 values, and its real
    roots in [-1, 1] from a colleague matrix; each is then polished on L itself.

    Raises
    ------
    InputError
        Where abs(L) = 1 at every frequency: then every frequency is a crossover.

    Examples
    --------
    >>> import control
    >>> from rcac_numeric.broken_loops import broken_loop
    >>> from rcac_numeric.crossovers import gain_crossovers
    >>> L = broken_loop(control.tf([1.0], [1.0, -1.0], True), feedback=-1)   # 1/(q - 1)
    >>> gain_crossovers(L).round(12)                             # abs(q - 1) = 1 at pi/3
    array([1.04719755])
    """
    n = len(loop.A)
    omega, N, D = _on_the_circle(loop, n + 1)
    excess = np.abs(N) ** 2 - np.abs(D) ** 2
    sizes = np.abs(N) ** 2 + np.abs(D) ** 2
    if np.all(np.abs(excess) <= 1e-12 * sizes):
        raise InputError(
            "abs(L) = 1 at every frequency, so that every frequency is a gain crossover and phase "
            "and delay have no single margin. Change the gain of the loop a little."
        )
    found = _frequencies(excess, omega)

    def gap(z: ComplexArray) -> tuple[Array, Array]:
        L = loop.at(z)
        # log abs(L) and its slope along the circle, whatever the size of L nearby
        return np.log(np.abs(L)), np.real(loop.slope(z) / L * 1j * z)

    return _polished(found, gap)


def phase_crossovers(loop: BrokenLoop) -> Array:
    """All omega in [0, pi] with L(e^{j omega}) real and negative, ascending, rad/sample.

    The imaginary part of N conj(D) is sin(omega) times a polynomial of degree n - 1 in
    cos omega; the ends 0 and pi are always candidates.
    """
    n = len(loop.A)
    candidates = [np.zeros(0)]
    if n:
        omega, N, D = _on_the_circle(loop, n)
        across = np.imag(N * np.conj(D)) / np.sin(omega)
        if np.any(np.abs(across) > 1e-14 * np.abs(N * D).max(initial=0.0)):
            candidates.append(_frequencies(across, omega))

    def gap(z: ComplexArray) -> tuple[Array, Array]:
        L = loop.at(z)
        return np.imag(L) / np.abs(L), np.imag(loop.slope(z) * 1j * z) / np.abs(L)

    inner = _polished(np.concatenate(candidates), gap)
    inner = inner[(inner > 0) & (inner < np.pi)]
    every = np.concatenate([[0.0], inner, [np.pi]])
    values = loop.response(every)
    is_real = np.abs(values.imag) < 1e-6 * np.abs(values)
    negative = np.isfinite(values) & (values.real < 0) & is_real
    return np.asarray(every[negative], dtype=np.float64)


def _on_the_circle(loop: BrokenLoop, count: int) -> tuple[Array, ComplexArray, ComplexArray]:
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


def _polished(omega: Array, gap: Gap) -> Array:
    """Newton steps on L itself; candidates that do not reach a crossover are dropped."""
    with np.errstate(all="ignore"):
        best = omega.copy()
        smallest = np.abs(gap(np.exp(1j * best))[0])
        for end in (0.0, np.pi):  # where a real L is exactly real, cos omega resolves omega poorly
            size = np.abs(gap(np.exp(1j * np.array([end])))[0])[0]
            near = (np.abs(best - end) < 1e-3) & (size <= 1e-14)
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
        reached = np.sort(best[smallest <= REACHED])
    is_new = np.diff(reached, prepend=-1.0) > 1e-12
    return np.asarray(reached[is_new])
