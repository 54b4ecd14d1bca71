"""Sylvester matrices with formal degrees, and what their rank says about common roots."""

from collections.abc import Sequence
from typing import Any

import sympy
from sympy import Expr, ImmutableMatrix, Poly

from compensator_theory.errors import InputError
from compensator_theory.matrices.linear_algebra import determinant, rank
from compensator_theory.polynomials.numbers import exact_number
from compensator_theory.polynomials.poly import PolynomialLike, polynomial

MAX_ORDER = 10_000


def sylvester_m(D: PolynomialLike, N: PolynomialLike, n_c: int, m_hat: int) -> ImmutableMatrix:
    r"""Return the matrix of the pole placement equation.

    .. math:: M \begin{bmatrix} d \\ c \end{bmatrix} \text{ lists the coefficients of }
              D(s)\sum_{i<n_c} d_i s^i + N(s)\sum_{i\le\hat m_c} c_i s^i

    Parameters
    ----------
    D, N : polynomial
        Degrees n and m; lists hold descending coefficients.
    n_c : int
        Number of columns with coefficients of D, the order of the compensator.
    m_hat : int
        Formal degree of the compensator's numerator; -1 for none.

    Returns
    -------
    sympy.ImmutableMatrix
        (n + n_c) x (n_c + m_hat + 1).

    Raises
    ------
    InputError
        If :math:`m + \hat m_c \ge n + n_c`, so that a column of N does not fit.

    Notes
    -----
    Source: (7.37), (7.38). With :math:`\hat m_c = n-1` it is the square matrix
    :math:`\mathcal M_1(D, N)`, N taken with formal degree n_c, for every :math:`n_c \ge n-1`;
    Proposition 3 asks for :math:`n_c \le n` only because its :math:`\mathcal M_1` asks for
    :math:`l \le k`.

    Examples
    --------
    >>> from compensator_theory import sylvester_m
    >>> sylvester_m("s**2 + 3*s + 2", "s + 5", n_c=1, m_hat=1)
    Matrix([
    [1, 1, 0],
    [3, 5, 1],
    [2, 0, 5]])
    """
    if not (isinstance(n_c, int) and isinstance(m_hat, int)):
        raise InputError(f"n_c = {n_c!r} and m_hat = {m_hat!r} must be integers")
    if n_c > MAX_ORDER:
        raise InputError(f"n_c = {n_c} exceeds {MAX_ORDER}, the largest order that is built")
    d, n = _trimmed(D), _trimmed(N)
    rows = len(d) - 1 + n_c
    if n_c < 0 or m_hat < -1:
        raise InputError(f"n_c = {n_c} must be at least 0 and m_hat = {m_hat} at least -1")
    offset = rows - (len(n) - 1) - m_hat - 1
    if offset < 0 <= m_hat:
        raise InputError(
            f"a numerator of degree {m_hat} times N of degree {len(n) - 1} exceeds the degree "
            f"{rows - 1} of this equation; lower m_hat to {m_hat + offset} or raise n_c"
        )
    columns = _shifts(d, n_c, 0, rows) + _shifts(n, m_hat + 1, offset, rows)
    return _from_columns(columns, rows)


def sylvester_m1(
    a: PolynomialLike,
    b: PolynomialLike,
    k: int | None = None,
    l: int | None = None,  # noqa: E741
) -> ImmutableMatrix:
    r"""Return the Sylvester matrix of two polynomials of formal degrees k and l.

    .. math:: \mathcal M_1(a, b) \in \mathbb R^{(k+l)\times(k+l)}

    Parameters
    ----------
    a, b : polynomial
        Lists hold descending coefficients, leading zeros included.
    k, l : int, optional
        Formal degrees, at least the true ones. Default: the length of a list minus 1, the true
        degree of anything else (0 for the zero polynomial).

    Returns
    -------
    sympy.ImmutableMatrix
        l shifted columns of a, then k shifted columns of b.

    Raises
    ------
    InputError
        If a formal degree is below the true one, or both are 0.

    Notes
    -----
    Source: (B.1). SymPy's ``sylvester(f, g, x)`` is the transpose for true degrees.

    Examples
    --------
    >>> from compensator_theory import sylvester_m1
    >>> sylvester_m1([1, 1], [1, 3, 2])
    Matrix([
    [1, 0, 1],
    [1, 1, 3],
    [0, 1, 2]])
    """
    first, second = _formal(a, k, "a"), _formal(b, l, "b")
    k, l = len(first) - 1, len(second) - 1  # noqa: E741
    if k + l == 0:
        raise InputError("a and b are both constants (k + l = 0), so the matrix would be empty")
    return _from_columns(_shifts(first, l, 0, k + l) + _shifts(second, k, 0, k + l), k + l)


