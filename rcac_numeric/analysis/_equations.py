"""Numerical solution of the discrete-time algebraic Riccati equation, with checks."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np

from compensator_theory.errors import CompensatorError, InputError, NoSolutionError
from rcac_numeric.analysis._gramians import norm, stein_solution
from rcac_numeric.analysis._obstacles import (
    Role,
    require_no_zero_on_circle,
    require_rank,
    require_stabilisable,
)
from rcac_numeric.analysis._solutions import StabilisingSolution
from rcac_numeric.analysis._square_roots import kleinman, starting_gains
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import square_root_columns

# Distance of a closed-loop pole to the unit circle below which a zero on it is searched (for a
# zero of multiplicity d the pole is off by the 2d-th root of a rounding error), and the relative
# residual above which a solution is refused.
CLOSE, LARGEST_RESIDUAL = 0.05, 1e-8


def stabilising_solution(
    A: Array,
    B: Array,
    weights: tuple[Array, Array, Array],
    factor: tuple[Array, Array] | None,
    role: Role,
) -> StabilisingSolution:
    """Return the solution for (Q, N, R) and their factor (E_1, E_2); `role` words the errors."""
    if not A.size:
        raise InputError("A is 0 x 0: the plant has no states to estimate or control.")
    with np.errstate(all="ignore"):  # an overflow gives a large residual
        require_stabilisable(A, B, role)
        if factor is not None:
            require_rank(A, B, *factor, role)
        best = _best(A, B, weights)
        if factor is not None:
            best = _in_square_roots(A, B, weights, factor, best)
    if best is None or not best.margin > 0 or not best.residual < LARGEST_RESIDUAL:
        if factor is not None:  # search the whole circle for the reason
            around = np.exp(1j * np.linspace(0, np.pi, 64))
            require_no_zero_on_circle(A, B, *factor, near=around, role=role)
        residual = "none" if best is None else repr(best)
        advice = (
            "The full weight is not positive semidefinite, so a solution may not exist."
            if factor is None
            else "Scale the states and signals to similar magnitude; for scalar signals "
            "compensator_theory.solve_riccati is exact."
        )
        raise NoSolutionError(
            f"no stabilising solution of the Riccati equation of {role.map} was found in float64 "
            f"(the best: {residual}). {advice}"
        )
    if factor is not None and best.margin < CLOSE:
        close = best.poles[np.abs(np.abs(best.poles) - 1) < CLOSE]
        require_no_zero_on_circle(A, B, *factor, near=close, role=role)
    return best


def _best(A: Array, B: Array, weights: tuple[Array, Array, Array]) -> StabilisingSolution | None:
    """Return the best of SciPy's solutions after Newton steps: balanced, unbalanced, shifted.

    Where P is zero or nearly, as for a square G_zu whose zeros are all inside the unit circle,
    SciPy compares rounding noise with itself and fails. P + cI is not small.
    """
    candidates = []
    for balanced, shifted in ((True, False), (False, False), (True, True), (False, True)):
        try:
            P = _from_scipy(A, B, weights, balanced=balanced, shifted=shifted)
            candidates.append(_refined(_evaluated(A, B, weights, P)))
        except (np.linalg.LinAlgError, ValueError):
            continue
        if candidates[-1].margin > 0 and candidates[-1].residual < 1e-13:
            break
    return min(candidates, key=lambda s: (not s.margin > 0, s.residual), default=None)


def _in_square_roots(
    A: Array,
    B: Array,
    weights: tuple[Array, Array, Array],
    factor: tuple[Array, Array],
    best: StabilisingSolution | None,
) -> StabilisingSolution | None:
    """Return the solution by the square-root method; `best` if it fails."""
    starts: Iterator[Array] = starting_gains(A, B, *factor)
    if best is not None and best.margin > 0:
        starts = chain([best.K], starts)
    for K in starts:
        try:
            gain, S = kleinman(A, B, *factor, K)
            solution = _with_gain(A, B, weights, S.T @ S, gain, S)
            # The factor is a product of tens of orthogonal matrices; P can be better than S'S.
            P = solution.P + stein_solution(solution.closed_loop.T, _left_over(solution)[0])
            refined = _with_gain(A, B, weights, P, gain, S)
            return refined if refined.residual < solution.residual else solution
        except (np.linalg.LinAlgError, ValueError):
            continue
    return best


def _from_scipy(
    A: Array, B: Array, weights: tuple[Array, Array, Array], *, balanced: bool, shifted: bool
) -> Array:
    """Return SciPy's P; `shifted` solves for P + cI with other weights."""
    from scipy.linalg import solve_discrete_are

    Q, N, R = weights
    c = norm(Q) / (1 + norm(A) ** 2) if shifted else 0.0
    if shifted:
        Q, N, R = Q + c * (np.eye(len(A)) - A.T @ A), N - c * A.T @ B, R - c * B.T @ B
    with np.errstate(all="ignore"):
        P = solve_discrete_are(A, B, Q, R, s=N, balanced=balanced)
    return np.asarray(P - c * np.eye(len(A)))


