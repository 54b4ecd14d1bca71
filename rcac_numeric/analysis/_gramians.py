"""The discrete-time Lyapunov equation by doubling: in float64, and enclosed in balls."""

from __future__ import annotations

import numpy as np
from flint import arb, arb_mat, fmpq, fmpq_mat

from compensator_theory.errors import IllConditionedError
from compensator_theory.polynomials._ball_precision import ball_precision
from rcac_numeric.arrays._array_types import Array

# Successive precisions of the balls in bits, and doublings: enough for every float64 matrix.
PRECISIONS, DOUBLINGS = (192, 512, 1536, 4096), 100
REFINEMENTS = 2  # of the float64 solution by its residual, where rounding took digits of it
# Largest order for the enclosure in balls if float64 fails, one second; the Schur form beyond it.
MOST_STATES = 50


def stein_solution(A: Array, Q: Array) -> Array:
    """Solve X = A X A' + Q for a spectral radius below 1, as the sum of A^k Q A'^k.

    Each step of the doubling doubles the number of terms, X <- X + F X F' and F <- F F. Unlike a
    linear solve it keeps a positive semidefinite X so, and the relative accuracy of badly scaled
    entries. The powers of a strongly non-normal A are lost to rounding, though, and may leave
    float64: where the residual shows it, X is corrected by the solution for the residual; if that
    is not enough, X is enclosed in balls and rounded once.

    Notes
    -----
    Source: (4.23); R. A. Smith, SIAM J. Appl. Math. 16 (1968) 198-201.
    """
    A, Q = np.asarray(A, dtype=np.float64), np.asarray(Q, dtype=np.float64)
    with np.errstate(all="ignore"):  # an overflow shows in the residual
        solution = _doubled(A, Q)
        for _ in range(REFINEMENTS):
            if solution is None or stein_residual(A, Q, solution) <= _rounding(A):
                break
            rest = A @ solution @ A.T + Q - solution
            correction = _doubled(A, (rest + rest.T) / 2)
            solution = None if correction is None else solution + correction
        if solution is not None and stein_residual(A, Q, solution) <= _rounding(A):
            return solution
        is_finite = bool(np.isfinite(A).all() and np.isfinite(Q).all())
        radius = float(np.abs(np.linalg.eigvals(A)).max()) if is_finite else np.inf
        if radius < 1:
            second = _from_balls(A, Q) if len(A) <= MOST_STATES else _from_schur(A, Q)
            if second is not None and stein_residual(A, Q, second) <= _rounding(A):
                return second
    raise IllConditionedError(
        f"X = A X A' + Q has no solution that float64 holds with a residual of rounding, for A of "
        f"{len(A)} states, spectral radius {radius:.6g} and norm {norm(A):.3g}. Scale the states "
        "and signals to similar magnitude, or move the poles away from the unit circle."
    )


def norm(value: Array) -> float:
    """The 2-norm; zero for an empty matrix, infinite where an entry is not finite."""
    if not np.isfinite(value).all():
        return np.inf
    return float(np.linalg.norm(value, 2)) if value.size else 0.0


def stein_residual(A: Array, Q: Array, X: Array) -> float:
    """Return the residual of X = A X A' + Q relative to its terms; infinite if not finite."""
    left = np.abs(A @ X @ A.T + Q - X).max(initial=0.0)
    size = (np.abs(A) @ np.abs(X) @ np.abs(A).T + np.abs(Q) + np.abs(X)).max(initial=0.0)
    return float(left / size) if np.isfinite(size) and size else (0.0 if size == 0 else np.inf)


def _rounding(A: Array) -> float:
    """Return the residual that rounding may cause in tens of doublings."""
    return 200 * (len(A) + 1) * float(np.finfo(float).eps)


def _doubled(A: Array, Q: Array) -> Array | None:
    X, power = np.array(Q), np.array(A)
    for _ in range(64):  # 2^64 terms: enough for every spectral radius in float64
        added = power @ X @ power.T
        X = X + (added + added.T) / 2
        small = not np.abs(added).max(initial=0.0) > 1e-18 * np.abs(X).max(initial=0.0)
        # A nilpotent part may hide Q for some steps: the powers must have died out as well.
        if small and np.abs(power).max(initial=0.0) <= 1e-9:
            return X
        power = power @ power
    return None


def _from_schur(A: Array, Q: Array) -> Array:
    """Return X from the triangular equation Y = T Y T' + U'QU, column by column from the last.

    Source: G. Kitagawa, International Journal of Control 25 (1977).
    """
    from scipy.linalg import schur, solve_triangular

    T, U = schur(A.astype(complex), output="complex")
    right, Y = U.conj().T @ Q @ U, np.zeros_like(T)
    for k in reversed(range(len(A))):
        known = right[:, k] + T @ (Y[:, k + 1 :] @ T[k, k + 1 :].conj())
        Y[:, k] = solve_triangular(np.eye(len(A)) - T[k, k].conj() * T, known)
    X = (U @ Y @ U.conj().T).real
    return np.asarray((X + X.T) / 2, dtype=np.float64)


def _from_balls(A: Array, Q: Array) -> Array | None:
    state, source = rational(A), rational(Q)
    for precision in PRECISIONS:
        gramians = enclosed_gramians(state, source, fmpq_mat(len(A), len(A)), precision)
        if gramians is None:
            continue
        entries, largest = (
            gramians[0].entries(),
            max(float(e.abs_upper()) for e in gramians[0].entries()),
        )
        if all(float(entry.rad()) <= 1e-17 * largest for entry in entries):
            return np.array([float(entry.mid()) for entry in entries]).reshape(A.shape)
    return None


def rational(A: Array) -> fmpq_mat:
    """Return the exact rational matrix of a float64 matrix."""
    entries = [fmpq(*float(entry).as_integer_ratio()) for entry in A.ravel()]
    return fmpq_mat(*A.shape, entries)


def enclosed_gramians(
    A: fmpq_mat, Q: fmpq_mat, R: fmpq_mat, precision: int
) -> tuple[arb_mat, arb_mat] | None:
    """Enclose X = A X A' + Q and Y = A' Y A + R in balls, which proves that A is stable.

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
