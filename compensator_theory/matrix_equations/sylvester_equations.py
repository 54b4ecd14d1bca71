"""Sylvester, Lyapunov and Stein equations, exact: unique solutions, families, or none."""

import math
from collections.abc import Sequence
from typing import Any

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, eye
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices.exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices.flint_matrices import is_rational_matrix
from compensator_theory.matrices.linear_algebra import determinant, solve
from compensator_theory.matrix_equations.rational_equations import solve_rational, sum_of_products
from compensator_theory.matrix_equations.solutions import (
    MatrixSolution,
    certified,
    solve_by_kronecker,
)
from compensator_theory.polynomial_matrices.exceptional_factors import denominators_of
from compensator_theory.polynomials.budget import ask


def solve_sylvester(A: MatrixLike, B: MatrixLike, C: MatrixLike) -> MatrixSolution:
    r"""Solve Sylvester's equation.

    .. math:: A X + X B = C

    Parameters
    ----------
    A, B, C : matrix
        n x n, m x m and n x m; with symbols, for generic values of them.

    Returns
    -------
    MatrixSolution
        One solution if no eigenvalue of A is one of -B: with p = det(sI - A) and
        :math:`p(A) X - X p(-B) = \sum_k p_k \sum_{i+j=k-1} A^i C (-B)^j`, where p(A) = 0. Else a
        family, by Kronecker's system.

    Raises
    ------
    NoSolutionError
        If A and -B share an eigenvalue and the equation contradicts itself.
    InputError, BudgetError
        If the shapes do not fit, or the matrices are too large.

    Notes
    -----
    Source: J. J. Sylvester (1884); A. Jameson, SIAM J. Applied Mathematics 16 (1968) 1020-1023. The
    convention is that of ``scipy.linalg.solve_sylvester``.

    Examples
    --------
    >>> from compensator_theory import solve_sylvester
    >>> found = solve_sylvester([[0, 1], [-2, -3]], [["a"]], [[1], [0]])
    >>> print(found, found.exceptional)
    X = [[(a - 3)/(a**2 - 3*a + 2)], [2/(a**2 - 3*a + 2)]] (a - 1, a - 2)
    """
    a, b, c = (exact_matrix(M, name) for M, name in ((A, "A"), (B, "B"), (C, "C")))
    _require_shapes(a, b, c, "C")
    identity, sources = "A X + X B = C", (a, b, c)
    found = _by_characteristic_polynomial(a, b, c)
    if found is not None:
        X, divisors = found
        residual = [sum_of_products((a, X), (X, b), (-c,))]
        return certified(identity, residual, X, (), [*divisors, *denominators_of(sources)])
    X, more, divisors = solve_by_kronecker(
        [[(a, eye(b.rows)), (eye(a.rows), b)]],
        c.shape,
        list(c),
        contradiction="A X + X B = C has no solution: A and -B share an eigenvalue, and C lies "
        "outside of what A X + X B reaches; change C, or give the symbols other values",
        sources=sources,
    )
    return certified(
        identity, [a * X + X * b - c, *(a * Y + Y * b for Y in more)], X, more, divisors
    )


def solve_lyapunov(A: MatrixLike, Q: MatrixLike) -> MatrixSolution:
    r"""Solve Lyapunov's equation.

    .. math:: A X + X A' + Q = 0

    Parameters
    ----------
    A, Q : matrix
        n x n; Q need not be symmetric. For :math:`A' P + P A + Q = 0` give the transpose of A.

    Returns
    -------
    MatrixSolution
        X is symmetric if Q is and X is unique.

    Raises
    ------
    NoSolutionError
        If A has two eigenvalues with the sum 0 and the equation contradicts itself.
    InputError, BudgetError
        If the shapes do not fit, or the matrices are too large.

    Notes
    -----
    Source: A. M. Lyapunov (1892). The convention is that of ``control.lyap``.

    Examples
    --------
    >>> from compensator_theory import solve_lyapunov
    >>> solve_lyapunov([[0, -2], [1, -3]], [[1, 0], [0, 1]]).X
    Matrix([
    [5/4, 1/4],
    [1/4, 1/4]])
    >>> found = solve_lyapunov([[0, 1], ["-b", "-a"]], [[0, 0], [0, 1]])
    >>> found.X, found.exceptional
    (Matrix([
    [1/(2*a*b),       0],
    [        0, 1/(2*a)]]), (a, b))
    """
    a, q = exact_matrix(A, "A"), exact_matrix(Q, "Q")
    _require_shapes(a, a.T, q, "Q")
    identity = "A X + X A' + Q = 0"
    found = _by_characteristic_polynomial(a, a.T, -q)
    if found is not None:
        X, divisors = found
        residual = [sum_of_products((a, X), (X, a.T), (q,))]
        return certified(identity, residual, X, (), [*divisors, *denominators_of((a, q))])
    X, more, divisors = solve_by_kronecker(
        [[(a, eye(a.rows)), (eye(a.rows), a.T)]],
        q.shape,
        list(-q),
        contradiction="A X + X A' + Q = 0 has no solution: two eigenvalues of A have the sum 0, "
        "and Q lies outside of what A X + X A' reaches; remove these modes, or change Q",
        sources=(a, q),
    )
    left = [a * X + X * a.T + q, *(a * Y + Y * a.T for Y in more)]
    return certified(identity, left, X, more, divisors)


