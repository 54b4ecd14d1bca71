"""Sylvester, Lyapunov and Stein equations, exact: unique solutions, families, or none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from operator import add, mul
from typing import Any

import flint
from sympy import Expr, ImmutableMatrix, Matrix, Poly, eye
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.lqg._solutions import (
    MatrixSolution,
    certified,
    solve_by_kronecker,
)
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._exceptional_factors import denominators_of
from compensator_theory.matrices._flint_matrices import (
    from_flint,
    is_rational_matrix,
    rational_in_flint,
    to_flint,
)
from compensator_theory.matrices._linear_algebra import determinant, solve
from compensator_theory.matrices._residues import primes
from compensator_theory.polynomials._budget import ask, decimal_digits
from compensator_theory.polynomials._carrying import carrying


@carrying()
def solve_sylvester(A: MatrixLike, B: MatrixLike, C: MatrixLike) -> MatrixSolution:
    r"""Solve Sylvester's equation.

    .. math:: A X + X B + C = 0

    Parameters
    ----------
    A, B, C : matrix
        n x n, m x m and n x m; with symbols, for generic values of them.

    Returns
    -------
    MatrixSolution
        One solution if no eigenvalue of A is one of -B: with p = det(sI - A) and
        :math:`X p(-B) - p(A) X = \sum_k p_k \sum_{i+j=k-1} A^i C (-B)^j`, where p(A) = 0. Else a
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
    sign is that of Lyapunov's and Stein's equations here, and of ``control.lyap(A, B, C)``: for the
    A X + X B = C of ``scipy.linalg.solve_sylvester`` and MATLAB's ``sylvester`` give -C.

    Examples
    --------
    >>> from compensator_theory import solve_sylvester
    >>> solution = solve_sylvester([[0, 1], [-2, -3]], [["a"]], [[-1], [0]])
    >>> print(solution, solution.exceptional)
    X = [[(a - 3)/(a**2 - 3*a + 2)], [2/(a**2 - 3*a + 2)]] (a - 1, a - 2)
    """
    a, b, c = (exact_matrix(M, name) for M, name in ((A, "A"), (B, "B"), (C, "C")))
    _require_shapes(a, b, c, "C")
    identity, sources = "A X + X B + C = 0", (a, b, c)
    solution = _by_characteristic_polynomial(a, b, -c)
    if solution is not None:
        X, divisors = solution
        residual = [sum_of_products((a, X), (X, b), (c,))]
        return certified(identity, residual, X, (), [*divisors, *denominators_of(sources)])
    X, more, divisors = solve_by_kronecker(
        [[(a, eye(b.rows)), (eye(a.rows), b)]],
        c.shape,
        list(-c),
        contradiction="A X + X B + C = 0 has no solution: A and -B share an eigenvalue, and C is "
        "not in the range of X -> A X + X B; change C, or give the symbols other values",
        sources=sources,
    )
    return certified(
        identity, [a * X + X * b + c, *(a * Y + Y * b for Y in more)], X, more, divisors
    )


@carrying()
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
    >>> solution = solve_lyapunov([[0, 1], ["-b", "-a"]], [[0, 0], [0, 1]])
    >>> solution.X, solution.exceptional
    (Matrix([
    [1/(2*a*b),       0],
    [        0, 1/(2*a)]]), (a, b))
    """
    a, q = exact_matrix(A, "A"), exact_matrix(Q, "Q")
    _require_shapes(a, a.T, q, "Q")
    identity = "A X + X A' + Q = 0"
    solution = _by_characteristic_polynomial(a, a.T, -q)
    if solution is not None:
        X, divisors = solution
        residual = [sum_of_products((a, X), (X, a.T), (q,))]
        return certified(identity, residual, X, (), [*divisors, *denominators_of((a, q))])
    X, more, divisors = solve_by_kronecker(
        [[(a, eye(a.rows)), (eye(a.rows), a.T)]],
        q.shape,
        list(-q),
        contradiction="A X + X A' + Q = 0 has no solution: two eigenvalues of A have the sum 0, "
        "and Q is not in the range of X -> A X + X A'; remove these modes, or change Q",
        sources=(a, q),
    )
    left = [a * X + X * a.T + q, *(a * Y + Y * a.T for Y in more)]
    return certified(identity, left, X, more, divisors)


