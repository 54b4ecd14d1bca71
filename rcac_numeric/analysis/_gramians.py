"""The discrete-time Lyapunov equation by doubling: in float64, and enclosed in balls."""

from __future__ import annotations

import numpy as np
from flint import arb, arb_mat, fmpq, fmpq_mat

from compensator_theory.polynomials._ball_precision import ball_precision
from rcac_numeric.arrays._array_types import Array

# Bits that ball arithmetic takes in turn, and doublings: more than any float64 matrix asks for.
PRECISIONS, DOUBLINGS = (192, 512, 1536, 4096), 100


def stein_solution(A: Array, Q: Array) -> Array:
    """X = A X A' + Q, as the sum of A^k Q A'^k, for a spectral radius below 1.

    Each step doubles the number of terms, X <- X + F X F' and F <- F F. Unlike a linear solve it
    keeps a positive semidefinite X so, and the relative accuracy of badly scaled entries; where
    the sum leaves float64 its entries are infinite or NaN, for the caller to refuse.

    Notes
    -----
    Source: (4.23); R. A. Smith, SIAM J. Appl. Math. 16 (1968) 198-201.
    """
    X, power = np.array(Q, dtype=np.float64), np.array(A, dtype=np.float64)
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        for _ in range(64):  # 2^64 terms: more than any spectral radius in float64 asks for
            added = power @ X @ power.T
            X = X + (added + added.T) / 2
            small = not np.abs(added).max(initial=0.0) > 1e-18 * np.abs(X).max(initial=0.0)
            # A nilpotent part may hide Q for some steps: the powers must have died out as well.
            if small and not np.abs(power).max(initial=0.0) > 1e-9:
                break
            power = power @ power
    return X


def rational(A: Array) -> fmpq_mat:
    """A float64 matrix, exactly."""
    entries = [fmpq(*float(entry).as_integer_ratio()) for entry in A.ravel()]
    return fmpq_mat(*A.shape, entries)


def enclosed_gramians(
    A: fmpq_mat, Q: fmpq_mat, R: fmpq_mat, precision: int
) -> tuple[arb_mat, arb_mat] | None:
    """Balls that hold X = A X A' + Q and Y = A' Y A + R, and so prove that A is stable.

    Doubling ends when a power F = A^(2^k) has norm f < 1: what is left out is then at most
    norm(X) f^2 / (1 - f^2), which widens every ball. None where this precision (in bits) or
    2^100 steps do not suffice, as for every A that is not stable.
    """
    with ball_precision(precision):
        power, X, Y = arb_mat(A), arb_mat(Q), arb_mat(R)
        for _ in range(DOUBLINGS):
            squared = sum((entry**2 for entry in power.entries()), arb(0)).abs_upper()
            if squared < arb(2) ** (-precision // 2):
                left = squared / (1 - squared)
                return _widened(X, left), _widened(Y, left)
            if not squared < arb(10) ** 2000:
                return None
            dual = power.transpose()
            X, Y, power = X + power * X * dual, Y + dual * Y * power, power * power
    return None


def _widened(X: arb_mat, share: arb) -> arb_mat:
    size = sum((entry**2 for entry in X.entries()), arb(0)).abs_upper().sqrt()
    around = arb(0, (size * share).abs_upper())
    return arb_mat(X.nrows(), X.ncols(), [entry + around for entry in X.entries()])
