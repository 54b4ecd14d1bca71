"""How elementary operations reach the Smith form: by Euclid, or without fractions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from sympy import Poly

from compensator_theory.matrices._elimination import Elimination
from compensator_theory.matrices._function_rings import FunctionRing
from compensator_theory.matrices._rings import ring_of

TRIALS = (1, -1, 2, -2, 3, -3, 5, -5)
"""Multiples of one column that are added to another, until their gcd is that of both."""


def diagonalise(work: Elimination) -> int:
    """Reach the Smith form; return the rank.

    Over a field of rational functions every remainder of Euclid's algorithm swells. There a column
    is chosen whose entries have the gcd of all that is left; the multipliers of its identity come
    from one Sylvester system without fractions, and what remains are exact divisions.
    """
    ring = work.ring
    if not isinstance(ring, FunctionRing):
        return by_euclid(work)
    if work.columns > work.rows:  # a single last row is a case for Euclid's algorithm
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
    that remains, a row that it does not divide is added to its row, and its degree falls.
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


def invariant_polynomials(rows: Iterable[Iterable[Poly]]) -> list[Poly]:
    """Return the monic invariant polynomials of a polynomial matrix, each a divisor of the next."""
    entries = [[*row] for row in rows]
    ring = ring_of(chain(*entries))
    work = Elimination(ring, [[ring.read(entry) for entry in row] for row in entries])
    return [ring.write(work.matrix[i][i]) for i in range(diagonalise(work))]