@carrying()
def solve_stein(A: MatrixLike, Q: MatrixLike, B: MatrixLike | None = None) -> MatrixSolution:
    r"""Solve Stein's equation, the discrete Lyapunov equation.

    .. math:: A X B - X + Q = 0, \qquad B = A' \text{ by default}

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
    >>> solution = solve_stein([[0, 1], ["-b", "-a"]], [[0, 0], [0, 1]])
    >>> solution.X[0, 0].factor(), solution.exceptional
    ((b + 1)/((b - 1)*(a - b - 1)*(a + b + 1)), (b - 1, a + b + 1, a - b - 1))
    """
    a, q = exact_matrix(A, "A"), exact_matrix(Q, "Q")
    b = a.T if B is None else exact_matrix(B, "B")
    _require_shapes(a, b, q, "Q", stein=True)
    identity = "X = A X B + Q"
    solution = _by_characteristic_polynomial(a, b, q, stein=True)
    if solution is not None:
        X, divisors = solution
        residual = [sum_of_products((-a, X, b), (X,), (-q,))]
        return certified(identity, residual, X, (), [*divisors, *denominators_of((a, b, q))])
    X, more, divisors = solve_by_kronecker(
        [[(eye(a.rows), eye(b.rows)), (-a, b)]],
        q.shape,
        list(q),
        contradiction="X = A X B + Q has no solution: an eigenvalue of A is the reciprocal of one "
        "of B, and Q is not in the range of X -> X - A X B; remove these modes, or change Q",
        sources=(a, b, q),
    )
    left = [a * X * b + q - X, *(a * Y * b - Y for Y in more)]
    return certified(identity, left, X, more, divisors)


def _require_shapes(a: Matrix, b: Matrix, c: Matrix, name: str, *, stein: bool = False) -> None:
    if a.rows != a.cols or b.rows != b.cols or c.shape != (a.rows, b.rows):
        raise InputError(
            f"A is {a.rows} x {a.cols}, B is {b.rows} x {b.cols} and {name} is {c.rows} x "
            f"{c.cols}; A and B must be square, and {name} have the rows of A and the columns of B"
        )
    if 0 in c.shape:
        raise InputError(f"{name} is {c.rows} x {c.cols}; an equation needs at least one unknown")
    divisor = (a, b) if stein else (a, b, c)
    symbols = set().union(*(matrix.free_symbols for matrix in divisor))
    if symbols:  # the determinant that is divided by has as many terms, in the worst case
        degree = (a.rows + b.rows) * (2 if stein else 1)  # products of eigenvalues, or sums
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
    _ask_for_determinant(inverted)
    try:
        X = solve(inverted.T, right.T).T
    except NoSolutionError:
        return None
    return ImmutableMatrix(X), [determinant(inverted)]


def _ask_for_determinant(matrix: ImmutableMatrix) -> None:
    """Refuse a division by a determinant with too many terms, by its degrees in the symbols."""
    symbols = sorted(matrix.free_symbols, key=str)
    if not symbols or not all(entry.is_polynomial(*symbols) for entry in matrix):
        return
    entries = [Poly(entry, *symbols) for entry in matrix]
    degree = matrix.rows * int(max(0, *(entry.total_degree() for entry in entries)))
    separate = (max(d) for d in zip(*(entry.degree_list() for entry in entries), strict=True))
    box = math.prod(matrix.rows * max(0, int(d)) + 1 for d in separate)
    most = min(box, math.comb(degree + len(symbols), degree))
    ask("terms", most, "the determinant of the matrix equation with symbols")


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


# Sylvester's and Stein's equations over the rationals, in python-flint's integers.

