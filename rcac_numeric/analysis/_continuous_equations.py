"""Numerical solution of the continuous-time algebraic Riccati equation, with checks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import linalg

from compensator_theory.errors import (
    CompensatorError,
    InputError,
    NoSolutionError,
    NotControllableError,
    UnitCircleError,
)
from rcac_numeric.analysis._equations import (
    LARGEST_RESIDUAL,
    stabilising_solution,
)
from rcac_numeric.analysis._gramians import norm
from rcac_numeric.analysis._obstacles import EPS, REGULATOR, balanced_pencil, words
from rcac_numeric.analysis._square_roots import triangle
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._balancing import balancing_scales, scaled_states
from rcac_numeric.arrays._definite_matrices import square_root_columns
from rcac_numeric.arrays._values import Result

# The target residual; and the order from which SciPy's solution with Newton steps is accepted
# before the square-root method is tried.
GOOD, MANY_STATES, GOOD_OF_MANY = 1e-12, 40, 1e-10

Weights = tuple[Array, Array, Array]


@dataclass(frozen=True, eq=False)
class ContinuousSolution(Result):
    """The stabilising solution of a continuous-time Riccati equation.

    Attributes
    ----------
    A, B : arrays of shape (n, n), (n, m)
    Q, R, N : arrays of shape (n, n), (m, m), (n, m)
        The weights.
    P : array, shape (n, n)
    K : array, shape (m, n)
        The gain -R^{-1} (N' + B'P), for u = Kx.
    P_root : array, shape (n, n), or None
        S with P = S'S; None where the weight is not positive semidefinite.
    residual : float
        Norm of the residual of the equation over the sum of the norms of its terms.
    """

    A: Array
    B: Array
    Q: Array
    R: Array
    N: Array
    P: Array
    K: Array
    residual: float
    P_root: Array | None = None

    @property
    def closed_loop(self) -> Array:
        """A + BK, shape (n, n)."""
        return np.asarray(self.A + self.B @ self.K)

    @cached_property
    def poles(self) -> ComplexArray:
        """The n eigenvalues of A + BK, in the open left half plane."""
        return np.linalg.eigvals(self.closed_loop).astype(np.complex128)

    @property
    def margin(self) -> float:
        """Distance of the closed-loop poles to the imaginary axis."""
        return -float(self.poles.real.max(initial=-np.inf))

    def __repr__(self) -> str:
        return (
            f"ContinuousSolution(n={len(self.A)}, residual={self.residual:.1e}, "
            f"margin={self.margin:.3g})"
        )


def continuous_solution(
    A: Array, B: Array, weights: Weights, factor: tuple[Array, Array] | None, *, of_factors: bool
) -> ContinuousSolution:
    """Return the continuous-time solution for (Q, N, R) and their factor (E_1, E_2), if any."""
    if not A.size:
        raise InputError("A is 0 x 0: the plant has no states to estimate or control.")
    _require_regular(weights[2], factor if of_factors else None)
    with np.errstate(all="ignore"):  # an overflow gives a large residual
        _require_stabilisable(A, B)
        if factor is not None:
            _require_no_zero_on_axis(A, B, *factor)
        solution = min(
            _until_good(_candidates(A, B, weights, factor)),
            key=lambda s: (not s.margin > 0, s.residual), default=None,
        )  # fmt: skip
    if solution is None or not solution.margin > 0 or not solution.residual < LARGEST_RESIDUAL:
        best = "none" if solution is None else repr(solution)
        advice = (
            "The full weight is not positive semidefinite, so a solution may not exist."
            if factor is None
            else "Scale the states and signals to similar magnitude; for scalar signals "
            "compensator_theory.solve_riccati is exact."
        )
        raise NoSolutionError(
            "no stabilising solution of the continuous-time Riccati equation was found in float64 "
            f"(the best: {best}). {advice}"
        )
    if factor is None:
        _require_no_pole_on_axis(solution, weights)
    return solution


def _require_regular(R: Array, factor: tuple[Array, Array] | None) -> None:
    """Raise if a direction of u has no weight; with factors, E_2 decides."""
    advice = (
        "in continuous time every direction of u needs a weight. Weight it, or sample the plant "
        'and use time="discrete".'
    )
    m = len(R)
    if factor is not None:
        scaled = factor[1] / np.maximum(np.linalg.norm(factor[1], axis=0), 1e-300)
        if np.linalg.matrix_rank(scaled) < m:
            raise InputError(f"E_2 has dependent columns: {advice}")
        return
    sizes = np.sqrt(np.abs(np.diag(R)))
    scale = np.where(sizes > 0, sizes, np.sqrt(np.abs(R).max(initial=0.0)) or 1.0)
    values = np.abs(np.linalg.eigvalsh(R / np.outer(scale, scale)))
    if not values.min(initial=1.0) > 10 * m * EPS * values.max(initial=1.0):
        raise InputError(f"R is singular: {advice}")


def _until_good(candidates: Iterator[ContinuousSolution]) -> Iterator[ContinuousSolution]:
    """Return the candidates up to the first with a residual of rounding."""
    for one in candidates:
        yield one
        if one.margin > 0 and one.residual < (GOOD if len(one.A) <= MANY_STATES else GOOD_OF_MANY):
            return


def _candidates(
    A: Array, B: Array, weights: Weights, factor: tuple[Array, Array] | None
) -> Iterator[ContinuousSolution]:
    """Yield refined solutions, the preferred method first."""
    if factor is not None and len(A) <= MANY_STATES:
        yield from _in_square_roots(A, B, weights, factor)
    for balanced in (True, False):
        try:
            P = linalg.solve_continuous_are(
                A, B, weights[0], weights[2], s=weights[1], balanced=balanced
            )
            yield _refined(A, B, weights, np.asarray(P), factor)
        except (np.linalg.LinAlgError, ValueError):
            continue
    if factor is not None and len(A) > MANY_STATES:
        yield from _in_square_roots(A, B, weights, factor)


def _evaluated(A: Array, B: Array, weights: Weights, P: Array) -> tuple[Array, Array, float]:
    """Return the gain of P, the residual, and the sum of the norms of the terms."""
    _, N, R = weights
    if not np.isfinite(P).all():
        raise np.linalg.LinAlgError("not finite")
    K = -np.asarray(np.linalg.solve(R, N.T + B.T @ P))
    left, size = _left_over(A, B, weights, P, K)
    return K, left, size


def _left_over(A: Array, B: Array, weights: Weights, P: Array, K: Array) -> tuple[Array, float]:
    Q, N, R = weights
    closed, cross = A + B @ K, N @ K
    terms = (closed.T @ P, P @ closed, Q, cross + cross.T, K.T @ R @ K)
    return np.asarray(sum(terms[1:], terms[0])), sum(map(norm, terms))


def _solution(
    A: Array, B: Array, weights: Weights, P: Array, K: Array, S: Array | None
) -> ContinuousSolution:
    left, size = _left_over(A, B, weights, P, K)
    return _answer(A, B, weights, P, K, norm(left) / size if size else 0.0, S)


def _answer(
    A: Array, B: Array, weights: Weights, P: Array, K: Array, residual: float, S: Array | None
) -> ContinuousSolution:
    Q, N, R = weights
    return ContinuousSolution(A, B, Q, R, N, P, K, residual, S)


def _refined(
    A: Array, B: Array, weights: Weights, P: Array, factor: tuple[Array, Array] | None
) -> ContinuousSolution:
    """Refine P by Newton steps (a Lyapunov equation each) while the residual decreases."""
    P = (P + P.T) / 2
    K, left, size = _evaluated(A, B, weights, P)
    for _ in range(5):
        try:
            better = P + _lyapunov((A + B @ K).T, -left)
            refined = better, *_evaluated(A, B, weights, better)
        except (np.linalg.LinAlgError, ValueError):
            break
        if not norm(refined[2]) / (refined[3] or 1.0) < norm(left) / (size or 1.0):
            break
        P, K, left, size = refined
    S = None if factor is None else triangle(square_root_columns(P).T)
    return _answer(A, B, weights, P, K, norm(left) / size if size else 0.0, S)


def _lyapunov(A: Array, Q: Array) -> Array:
    """Return the symmetric X with A X + X A' = Q, by Bartels and Stewart; raise if singular."""
    T, V = linalg.schur(A, output="real")
    X, scale, info = linalg.lapack.dtrsyl(T, T, V.T @ Q @ V, tranb="C")
    if info:  # two modes of opposite sign: LAPACK perturbs one of them
        raise np.linalg.LinAlgError("the Lyapunov equation is singular")
    X = scale * V @ X @ V.T
    return np.asarray((X + X.T) / 2)


