"""Elementary operations on polynomial matrices, with the unimodular matrices that they make up."""

from collections.abc import Iterator

from compensator_theory.bezout.fraction_free import FractionFree
from compensator_theory.polynomial_matrices.rings import (
    Element,
    Grid,
    Ring,
    SymbolicRing,
    identity,
    multiply,
)

TRIALS = (1, -1, 2, -2, 3, -3, 5, -5)
"""Multiples of one column that are added to another, until their gcd is that of both."""


class Elimination:
    """A polynomial matrix under row and column operations, U M V = current, all of them kept.

    Attributes
    ----------
    matrix : list of lists
        U M V.
    U, V, U_inverse, V_inverse : list of lists
        Products of the operations so far, and of their inverses.

    Examples
    --------
    >>> from compensator_theory import polynomial_matrix
    >>> from compensator_theory.polynomial_matrices.elimination import Elimination
    >>> from compensator_theory.polynomial_matrices.polynomial_matrices import joint_ring
    >>> from compensator_theory.polynomial_matrices.polynomial_matrices import read_into, written
    >>> P = polynomial_matrix([["s"], ["s**2 + 1"]])
    >>> ring = joint_ring(P)
    >>> work = Elimination(ring, read_into(ring, P))
    >>> work.triangulate_column(0, 0)
    >>> print(written(ring, work.matrix), written(ring, work.U))
    [[1], [0]] [[-s, 1], [s**2 + 1, -s]]
    """

    def __init__(self, ring: Ring, matrix: Grid) -> None:
        self.ring = ring
        self.matrix = [list(row) for row in matrix]
        self.rows, self.columns = len(matrix), len(matrix[0])
        self.U, self.U_inverse = identity(ring, self.rows), identity(ring, self.rows)
        self.V, self.V_inverse = identity(ring, self.columns), identity(ring, self.columns)

    def add_row(self, target: int, source: int, factor: Element) -> None:
        """Add a multiple of one row to another."""
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
        self.add_row(target, source, -self.ring.divide(a, b)[0])

    def reduce_column(self, target: int, source: int, row: int) -> None:
        """Subtract a multiple of a column, so that a remainder is left in a row."""
        a, b = self.matrix[row][target], self.matrix[row][source]
        self.add_column(target, source, -self.ring.divide(a, b)[0])

    def combine_rows(self, i: int, j: int, step: Grid, inverse: Grid) -> None:
        """Multiply two rows by a unimodular 2 x 2 matrix; both are given, as nothing is divided."""
        for grid in (self.matrix, self.U):
            grid[i], grid[j] = multiply(self.ring, step, [grid[i], grid[j]])
        pairs = [[row[i], row[j]] for row in self.U_inverse]
        for row, pair in zip(self.U_inverse, multiply(self.ring, pairs, inverse), strict=True):
            row[i], row[j] = pair

    def diagonalise(self, start: int = 0) -> int:
        """Reach the Smith form by Euclid's algorithm from a row on; return the rank.

        The pivot is always an entry of least degree; where it divides its row and column and not
        all that is left, a row that it does not divide is added to its own, and its degree falls.
        """
        size = min(self.rows, self.columns)
        for k in range(start, size):
            places = [(i, j) for i in range(k, self.rows) for j in range(k, self.columns)]
            place = self.least(places)
            if place is None:
                return k
            while place is not None:
                self.swap_rows(k, place[0])
                self.swap_columns(k, place[1])
                for i in range(k + 1, self.rows):
                    self.reduce_row(i, k, k)
                for j in range(k + 1, self.columns):
                    self.reduce_column(j, k, k)
                cross = [(i, k) for i in range(k + 1, self.rows)]
                cross += [(k, j) for j in range(k + 1, self.columns)]
                place = self.least(cross)
                if place is None and (bad := self._undivided(k)) is not None:
                    self.add_row(k, bad, self.ring.one)
                    place = (k, k)
            self.make_monic(k, k)
        return size

    def _undivided(self, k: int) -> int | None:
        pivot = self.matrix[k][k]
        if self.ring.degree(pivot) == 0:
            return None
        for i in range(k + 1, self.rows):
            for entry in self.matrix[i][k + 1 :]:
                if self.ring.degree(self.ring.divide(entry, pivot)[1]) >= 0:
                    return i
        return None


