"""Riccati equations of a regulator in float64, discrete and continuous time."""

from __future__ import annotations

from typing import Literal, overload

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.analysis._continuous_equations import (
    ContinuousSolution,
    Weights,
    continuous_solution,
)
from rcac_numeric.analysis._equations import factor_of, stabilising_solution, symmetric
from rcac_numeric.analysis._obstacles import REGULATOR
from rcac_numeric.analysis._solutions import StabilisingSolution
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import matrix, one_of

Factor = tuple[Array, Array]


@overload
def solve_riccati(
    A: ArrayLike, B: ArrayLike, Q: ArrayLike | None = ..., R: ArrayLike | None = ...,
    N: ArrayLike | None = ..., *, time: Literal["discrete"], E_1: ArrayLike | None = ...,
    E_2: ArrayLike | None = ...,
) -> StabilisingSolution: ...  # fmt: skip
@overload
def solve_riccati(
    A: ArrayLike, B: ArrayLike, Q: ArrayLike | None = ..., R: ArrayLike | None = ...,
    N: ArrayLike | None = ..., *, time: Literal["continuous"], E_1: ArrayLike | None = ...,
    E_2: ArrayLike | None = ...,
) -> ContinuousSolution: ...  # fmt: skip
def solve_riccati(
    A: ArrayLike,
    B: ArrayLike,
    Q: ArrayLike | None = None,
    R: ArrayLike | None = None,
    N: ArrayLike | None = None,
    *,
    time: str | None = None,
    E_1: ArrayLike | None = None,
    E_2: ArrayLike | None = None,
) -> StabilisingSolution | ContinuousSolution:
    """Solve a regulator's Riccati equation for the stabilising P, in float64.

    In discrete time P = A'PA + Q - (A'PB + N) (R + B'PB)^{-1} (B'PA + N'), in continuous time
    A'P + PA + Q - (PB + N) R^{-1} (B'P + N') = 0. The gain K minimises the sum, or the integral, of
    x'Qx + 2 x'Nu + u'Ru over u = Kx.

    Parameters
    ----------
    A, B : arrays of shape (n, n), (n, m)
    Q, R, N : arrays of shape (n, n), (m, m), (n, m), optional
        Weights; Q and R symmetric. R and N are zero by default; in continuous time R is regular.
        Where [Q N; N' R] is not positive semidefinite the causes of a failure are not looked for.
    time : {"continuous", "discrete"}
    E_1, E_2 : arrays of shape (p, n), (p, m), optional
        In place of Q, R and N, the weights as a signal z = E_1 x + E_2 u: Q = E_1'E_1, N = E_1'E_2,
        R = E_2'E_2. No weight is squared then: an E_2 of 1e-10 costs no digit. E_2 is zero by
        default; in continuous time it has full column rank.

    Returns
    -------
    StabilisingSolution, in continuous time ContinuousSolution

    Raises
    ------
    NotControllableError
        Where a mode on or beyond the boundary of stability cannot be moved; it is named.
    NoSolutionError
        Where the weights do not determine the gain (the deficient rank is named), or no
        stabilising solution was found with a small residual.
    UnitCircleError
        Where a zero is on the unit circle, in continuous time on the imaginary axis; it is named.
    InputError
        Where an argument has the wrong shape, a weight is not symmetric, or R is singular in
        continuous time.

    Notes
    -----
    `compensator_theory.solve_riccati` answers the same exactly.

    In discrete time from the gain of `scipy.linalg.solve_discrete_are`, or of the pencil in which
    no weight is squared, by Kleinman's iteration in square roots (`square_roots`): a weight R of
    1e-14 Q costs no digit. Where the full weight is indefinite, by Newton steps on P. SciPy returns
    without a word a solution with a closed-loop pole on the unit circle for a zero at 1, and a
    meaningless one where R = 0 and the inputs outnumber the outputs: hence the checks. Source:
    (A.6), (A.7). The form here needs no inverse of R, as (A.9) does. "Unique positive-semidefinite
    solution", said after (A.12), is true of the stabilising one only.

    In continuous time, where the weights have factors, P is also that of the discrete-time equation
    of ``(I - hA)^{-1} (I + hA), sqrt(2h) (I - hA)^{-1} B, sqrt(2h) E_1 (I - hA)^{-1},
    E_2 + h E_1 (I - hA)^{-1} B`` for every h > 0 that leaves I - hA regular, and is found there, in
    square roots; else by `scipy.linalg.solve_continuous_are`. Either is refined by Newton steps,
    one Lyapunov equation each, and compared with the equation itself. The Kalman-Bucy filter is the
    dual: A', C' and the spectral densities of the noises. Source: P. Benner, A. J. Laub and V.
    Mehrmann, A collection of benchmark examples for the numerical solution of algebraic Riccati
    equations I (1995).

    Examples
    --------
    >>> from rcac_numeric import solve_riccati
    >>> A, B, Q = [[2.0, -1.0], [1.0, 0.0]], [[1.0], [0.0]], [[0.0, 0.0], [0.0, 1.0]]
    >>> solution = solve_riccati(A, B, Q, time="discrete")
    >>> solution.P.round(12) + 0.0
    array([[1., 0.],
           [0., 1.]])
    >>> solution.residual < 1e-14, round(solution.margin, 6)
    (True, 1.0)
    >>> A, B, Q, R = [[0, 1], [0, 0]], [[0], [1]], [[1, 0], [0, 0]], [[1]]
    >>> solution = solve_riccati(A, B, Q, R, time="continuous")  # poles: -1, -sqrt(2)
    >>> solution.K.round(12), solution.residual < 1e-14
    (array([[-1.        , -1.41421356]]), True)
    >>> solve_riccati([[1]], [[1]], E_1=[[0], [0]], E_2=[[0], [1]], time="continuous").P
    array([[2.]])
    """
    one_of(time, "time", ("continuous", "discrete"))
    A = matrix(A, "A", (None, None))
    n = len(A)
    A, B = matrix(A, "A", (n, n)), matrix(B, "B", (n, None))
    weights, factor = _weights(n, B.shape[1], Q, R, N, E_1, E_2)
    if time == "continuous":
        return continuous_solution(A, B, weights, factor, of_factors=E_1 is not None)
    return stabilising_solution(A, B, weights, factor, REGULATOR)


