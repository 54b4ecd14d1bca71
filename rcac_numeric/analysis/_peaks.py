"""Peaks of singular values over the unit circle, by level sets without a grid."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import eigvals

from rcac_numeric.analysis._resolvents import MANY_STATES, hessenberg_form, responses
from rcac_numeric.arrays._array_types import Array, ComplexArray

Matrices = tuple[Array, Array, Array, Array]
# A response below this is not refined: the matrices of its level set would overflow float64.
SMALLEST = 1e-150
GRID = np.geomspace(1e-3, 3.0, 40)  # rad/sample, where a peak may be beside those of the poles
COARSE = 1e-6  # a tolerance above this is met by the level sets themselves


def hinf_norm(
    system: Matrices,
    rtol: float = 1e-10,
    response: Callable[[Array], ComplexArray] | None = None,
    most: float = np.inf,
) -> tuple[float, float]:
    """Return the H-infinity norm of a stable system and its frequency.

    Above `most` a lower bound of it is enough.

    The level-set method of Bruinsma and Steinbuch: the frequencies at which a singular value
    equals a level are eigenvalues of a symplectic pencil on the unit circle; the level is raised
    to the best value at the midpoints between them until there is none.

    `response` is a quicker way than by the states to the values of a scalar system.
    """
    n = len(system[0])
    if n >= MANY_STATES:
        system = (*hessenberg_form(*system[:3]), system[3])
    A = system[0]

    def sizes(omegas: Array) -> Array:
        if response is not None:
            return np.abs(response(omegas))
        return np.asarray(np.linalg.norm(responses_of(system, omegas), 2, axis=(1, 2)))

    def highest(omegas: Array) -> tuple[float, float]:
        values = sizes(omegas)
        i = int(np.argmax(values))
        return float(values[i]), float(omegas[i])

    # A good start saves level sets, which cost more than these frequencies.
    starts = np.r_[0.0, np.pi, np.abs(np.angle(np.linalg.eigvals(A))), GRID] if n else np.zeros(1)
    best, where = highest(starts)
    if n and response is not None:
        starts = np.unique(starts)
        i = int(np.searchsorted(starts, where))
        sides = starts[max(i - 1, 0)], starts[min(i + 1, len(starts) - 1)]
        best, where = _refined(lambda w: highest(np.array([w]))[0], best, where, sides)
    for _ in range(60):
        if not n or best < SMALLEST or best > most:
            break
        level = best * (1 + rtol)
        crossings = level_crossings(system, level)
        ends = np.concatenate([[0.0], crossings, [np.pi]])
        middles = (ends[1:] + ends[:-1]) / 2
        higher, at = highest(middles)
        if higher <= level:
            break
        best, where = higher, at
    if rtol > COARSE:
        return best, where
    return _refined(lambda w: highest(np.array([w]))[0], best, where)


def response_of(system: Matrices, omega: float) -> ComplexArray:
    """Return C (e^{j omega} I - A)^{-1} B + D."""
    return np.asarray(responses_of(system, np.array([omega]))[0])


def responses_of(system: Matrices, omegas: Array) -> ComplexArray:
    """Return the response at several frequencies; shape (len(omegas), outputs, inputs)."""
    A, B, C, D = (np.asarray(part) for part in system)
    if not len(A):
        return np.broadcast_to(D.astype(np.complex128), (len(omegas), *D.shape))
    if len(A) >= MANY_STATES:
        return responses(*hessenberg_form(A, B, C), np.exp(1j * omegas)) + D
    z = np.exp(1j * omegas)[:, None, None]
    return np.asarray(C @ np.linalg.solve(z * np.eye(len(A)) - A, B[None] + 0j) + D)


def level_crossings(system: Matrices, level: float) -> Array:
    """Return the omega in [0, pi] at which a singular value equals `level`."""
    A, B, C, D = (np.asarray(part) for part in system)
    n, m, p = len(A), B.shape[1], len(C)
    if not n:
        return np.zeros(0)
    B, D = B / level, D / level
    # z x = A x + B v, lambda = z A' lambda + C' y, y = C x + D v, v = z B' lambda + D' y
    left = np.block([
        [A, np.zeros((n, n)), B, np.zeros((n, p))],
        [np.zeros((n, n)), np.eye(n), np.zeros((n, m)), -C.T],
        [np.zeros((m, 2 * n)), np.eye(m), -D.T],
        [C, np.zeros((p, n)), D, -np.eye(p)],
    ])  # fmt: skip
    right = np.zeros_like(left)
    right[:n, :n] = np.eye(n)
    right[n : 2 * n, n : 2 * n] = A.T
    right[2 * n : 2 * n + m, n : 2 * n] = B.T
    values = eigvals(left, right)
    values = values[np.isfinite(values)]
    # Near a maximum two crossings merge and rounding moves them off the circle by sqrt(eps).
    return np.unique(np.abs(np.angle(values[np.abs(np.abs(values) - 1) < 1e-5])))


def _refined(
    value: Callable[[float], float],
    best: float,
    where: float,
    sides: tuple[float, float] | None = None,
) -> tuple[float, float]:
    """Return the maximum of an isolated peak, or between two points."""
    from scipy.optimize import minimize_scalar  # imported here: it takes 0.17 s

    width = 1e-4
    low, high = sides or (max(where - width, 0.0), min(where + width, np.pi))
    peak = minimize_scalar(
        lambda w: -value(w),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-12},
    )
    return (-float(peak.fun), float(peak.x)) if -peak.fun > best else (best, where)