def diagonalise(work: Elimination) -> int:
    """Reach the Smith form; return the rank.

    Over a field of rational functions every remainder of Euclid's algorithm swells. There a column
    is chosen whose entries have the gcd of all that is left; the multipliers of its identity come
    from one Sylvester system without fractions, and what remains are exact divisions.

    Examples
    --------
    >>> from compensator_theory import polynomial_matrix
    >>> from compensator_theory.polynomial_matrices.elimination import Elimination, diagonalise
    >>> from compensator_theory.polynomial_matrices.polynomial_matrices import joint_ring
    >>> from compensator_theory.polynomial_matrices.polynomial_matrices import read_into, written
    >>> P = polynomial_matrix([["s", "a"], [0, "s"]])
    >>> work = Elimination(joint_ring(P), read_into(joint_ring(P), P))
    >>> diagonalise(work), str(written(work.ring, work.matrix))
    (2, '[[1, 0], [0, s**2]]')
    """
    ring = work.ring
    if not (isinstance(ring, SymbolicRing) and FractionFree.serves(ring.field)):
        return work.diagonalise()
    steps = FractionFree(ring.ring)
    for k in range(min(work.rows, work.columns)):
        rest = [row[k:] for row in work.matrix[k:]]
        goal = steps.degree_of_gcd([e for row in rest for e in row])
        if goal < 0:
            return k
        if not _place_pivot(work, k, goal) and not _place_column(work, steps, k, goal):
            return work.diagonalise(k)
        for i in range(k + 1, work.rows):
            if work.matrix[i][k]:
                _combine(work, steps, k, i)
        work.make_monic(k, k)
        pivot = work.matrix[k][k]
        for j in range(k + 1, work.columns):
            if work.matrix[k][j]:
                work.add_column(j, k, -ring.divide(work.matrix[k][j], pivot)[0])
    return min(work.rows, work.columns)


def _place_pivot(work: Elimination, k: int, goal: int) -> bool:
    """Bring the shortest entry that divides all others to its place, if there is one."""
    places = [
        (sum(len(c.numer) + len(c.denom) for c in work.matrix[i][j].values()), i, j)
        for i in range(k, work.rows)
        for j in range(k, work.columns)
        if work.ring.degree(work.matrix[i][j]) == goal
    ]
    if not places:
        return False
    _, i, j = min(places)
    work.swap_rows(k, i)
    work.swap_columns(k, j)
    return True


def _place_column(work: Elimination, steps: FractionFree, k: int, goal: int) -> bool:
    """Bring a column to its place whose gcd is that of all columns: one of them, or a sum."""
    for j in range(k, work.columns):
        if steps.degree_of_gcd([row[j] for row in work.matrix[k:]]) == goal:
            work.swap_columns(k, j)
            return True
    for factors in _combinations(work.columns - k - 1):
        column = [
            row[k] + sum(row[j] * c for j, c in enumerate(factors, k + 1)) for row in work.matrix
        ]
        if steps.degree_of_gcd(column[k:]) == goal:
            for j, c in enumerate(factors, k + 1):
                work.add_column(k, j, work.ring.one * c)
            return True
    return False


def _combinations(count: int) -> Iterator[list[int]]:
    """Yield multipliers for the other columns; all but finitely many choices serve."""
    for c in TRIALS:
        yield [c**power for power in range(1, count + 1)]


def _combine(work: Elimination, steps: FractionFree, k: int, i: int) -> None:
    """Leave the gcd of two entries of column k in row k, and zero in row i."""
    x, y, a, b = steps.identity(work.matrix[k][k], work.matrix[i][k])
    work.combine_rows(k, i, [[x, y], [-b, a]], [[a, -y], [b, x]])
