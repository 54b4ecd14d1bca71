"""Subspaces as columns of exact matrices: sums, intersections, preimages, divisors."""

from __future__ import annotations

from dataclasses import dataclass, field

from sympy import Expr, ImmutableMatrix, Matrix

from compensator_theory.matrices._echelon import echelon, independent_columns
from compensator_theory.matrices._flint_matrices import identity_matrix
from compensator_theory.matrices._linear_algebra import in_lowest_terms


@dataclass
class Subspaces:
    """Operations on subspaces of one space, each a matrix of independent columns.

    Attributes
    ----------
    divisors : list of sympy.Expr
        The minors that the operations so far divided by: with symbols, all of them hold where none
        is zero.
    """

    divisors: list[Expr] = field(default_factory=list)

    def span(self, matrix: Matrix) -> ImmutableMatrix:
        """Return the first independent columns."""
        basis, minor = independent_columns(ImmutableMatrix(matrix))
        self.divisors.append(minor)
        return basis

    def sum(self, *spaces: Matrix) -> ImmutableMatrix:
        """Return a basis of the sum, that of the first space first."""
        return self.span(ImmutableMatrix.hstack(*spaces))

    def kernel(self, matrix: Matrix) -> ImmutableMatrix:
        """Return a basis of the null space."""
        if not matrix.rows:
            return identity_matrix(matrix.cols)
        reduced = echelon(ImmutableMatrix(matrix))
        self.divisors.append(reduced.divided_by)
        return in_lowest_terms(reduced.kernel())

    def intersection(self, left: Matrix, right: Matrix) -> ImmutableMatrix:
        """Return a basis of the intersection."""
        meeting = self.kernel(left.row_join(-right))
        return in_lowest_terms(ImmutableMatrix(left * meeting[: left.cols, :]))

    def preimage(self, A: Matrix, space: Matrix) -> ImmutableMatrix:
        """Return a basis of the vectors that A maps into a space."""
        pairs = self.kernel(A.row_join(-space))
        return self.span(pairs[: A.cols, :])

    def contains(self, space: Matrix, vectors: Matrix) -> bool:
        """Tell whether a space contains vectors, with symbols for generic values."""
        return bool(self.sum(space, vectors).cols == space.cols)

    def canonical(self, space: Matrix) -> ImmutableMatrix:
        """Return the basis whose transpose is in reduced row echelon form: one for each space."""
        if not space.cols:
            return ImmutableMatrix(space)
        reduced = echelon(ImmutableMatrix(space.T))
        self.divisors.append(reduced.divided_by)
        return in_lowest_terms(ImmutableMatrix(reduced.matrix.T))

    def coordinates(self, basis: Matrix, vectors: Matrix) -> ImmutableMatrix | None:
        """Return X with basis X = vectors, its free entries 0; None if there is none."""
        reduced = echelon(ImmutableMatrix(basis.row_join(vectors)))
        self.divisors.append(reduced.divided_by)
        if any(pivot >= basis.cols for pivot in reduced.pivots):
            return None
        X = Matrix.zeros(basis.cols, vectors.cols)
        for row, pivot in enumerate(reduced.pivots):
            X[pivot, :] = reduced.matrix[row, basis.cols :]
        return in_lowest_terms(ImmutableMatrix(X))
