"""Sylvester matrices with formal degrees."""

from __future__ import annotations

from collections.abc import Callable, Sized
from typing import Any, TypeVar

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.matrices._flint_matrices import from_flint
from compensator_theory.polynomials._budget import ask, integer, repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import generic_answer_of
from compensator_theory.polynomials._polynomial_objects import in_our_order
from compensator_theory.polynomials._reading import PolynomialLike, in_one_variable, is_list

Function = TypeVar("Function", bound=Callable[..., Any])


def holds_while_degrees_do(function: Function) -> Function:
    """Mark a function of two polynomials whose result holds while their degrees do not drop."""

    @generic_answer_of(function)
    def companion(
        a: PolynomialLike, b: PolynomialLike, *sizes: int, variable: str | Symbol | None = None
    ) -> tuple[Any, list[Expr]]:
        read = in_one_variable(a, b, variable=variable, default="s")
        leading = [poly.LC() for poly in read if not poly.is_zero]
        return function(a, b, *sizes, variable=variable), leading

    return function


@holds_while_degrees_do
@carrying()
def sylvester_m(
    D: PolynomialLike,
    N: PolynomialLike,
    n_c: int,
    m_hat: int,
    *,
    variable: str | Symbol | None = None,
) -> ImmutableMatrix:
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
    variable : str or Symbol, optional
        Default: evident from the two together; lists show none.

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
    Proposition 3 requires :math:`n_c \le n` only because its :math:`\mathcal M_1` needs
    :math:`l \le k`.

    Examples
    --------
    >>> from compensator_theory.bezout import sylvester_m
    >>> sylvester_m("s**2 + 3*s + 2", "s + 5", n_c=1, m_hat=1)
    Matrix([
    [1, 1, 0],
    [3, 5, 1],
    [2, 0, 5]])
    """
    for name, number in (("n_c", n_c), ("m_hat", m_hat)):
        integer(number, name)
    d, n = (p.all_coeffs() for p in in_one_variable(D, N, variable=variable, default="s"))
    rows = len(d) - 1 + n_c
    if n_c < 0 or m_hat < -1:
        raise InputError(
            f"n_c = {repr_of(n_c)} must be at least 0 and m_hat = {repr_of(m_hat)} at least -1"
        )
    offset = rows - (len(n) - 1) - m_hat - 1
    if offset < 0 <= m_hat:
        raise InputError(
            f"a numerator of degree {repr_of(m_hat)} times N of degree {len(n) - 1} exceeds the "
            f"degree {repr_of(rows - 1)} of this equation; lower m_hat to "
            f"{repr_of(m_hat + offset)} or raise n_c"
        )
    ask("entries", rows * (n_c + m_hat + 1), "the Sylvester matrix")
    columns = _shifts(d, n_c, 0) + _shifts(n, m_hat + 1, offset)
    return _from_columns(columns, rows)


@holds_while_degrees_do
@carrying()
def sylvester_m1(
    a: PolynomialLike,
    b: PolynomialLike,
    k: int | None = None,
    l: int | None = None,  # noqa: E741
    *,
    variable: str | Symbol | None = None,
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
    variable : str or Symbol, optional
        Default: evident from the two together; lists show none.

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
    >>> from compensator_theory.bezout import sylvester_m1
    >>> sylvester_m1([1, 1], [1, 3, 2])
    Matrix([
    [1, 0, 1],
    [1, 1, 3],
    [0, 1, 2]])
    """
    first, second = (
        formal_coefficients(*pair) for pair in with_formal_degrees(a, b, variable, (k, l))
    )
    if len(first) == len(second) == 1:
        raise InputError("a and b are both constants (k + l = 0), so the matrix would be empty")
    return matrix_of_coefficients(first, second)


