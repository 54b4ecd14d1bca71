"""The Smith form of a polynomial matrix, with the unimodular matrices that lead to it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from sympy import Expr, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.forms._elimination import Elimination
from compensator_theory.forms._equivalence import by_rows_and_columns, elimination_of
from compensator_theory.forms._function_rings import FunctionRing
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    PolynomialMatrixLike,
    polynomial_matrix,
)
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.polynomials._values import ExactValue

IDENTITY = "U P V = S, U U^-1 = I, V V^-1 = I"


@dataclass(frozen=True)
class SmithForm(ExactValue):
    r"""The diagonal form of a polynomial matrix under unimodular row and column operations.

    .. math:: U P V = S = \mathrm{diag}(\lambda_1, \ldots, \lambda_r, 0, \ldots), \qquad
              \lambda_i \mid \lambda_{i+1}

    Attributes
    ----------
    matrix, form : PolynomialMatrix
        P and S, both p x m; the invariant polynomials are monic.
    U, V, U_inverse, V_inverse : PolynomialMatrix
        p x p and m x m, unimodular: their inverses are polynomial too. S is unique, they are not.
    rank : int
        The normal rank r.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the form holds where none of them is zero, and
        there may be another one where one is. Empty without symbols.
    certificate : Certificate
        U P V - S and the products with the inverses, multiplied out anew.
    """

    matrix: PolynomialMatrix
    form: PolynomialMatrix
    U: PolynomialMatrix
    V: PolynomialMatrix
    U_inverse: PolynomialMatrix
    V_inverse: PolynomialMatrix
    rank: int
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def invariant_polynomials(self) -> tuple[Poly, ...]:
        """The nonzero diagonal entries, each a divisor of the next."""
        return tuple(self.form[i, i] for i in range(self.rank))

    @property
    def elementary_divisors(self) -> tuple[tuple[Poly, int], ...]:
        """Powers of irreducible polynomials: all factors of all invariant polynomials."""
        return tuple(
            (factor.monic(), power)
            for invariant in self.invariant_polynomials
            for factor, power in invariant.factor_list()[1]
        )

    def __str__(self) -> str:
        return str(self.form)

    def _repr_latex_(self) -> str:
        parts = latex(self.U_inverse) + latex(self.form) + latex(self.V_inverse)
        return displayed(
            rf"P = {latex(self.matrix)} = U^{{-1}} S\, V^{{-1}} = {parts}", unless(self.exceptional)
        )


def smith_form(matrix: PolynomialMatrixLike, variable: str | Symbol | None = None) -> SmithForm:
    r"""Bring a polynomial matrix to its Smith form.

    .. math:: \lambda_1 \cdots \lambda_k = \text{the monic gcd of all } k \times k \text{ minors}

    Parameters
    ----------
    matrix : polynomial matrix
        Anything :func:`polynomial_matrix` reads, of any shape.
    variable : str or Symbol, optional
        As for :func:`polynomial_matrix`.

    Raises
    ------
    InputError, BudgetError
        If it is no polynomial matrix, or too large.

    Notes
    -----
    With symbols, the form is that for generic values of them, and it jumps: that of
    [[s, a], [0, s]] is diag(1, s**2), and at a = 0 diag(s, s). So `exceptional` lists what U, V and
    their inverses are divided by: elsewhere the certificate proves the form. Euclid's algorithm
    lets the numbers in U and V grow fast beyond 6 x 6.

    Source: H. J. S. Smith (1861); T. Kailath, Linear Systems (1980), Section 6.3.

    Examples
    --------
    >>> from compensator_theory.forms import smith_form
    >>> print(smith_form([["s*(s + 1)", 0], [0, "s*(s + 2)"]]))
    [[s, 0], [0, s**3 + 3*s**2 + 2*s]]
    >>> found = smith_form([["s", "a"], [0, "s"]])
    >>> print(found, found.exceptional)
    [[1, 0], [0, s**2]] (a,)
    """
    source = polynomial_matrix(matrix, variable)
    work = elimination_of(source)
    rank = diagonalise(work)
    found = by_rows_and_columns(work, IDENTITY)
    return SmithForm(
        source,
        found.form,
        found.U,
        found.V,
        found.U_inverse,
        found.V_inverse,
        rank,
        found.exceptional,
        found.certificate,
    )


# How elementary operations reach the Smith form: by Euclid, or without fractions.

TRIALS = (1, -1, 2, -2, 3, -3, 5, -5)
"""Multiples of one column that are added to another, until their gcd is that of both."""


def diagonalise(work: Elimination) -> int:
    """Reach the Smith form; return the rank.

    Over a field of rational functions every remainder of Euclid's algorithm swells. There a column
    is chosen whose entries have the gcd of all that is left; the multipliers of its identity come
    from one Sylvester system without fractions, and what remains are exact divisions.

    Examples
    --------
    >>> from compensator_theory import polynomial_matrix
    >>> from compensator_theory.forms._smith import diagonalise
    >>> from compensator_theory.forms._equivalence import elimination_of
    >>> from compensator_theory.forms._polynomial_matrices import written
    >>> work = elimination_of(polynomial_matrix([["s", "a"], [0, "s"]]))
    >>> diagonalise(work), str(written(work.ring, work.matrix))
    (2, '[[1, 0], [0, s**2]]')
    """
    ring = work.ring
    if not isinstance(ring, FunctionRing):
        return by_euclid(work)
    if work.columns > work.rows:  # a last row alone would be left to Euclid
        work.transpose()
        rank = diagonalise(work)
        work.transpose()
        return rank
    for k in range(min(work.rows, work.columns)):
        rest = [row[k:] for row in work.matrix[k:]]
        goal = ring.degree_of_gcd(e for row in rest for e in row)
        if goal < 0:
            return k
        if not _place_pivot(work, ring, k, goal) and not _place_column(work, ring, k, goal):
            return by_euclid(work, k)
        for i in range(k + 1, work.rows):
            if work.matrix[i][k]:
                _combine(work, ring, k, i)
        work.make_monic(k, k)
        pivot = work.matrix[k][k]
        for j in range(k + 1, work.columns):
            if work.matrix[k][j]:
                work.add_column(j, k, -ring.divide(work.matrix[k][j], pivot)[0])
    return min(work.rows, work.columns)


def by_euclid(work: Elimination, start: int = 0) -> int:
    """Reach the Smith form by Euclid's algorithm from a row on; return the rank.

    The pivot is always an entry of least degree; where it divides its row and column and not all
    that is left, a row that it does not divide is added to its own, and its degree falls.
    """
    size = min(work.rows, work.columns)
    for k in range(start, size):
        places = [(i, j) for i in range(k, work.rows) for j in range(k, work.columns)]
        place = work.least(places)
        if place is None:
            return k
        while place is not None:
            work.swap_rows(k, place[0])
            work.swap_columns(k, place[1])
            for i in range(k + 1, work.rows):
                work.reduce_row(i, k, k)
            for j in range(k + 1, work.columns):
                work.reduce_column(j, k, k)
            cross = [(i, k) for i in range(k + 1, work.rows)]
            cross += [(k, j) for j in range(k + 1, work.columns)]
            place = work.least(cross)
            if place is None and (bad := _undivided(work, k)) is not None:
                work.add_row(k, bad, work.ring.one)
                place = (k, k)
        work.make_monic(k, k)
    return size


def _undivided(work: Elimination, k: int) -> int | None:
    pivot = work.matrix[k][k]
    if work.ring.degree(pivot) == 0:
        return None
    for i in range(k + 1, work.rows):
        for entry in work.matrix[i][k + 1 :]:
            if work.ring.degree(work.ring.divide(entry, pivot)[1]) >= 0:
                return i
    return None


def _place_pivot(work: Elimination, ring: FunctionRing, k: int, goal: int) -> bool:
    """Bring the shortest entry that divides all others to its place, if there is one."""
    places = [
        (ring.terms(work.matrix[i][j]), i, j)
        for i in range(k, work.rows)
        for j in range(k, work.columns)
        if ring.degree(work.matrix[i][j]) == goal
    ]
    if not places:
        return False
    _, i, j = min(places)
    work.swap_rows(k, i)
    work.swap_columns(k, j)
    return True


def _place_column(work: Elimination, ring: FunctionRing, k: int, goal: int) -> bool:
    """Bring a column to its place whose gcd is that of all columns: one of them, or a sum."""
    for j in range(k, work.columns):
        if ring.degree_of_gcd(row[j] for row in work.matrix[k:]) == goal:
            work.swap_columns(k, j)
            return True
    for factors in _combinations(work.columns - k - 1):
        column = [
            sum((row[j] * c for j, c in enumerate(factors, k + 1)), row[k]) for row in work.matrix
        ]
        if ring.degree_of_gcd(column[k:]) == goal:
            for j, c in enumerate(factors, k + 1):
                work.add_column(k, j, ring.one * c)
            return True
    return False


def _combinations(count: int) -> Iterator[list[int]]:
    """Yield multipliers for the other columns; all but finitely many choices serve."""
    for c in TRIALS:
        yield [c**power for power in range(1, count + 1)]


def _combine(work: Elimination, ring: FunctionRing, k: int, i: int) -> None:
    """Leave the gcd of two entries of column k in row k, and zero in row i."""
    x, y, a, b = ring.identity(work.matrix[k][k], work.matrix[i][k])
    work.combine_rows(k, i, [[x, y], [-b, a]], [[a, -y], [b, x]])
