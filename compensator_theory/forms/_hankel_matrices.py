"""Block Hankel matrices of Markov parameters, whose rank is the McMillan degree."""

from __future__ import annotations

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory.errors import ImproperError
from compensator_theory.forms._expansions import markov_parameters
from compensator_theory.matrices._echelon import echelon
from compensator_theory.polynomials._budget import ask, integer
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import generic_answer_of, holds_where_defined
from compensator_theory.polynomials._poly import canonical, common_divisor
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix


@holds_where_defined
@carrying()
def hankel_matrix(
    G: TransferMatrixLike, rows: int, columns: int, *, variable: str | Symbol | None = None
) -> ImmutableMatrix:
    r"""Return the block Hankel matrix of the Markov parameters.

    .. math:: \mathcal H = \begin{bmatrix} H_1 & H_2 & \cdots \\ H_2 & H_3 & \cdots \\
              \vdots & \vdots & \ddots \end{bmatrix}, \qquad G = \sum_{k\ge 0} H_k s^{-k}

    Parameters
    ----------
    G : transfer matrix
        p x m and proper; anything :func:`transfer_matrix` reads.
    rows, columns : int
        Numbers of block rows and block columns.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Returns
    -------
    sympy.ImmutableMatrix
        (p rows) x (m columns). With as many of each as the common denominator has degree, its rank
        is the McMillan degree.

    Raises
    ------
    ImproperError
        If an entry is improper.
    InputError, BudgetError
        If G cannot be read, a number is not positive, or the matrix is too large.

    Examples
    --------
    >>> from compensator_theory import hankel_matrix
    >>> hankel_matrix("(s + 5)/(s**2 + 3*s + 2)", 2, 2)
    Matrix([
    [1,  2],
    [2, -8]])
    """
    for name, number in (("rows", rows), ("columns", columns)):
        integer(number, name, at_least=1)
    source = transfer_matrix(G, variable)
    outputs, inputs = source.shape
    ask("entries", rows * outputs * columns * inputs, "the Hankel matrix")
    series = {
        (i, j): markov_parameters(proper_entry(source, i, j), rows + columns)
        for i, j in places(source)
    }
    return ImmutableMatrix([
        [series[i, j][r + c + 1] for c in range(columns) for j in range(inputs)]
        for r in range(rows)
        for i in range(outputs)
    ])  # fmt: skip


@carrying()
def mcmillan_degree(G: TransferMatrixLike, variable: str | Symbol | None = None) -> int:
    r"""Return the number of poles with multiplicity, those at infinity included.

    .. math:: \delta(G) = \mathrm{rank}\,\mathcal H(G_{sp}) + \mathrm{rank}\,\mathcal H(P(1/s)),
              \qquad G = G_{sp} + P

    Parameters
    ----------
    G : transfer matrix
        Anything :func:`transfer_matrix` reads, improper ones too; with symbols, for generic values,
        and :func:`exceptional_cases` gives it for the others.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Notes
    -----
    Source: B. McMillan, Introduction to formal realizability theory, Bell System Technical Journal
    31 (1952). The order of :func:`minimal_realisation` and the degree of the denominators of
    :func:`smith_mcmillan_form` are the same number.

    Examples
    --------
    >>> from compensator_theory import mcmillan_degree
    >>> mcmillan_degree([["1/(s + 1)", "1/(s + 1)"], ["1/(s + 1)", "2/(s + 1)"]])
    2
    >>> mcmillan_degree("s**2 + 1/s", "s")
    3
    """
    degree: int = _degree_and_minors(G, variable)[0]
    return degree


@generic_answer_of(mcmillan_degree)
def _degree_and_minors(
    G: TransferMatrixLike, variable: str | Symbol | None = None
) -> tuple[int, list[Expr]]:
    source = transfer_matrix(G, variable)
    s, bottom = source.variable, source.denominator
    parts = [[entry.div(bottom) for entry in row] for row in source.numerators]
    rest = TransferMatrix(tuple(tuple(canonical(r) for _, r in row) for row in parts), bottom)
    degree = max((int(q.degree()) for row in parts for q, _ in row if not q.is_zero), default=0)
    blocks = []
    if (size := block_rows(rest)) > 0:
        blocks.append(hankel_matrix(rest, size, size))
    if degree > 0:
        powers = [
            [q.coeff_monomial(s ** (r + c + 1)) for c in range(degree) for q, _ in row]
            for r in range(degree)
            for row in parts
        ]
        blocks.append(ImmutableMatrix(powers))
    forms = [echelon(block) for block in blocks]
    divisors = [form.divided_by for form in forms]
    divisors += [c for row in source.numerators for entry in row for c in _bottoms(entry)]
    return sum(len(form.pivots) for form in forms), [*divisors, *_bottoms(bottom)]


def _bottoms(poly: Poly) -> list[Expr]:
    """Return the denominators of the coefficients; where one is zero, G has another form."""
    return [sympy.fraction(c)[1] for c in map(sympy.cancel, poly.all_coeffs()) if c.free_symbols]


def block_rows(G: TransferMatrix) -> int:
    """Return the number of block rows that suffices: the degree of the reduced denominator."""
    common = common_divisor(G.denominator, *(entry for row in G.numerators for entry in row))
    return int(G.denominator.degree() - common.degree())


def places(G: TransferMatrix) -> list[tuple[int, int]]:
    """Return rows and columns of all entries."""
    return [(i, j) for i in range(G.shape[0]) for j in range(G.shape[1])]


def proper_entry(G: TransferMatrix, i: int, j: int) -> TransferFunction:
    """Return an entry of a transfer matrix in lowest terms."""
    entry = G[i, j].reduced()
    if not entry.is_proper:
        raise ImproperError(
            f"the entry {i}, {j} of the transfer matrix, {entry}, is improper; only proper ones "
            "have a realisation"
        )
    return entry
