"""Elementary operations on polynomial matrices, with the unimodular matrices that they make up."""

from __future__ import annotations

from compensator_theory.matrices._rings import (
    Element,
    Grid,
    Ring,
    identity,
    multiply,
)
from compensator_theory.polynomials._budget import ask

LEAST = 200
"""Digits in whose time the shortest entry is multiplied and added."""


class Elimination:
    """A polynomial matrix under row and column operations, U M V = current, all of them kept.

    Attributes
    ----------
    entries : list of lists
        M.
    matrix : list of lists
        U M V.
    U, V, U_inverse, V_inverse : list of lists
        Products of the operations so far, and of their inverses.
    effort : int
        How many digits the steps so far worked on; of 2 10^8 in about 2 s.
    """

    def __init__(self, ring: Ring, matrix: Grid) -> None:
        self.ring, self.entries = ring, matrix
        self.matrix = [list(row) for row in matrix]
        self.rows, self.columns = len(matrix), len(matrix[0])
        self.U, self.U_inverse = identity(ring, self.rows), identity(ring, self.rows)
        self.V, self.V_inverse = identity(ring, self.columns), identity(ring, self.columns)
        self.effort = 0

    def transpose(self) -> None:
        """Exchange the roles of rows and columns: (U M V)' = V' M' U'."""
        self.entries, self.matrix = _transposed(self.entries), _transposed(self.matrix)
        self.rows, self.columns = self.columns, self.rows
        self.U, self.V = _transposed(self.V), _transposed(self.U)
        self.U_inverse, self.V_inverse = _transposed(self.V_inverse), _transposed(self.U_inverse)

    def add_row(self, target: int, source: int, factor: Element) -> None:
        """Add a multiple of one row to another."""
        self._count(factor, factor)
        for grid in (self.matrix, self.U):
            grid[target] = [x + factor * y for x, y in zip(grid[target], grid[source], strict=True)]
        for row in self.U_inverse:
            row[source] -= factor * row[target]

    def swap_rows(self, i: int, j: int) -> None:
        """Exchange two rows."""
        if i != j:
            for grid in (self.matrix, self.U):
                grid[i], grid[j] = grid[j], grid[i]
            for row in self.U_inverse:
                row[i], row[j] = row[j], row[i]

    def scale_row(self, i: int, factor: Element, inverse: Element) -> None:
        """Multiply a row by a constant."""
        for grid in (self.matrix, self.U):
            grid[i] = [factor * x for x in grid[i]]
        for row in self.U_inverse:
            row[i] *= inverse

    def add_column(self, target: int, source: int, factor: Element) -> None:
        """Add a multiple of one column to another."""
        self._count(factor, factor)
        for grid in (self.matrix, self.V):
            for row in grid:
                row[target] += factor * row[source]
        inverse = self.V_inverse
        inverse[source] = [
            x - factor * y for x, y in zip(inverse[source], inverse[target], strict=True)
        ]

    def swap_columns(self, i: int, j: int) -> None:
        """Exchange two columns."""
        if i != j:
            for grid in (self.matrix, self.V):
                for row in grid:
                    row[i], row[j] = row[j], row[i]
            inverse = self.V_inverse
            inverse[i], inverse[j] = inverse[j], inverse[i]

    def make_monic(self, row: int, column: int) -> None:
        """Scale a row so that its entry in a column is monic."""
        entry, ring = self.matrix[row][column], self.ring
        factor = ring.reciprocal_of_leading(entry)
        if factor != ring.one:
            self.scale_row(row, factor, ring.divide(ring.one, factor)[0])

    def least(self, places: list[tuple[int, int]]) -> tuple[int, int] | None:
        """Return the first place with a nonzero entry of least degree."""
        nonzero = [(i, j) for i, j in places if self.ring.degree(self.matrix[i][j]) >= 0]
        return min(nonzero, key=lambda p: self.ring.degree(self.matrix[p[0]][p[1]]), default=None)

    def triangulate_column(self, row: int, column: int) -> None:
        """Make the entries below a row zero and the one in it their monic gcd."""
        below = list(range(row, self.rows))
        while (place := self.least([(i, column) for i in below])) is not None:
            self.swap_rows(row, place[0])
            rest = [i for i in below[1:] if self.ring.degree(self.matrix[i][column]) >= 0]
            if not rest:
                self.make_monic(row, column)
                return
            for i in rest:
                self.reduce_row(i, row, column)

    def reduce_row(self, target: int, source: int, column: int) -> None:
        """Subtract a multiple of a row, so that a remainder is left in a column."""
        a, b = self.matrix[target][column], self.matrix[source][column]
        self._count(a, b)
        self.add_row(target, source, -self.ring.divide(a, b)[0])

    def reduce_column(self, target: int, source: int, row: int) -> None:
        """Subtract a multiple of a column, so that a remainder is left in a row."""
        a, b = self.matrix[row][target], self.matrix[row][source]
        self._count(a, b)
        self.add_column(target, source, -self.ring.divide(a, b)[0])

    def _count(self, a: Element, b: Element) -> None:
        """Check the budget for the digits of one step: their growth cannot be predicted."""
        self.effort += (self.rows + self.columns) * max(LEAST, self.ring.effort(a, b))
        ask("entries", self.effort // 400, "the elimination, 400 digits as an entry,")

    def combine_rows(self, i: int, j: int, step: Grid, inverse: Grid) -> None:
        """Multiply two rows by a unimodular 2 x 2 matrix, with its known inverse."""
        for grid in (self.matrix, self.U):
            grid[i], grid[j] = multiply(self.ring, step, [grid[i], grid[j]])
        pairs = [[row[i], row[j]] for row in self.U_inverse]
        for row, pair in zip(self.U_inverse, multiply(self.ring, pairs, inverse), strict=True):
            row[i], row[j] = pair

    def triangulate(self) -> int:
        """Reach the Hermite form by row operations; return the rank."""
        rank = 0
        for column in range(self.columns):
            if rank == self.rows:
                break
            self.triangulate_column(rank, column)
            if self.ring.degree(self.matrix[rank][column]) >= 0:
                for above in range(rank):
                    self.reduce_row(above, rank, column)
                rank += 1
        return rank


def _transposed(grid: Grid) -> Grid:
    return [list(column) for column in zip(*grid, strict=True)]
