"""Continua of invariant subspaces, where a matrix has several Jordan blocks for one root."""

from __future__ import annotations

import random
from collections.abc import Iterator

import flint
import sympy
from sympy import ImmutableMatrix, Matrix, Symbol

from compensator_theory.matrices._flint_matrices import (
    from_flint,
    identity_matrix,
    rational_in_flint,
)
from compensator_theory.matrices._invariant_subspaces import PrimaryComponent, joined, kernel
from compensator_theory.matrices._linear_algebra import rank


def subspace_family(
    matrix: Matrix, component: PrimaryComponent, exponent: int, names: Iterator[Symbol]
) -> tuple[ImmutableMatrix, tuple[Symbol, ...]] | None:
    r"""Parametrise the cyclic invariant subspaces with the polynomial :math:`f^e`.

    .. math:: V(\alpha) = \mathrm{span}\{v, \tilde A v, \tilde A^2 v, \ldots\}, \qquad
              v = v_0 + \textstyle\sum_i \alpha_i c_i

    Notes
    -----
    The :math:`c_i` span an invariant complement of the cyclic subspace of :math:`v_0`: the kernel
    of a functional's first e deg f translates. A general v has the form :math:`r(\tilde A)v_0 + c`
    with r invertible modulo f, and v and v/r generate the same subspace.
    """
    size = exponent * component.degree
    whole = component.kernels[exponent]
    for v in _combinations(whole):
        cyclic = krylov(matrix, v, size)
        if rank(cyclic) < size:
            continue
        for functional in _combinations(identity_matrix(matrix.rows)):
            translates = krylov(matrix.T, functional, size).T
            if rank(translates * cyclic) == size:
                complement = whole * kernel(translates * whole)
                parameters = tuple(next(names) for _ in range(complement.cols))
                general = v + complement * Matrix(len(parameters), 1, list(parameters))
                return krylov(matrix, general, size), parameters
    return None


def sample_subspaces(
    matrix: Matrix, component: PrimaryComponent, exponent: int
) -> Iterator[ImmutableMatrix]:
    r"""Yield some invariant subspaces with the polynomial :math:`f^e`, cyclic or not."""
    size, rows = exponent * component.degree, matrix.rows
    lengths, rest = [], exponent
    for longest in component.block_lengths:
        lengths.append(min(rest, longest))
        rest -= lengths[-1]
    dice = random.Random(exponent)  # the same subspaces in every run
    for _ in range(20):
        blocks = []
        for length in filter(None, lengths):
            basis = component.kernels[length]
            weights = Matrix(basis.cols, 1, [dice.randint(-3, 3) for _ in range(basis.cols)])
            blocks.append(krylov(matrix, basis * weights, length * component.degree))
        span = joined(rows, blocks)
        if rank(span) == size:
            yield span


def krylov(matrix: Matrix, vector: Matrix, size: int) -> ImmutableMatrix:
    """Return the columns v, Av, ..., A^(size-1) v."""
    raw, column = rational_in_flint(matrix), rational_in_flint(vector)
    if raw is not None and column is not None:
        basis = [column]
        for _ in range(size - 1):
            basis.append(raw * basis[-1])
        entries = [x for one in basis for x in one.transpose().entries()]
        return from_flint(flint.fmpq_mat(len(basis), matrix.rows, entries).transpose())
    columns = [vector]
    for _ in range(size - 1):
        columns.append((matrix * columns[-1]).applyfunc(sympy.expand))
    return joined(matrix.rows, columns)


def _combinations(basis: ImmutableMatrix) -> Iterator[ImmutableMatrix]:
    """Yield the basis vectors and then sums of them with small distinct weights."""
    for column in range(basis.cols):
        yield basis[:, column]
    for base in (1, 2, 3, -2):
        yield basis * Matrix([base**k + k for k in range(basis.cols)])
