"""The Popov form of a polynomial matrix: one of least degrees in each class of row operations."""

from __future__ import annotations

from sympy import Symbol

from compensator_theory.errors import NoSolutionError
from compensator_theory.forms._equivalence import Equivalence, elimination_of, equivalence_of
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    PolynomialMatrixLike,
    polynomial_matrix,
)
from compensator_theory.matrices._elimination import Elimination
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying


@carrying()
def popov_form(matrix: PolynomialMatrixLike, variable: str | Symbol | None = None) -> Equivalence:
    r"""Bring a polynomial matrix to its Popov form by row operations.

    .. math:: U P = F, \qquad \deg F_{i p_i} > \deg F_{j p_i} \;(j \ne i), \qquad
              \deg F_{i p_i} \ge \deg F_{ik}, \text{ with } > \text{ for } k > p_i

    Parameters
    ----------
    matrix : polynomial matrix
        Anything :func:`polynomial_matrix` reads, of any shape; with symbols, for generic values.
    variable : str or Symbol, optional
        As for :func:`polynomial_matrix`.

    Returns
    -------
    Equivalence
        F is unique: two matrices have the same one if and only if their rows span the same module.

    Raises
    ------
    InputError, BudgetError
        If it is no polynomial matrix, or too large.

    Notes
    -----
    Rows whose pivots stand in one column are subtracted until none do (the weak form of T. Mulders
    and A. Storjohann, J. Symbolic Computation 35 (2003)); then columns are reduced. Source: V. M.
    Popov, SIAM J. Control 10 (1972) 252-264; T. Kailath, Linear Systems (1980), Section 6.7.2.

    Examples
    --------
    >>> from compensator_theory.forms import popov_form
    >>> print(popov_form([["s**2", "s**2 + 1"], ["s", "s"]]))
    [[0, 1], [s, 0]]
    """
    source = polynomial_matrix(matrix, variable)
    rows, width = source.shape
    ask("entries", rows**2 * width * (max(source.degree, 0) + 1) // 2, "the Popov form")
    work = elimination_of(source)
    ring, pivots = work.ring, _weak(work)
    order = sorted(pivots, key=lambda i: (ring.degree(work.matrix[i][pivots[i]]), pivots[i]))
    _permute(work, order)
    columns = [pivots[i] for i in order]
    for i, column in enumerate(columns):
        work.make_monic(i, column)
    _reduce(work, columns)
    form = equivalence_of(source, work, len(columns))
    if not _is_popov(form.form, columns):
        raise NoSolutionError("the form is not reduced; it is wrong, please report it")
    return form


def _pivot(work: Elimination, i: int) -> int | None:
    degrees = [work.ring.degree(entry) for entry in work.matrix[i]]
    highest = max(degrees)
    return None if highest < 0 else max(k for k, d in enumerate(degrees) if d == highest)


def _weak(work: Elimination) -> dict[int, int]:
    """Subtract rows until all pivots stand in different columns; return them by row."""
    ring = work.ring
    pivots = [_pivot(work, i) for i in range(work.rows)]
    while True:
        places: dict[int, int] = {}
        clash = None
        for i, column in enumerate(pivots):
            if column is None:
                continue
            if column in places:
                clash = (places[column], i, column)
                break
            places[column] = i
        if clash is None:
            return {row: column for column, row in places.items()}
        one, two, column = clash
        sizes = [ring.degree(work.matrix[i][column]) for i in (one, two)]
        target, source = (one, two) if sizes[0] > sizes[1] else (two, one)
        top, below = work.matrix[target][column], work.matrix[source][column]
        leading = ring.coefficient(top, ring.degree(top)) * ring.reciprocal_of_leading(below)
        shift = ring.power(ring.degree(top) - ring.degree(below))
        work.add_row(target, source, -leading * shift)
        pivots[target] = _pivot(work, target)


def _permute(work: Elimination, order: list[int]) -> None:
    """Bring rows into an order, those that it does not name last."""
    rows = list(range(work.rows))
    for place, row in enumerate(order):
        where = rows.index(row)
        work.swap_rows(place, where)
        rows[place], rows[where] = rows[where], rows[place]


def _reduce(work: Elimination, columns: list[int]) -> None:
    """Make each pivot the only entry of its degree in its column; rows keep their pivots."""
    changed = True
    while changed:
        changed = False
        for i, column in enumerate(columns):
            for j in range(len(columns)):
                quotient = work.ring.divide(work.matrix[j][column], work.matrix[i][column])[0]
                if i != j and work.ring.degree(quotient) >= 0:
                    work.add_row(j, i, -quotient)
                    changed = True


def _is_popov(form: PolynomialMatrix, columns: list[int]) -> bool:
    def degree(i: int, j: int) -> int:
        return -1 if form[i, j].is_zero else int(form[i, j].degree())

    rows, width = form.shape
    return len(set(columns)) == len(columns) and all(
        form[i, c].LC() == 1
        and all(degree(j, c) < degree(i, c) for j in range(rows) if j != i)
        and all(degree(i, k) <= degree(i, c) - (k > c) for k in range(width))
        for i, c in enumerate(columns)
    )
