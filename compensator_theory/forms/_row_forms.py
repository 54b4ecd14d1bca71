"""What row operations make of a polynomial matrix: the Hermite form and row-reduced forms."""

from __future__ import annotations

from dataclasses import dataclass, replace

from sympy import Expr, ImmutableMatrix, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.forms._equivalence import by_rows, elimination_of
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    PolynomialMatrixLike,
    polynomial_matrix,
)
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._elimination import Elimination
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._rings import Element, Grid, Ring
from compensator_theory.polynomials._values import ExactValue

IDENTITY = "U P = H, U U^-1 = I"


@dataclass(frozen=True)
class RowForm(ExactValue):
    r"""A polynomial matrix after row operations, and the unimodular matrix that does them.

    .. math:: U P = H

    Attributes
    ----------
    matrix, form : PolynomialMatrix
        P and H, both p x m; rows of zeros come last.
    U, U_inverse : PolynomialMatrix
        p x p, unimodular.
    rank : int
        The normal rank, the number of rows that are not zero.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the form holds where none of them is zero.
    certificate : Certificate
        U P - H and U U^-1 - I, multiplied out anew.
    """

    matrix: PolynomialMatrix
    form: PolynomialMatrix
    U: PolynomialMatrix
    U_inverse: PolynomialMatrix
    rank: int
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def row_degrees(self) -> tuple[int, ...]:
        """The largest degree in each row that is not zero."""
        rows = self.form.rows[: self.rank]
        return tuple(max(int(e.degree()) for e in row if not e.is_zero) for row in rows)

    @property
    def leading_matrix(self) -> ImmutableMatrix:
        """The coefficients of the powers `row_degrees`, row by row."""
        s = self.form.variable
        return ImmutableMatrix(
            self.rank,
            self.form.shape[1],
            [
                entry.coeff_monomial(s**degree)
                for row, degree in zip(self.form.rows, self.row_degrees, strict=False)
                for entry in row
            ],
        )

    def __str__(self) -> str:
        return str(self.form)

    def _repr_latex_(self) -> str:
        parts = latex(self.U_inverse) + latex(self.form)
        return displayed(
            rf"P = {latex(self.matrix)} = U^{{-1}} H = {parts}", unless(self.exceptional)
        )


def hermite_form(matrix: PolynomialMatrixLike, variable: str | Symbol | None = None) -> RowForm:
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
    RowForm
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
    return _result(source, work, rank)


def row_reduced_form(matrix: PolynomialMatrixLike, variable: str | Symbol | None = None) -> RowForm:
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
    RowForm
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
    >>> found = row_reduced_form([["s**2", "s**2 + 1"], ["s", "s"]])
    >>> print(found, found.row_degrees)
    [[0, 1], [s, s]] (0, 1)
    """
    source = polynomial_matrix(matrix, variable)
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
    found = _result(source, work, rank)
    minor = echelon(found.leading_matrix).divided_by
    return replace(found, exceptional=exceptional_factors([minor, *found.exceptional]))


def _row_degree(ring: Ring, row: list[Element]) -> int:
    return max(map(ring.degree, row))


def _relation(ring: Ring, grid: Grid) -> dict[int, Element] | None:
    """Return constants that combine the rows of leading coefficients to zero, by row."""
    rows = [i for i, row in enumerate(grid) if _row_degree(ring, row) >= 0]
    leading = [[ring.coefficient(e, _row_degree(ring, grid[i])) for e in grid[i]] for i in rows]
    if not rows:
        return None
    work = Elimination(ring, leading)
    rank = work.triangulate()
    if rank == len(rows):
        return None
    found = zip(rows, work.U[rank], strict=True)
    return {i: factor for i, factor in found if ring.degree(factor) >= 0}


def _result(source: PolynomialMatrix, work: Elimination, rank: int) -> RowForm:
    found = by_rows(work, IDENTITY)
    return RowForm(
        source, found.form, found.U, found.U_inverse, rank, found.exceptional, found.certificate
    )