def _in_square_roots(
    A: Array, B: Array, weights: Weights, factor: tuple[Array, Array]
) -> Iterator[ContinuousSolution]:
    """Return the solution of an equivalent discrete-time equation, for the best of several h."""
    h = 0.7 / (norm(A) or 1.0)
    candidate = None
    # h between the time constants of the fastest and the slowest closed-loop pole.
    for _ in range(5):
        try:
            better = _by_sampling(A, B, weights, factor, h)
        # Warnings concern the discrete-time equation.
        except (CompensatorError, np.linalg.LinAlgError):
            break
        if candidate is not None and not better.residual < 0.5 * candidate.residual:
            break
        candidate, sizes = better, np.abs(better.poles)
        h = float(np.exp(-np.mean(np.log(np.maximum(sizes, 1e-8 * sizes.max())))))
    if candidate is not None:
        yield candidate


def _by_sampling(
    A: Array, B: Array, weights: Weights, factor: tuple[Array, Array], h: float
) -> ContinuousSolution:
    n, root, (E_1, E_2) = len(A), np.sqrt(2 * h), factor
    inverse = np.linalg.inv(np.eye(n) - h * A)
    moved = (
        inverse @ (np.eye(n) + h * A), root * inverse @ B, root * E_1 @ inverse,
        E_2 + h * E_1 @ inverse @ B,
    )  # fmt: skip
    squares = moved[2].T @ moved[2], moved[2].T @ moved[3], moved[3].T @ moved[3]
    sampled = stabilising_solution(moved[0], moved[1], squares, moved[2:], REGULATOR)
    S = triangle(E_1) if sampled.P_root is None else sampled.P_root
    K = 2 / root * np.linalg.solve((np.eye(n) + sampled.closed_loop).T, sampled.K.T).T
    P, closed, performance = sampled.P, A + B @ K, E_1 + E_2 @ K
    terms = closed.T @ P, P @ closed, performance.T @ performance
    residual = norm(sum(terms[1:], terms[0])) / (sum(map(norm, terms)) or 1.0)
    return _answer(A, B, weights, P, np.asarray(K), residual, S)


