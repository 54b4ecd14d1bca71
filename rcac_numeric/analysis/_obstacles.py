"""Reasons why a discrete-time Riccati equation has no stabilising solution."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from compensator_theory.errors import (
    CompensatorError,
    NoSolutionError,
    NotControllableError,
    NotObservableError,
    UnitCircleError,
)
from rcac_numeric.analysis._square_roots import balanced_pair
from rcac_numeric.arrays._array_types import Array

EPS = float(np.finfo(float).eps)
# Distance to the circle within which a computed zero may be on it; a multiple zero is a cluster.
NEXT = 1e-3
# Largest distance of a computed eigenvalue to the circle, and to the zero that it stands for.
ABOUT = 0.1
# Largest distance between the members of a cluster.
CLUSTER = 1e-3
# Steps at the level of rounding noise after which a better zero is no longer expected.
NOISY = 5
# Step size at which the search ends.
SETTLED = 1e-10
# Points at which the normal rank is computed; all but finitely many points have it.
PROBES = (0.41 + 0.83j, -1.37 + 0.29j, 0.07 - 1.61j)


@dataclass(frozen=True)
class Role:
    """Text for one of the two equations; the estimator is the dual regulator."""

    pair: str
    hidden: str
    error: type[CompensatorError]
    map: str
    inputs: str
    outputs: str
    remedy: str


REGULATOR = Role(
    pair="(A, B)",
    hidden="not stabilisable",
    error=NotControllableError,
    map="G_zu",
    inputs="u",
    outputs="z",
    remedy="Weight u (R_2 > 0), drop an input, or give z another component",
)
ESTIMATOR = Role(
    pair="(A, C)",
    hidden="not detectable",
    error=NotObservableError,
    map="G_yw",
    inputs="y",
    outputs="w",
    remedy="Add noise to the measurements (V_2 > 0), drop a measurement, or add a noise",
)


def require_stabilisable(A: Array, B: Array, role: Role = REGULATOR) -> None:
    """Raise for an uncontrollable mode on or outside the unit circle."""
    size = max(float(np.linalg.norm(A, 2)), 1.0) if A.size else 1.0
    widths = np.linalg.norm(B, axis=0)
    scaled = B[:, widths > 0] / widths[widths > 0] * size
    for mode in _suspects(np.linalg.eigvals(A), size):
        pencil = np.hstack([A - mode * np.eye(len(A)), scaled])
        smallest = np.linalg.svd(pencil, compute_uv=False)[len(A) - 1]
        if smallest <= 100 * len(A) * EPS * size:
            raise role.error(
                f"{role.pair} is {role.hidden}: no gain moves the mode {words(mode)} of A, which "
                f"is on or outside the unit circle (smallest singular value {smallest:.1e}). "
                "Remove it from the plant, or move it inside if it models a disturbance."
            )


def require_rank(A: Array, B: Array, E_1: Array, E_2: Array, role: Role = REGULATOR) -> None:
    """Raise for a transfer matrix with dependent columns: the gain is not unique."""
    n, columns = len(A), B.shape[1]
    rank = max(_rank(_pencil(A, B, E_1, E_2, probe)) for probe in PROBES) - n
    if rank < columns:
        raise NoSolutionError(
            f"{role.map} has rank {max(rank, 0)} at almost every q, but {role.inputs} has "
            f"{columns} component(s): the deficient rank leaves a direction of {role.inputs} "
            f"undetermined, and R_2 + B'PB (or V_2 + CQC') is singular. {role.remedy}."
        )


def require_no_zero_on_circle(
    A: Array,
    B: Array,
    E_1: Array,
    E_2: Array,
    *,
    near: NDArray[np.complex128],
    role: Role = REGULATOR,
) -> None:
    """Raise for a zero on the unit circle next to one of the numbers `near`.

    The zeros are among the eigenvalues of a square pencil. Those near the circle are refined by
    Newton's method on the smallest singular value of the system pencil; at a zero that value is
    rounding noise.
    """
    starts = _possible_zeros(A, B, E_1, E_2, near)
    # At a multiple zero the derivative is noise too, so that a step leads away from a good start.
    refined = (_nearest_zero(A, B, E_1, E_2, start) for start in starts)
    size = len(A) + B.shape[1]
    for zero in chain(starts, refined):
        if not (np.isfinite(zero) and abs(abs(zero) - 1) < NEXT):
            continue
        # A multiple zero is accurate to a root of the rounding error only; 1 and -1 are the usual
        # ones.
        likely = [at for at in (1, -1, 1j, -1j) if abs(at - zero) < NEXT]
        for at in (*likely, zero / abs(zero)):
            pencil = balanced_pencil(_pencil(A, B, E_1, E_2, at))
            least = float(np.linalg.svd(pencil, compute_uv=False)[size - 1])
            if least <= 100 * size * EPS:
                raise _zero_on_circle(at, least, role)


def _zero_on_circle(at: complex, least: float, role: Role) -> UnitCircleError:
    return UnitCircleError(
        f"{role.map} has a zero on the unit circle at {words(at)} (or A has a mode there "
        f"that {role.outputs} does not show; smallest singular value {least:.1e}). The closed loop "
        "would keep a pole on the circle, so no solution is stabilising. "
        f"{role.remedy}."
    )


def words(value: complex) -> str:
    """Return a complex number as text, without parts of the size of rounding."""
    value = complex(value)
    if abs(value.imag) < 1e-12 * max(abs(value), 1.0):
        return f"{value.real:.12g}"
    if abs(value.real) < 1e-12 * abs(value):
        return f"{value.imag:.12g}j"
    return f"{value.real:.12g}{value.imag:+.12g}j"


def _possible_zeros(
    A: Array, B: Array, E_1: Array, E_2: Array, near: NDArray[np.complex128]
) -> list[complex]:
    """Return where zeros may be: next to the circle and `near`, one of each conjugate pair."""
    sizes = np.linalg.svd(E_2, compute_uv=False)
    if len(sizes) == B.shape[1] and sizes.min(initial=np.inf) > 1e-6 * sizes.max(initial=0):
        # E_2 is one to one, and u = -E_2^+ E_1 x at a zero, which is then one of these:
        values = np.linalg.eigvals(A - B @ np.linalg.lstsq(E_2, E_1, rcond=None)[0])
    else:
        values = _eigenvalues_of_square_pencil(A, B, E_1, E_2)
    values = values[np.isfinite(values) & (np.abs(np.abs(values) - 1) < ABOUT)]
    # A multiple zero is a cluster, whose centre is more accurate than its members.
    centres = [values[np.abs(values - value) < CLUSTER].mean() for value in values]
    starts = np.unique(np.round([*centres, *values], 12)) if len(values) else values
    starts = starts[starts.imag >= 0]
    return list(starts[np.abs(near[:, None] - starts).min(axis=0, initial=np.inf) < ABOUT])


def _eigenvalues_of_square_pencil(
    A: Array, B: Array, E_1: Array, E_2: Array
) -> NDArray[np.complex128]:
    """Return the eigenvalues of the pencil with as many mixtures of its outputs as inputs.

    Every zero is one of them: where the columns of the pencil are dependent, those of the mixtures
    are too.
    """
    n, m = B.shape
    left = np.block([[A, B], [E_1, E_2]])
    right = np.zeros_like(left)
    right[:n, :n] = np.eye(n)
    left, right, _ = balanced_pair(left, right)
    mixing = linalg.qr(np.random.default_rng(0).standard_normal((len(E_1), m)), mode="economic")[0]
    left, right = np.vstack([left[:n], mixing.T @ left[n:]]), right[: n + m]
    above, below = linalg.eigvals(left, right, homogeneous_eigvals=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(above / below)


def _nearest_zero(A: Array, B: Array, E_1: Array, E_2: Array, start: complex) -> complex:
    """Return a zero of the system pencil; not a zero if the iteration does not converge."""
    n, at, before, noisy = len(A), complex(start), np.inf, 0
    for _ in range(60):
        left, values, right = np.linalg.svd(_pencil(A, B, E_1, E_2, at))
        u, v = left[:, len(values) - 1], right[len(values) - 1].conj()
        slope = np.vdot(u[:n], v[:n])
        noisy += bool(values[-1] <= 10 * EPS * values[0])
        if values[-1] == 0 or noisy == NOISY:
            break
        if values[-1] >= 10 * abs(slope):
            return complex(np.nan)  # no zero nearby
        step = values[-1] / slope
        at += step
        if not abs(at - start) < ABOUT:
            return complex(np.nan)  # the zero of another start, if of any
        # Converged to rounding, or a multiple zero.
        if abs(step) < SETTLED and not abs(step) < before / 2:
            break
        before = abs(step)
    return at


def _suspects(modes: NDArray[Any], size: float) -> list[complex]:
    """Return the modes on or outside the circle, and the centres of their clusters.

    A multiple eigenvalue is computed as a cluster, off by a root of the rounding error; its centre
    is not.
    """
    suspects = []
    for mode in modes:
        cluster = modes[np.abs(modes - mode) < 1e-4 * size]
        suspects += [value for value in (mode, cluster.mean()) if abs(value) >= 1 - 1e-12]
    return suspects


def _pencil(A: Array, B: Array, E_1: Array, E_2: Array, at: complex) -> NDArray[np.complex128]:
    n = len(A)
    pencil = np.empty((n + len(E_1), n + B.shape[1]), dtype=np.complex128)
    pencil[:n, :n], pencil[:n, n:], pencil[n:, :n], pencil[n:, n:] = A, B, E_1, E_2
    pencil[np.arange(n), np.arange(n)] -= at
    return pencil


def balanced_pencil(pencil: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the matrix with rows and columns scaled to one; the rank is unchanged."""
    for _ in range(3):
        for axis in (1, 0):
            sizes = np.linalg.norm(pencil, axis=axis, keepdims=True)
            pencil = pencil / np.where(sizes > 0, sizes, 1.0)
    return pencil


def _rank(pencil: NDArray[np.complex128]) -> int:
    values = np.linalg.svd(balanced_pencil(pencil), compute_uv=False)
    return int(np.sum(values > 10 * max(pencil.shape) * EPS * values.max(initial=0.0)))
