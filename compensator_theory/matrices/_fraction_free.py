"""Elimination without fractions in matrices of rational functions of symbols."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

import flint
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory.matrices._rational_functions import RationalFunctions
from compensator_theory.matrices._symbolic_matrices import (
    Numerators,
    common_factor,
    multiplied_grids,
    of_numerators,
    over_common_symbols,
    over_one,
)


class SymbolicRows:
    """Matrices of one height side by side, each row times its least common denominator.

    Attributes
    ----------
    rows : list of lists of flint.fmpz_mpoly
    scales : list of flint.fmpz_mpoly
        The factor of each row.
    last : flint.fmpz_mpoly
        The minor that the reduced rows have as their common factor.
    """

    def __init__(self, work: RationalFunctions, parts: Sequence[Numerators]) -> None:
        self.work, self.last, self.sign = work, work.one, 1
        flats, common = over_one(work, parts)
        widths = [part.columns for part in parts]
        rows = (
            [x for flat, m in zip(flats, widths, strict=True) for x in flat[i * m : (i + 1) * m]]
            for i in range(parts[0].rows)
        )
        lowest_terms = (_in_lowest_terms(row, common) for row in rows)
        self.rows, self.scales = map(list, zip(*lowest_terms, strict=True))

    @classmethod
    def of(cls, *matrices: Matrix) -> SymbolicRows | None:
        """Read matrices of rational functions of symbols over QQ; None where they hold others."""
        if 0 in matrices[0].shape or (read := over_common_symbols(*matrices)) is None:
            return None
        return cls(*read)

    def at_a_point(self) -> flint.fmpz_mat:
        """Return the rows at some integers in place of the symbols."""
        point = [10**6 + 3 + 1009 * k**2 for k in range(len(self.work.symbols))]
        return flint.fmpz_mat([[x(*point) for x in row] for row in self.rows])

    def reduce(self, columns: int, *, shortest: bool = True) -> list[int]:
        """Bring the first columns to reduced echelon form, times `last`; return the pivots.

        With `shortest` the pivot of a column is its shortest entry, else its first.
        """
        pivots: list[int] = []
        for column in range(columns):
            k = len(pivots)
            below = [i for i in range(k, len(self.rows)) if not self.rows[i][column].is_zero()]
            if not below:
                continue
            place = min(below, key=lambda i: len(self.rows[i][column])) if shortest else below[0]
            if place != k:
                self.rows[k], self.rows[place] = self.rows[place], self.rows[k]
                self.sign = -self.sign
            self._clear_column(k, column)
            pivots.append(column)
            if len(pivots) == len(self.rows):
                break
        return pivots

    def _clear_column(self, k: int, column: int) -> None:
        """Bareiss's step: every entry stays a minor of the matrix, so that the division is exact.

        A row that is zero in the column is multiplied all the same, so that all have one factor.
        """
        chosen, pivot, before = self.rows[k], self.rows[k][column], self.last
        for i, row in enumerate(self.rows):
            if i != k:
                head = row[column]
                if not head.is_zero():
                    self.rows[i] = [
                        (pivot * x - head * y) / before for x, y in zip(row, chosen, strict=True)
                    ]
                elif pivot != before:
                    self.rows[i] = [x if x.is_zero() else pivot * x / before for x in row]
        self.last = pivot

    def quotients(self, rows: Sequence[int], columns: Sequence[int]) -> ImmutableMatrix:
        """Return entries of the reduced form, in lowest terms."""
        numerators = [self.rows[i][j] for i in rows for j in columns]
        return of_numerators(self.work, numerators, self.last, (len(rows), len(columns)))

    def minor(self) -> Expr:
        """The minor of the rows without denominators by which the reduced form was multiplied."""
        return self.work.expression(self.last)

    def determinant(self) -> Expr:
        """Return the determinant of a square matrix whose rows have all been reduced."""
        below, above = prod(self.scales, start=self.work.one), self.last * self.sign
        if below.is_constant():
            return self.work.expression(above, int(below.leading_coefficient()))
        return self.work.write(above, below)


def _in_lowest_terms(
    row: list[flint.fmpz_mpoly], below: flint.fmpz_mpoly
) -> tuple[list[flint.fmpz_mpoly], flint.fmpz_mpoly]:
    """Return a row of numerators over its least denominator, and that denominator."""
    shared = common_factor(below, row)
    return (row if shared.is_one() else [x / shared for x in row]), below / shared


def symbolic_characteristic_polynomial(matrix: Matrix, variable: Symbol) -> Poly | None:
    r"""Return det(sI - A) by Faddeev and LeVerrier; None for other than rational functions over QQ.

    .. math:: M_1 = I, \quad c_k = -\mathrm{tr}(A M_k)/k, \quad M_{k+1} = A M_k + c_k I
    """
    if (read := over_common_symbols(matrix)) is None:
        return None
    work, (numerators,) = read
    n, A, common = numerators.rows, numerators.grid(), numerators.below
    coefficients, below, product = [(work.one, work.one)], work.one, [list(row) for row in A]
    for k in range(1, n + 1):
        below = below * common
        c = -sum((product[i][i] for i in range(n)), start=work.zero) / k
        coefficients.append((c, below))
        for i in range(n):
            product[i][i] = product[i][i] + c
        if k < n:
            product = multiplied_grids(work, A, product)
    return work.polynomial(coefficients, variable)
