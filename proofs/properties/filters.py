"""The unscented filter of Chapter 8 with a linear system, in rational arithmetic."""

from collections.abc import Callable

from hypothesis import strategies as st
from sympy import Matrix, Rational, eye, zeros

from compensator_theory.strategies import matrices, semidefinite_matrices

from ..ledger.checks import for_all

roots = st.sampled_from([Rational(1), Rational(2), Rational(1, 2)])  # of alpha


def weighted(x: Matrix, S: Matrix, root: Rational, f: Callable[[Matrix], Matrix]) -> Matrix:
    """Sum f over the points (8.10) with the weights (8.11), gamma_0 = (alpha - n) / alpha."""
    n, alpha = S.rows, root**2
    mean = (alpha - n) / alpha * f(x)
    for i in range(n):
        for sign in (1, -1):
            mean += f(x + sign * root * S[:, i]) / (2 * alpha)
    return mean


@for_all(A=matrices(2, 2), C=matrices(1, 2), S=matrices(2, 2), noise=matrices(2, 2),
         R=semidefinite_matrices(1), x=matrices(2, 1), root=roots)  # fmt: skip
def unscented_is_kalman(
    A: Matrix, C: Matrix, S: Matrix, noise: Matrix, R: Matrix, x: Matrix, root: Rational
) -> bool:
    """(8.22)-(8.24) give Ax and APA' + Q; the points of a square root of that have the cross
    covariance P^-C' and the variance CP^-C' + R; those of (8.22) know no Q.
    """
    A, C, S, noise, R, x = (Matrix(M) for M in (A, C, S, noise, R, x))
    P, Q = S * S.T, noise * noise.T
    mean = weighted(x, S, root, lambda X: A * X)
    spread = weighted(x, S, root, lambda X: (A * X - mean) * (A * X - mean).T)
    P_minus = A * P * A.T + Q
    wide = Matrix.hstack(A * S, noise)  # a square root of P^-, padded to a square one
    square = Matrix.vstack(wide, zeros(2, 4))
    row = Matrix.hstack(C, zeros(1, 2))
    start = Matrix.vstack(mean, zeros(2, 1))
    y = weighted(start, square, root, lambda X: row * X)
    P_xy = weighted(start, square, root, lambda X: (X - start) * (row * X - y).T)
    P_yy = weighted(start, square, root, lambda X: (row * X - y) * (row * X - y).T) + R
    printed = weighted(mean, A * S, root, lambda X: (X - mean) * (C * X - C * mean).T)
    return bool(
        mean == A * x
        and spread + Q == P_minus
        and P_xy[:2, :] == P_minus * C.T
        and P_yy == C * P_minus * C.T + R
        and printed == A * P * A.T * C.T
        and square * square.T == Matrix.diag(P_minus, 0 * eye(2))
    )
