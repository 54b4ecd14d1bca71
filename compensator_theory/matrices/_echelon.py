"""Ranks, kernels and bases, with the polynomials in the symbols that they were divided by."""

from __future__ import annotations

from dataclasses import dataclass

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Matrix

from compensator_theory.matrices._domain_matrices import divided_by, domain_matrices
from compensator_theory.matrices._flint_matrices import (
    from_flint,
    identity_matrix,
    is_rational_matrix,
    rational_in_flint,
    to_flint,
    zero_matrix,
)
from compensator_theory.matrices._fraction_free import SymbolicRows
from compensator_theory.matrices._residues import large_prime


@dataclass(frozen=True)
class Echelon:
    """The reduced row echelon form of a matrix.

    Attributes
    ----------
    matrix : sympy.ImmutableMatrix
        Its nonzero rows.
    pivots : tuple of int
        Columns of the leading ones; as many as the rank, with symbols the generic one.
    divided_by : sympy.Expr
        The minor that was divided by; where it is zero, the rank may be smaller.
    """

    matrix: ImmutableMatrix
    pivots: tuple[int, ...]
    divided_by: Expr

    def kernel(self) -> ImmutableMatrix:
        """Return a basis of the null space, as columns; there may be none."""
        columns = self.matrix.cols
        free = [column for column in range(columns) if column not in self.pivots]
        stacked = (-self.matrix[:, free]).col_join(identity_matrix(len(free)))
        places = [*self.pivots, *free]
        return stacked[[places.index(k) for k in range(columns)], :]

    def solutions(self) -> tuple[ImmutableMatrix, tuple[ImmutableMatrix, ...]]:
        """Return a solution of A x = b and a basis of the homogeneous ones; this is of [A | b]."""
        kernel = self.kernel()[:-1, :]
        *basis, last = (kernel[:, k] for k in range(kernel.cols))
        return -last, tuple(basis)


def echelon(matrix: Matrix) -> Echelon:
    """Return the reduced row echelon form, by python-flint or without fractions."""
    columns = int(matrix.cols)
    if 0 in matrix.shape:
        return Echelon(zero_matrix(0, columns), (), sympy.Integer(1))
    if is_rational_matrix(matrix):
        raw = to_flint(matrix)
        if matrix.rows >= columns and has_full_rank(raw.numer_denom()[0]):
            return Echelon(identity_matrix(columns), tuple(range(columns)), sympy.Integer(1))
        reduced, rank = raw.rref()
        rows = reduced.tolist()[: int(rank)]
        pivots = tuple(next(c for c in range(columns) if row[c]) for row in rows)
        form = flint.fmpq_mat(len(rows), columns, [entry for row in rows for entry in row])
        return Echelon(from_flint(form), pivots, sympy.Integer(1))
    if (symbolic := SymbolicRows.of(matrix)) is not None:
        pivot_columns = symbolic.reduce(columns, shortest=False)
        form = symbolic.quotients(range(len(pivot_columns)), range(columns))
        return Echelon(form, tuple(pivot_columns), symbolic.minor())
    (over_ring,) = domain_matrices(matrix)
    if over_ring.domain.has_assoc_Ring:
        over_ring = over_ring.clear_denoms_rowwise(convert=True)[1]
    numerator, minor, pivots = over_ring.rref_den(method="FF")
    form = divided_by(numerator, minor).to_Matrix()[: len(pivots), :]
    return Echelon(ImmutableMatrix(form), tuple(pivots), numerator.domain.to_sympy(minor))


def pivot_columns(matrix: Matrix) -> tuple[tuple[int, ...], Expr]:
    """Return the first columns that span the column space, and the minor that proves it."""
    size = min(matrix.shape)
    raw = rational_in_flint(matrix[:, :size]) if size else None
    if raw is not None and has_full_rank(raw.numer_denom()[0]):
        return tuple(range(size)), sympy.Integer(1)
    reduced = echelon(matrix)
    return reduced.pivots, reduced.divided_by


def has_full_rank(matrix: flint.fmpz_mat) -> bool:
    """Tell whether a rank modulo a prime shows that of an integer matrix to be full.

    It is never larger than the rank of the matrix; False may be the fault of the prime.
    """
    size = min(int(matrix.nrows()), int(matrix.ncols()))
    return int(flint.nmod_mat(matrix, large_prime()).rank()) == size


def independent_columns(matrix: Matrix) -> tuple[ImmutableMatrix, Expr]:
    """Return the first columns that span the column space, and the minor that proves it."""
    chosen, minor = pivot_columns(matrix)
    return ImmutableMatrix(matrix[:, list(chosen)]), minor


def contradictions(matrix: Matrix, right_side: Matrix) -> list[Expr]:
    r"""Return y b for a basis of the relations y A = 0 of a linear system A x = b.

    The system is contradictory wherever one of them is not zero, for they hold no denominators.
    """
    if not (matrix.free_symbols or right_side.free_symbols):
        return [sympy.Integer(1)]
    relations = echelon(ImmutableMatrix(matrix.T)).kernel()
    rows = []
    for k in range(relations.cols):
        bottoms = [sympy.fraction(sympy.cancel(entry))[1] for entry in relations[:, k]]
        common = sympy.lcm_list(bottoms)
        total = sum(common * y * b for y, b in zip(relations[:, k], right_side, strict=True))
        if (value := sympy.cancel(total)) != 0:
            rows.append(value)
    return rows
