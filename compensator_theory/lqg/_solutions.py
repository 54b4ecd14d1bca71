"""Solutions of a linear matrix equation: one solution, the family, and the conditions."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import sympy
from sympy import Expr, ImmutableMatrix, Matrix

from compensator_theory._latex import displayed, latex, total, unless
from compensator_theory._terminal import matrix_line
from compensator_theory.errors import NoSolutionError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._echelon import contradictions, echelon
from compensator_theory.matrices._exceptional_factors import denominators_of, exceptional_factors
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._letters import names_in_all, numbered
from compensator_theory.polynomials._values import ExactValue


@dataclass(frozen=True)
class MatrixSolution(ExactValue):
    """Every solution of a linear equation for a matrix X.

    Attributes
    ----------
    X : sympy.ImmutableMatrix
        One solution.
    homogeneous : tuple of sympy.ImmutableMatrix
        A basis of the homogeneous solutions; empty where X is the only solution.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero. For
        values where one is, solve again with these values: there may be no solution or a family.
    certificate : Certificate
        The equation, evaluated anew for X and for the basis.
    """

    X: ImmutableMatrix
    homogeneous: tuple[ImmutableMatrix, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def is_unique(self) -> bool:
        """Whether X is the only solution."""
        return not self.homogeneous

    def __str__(self) -> str:
        count = len(self.homogeneous)
        return matrix_line("X", self.X) + f", one of a family of dimension {count}" * bool(count)

    def _repr_latex_(self) -> str:
        alpha = numbered(names_in_all(self), "alpha", len(self.homogeneous))
        pairs = zip(alpha, self.homogeneous, strict=True)
        terms = [f"{latex(letter)} {latex(part)}" for letter, part in pairs]
        return displayed(f"X = {total([latex(self.X), *terms])}", unless(self.exceptional))


Terms: TypeAlias = Sequence[tuple[Matrix, Matrix]]
"""Pairs (L_i, R_i) of a linear map, the sum of the L_i X R_i."""


def solve_by_kronecker(
    maps: Sequence[Terms],
    shape: tuple[int, int],
    right: Sequence[Expr],
    *,
    contradiction: str,
    sources: Iterable[Matrix] = (),
) -> tuple[ImmutableMatrix, tuple[ImmutableMatrix, ...], list[Expr]]:
    r"""Solve linear equations for a matrix as one system of n m unknowns.

    .. math:: \sum_i L_i X R_i = C \quad\Leftrightarrow\quad
              \left(\textstyle\sum_i L_i \otimes R_i^T\right) \mathrm{vec}\, X = \mathrm{vec}\, C

    where vec lists a matrix row by row.
    """
    rows, columns = shape
    size = rows * columns
    ask("entries", len(right) * (size + 1), "the linear system of the matrix equation")
    table = Matrix.vstack(*(_table(terms) for terms in maps))
    reduced = echelon(table.row_join(Matrix(len(right), 1, list(right))))
    divisors = [reduced.divided_by, *denominators_of(sources)]
    if size in reduced.pivots:
        column = Matrix(len(right), 1, list(right))
        raise NoSolutionError(contradiction).holding(contradictions(table, column))
    particular, basis = reduced.solutions()
    X, *more = (ImmutableMatrix(rows, columns, list(v)) for v in (particular, *basis))
    return X, tuple(more), divisors


def _table(terms: Terms) -> Matrix:
    """Add up the Kronecker products, entries that are not zero only."""
    left, right = terms[0]
    below, width = right.cols, right.rows
    entries: dict[tuple[int, int], Expr] = defaultdict(lambda: sympy.Integer(0))
    for L, R in terms:
        columns = list(R.todok().items())
        for (i, j), x in L.todok().items():
            for (k, n), y in columns:
                entries[i * below + n, j * width + k] += x * y
    return Matrix(left.rows * below, left.cols * width, lambda i, j: entries.get((i, j), 0))


def certified(
    identity: str,
    residuals: Iterable[Matrix],
    X: ImmutableMatrix,
    homogeneous: tuple[ImmutableMatrix, ...],
    divisors: Iterable[Expr],
) -> MatrixSolution:
    """Return a solution with its certificate; refuse a wrong one."""
    certificate = certificate_of(identity, residuals)
    return MatrixSolution(X, homogeneous, exceptional_factors(divisors), certificate)
