"""The discrete-time algebraic Riccati equation, in square roots, and checked."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import CompensatorError, InputError, NoSolutionError
from rcac_numeric.analysis._gramians import norm, stein_solution
from rcac_numeric.analysis._obstacles import (
    REGULATOR,
    Role,
    require_no_zero_on_circle,
    require_rank,
    require_stabilisable,
)
from rcac_numeric.analysis._solutions import StabilisingSolution
from rcac_numeric.analysis._square_roots import kleinman, starting_gains
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import square_root_columns
from rcac_numeric.arrays._validation import matrix

# From which closeness of a closed-loop pole to the unit circle a zero on it is looked for (for a
# zero of multiplicity d the pole is off by the 2d-th root of a rounding error), and the relative
# residual above which a solution is refused.
CLOSE, LARGEST_RESIDUAL = 0.05, 1e-8


def solve_dare(
    A: ArrayLike,
    B: ArrayLike,
    R_1: ArrayLike,
    R_2: ArrayLike | None = None,
    R_12: ArrayLike | None = None,
) -> StabilisingSolution:
    """Solve P = A'PA + R_1 - (A'PB + R_12)(R_2 + B'PB)^{-1}(B'PA + R_12') for the stabilising P.

    Parameters
    ----------
    A, B : arrays of shape (n, n), (n, m)
    R_1, R_2, R_12 : arrays of shape (n, n), (m, m), (n, m)
        Weights; R_1 and R_2 symmetric. R_2 may be singular or zero, the default; R_12 is zero by
        default. Where [R_1 R_12; R_12' R_2] is not positive semidefinite the causes of a failure
        are not looked for.

    Returns
    -------
    StabilisingSolution

    Raises
    ------
    NotControllableError
        Where a mode on or outside the unit circle cannot be moved; it is named.
    NoSolutionError
        Where the weights do not determine the gain (the deficient rank is named), or no
        stabilising solution was found.
    UnitCircleError
        Where a zero is on the unit circle; it is named.
    InputError
        Where an argument has the wrong shape or a weight is not symmetric.

    Notes
    -----
    From the gain of `scipy.linalg.solve_discrete_are`, or of the pencil in which no weight is
    squared, by Kleinman's iteration in square roots (`square_roots`): a weight R_2 of 1e-14 R_1
    costs no digit. Where the full weight is indefinite, by Newton steps on P. SciPy returns without
    a word a solution with a closed-loop pole on the unit circle for a zero at 1, and a meaningless
    one where R_2 = 0 and the inputs outnumber the outputs: hence the checks. Source: (A.6), (A.7).
    The form here needs no inverse of R_2, as (A.9) does. "Unique positive-semidefinite solution",
    said after (A.12), is true of the stabilising one only.

    Examples
    --------
    >>> from rcac_numeric import solve_dare
    >>> found = solve_dare([[2.0, -1.0], [1.0, 0.0]], [[1.0], [0.0]], [[0.0, 0.0], [0.0, 1.0]])
    >>> found.P.round(12) + 0.0
    array([[1., 0.],
           [0., 1.]])
    >>> found.residual < 1e-14, round(found.margin, 6)
    (True, 1.0)
    """
    A = matrix(A, "A", (None, None))
    n = len(A)
    A, B = matrix(A, "A", (n, n)), matrix(B, "B", (n, None))
    m = B.shape[1]
    weights = (
        symmetric(matrix(R_1, "R_1", (n, n)), "R_1"),
        np.zeros((n, m)) if R_12 is None else matrix(R_12, "R_12", (n, m)),
        np.zeros((m, m)) if R_2 is None else symmetric(matrix(R_2, "R_2", (m, m)), "R_2"),
    )
    return stabilising_solution(A, B, weights, factor_of(weights), REGULATOR)


def stabilising_solution(
    A: Array,
    B: Array,
    weights: tuple[Array, Array, Array],
    factor: tuple[Array, Array] | None,
    role: Role,
) -> StabilisingSolution:
    """As `solve_dare`, with (R_1, R_12, R_2), their factor (E_1, E_2) and the words for errors."""
    if not A.size:
        raise InputError("A is 0 x 0: a plant without states leaves nothing to estimate or move.")
    with np.errstate(all="ignore"):  # what leaves float64 ends in a bad residual
        require_stabilisable(A, B, role)
        if factor is not None:
            require_rank(A, B, *factor, role)
        best = _best(A, B, weights)
        if factor is not None:
            best = _in_square_roots(A, B, weights, factor, best)
    if best is None or not best.margin > 0 or not best.residual < LARGEST_RESIDUAL:
        if factor is not None:  # look all around the circle for the reason
            around = np.exp(1j * np.linspace(0, np.pi, 64))
            require_no_zero_on_circle(A, B, *factor, near=around, role=role)
        found = "none" if best is None else repr(best)
        advice = (
            "The full weight is not positive semidefinite, so that there may be none."
            if factor is None
            else "Scale the states and signals to like size; for scalar signals "
            "compensator_theory.solve_riccati is exact."
        )
        raise NoSolutionError(
            f"no stabilising solution of the Riccati equation of {role.map} was found in float64 "
            f"(the best: {found}). {advice}"
        )
    if factor is not None and best.margin < CLOSE:
        close = best.poles[np.abs(np.abs(best.poles) - 1) < CLOSE]
        require_no_zero_on_circle(A, B, *factor, near=close, role=role)
    return best


def _best(A: Array, B: Array, weights: tuple[Array, Array, Array]) -> StabilisingSolution | None:
    """The best of SciPy's answers after Newton steps: balanced, as it is, and shifted.

    Where P is zero or nearly, as for a square G_zu whose zeros are all inside the unit circle,
    SciPy holds rounding noise against itself and refuses. P + cI is not small.
    """
    found = []
    for balanced, shifted in ((True, False), (False, False), (True, True), (False, True)):
        try:
            P = _from_scipy(A, B, weights, balanced=balanced, shifted=shifted)
            found.append(_refined(_evaluated(A, B, weights, P)))
        except (np.linalg.LinAlgError, ValueError):
            continue
        if found[-1].margin > 0 and found[-1].residual < 1e-13:
            break
    return min(found, key=lambda s: (not s.margin > 0, s.residual), default=None)


def _in_square_roots(
    A: Array,
    B: Array,
    weights: tuple[Array, Array, Array],
    factor: tuple[Array, Array],
    best: StabilisingSolution | None,
) -> StabilisingSolution | None:
    """The solution that no weight was squared for; `best` where there is none."""
    starts: Iterator[Array] = starting_gains(A, B, *factor)
    if best is not None and best.margin > 0:
        starts = chain([best.gain], starts)
    for K in starts:
        try:
            gain, S = kleinman(A, B, *factor, K)
            found = _with_gain(A, B, weights, S.T @ S, gain, S)
            # The factor is a product of tens of orthogonal matrices; P can be better than S'S.
            P = found.P + stein_solution(found.closed_loop.T, _left_over(found)[0])
            refined = _with_gain(A, B, weights, P, gain, S)
            return refined if refined.residual < found.residual else found
        except (np.linalg.LinAlgError, ValueError):
            continue
    return best


def _from_scipy(
    A: Array, B: Array, weights: tuple[Array, Array, Array], *, balanced: bool, shifted: bool
) -> Array:
    """SciPy's P; `shifted` by way of P + cI, which solves the equation with other weights."""
    from scipy.linalg import solve_discrete_are

    R_1, R_12, R_2 = weights
    c = norm(R_1) / (1 + norm(A) ** 2) if shifted else 0.0
    if shifted:
        R_1, R_12, R_2 = R_1 + c * (np.eye(len(A)) - A.T @ A), R_12 - c * A.T @ B, R_2 - c * B.T @ B
    with np.errstate(all="ignore"):
        P = solve_discrete_are(A, B, R_1, R_2, s=R_12, balanced=balanced)
    return np.asarray(P - c * np.eye(len(A)))


def _refined(solution: StabilisingSolution) -> StabilisingSolution:
    """Newton steps: one Lyapunov equation each, as long as the residual falls."""
    for _ in range(5):
        if not solution.margin > 0:
            break
        s = solution
        try:
            P = s.P + stein_solution(s.closed_loop.T, _left_over(s)[0])
            better = _evaluated(s.A, s.B, (s.R_1, s.R_12, s.R_2), P)
        except (np.linalg.LinAlgError, CompensatorError):
            break
        if not (better.residual < solution.residual and better.margin > 0):
            break
        solution = better
    return solution


def _evaluated(
    A: Array, B: Array, weights: tuple[Array, Array, Array], P: Array
) -> StabilisingSolution:
    _, R_12, R_2 = weights
    innovation = R_2 + B.T @ P @ B
    gain: Array = -np.asarray(np.linalg.solve(innovation, R_12.T + B.T @ P @ A), np.float64)
    return _with_gain(A, B, weights, P, gain)


def _with_gain(
    A: Array, B: Array, weights: tuple[Array, Array, Array], P: Array, gain: Array,
    factor: Array | None = None,
) -> StabilisingSolution:  # fmt: skip
    R_1, R_12, R_2 = weights
    innovation = R_2 + B.T @ P @ B
    if not (np.isfinite(P).all() and np.isfinite(gain).all()):
        raise np.linalg.LinAlgError("not finite")
    bare = StabilisingSolution(A, B, R_1, R_12, R_2, P, gain, innovation, np.inf)
    left, size = _left_over(bare)
    residual = norm(left) / size if size else 0.0
    return StabilisingSolution(A, B, R_1, R_12, R_2, P, gain, innovation, residual, factor)


def _left_over(s: StabilisingSolution) -> tuple[Array, float]:
    """What is left of the equation, and the sum of the norms of its terms."""
    terms = (s.A.T @ s.P @ s.A, (s.R_12 + s.A.T @ s.P @ s.B) @ s.gain, s.R_1, -s.P)
    left = sum(terms[1:], terms[0])
    return np.asarray((left + left.T) / 2), sum(map(norm, terms))


def factor_of(weights: tuple[Array, Array, Array]) -> tuple[Array, Array] | None:
    """(E_1, E_2) with [R_1 R_12; R_12' R_2] = [E_1 E_2]'[E_1 E_2]; None where there is none."""
    R_1, R_12, R_2 = weights
    full = np.block([[R_1, R_12], [R_12.T, R_2]])
    scale = np.sqrt(np.abs(np.diag(full)))
    scale = np.where(scale > 0, scale, 1.0)
    scaled = full / np.outer(scale, scale)
    if np.linalg.eigvalsh(scaled).min(initial=0.0) < -1e-12:
        return None
    rows = square_root_columns(scaled).T * scale
    return rows[:, : len(R_1)], rows[:, len(R_1) :]


def symmetric(weight: Array, name: str) -> Array:
    if np.abs(weight - weight.T).max(initial=0.0) > 1e-12 * np.abs(weight).max(initial=0.0):
        raise InputError(f"{name} is not symmetric; use ({name} + {name}') / 2.")
    return np.asarray((weight + weight.T) / 2)