_SMALL = 15  # measured: from order 20 on the lifting is faster
_PROBES = 2
_SMALL_PRIMES = 2**16 * 3**8 * 5**4 * 7**4 * 11**2 * 13**2  # combinations may cancel these
_SPARE_BITS = 64 + _SMALL_PRIMES.bit_length()
_DOUBLINGS = 3  # of the modulus, until a step of the lifting is as long as the matrix's entries


def solve_rational(
    a: Matrix, b: Matrix, c: Matrix, *, stein: bool = False
) -> ImmutableMatrix | None:
    r"""Solve A X + X B = C, or X = A X B + C; None where the solution is not unique.

    .. math:: X p(-B) = -\sum_k p_k \sum_{i+j=k-1} A^i C (-B)^j, \qquad p(A) = 0

    The determinant of p(-B), a resultant, is known before the work begins, and with it how long the
    entries of X may be.
    """
    (A, over_a), (B, over_b), (C, over_c) = (to_flint(M).numer_denom() for M in (a, b, c))
    if stein:
        step = over_a * over_b  # A^k X B^k = step^k X - T_k with T_(k+1) = A T_k B + step^(k+1) C
        M, C = B, C * step
        p = A.charpoly().coeffs()
        modes = flint.fmpz_poly([p[k] * step**k for k in range(len(p) - 1, -1, -1)])
    else:
        step = over_a.lcm(over_b)
        A, M, C = A * (step // over_a), B * -(step // over_b), C * step
        modes = A.charpoly()
        p = modes.coeffs()
    divisor = abs(modes.resultant(M.charpoly()))
    if divisor == 0:
        return None
    _ask_for_digits(C, int(divisor).bit_length(), "a hundred")  # may be cancelled in part
    value, total = (_stein if stein else _sylvester)(A, M, C, p, step)
    numerators, denominator = _by_inverse(value, total)
    return from_flint(flint.fmpq_mat(numerators) / (denominator * over_c))


def _ask_for_digits(shape: flint.fmpz_mat, bits: int, unit: str) -> None:
    size = shape.nrows() * shape.ncols() * (1 + decimal_digits(bits) // 100)
    ask("entries", size, f"the solution of the matrix equation, {unit} digits counted as one,")


def _sylvester(
    A: flint.fmpz_mat, M: flint.fmpz_mat, C: flint.fmpz_mat, p: list[flint.fmpz], _step: flint.fmpz
) -> tuple[flint.fmpz_mat, flint.fmpz_mat]:
    """Sum p_k M^k, and p_k (A^k X - X M^k) with the other sign."""
    power = M**0
    total, value, term = C * 0, power * 0, C * 0
    for k, coefficient in enumerate(p):
        total, value = total - term * coefficient, value + power * coefficient
        if k < len(p) - 1:
            term, power = A * term + C * power, power * M
    return value, total


def _stein(
    A: flint.fmpz_mat, B: flint.fmpz_mat, C: flint.fmpz_mat, p: list[flint.fmpz], step: flint.fmpz
) -> tuple[flint.fmpz_mat, flint.fmpz_mat]:
    """Sum p_k step^k B^(n-k) and p_k T_k B^(n-k), since p(A) X B^n is 0."""
    scales, terms = [flint.fmpz(1)], [C * 0]
    for _ in p[1:]:
        terms.append(A * terms[-1] * B + C * scales[-1])
        scales.append(scales[-1] * step)
    power = B**0
    total, value = C * 0, power * 0
    for coefficient, scale, term in reversed(list(zip(p, scales, terms, strict=True))):
        weighted = power * coefficient
        value, total = value + weighted * scale, total + term * weighted
        power = power * B
    return value, total


def _by_inverse(matrix: flint.fmpz_mat, right: flint.fmpz_mat) -> tuple[flint.fmpz_mat, flint.fmpz]:
    """Return numerators and denominator of right * matrix^-1, by Dixon's lifting modulo a prime.

    Some combinations of the rows are solved for first. Their denominator is that of all rows but
    for small primes, and to know it saves half of the steps and every reconstruction of a fraction.
    Where the product of the result and the matrix shows bad luck, and where the system is small,
    python-flint solves.
    """
    if matrix.nrows() <= _SMALL:
        quotient = flint.fmpq_mat(matrix.transpose().solve(right.transpose()))
        numerators, denominator = quotient.transpose().numer_denom()
        return numerators, denominator
    rows, modulo = right.nrows(), 10_007
    weights = [pow(5, k * k + k, modulo) for k in range(_PROBES * rows)]
    combined = flint.fmpz_mat(_PROBES, rows, weights) * right
    turned = flint.fmpq_mat(matrix.transpose())
    probe = turned.solve(flint.fmpq_mat(combined.transpose()), algorithm="dixon")
    numerators, denominator = probe.numer_denom()
    longest = max(abs(int(entry)).bit_length() for entry in [*numerators.entries(), denominator])
    _ask_for_digits(right, 4 * longest, "fifty")  # above and below
    denominator *= _SMALL_PRIMES
    quotient = _lifted(matrix, right, denominator, longest + _SPARE_BITS)
    if quotient * matrix == right * denominator:
        return quotient, denominator
    solution = turned.solve(flint.fmpq_mat(right.transpose()), algorithm="dixon").transpose()
    top, bottom = solution.numer_denom()
    return top, bottom


def _lifted(
    matrix: flint.fmpz_mat, right: flint.fmpz_mat, denominator: flint.fmpz, bits: int
) -> flint.fmpz_mat:
    """Return denominator * right * matrix^-1 if it is integer and of so many bits at most."""
    modulus = flint.fmpz(next(p for p in primes() if flint.nmod_mat(matrix, p).det() != 0))
    size = matrix.nrows()
    inverse = flint.nmod_mat(matrix, int(modulus)).inv()
    inverse = flint.fmpz_mat(size, size, [int(x) for x in inverse.entries()])
    for _ in range(_DOUBLINGS):
        modulus *= modulus
        twice = matrix**0 * 2
        inverse = _mod(inverse * (twice - _mod(matrix * inverse, modulus)), modulus)
    digits, rest, whole = [], right, flint.fmpz(1)
    while int(whole).bit_length() < bits:
        digits.append(_mod(rest * inverse, modulus))
        rest = _over(rest - digits[-1] * matrix, modulus)
        whole *= modulus
    while len(digits) > 1:
        pairs = [digits[i : i + 2] for i in range(0, len(digits), 2)]
        digits = [pair[0] + pair[1] * modulus if len(pair) > 1 else pair[0] for pair in pairs]
        modulus *= modulus
    value = _mod(digits[0] * denominator, whole)
    half = whole // 2
    entries = [entry if entry <= half else entry - whole for entry in value.entries()]
    return flint.fmpz_mat(value.nrows(), value.ncols(), entries)


def _mod(matrix: flint.fmpz_mat, modulus: flint.fmpz) -> flint.fmpz_mat:
    entries = [entry % modulus for entry in matrix.entries()]
    return flint.fmpz_mat(matrix.nrows(), matrix.ncols(), entries)


def _over(matrix: flint.fmpz_mat, divisor: flint.fmpz) -> flint.fmpz_mat:
    entries = [entry // divisor for entry in matrix.entries()]
    return flint.fmpz_mat(matrix.nrows(), matrix.ncols(), entries)


def sum_of_products(*products: tuple[Matrix, ...]) -> Matrix:
    """Return a sum of products of matrices, in integers where all of them are rational."""
    factors_in_flint = [[rational_in_flint(factor) for factor in factors] for factors in products]
    if any(factor is None for factors in factors_in_flint for factor in factors):
        terms = [reduce(mul, factors) for factors in products]
        return reduce(add, terms)
    total, over = None, flint.fmpz(1)
    for factors in factors_in_flint:
        split = [factor.numer_denom() for factor in factors if factor is not None]
        term, divisor = reduce(mul, [n for n, _ in split]), reduce(mul, [d for _, d in split])
        common = over.lcm(divisor)
        term *= common // divisor
        total = term if total is None else total * (common // over) + term
        over = common
    return from_flint(flint.fmpq_mat(total) / over)