def _require_stabilisable(A: Array, B: Array) -> None:
    """Raise for an uncontrollable mode of A on or right of the imaginary axis."""
    scale = balancing_scales(A)
    A, B = scaled_states(A, scale), B / scale[:, None]
    size = norm(A) or 1.0
    widths = np.linalg.norm(B, axis=0)
    scaled = B[:, widths > 0] / widths[widths > 0] * size
    for mode in np.linalg.eigvals(A):
        if not mode.real >= -EPS * abs(mode):
            continue
        pencil = np.hstack([A - mode * np.eye(len(A)), scaled])
        smallest = np.linalg.svd(pencil, compute_uv=False)[len(A) - 1]
        if smallest <= 100 * len(A) * EPS * size:
            raise NotControllableError(
                f"(A, B) is not stabilisable: no gain moves the mode {words(mode)} of A, which is "
                f"on or right of the imaginary axis (smallest singular value {smallest:.1e} of "
                f"[A - sI, B], of norm {size:.3g}). Remove it from the plant, or move it into the "
                "left half plane if it models a disturbance."
            )


def _require_no_zero_on_axis(A: Array, B: Array, E_1: Array, E_2: Array) -> None:
    """Raise for a zero of [A - sI, B; E_1, E_2] on the imaginary axis.

    E_2 is one to one, so that these are the modes of A - B E_2^+ E_1 there which the rest of z,
    (I - E_2 E_2^+) E_1, does not show.
    """
    onto = np.linalg.lstsq(E_2, E_1, rcond=None)[0]
    inner, rest = A - B @ onto, E_1 - E_2 @ onto
    scale = balancing_scales(inner)
    inner, rest = scaled_states(inner, scale), rest * scale
    size = norm(inner) or 1.0
    shown = rest / (norm(E_1 * scale) or 1.0) * size
    modes = np.linalg.eigvals(inner)
    for mode in modes:
        # A multiple mode is computed as a cluster, off by a root of the rounding error.
        for one in (mode, modes[np.abs(modes - mode) < 1e-4 * size].mean()):
            at = 1j * one.imag
            if not abs(one.real) <= 100 * len(A) * EPS * size:
                continue
            pencil = np.vstack([inner - at * np.eye(len(A)), shown])
            least = float(np.linalg.svd(pencil, compute_uv=False)[-1])
            # The pencil is scaled by rows: a slow mode is below the rounding of a fast one.
            smallest = float(np.linalg.svd(balanced_pencil(pencil), compute_uv=False)[-1])
            if least <= 100 * len(A) * EPS * size and smallest <= 100 * len(A) * EPS:
                raise UnitCircleError(
                    "[A - sI, B; E_1, E_2], with E_1 and E_2 the factors of the weights, has a "
                    f"zero on the imaginary axis at {words(at)} (or A has a mode there without "
                    f"weight; smallest singular value {least:.1e}). The closed loop would keep a "
                    "pole on the axis, so no solution is stabilising. Weight the states of that "
                    "mode in Q."
                )


def _require_no_pole_on_axis(solution: ContinuousSolution, weights: Weights) -> None:
    """Raise for eigenvalues of the Hamiltonian matrix on the axis, up to rounding."""
    (Q, N, R), A, B = weights, solution.A, solution.B
    n = len(A)
    closing = np.linalg.solve(R, np.hstack([N.T, B.T]))
    inner = A - B @ closing[:, :n]
    H = np.block([[inner, -B @ closing[:, n:]], [N @ closing[:, :n] - Q, -inner.T]])
    size = norm(H)
    pole = solution.poles[np.argmax(solution.poles.real)]
    # A double eigenvalue on the axis is moved off it by the root of the rounding error.
    if solution.margin <= 100 * np.sqrt(EPS) * size:
        at = 1j * float(pole.imag)
        least = float(np.linalg.svd(H - at * np.eye(2 * n), compute_uv=False)[-1])
        if least <= 100 * n * EPS * size:
            raise UnitCircleError(
                f"the Hamiltonian matrix has an eigenvalue on the imaginary axis at {words(at)} "
                f"(smallest singular value {least:.1e}): a closed-loop pole would have to lie "
                "there, so no solution is stabilising. Change the weights: the full weight is not "
                "positive semidefinite."
            )