def _weights(
    n: int, m: int, Q: ArrayLike | None, R: ArrayLike | None, N: ArrayLike | None,
    E_1: ArrayLike | None, E_2: ArrayLike | None,
) -> tuple[Weights, Factor | None]:  # fmt: skip
    """Return (Q, N, R), and (E_1, E_2) if the full weight has a factor."""
    if (E_1 is None) == (Q is None) or (E_1 is not None and not (R is None is N)):
        raise InputError(
            "give the weights either as Q, R and N, or as E_1 and E_2, with z = E_1 x + E_2 u"
        )
    if E_1 is not None:
        left = matrix(E_1, "E_1", (None, n))
        right = np.zeros((len(left), m)) if E_2 is None else matrix(E_2, "E_2", (len(left), m))
        return (left.T @ left, left.T @ right, right.T @ right), (left, right)
    if E_2 is not None:
        raise InputError("E_2 goes with E_1; with Q give R and N")
    assert Q is not None
    shape: tuple[int, ...] = np.shape(Q)
    if len(shape) == 2 and shape[1] == n != shape[0]:
        raise InputError(
            f"Q has shape {shape}, and a weight of x is {n} x {n}. Pass factors as E_1 and E_2: "
            f"solve_riccati(A, B, E_1=E_1, E_2=E_2, time=time)."
        )
    weights = (
        symmetric(matrix(Q, "Q", (n, n)), "Q"),
        np.zeros((n, m)) if N is None else matrix(N, "N", (n, m)),
        np.zeros((m, m)) if R is None else symmetric(matrix(R, "R", (m, m)), "R"),
    )
    return weights, factor_of(weights)
