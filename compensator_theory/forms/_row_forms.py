"""Forms of a polynomial matrix under row operations: Hermite and row-reduced."""

from __future__ import annotations

from dataclasses import replace

import flint
from sympy import Symbol

from compensator_theory.forms._equivalence import Equivalence, elimination_of, equivalence_of
from compensator_theory.forms._polynomial_matrices import PolynomialMatrixLike, polynomial_matrix
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._elimination import Elimination
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._rings import Element, Grid, RationalRing, Ring
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying


@carrying()
def hermite_form(matrix: PolynomialMatrixLike, variable: str | Symbol | None = None) -> Equivalence:
    r"""Bring a polynomial matrix to its Hermite form by row operations.

    .. math:: U P = \begin{bmatrix} h_{11} & h_{12} & \cdots \\ & h_{22} & \cdots \\ & & \ddots
              \end{bmatrix}, \qquad \deg h_{ij} < \deg h_{jj} \quad (i < j)

    Parameters
    ----------
    matrix : polynomial matrix
        Anything :func:`polynomial_matrix` reads, of any shape.
    variable : str or Symbol, optional
        As for :func:`polynomial_matrix`.

    Returns
    -------
    Equivalence
        An echelon form with monic pivots; it is unique, and so is U if P is square and nonsingular.

    Raises
    ------
    InputError, BudgetError
        If it is no polynomial matrix, or too large.

    Notes
    -----
    Source: C. Hermite (1851); T. Kailath, Linear Systems (1980), Section 6.3.

    Examples
    --------
    >>> from compensator_theory.forms import hermite_form
    >>> print(hermite_form([["s", "s**2"], ["s + 1", "1"]]))
    [[1, -s**2 + 1], [0, s**3 + s**2 - s]]
    """
    source = polynomial_matrix(matrix, variable)
    work = elimination_of(source)
    rank = work.triangulate()
    return equivalence_of(source, work, rank)


@carrying()
def row_reduced_form(
    matrix: PolynomialMatrixLike, variable: str | Symbol | None = None
) -> Equivalence:
    r"""Bring a polynomial matrix to a row-reduced form: no combination of rows has a lower degree.

    .. math:: \deg\det H = \sum_i \text{(degree of row } i) \quad\text{for square nonsingular } P

    Parameters
    ----------
    matrix : polynomial matrix
        Anything :func:`polynomial_matrix` reads, of any shape.
    variable : str or Symbol, optional
        As for :func:`polynomial_matrix`.

    Returns
    -------
    Equivalence
        Its `leading_matrix` has independent rows; the row degrees are unique but for their order.

    Raises
    ------
    InputError, BudgetError
        If it is no polynomial matrix, or too large.

    Notes
    -----
    Where a combination c of the rows of leading coefficients is zero, that combination, shifted to
    the largest degree among them, replaces the row of that degree. A column-reduced form is that of
    the transpose. Source: T. Kailath, Linear Systems (1980), Section 6.3.2.

    Examples
    --------
    >>> from compensator_theory.forms import row_reduced_form
    >>> form = row_reduced_form([["s**2", "s**2 + 1"], ["s", "s"]])
    >>> print(form, form.row_degrees)
    [[0, 1], [s, s]] (0, 1)
    """
    source = polynomial_matrix(matrix, variable)
    rows, columns = source.shape
    ask("entries", rows**2 * columns * (max(source.degree, 0) + 1) // 2, "the row-reduced form")
    work = elimination_of(source)
    ring = work.ring
    while (relation := _relation(ring, work.matrix)) is not None:
        target = max(relation, key=lambda i: _row_degree(ring, work.matrix[i]))
        height = _row_degree(ring, work.matrix[target])
        inverse = ring.reciprocal_of_leading(relation.pop(target))
        for source_row, factor in relation.items():
            shift = height - _row_degree(ring, work.matrix[source_row])
            work.add_row(target, source_row, ring.power(shift) * factor * inverse)
    rank = 0
    for i in range(work.rows):
        if _row_degree(ring, work.matrix[i]) >= 0:
            work.swap_rows(rank, i)
            rank += 1
    form = equivalence_of(source, work, rank)
    minor = echelon(form.leading_matrix).divided_by
    return replace(form, exceptional=exceptional_factors([minor, *form.exceptional]))


def _row_degree(ring: Ring, row: list[Element]) -> int:
    return max(map(ring.degree, row))


def _relation(ring: Ring, grid: Grid) -> dict[int, Element] | None:
    """Return constants that combine the rows of leading coefficients to zero, by row."""
    rows = [i for i, row in enumerate(grid) if _row_degree(ring, row) >= 0]
    leading = [[ring.coefficient(e, _row_degree(ring, grid[i])) for e in grid[i]] for i in rows]
    if not rows:
        return None
    if isinstance(ring, RationalRing):
        return _rational_relation(rows, leading)
    work = Elimination(ring, leading)
    rank = work.triangulate()
    if rank == len(rows):
        return None
    terms = zip(rows, work.U[rank], strict=True)
    return {i: factor for i, factor in terms if ring.degree(factor) >= 0}


def _rational_relation(rows: list[int], leading: Grid) -> dict[int, Element] | None:
    """Express the first row that depends on those before it by them."""
    width = len(leading[0])
    coefficients = flint.fmpq_mat(len(rows), width, [e[0] for row in leading for e in row])
    reduced, rank = coefficients.transpose().rref()
    if rank == len(rows):
        return None
    pivots = [next(j for j in range(len(rows)) if reduced[i, j]) for i in range(rank)]
    first = next(j for j in range(len(rows)) if j not in pivots)
    factors = {j: -reduced[i, first] for i, j in enumerate(pivots) if j < first} | {first: 1}
    return {rows[j]: flint.fmpq_poly([c]) for j, c in factors.items() if c}
