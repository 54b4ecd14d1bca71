"""Rigorous Schur stability test of float64 matrices."""

from __future__ import annotations

import numpy as np
from flint import fmpq_mat
from scipy.linalg import matrix_balance
from sympy import Poly, Rational, Symbol

import compensator_theory as exact
from compensator_theory.errors import IllConditionedError, InputError
from rcac_numeric.analysis._gramians import rational
from rcac_numeric.arrays._array_types import Array

EPS = float(np.finfo(float).eps)
# Largest number of squarings: 2^64 steps, enough for float64 entries.
SQUARINGS = 64
# Largest order for which eigenvalues are counted over the rationals.
LARGEST = 150


def is_schur_stable(A: Array, uncertainty: Array | None = None) -> bool:
    """Decide whether the spectral radius of A is below 1, for these float64 numbers.

    The computed eigenvalues of a strongly non-normal matrix are wrong by far more than rounding,
    so that a radius below 1 shows nothing by itself. In turn, until one decides:

    - A^2, A^4, A^8, ... with a running bound of their rounding: stable once a norm is below 1,
      unstable once a trace is above n;
    - the eigenvalues with the bound of Bauer and Fike, from the residual of the eigenvectors;
    - the count of roots of det(qI - A) inside the circle, over the rationals.
    """
    if not np.isfinite(A).all():
        raise InputError("the matrix has entries that are not finite; stability is undefined.")
    decision = _decided(A, np.zeros_like(A) if uncertainty is None else uncertainty)
    if decision is not None:
        return decision
    if uncertainty is not None or len(A) > LARGEST:
        raise IllConditionedError(
            f"float64 does not determine whether the eigenvalues of a {len(A)} x {len(A)} matrix "
            "are inside the unit circle. Scale the states to similar magnitude, or use exact data."
        )
    return counted_stable(rational(A))


def _decided(A: Array, uncertainty: Array) -> bool | None:
    """Decide in floating point for every matrix within the uncertainty; None if undecided."""
    if not A.size:
        return True
    with np.errstate(all="ignore"):  # an overflow leaves the test undecided
        scaled, (scale, _) = matrix_balance(A, permute=False, separate=True)
        off = float(np.linalg.norm(uncertainty * scale / scale[:, None]))
        verdict = _by_powers(scaled, off)
        return _by_eigenvalues(scaled, off) if verdict is None else verdict


def _by_powers(A: Array, off: float) -> bool | None:
    n, power, error = len(A), A, off
    for _ in range(SQUARINGS):
        size = float(np.linalg.norm(power))
        if size + error < 1:
            return True
        trace = abs(float(np.trace(power)))
        if trace - np.sqrt(n) * error > n * (1 + n * EPS):
            return False
        # (F + E)^2 - F^2 in the Frobenius norm, and the rounding of F^2 itself
        error = 2 * size * error + error**2 + (n + 2) * EPS * size**2
        if not error < size**2 * 1e3 + 1:  # the error bound exceeds the entries
            return None
        power = power @ power
        if not np.isfinite(power).all():
            return None
    return None


def _by_eigenvalues(A: Array, off: float) -> bool | None:
    n = len(A)
    try:
        values, vectors = np.linalg.eig(A)
        singular = np.linalg.svd(vectors, compute_uv=False)
    except np.linalg.LinAlgError:
        return None
    if not singular[-1] > n * EPS * singular[0] * 10:
        return None
    residual = float(np.linalg.norm(A @ vectors - vectors * values))
    residual += 4 * (n + 2) * EPS * float(np.linalg.norm(A) + np.abs(values).max()) * singular[0]
    # vectors diag(values) vectors^-1 = A + E, norm(E) <= residual / least singular value
    moved = 2 * singular[0] / singular[-1] * (residual / singular[-1] + off)
    radius = float(np.abs(values).max())
    if radius + moved < 1:
        return True
    # a chain of n overlapping disks of that radius still stays outside
    return False if radius - 2 * n * moved > 1 else None


def counted_stable(A: fmpq_mat) -> bool:
    """Whether all roots of det(qI - A) are inside the unit circle, decided exactly."""
    if not A.nrows():
        return True
    coefficients = [Rational(int(c.p), int(c.q)) for c in reversed(A.charpoly().coeffs())]
    count = exact.locate_roots(Poly(coefficients, Symbol("q"), domain="QQ"), time="discrete")
    return bool(count.unstable + count.boundary == 0)