def matrix_of_coefficients(first: list[Expr], second: list[Expr]) -> ImmutableMatrix:
    """Return the Sylvester matrix of two lists of exact descending coefficients."""
    k, l = len(first) - 1, len(second) - 1  # noqa: E741
    ask("entries", (k + l) ** 2, "the Sylvester matrix")
    return _from_columns(_shifts(first, l, 0) + _shifts(second, k, 0), k + l)


@holds_while_degrees_do
@carrying()
def sylvester_m2(
    a: PolynomialLike, b: PolynomialLike, *, variable: str | Symbol | None = None
) -> ImmutableMatrix:
    r"""Return the 2k x 2k Sylvester matrix, with b written to the formal degree k of a.

    .. math:: \mathcal M_2(a, b) = \mathcal M_1(a,\; 0 s^k + \cdots + b), \qquad
              \det\mathcal M_2 = a_k^{\,k-l}\det\mathcal M_1

    Parameters
    ----------
    a, b : polynomial
        deg b <= k, where k is the formal degree of a (see :func:`sylvester_m1`).
    variable : str or Symbol, optional
        Default: evident from the two together; lists show none.

    Raises
    ------
    InputError
        If deg b > k or k = 0.

    Notes
    -----
    Source: (B.2). Erratum: the passage from Theorem A1 to A2 adds k - l zeros and not k + l - 1.

    Examples
    --------
    >>> from compensator_theory.bezout import sylvester_m2
    >>> sylvester_m2([1, 2], [6])
    Matrix([
    [1, 0],
    [2, 6]])
    """
    (first, k), (second, _) = with_formal_degrees(a, b, variable)
    return sylvester_m1(first, second, k, k)


def with_formal_degrees(
    a: PolynomialLike,
    b: PolynomialLike,
    variable: str | Symbol | None,
    degrees: tuple[int | None, int | None] = (None, None),
) -> list[tuple[Poly, int]]:
    """Read two polynomials in one variable, each with its formal degree."""
    a, b = in_our_order(a), in_our_order(b)
    read = in_one_variable(a, b, variable=variable, default="s")
    padded = []
    for name, argument, poly, formal_degree in zip("ab", (a, b), read, degrees, strict=True):
        degree = formal_degree
        if degree is None:
            size = len(argument) if is_list(argument) and isinstance(argument, Sized) else 0
            degree = size - 1 if size else _degree(poly)
        integer(degree, f"the formal degree of {name}", at_least=0)
        if _degree(poly) > degree:
            raise InputError(f"{name} has degree {poly.degree()}, above the formal {degree}")
        ask("degree", degree, f"the formal degree of {name}")
        padded.append((poly, degree))
    return padded


def _degree(poly: Poly) -> int:
    return 0 if poly.is_zero else int(poly.degree())


def formal_coefficients(poly: Poly, degree: int) -> list[Expr]:
    """Return descending coefficients with leading zeros up to a formal degree."""
    true = [] if poly.is_zero else poly.all_coeffs()
    return [sympy.Integer(0)] * (degree + 1 - len(true)) + true


def _shifts(column: list[Expr], count: int, offset: int) -> list[dict[int, Expr]]:
    """Return the rows of a band matrix: one column, shifted down by offset, offset + 1, ..."""
    entries = [(row, entry) for row, entry in enumerate(column) if entry != 0]
    return [{row + offset + shift: e for row, e in entries} for shift in range(count)]


def _from_columns(columns: list[dict[int, Expr]], rows: int) -> ImmutableMatrix:
    shape = (rows, len(columns))
    if all(entry.is_Rational for column in columns for entry in column.values()):
        entries = [flint.fmpq()] * (rows * len(columns))
        for j, column in enumerate(columns):
            for i, entry in column.items():
                entries[i * len(columns) + j] = flint.fmpq(int(entry.p), int(entry.q))
        return from_flint(flint.fmpq_mat(*shape, entries))
    return ImmutableMatrix(*shape, lambda i, j: columns[int(j)].get(int(i), sympy.S.Zero))