def _refined(solution: StabilisingSolution) -> StabilisingSolution:
    """Refine P by Newton steps (a Lyapunov equation each) while the residual decreases."""
    for _ in range(5):
        if not solution.margin > 0:
            break
        s = solution
        try:
            P = s.P + stein_solution(s.closed_loop.T, _left_over(s)[0])
            better = _evaluated(s.A, s.B, (s.Q, s.N, s.R), P)
        except (np.linalg.LinAlgError, CompensatorError):
            break
        if not (better.residual < solution.residual and better.margin > 0):
            break
        solution = better
    return solution


def _evaluated(
    A: Array, B: Array, weights: tuple[Array, Array, Array], P: Array
) -> StabilisingSolution:
    _, N, R = weights
    innovation = R + B.T @ P @ B
    gain: Array = -np.asarray(np.linalg.solve(innovation, N.T + B.T @ P @ A), np.float64)
    return _with_gain(A, B, weights, P, gain)


def _with_gain(
    A: Array, B: Array, weights: tuple[Array, Array, Array], P: Array, gain: Array,
    root: Array | None = None,
) -> StabilisingSolution:  # fmt: skip
    Q, N, R = weights
    innovation = R + B.T @ P @ B
    if not (np.isfinite(P).all() and np.isfinite(gain).all()):
        raise np.linalg.LinAlgError("not finite")
    bare = StabilisingSolution(A, B, Q, R, N, P, gain, innovation, np.inf)
    left, size = _left_over(bare)
    residual = norm(left) / size if size else 0.0
    return StabilisingSolution(A, B, Q, R, N, P, gain, innovation, residual, root)


def _left_over(s: StabilisingSolution) -> tuple[Array, float]:
    """Return the residual of the equation, and the sum of the norms of its terms."""
    terms = (s.A.T @ s.P @ s.A, (s.N + s.A.T @ s.P @ s.B) @ s.K, s.Q, -s.P)
    left = sum(terms[1:], terms[0])
    return np.asarray((left + left.T) / 2), sum(map(norm, terms))


def factor_of(weights: tuple[Array, Array, Array]) -> tuple[Array, Array] | None:
    """Return (E_1, E_2) with [Q N; N' R] = [E_1 E_2]'[E_1 E_2]; None if not semidefinite."""
    Q, N, R = weights
    full = np.block([[Q, N], [N.T, R]])
    scale = np.sqrt(np.abs(np.diag(full)))
    scale = np.where(scale > 0, scale, 1.0)
    scaled = full / np.outer(scale, scale)
    if np.linalg.eigvalsh(scaled).min(initial=0.0) < -1e-12:
        return None
    rows = square_root_columns(scaled).T * scale
    return rows[:, : len(Q)], rows[:, len(Q) :]


def symmetric(weight: Array, name: str) -> Array:
    if np.abs(weight - weight.T).max(initial=0.0) > 1e-12 * np.abs(weight).max(initial=0.0):
        raise InputError(f"{name} is not symmetric; use ({name} + {name}') / 2.")
    return np.asarray((weight + weight.T) / 2)
