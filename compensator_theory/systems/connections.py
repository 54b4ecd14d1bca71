"""What systems in state space make together: in parallel, in series, in a loop, all states kept."""

from typing import TypeAlias

import sympy
from sympy import ImmutableMatrix

from compensator_theory.errors import ImproperError, NoSolutionError
from compensator_theory.matrices.linear_algebra import solve

Matrices: TypeAlias = tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]
"""(A, B, C, D)."""


def in_parallel(first: Matrices, second: Matrices) -> Matrices:
    """Return the matrices of y = y_1 + y_2.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from compensator_theory.systems.connections import in_parallel
    >>> lag = tuple(ImmutableMatrix([[x]]) for x in (-2, 1, 3, 0))
    >>> in_parallel(lag, lag)[0]
    Matrix([
    [-2,  0],
    [ 0, -2]])
    """
    (A, B, C, D), (A_2, B_2, C_2, D_2) = first, second
    return ImmutableMatrix(sympy.diag(A, A_2)), B.col_join(B_2), C.row_join(C_2), D + D_2


def in_series(last: Matrices, before: Matrices) -> Matrices:
    """Return the matrices of u to the one before, and its output to the last.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from compensator_theory.systems.connections import in_series
    >>> lag = tuple(ImmutableMatrix([[x]]) for x in (-2, 1, 3, 0))
    >>> in_series(lag, lag)[0]
    Matrix([
    [-2,  3],
    [ 0, -2]])
    """
    (A, B, C, D), (A_2, B_2, C_2, D_2) = last, before
    above = A.row_join(B * C_2)
    below = ImmutableMatrix.zeros(A_2.rows, A.rows).row_join(A_2)
    return above.col_join(below), (B * D_2).col_join(B_2), C.row_join(D * C_2), D * D_2


def in_feedback(plant: Matrices, other: Matrices, feedback: int) -> Matrices:
    """Return the matrices from v to y of the plant under u = v + f K y.

    Raises
    ------
    ImproperError
        If det(I - f D D_k) = 0: the loop is not well posed.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from compensator_theory.systems.connections import in_feedback
    >>> lag = tuple(ImmutableMatrix([[x]]) for x in (-2, 1, 3, 0))
    >>> in_feedback(lag, lag, -1)[0]
    Matrix([
    [-2, -3],
    [ 3, -2]])
    """
    (A_1, B_1, C_1, D_1), (A_2, B_2, C_2, D_2) = plant, other
    n, n_2 = int(A_1.rows), int(A_2.rows)
    p, m = int(D_1.rows), int(D_1.cols)
    K_C, K_D = feedback * C_2, feedback * D_2
    try:  # y = E (C x + D K_C x_k + D v)
        E = solve(ImmutableMatrix(sympy.eye(p) - D_1 * K_D), sympy.eye(p))
    except NoSolutionError as error:
        raise ImproperError(
            "the loop is not well posed: det(I - f D D_k) = 0 for the direct terms; use a "
            "strictly proper one"
        ) from error
    C = E * C_1.row_join(D_1 * K_C)
    D = E * D_1
    u = (K_D * C) + ImmutableMatrix.zeros(m, n).row_join(K_C)
    u_v = sympy.eye(m) + K_D * D
    below = ImmutableMatrix.zeros(n_2, n).row_join(A_2) + B_2 * C
    above = A_1.row_join(ImmutableMatrix.zeros(n, n_2)) + B_1 * u
    A, B = above.col_join(below), (B_1 * u_v).col_join(B_2 * D)
    a, b, c, d = (ImmutableMatrix(x.applyfunc(sympy.cancel)) for x in (A, B, C, D))
    return a, b, c, d
