"""The Smith form with symbols: one greatest common divisor a step, and nothing divided before it.

Euclid's algorithm over a field of rational functions lets every remainder swell. Here a column is
chosen whose entries have the gcd of all that is left; the multipliers of its identity come from one
Sylvester system without fractions, and what remains are exact divisions.
"""

from collections.abc import Iterator

from compensator_theory.structure.elimination import Elimination
from compensator_theory.structure.fraction_free import FractionFree
from compensator_theory.structure.rings import SymbolicRing

TRIALS = (1, -1, 2, -2, 3, -3, 5, -5)


def diagonalise(work: Elimination) -> int:
    """Reach the Smith form; return the rank.

    Examples
    --------
    >>> from compensator_theory import polynomial_matrix
    >>> from compensator_theory.structure.elimination import Elimination
    >>> from compensator_theory.structure.gcd_steps import diagonalise
    >>> from compensator_theory.structure.polynomial_matrices import joint_ring, read_into, written
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