def solve_stein(A: MatrixLike, Q: MatrixLike, B: MatrixLike | None = None) -> MatrixSolution:
    r"""Solve Stein's equation, the discrete Lyapunov equation.

    .. math:: X = A X B + Q, \qquad B = A' \text{ by default}

    Parameters
    ----------
    A, Q, B : matrix
        n x n, n x m and m x m.

    Returns
    -------
    MatrixSolution

    Raises
    ------
    NoSolutionError
        If an eigenvalue of A is the reciprocal of one of B and the equation contradicts itself.
    InputError, BudgetError
        If the shapes do not fit, or the matrices are too large.

    Notes
    -----
    With p = det(sI - A) and the reciprocal polynomial :math:`\tilde p(B) = \sum_k p_k B^{n-k}`,
    :math:`X \tilde p(B) = \sum_k p_k \sum_{j<k} A^j Q B^{n-k+j}`. Source: P. Stein, J. Res.
    Nat. Bureau of Standards 48 (1952). The convention is that of
    ``scipy.linalg.solve_discrete_lyapunov``.

    Examples
    --------
    >>> from compensator_theory import solve_stein
    >>> found = solve_stein([[0, 1], ["-b", "-a"]], [[0, 0], [0, 1]])
    >>> found.X[0, 0].factor(), found.exceptional
    ((b + 1)/((b - 1)*(a - b - 1)*(a + b + 1)), (b - 1, a + b + 1, a - b - 1))
    """
    a, q = exact_matrix(A, "A"), exact_matrix(Q, "Q")
    b = a.T if B is None else exact_matrix(B, "B")
    _require_shapes(a, b, q, "Q")
    identity = "X = A X B + Q"
    found = _by_characteristic_polynomial(a, b, q, stein=True)
    if found is not None:
        X, divisors = found
        residual = [sum_of_products((-a, X, b), (X,), (-q,))]
        return certified(identity, residual, X, (), [*divisors, *denominators_of((a, b, q))])
    X, more, divisors = solve_by_kronecker(
        [[(eye(a.rows), eye(b.rows)), (-a, b)]],
        q.shape,
        list(q),
        contradiction="X = A X B + Q has no solution: an eigenvalue of A is the reciprocal of one "
        "of B, and Q lies outside of what X - A X B reaches; remove these modes, or change Q",
        sources=(a, b, q),
    )
    left = [a * X * b + q - X, *(a * Y * b - Y for Y in more)]
    return certified(identity, left, X, more, divisors)


def _require_shapes(a: Matrix, b: Matrix, c: Matrix, name: str) -> None:
    if a.rows != a.cols or b.rows != b.cols or c.shape != (a.rows, b.rows):
        raise InputError(
            f"A is {a.rows} x {a.cols}, B is {b.rows} x {b.cols} and {name} is {c.rows} x "
            f"{c.cols}; A and B must be square, and {name} have the rows of A and the columns of B"
        )
    if 0 in c.shape:
        raise InputError(f"{name} is {c.rows} x {c.cols}; an equation needs at least one unknown")
    symbols = set().union(*(matrix.free_symbols for matrix in (a, b, c)))
    if symbols:  # the determinant that is divided by has as many terms, in the worst case
        degree = a.rows + b.rows
        ask("terms", math.comb(degree + len(symbols), degree), "the matrix equation with symbols")
    ask("entries", (a.rows * b.rows) ** 2 // 400, "the matrix equation")


def _by_characteristic_polynomial(
    a: ImmutableMatrix, b: ImmutableMatrix, c: ImmutableMatrix, *, stein: bool = False
) -> tuple[ImmutableMatrix, list[Expr]] | None:
    """Solve A X + X B = C, or X = A X B + C; None where the solution is not unique.

    The right side is summed with the powers of one matrix, so that no system of n m unknowns
    appears: O(n) products.
    """
    if all(map(is_rational_matrix, (a, b, c))):
        X = solve_rational(a, b, c, stein=stein)
        return None if X is None else (X, [])
    work = _Symbolic(a, b, c)
    p = work.characteristic_polynomial()
    size, one = a.rows, work.identity(b.rows)
    A, B, C = work.matrices
    if stein:
        total, value, power, terms = C * 0, one * 0, one, [C * 0]
        for _ in range(size):  # A^k X B^k = X - T_k with T_(k+1) = A T_k B + C
            terms.append(A * terms[-1] * B + C)
        for k in range(size, -1, -1):  # 0 = p(A) X B^n = sum of p_k (X - T_k) B^(n-k)
            value = value + power * p[k]
            total = total + terms[k] * power * p[k]
            power = power * B
        sign = 1
    else:
        M = B * (-1)
        total, value, power, term = C * 0, one * 0, one, C * 0
        for k in range(size + 1):
            total, value = total + term * p[k], value + power * p[k]
            term = A * term + C * power  # A^k X - X M^k
            power = power * M
        sign = -1
    inverted, right = work.back(value), work.back(total * sign)
    try:
        X = solve(inverted.T, right.T).T
    except NoSolutionError:
        return None
    return ImmutableMatrix(X.applyfunc(sympy.cancel)), [determinant(inverted)]


class _Symbolic:
    """The three matrices over one ring of SymPy."""

    def __init__(self, *matrices: ImmutableMatrix) -> None:
        first, *rest = (DomainMatrix.from_Matrix(matrix) for matrix in matrices)
        self.matrices: Sequence[Any] = first.unify(*rest, fmt="dense")

    def characteristic_polynomial(self) -> list[Any]:
        return list(reversed(self.matrices[0].charpoly()))

    def identity(self, size: int) -> Any:
        return DomainMatrix.eye(size, self.matrices[0].domain).to_dense()

    def back(self, matrix: Any) -> ImmutableMatrix:
        return ImmutableMatrix(matrix.to_Matrix())