def sylvester_m2(a: PolynomialLike, b: PolynomialLike) -> ImmutableMatrix:
    r"""Return the 2k x 2k Sylvester matrix, with b written to the formal degree k of a.

    .. math:: \mathcal M_2(a, b) = \mathcal M_1(a,\; 0 s^k + \cdots + b), \qquad
              \det\mathcal M_2 = a_k^{\,k-l}\det\mathcal M_1

    Parameters
    ----------
    a, b : polynomial
        deg b <= k, where k is the formal degree of a (see :func:`sylvester_m1`).

    Raises
    ------
    InputError
        If deg b > k or k = 0.

    Notes
    -----
    Source: (B.2). Erratum: the passage from Theorem A1 to A2 adds k - l zeros and not k + l - 1.

    Examples
    --------
    >>> from compensator_theory import sylvester_m2
    >>> sylvester_m2([1, 2], [6])
    Matrix([
    [1, 0],
    [2, 6]])
    """
    k = len(_formal(a, None, "a")) - 1
    return sylvester_m1(a, _trimmed(b), k, k)


def number_of_common_roots(a: PolynomialLike, b: PolynomialLike) -> int | None:
    r"""Count the common roots of two polynomials, with multiplicity, by a rank.

    .. math:: \deg\gcd(a, b) = k + l - \mathrm{rank}\,\mathcal M_1(a, b)

    Parameters
    ----------
    a, b : polynomial
        b may be zero: then all roots of a count.

    Returns
    -------
    int or None
        None if it depends on the values of symbols.

    Raises
    ------
    InputError
        If the coefficient a_k of the formal degree is zero: if also b_l = 0, the rank would count
        a common root at infinity, as for 0 s**2 + s + 1 and 0 s + 5.

    Notes
    -----
    Source: Theorem A1, whose hypothesis :math:`l \le k` is not needed (and is not met by
    Example B.2); "number" is to be read with multiplicity.

    Examples
    --------
    >>> from compensator_theory import number_of_common_roots
    >>> number_of_common_roots("(s + 1)**2*(s + 2)", "(s + 1)**3*(s - 7)*s")
    2
    """
    first, second = _formal(a, None, "a"), _formal(b, None, "b")
    if first[0] == 0:
        raise InputError(
            f"the leading coefficient of a = {a} is zero; drop its leading zeros (or, if a = 0, "
            "exchange a and b)"
        )
    size = len(first) + len(second) - 2
    if not size:
        return 0
    matrix = sylvester_m1(first, second)
    if matrix.free_symbols:
        return 0 if determinant(matrix).is_nonzero else None
    return size - rank(matrix)


def resultant(a: PolynomialLike, b: PolynomialLike) -> Expr:
    r"""Return the resultant :math:`\det\mathcal M_1(a, b)`, 0 iff a and b share a root.

    Parameters
    ----------
    a, b : polynomial
        As for :func:`number_of_common_roots`, same condition on a_k.

    Raises
    ------
    InputError
        If the leading coefficient of a is zero.

    Notes
    -----
    Source: Theorem A1. For true degrees it is SymPy's ``resultant(a, b)``, except that SymPy
    (1.14, issue 10666) loses the sign if k < l are both odd.

    Examples
    --------
    >>> from compensator_theory import resultant
    >>> resultant("s + 1", "s + 2"), resultant("s + a", "s + b")
    (1, -a + b)
    """
    first, second = _formal(a, None, "a"), _formal(b, None, "b")
    if first[0] == 0:
        raise InputError(f"the leading coefficient of a = {a} is zero; drop its leading zeros")
    if len(first) == len(second) == 1:
        return sympy.Integer(1)
    return determinant(sylvester_m1(first, second))


def _formal(obj: Any, degree: int | None, name: str) -> list[Expr]:
    """Return descending coefficients, with leading zeros up to the formal degree."""
    if isinstance(obj, Sequence) and not isinstance(obj, str):
        coefficients = [exact_number(value) for value in obj]
        if not coefficients:
            raise InputError(f"{name} is an empty list of coefficients; the zero polynomial is [0]")
    else:
        coefficients = _trimmed(obj)
    if degree is None:
        return coefficients
    while len(coefficients) > degree + 1 and coefficients[0] == 0:
        coefficients = coefficients[1:]
    if len(coefficients) > degree + 1:
        raise InputError(f"{name} has degree {len(coefficients) - 1}, above the formal {degree}")
    return [sympy.Integer(0)] * (degree + 1 - len(coefficients)) + coefficients


def _trimmed(obj: Any) -> list[Expr]:
    """Return the descending coefficients from the true degree on."""
    if isinstance(obj, Sequence) and not isinstance(obj, str):
        obj = polynomial(obj, "s")
    elif not isinstance(obj, Poly):
        expression = exact_number(obj)
        obj = polynomial(expression, None if expression.free_symbols else "s")
    return list(obj.all_coeffs())


def _shifts(column: list[Expr], count: int, offset: int, rows: int) -> list[list[Expr]]:
    zero = sympy.Integer(0)
    padded = [
        [zero] * (offset + shift) + column + [zero] * (rows - offset - shift - len(column))
        for shift in range(count)
    ]
    return padded


def _from_columns(columns: list[list[Expr]], rows: int) -> ImmutableMatrix:
    return ImmutableMatrix(len(columns), rows, [entry for c in columns for entry in c]).T
