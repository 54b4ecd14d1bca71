"""Minimal polynomial bases of the null spaces of polynomial matrices (Forney)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import lcm

import flint
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.errors import NoSolutionError
from compensator_theory.forms._pencil_kernels import MEASURE, NullVectors, Pencil
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    PolynomialMatrixLike,
    polynomial_matrix,
)
from compensator_theory.forms._row_forms import row_reduced_form
from compensator_theory.matrices._certificates import Certified, Residuals, proven
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import zero_matrix
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.matrices._residues import pivots
from compensator_theory.polynomials._budget import ask, decimal_digits, unlimited
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._values import ExactValue

CHAINS = 5
"""Largest degree for the computation by a pencil; above it, row operations are as fast."""


@dataclass(frozen=True)
class MinimalBasis(Certified, ExactValue):
    r"""Polynomial vectors that span a null space, of the least degrees that there are.

    .. math:: P M = 0, \qquad W M = I

    Attributes
    ----------
    matrix : PolynomialMatrix
        P, p x m.
    basis : PolynomialMatrix or None
        M, m x k, column reduced; None where the null space is zero. Every polynomial vector in the
        null space is M t with one polynomial vector t, and its degree is the largest of
        deg t_i + indices_i.
    left_inverse : PolynomialMatrix or None
        W, k x m: that it is polynomial proves that M loses rank nowhere. None with M.
    indices : tuple of int
        Degrees of the columns, ascending: Forney's minimal indices. They are unique, M is not.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    """

    identity = "P M = 0, W M = I"

    matrix: PolynomialMatrix
    basis: PolynomialMatrix | None
    left_inverse: PolynomialMatrix | None
    indices: tuple[int, ...]
    exceptional: tuple[Expr, ...]

    def _residuals(self) -> Residuals:
        if self.basis is None or self.left_inverse is None:
            return [zero_matrix(1, 1)]
        with unlimited():  # P is validated already, and a product needs no elimination
            zero = (self.matrix @ self.basis).as_matrix()
            unit = (self.left_inverse @ self.basis).as_matrix()
        return [zero, unit - ImmutableMatrix.eye(unit.rows)]

    def __str__(self) -> str:
        return "0" if self.basis is None else str(self.basis)

    def _repr_latex_(self) -> str:
        if self.basis is None:
            return displayed(rf"\ker {latex(self.matrix)} = 0", unless(self.exceptional))
        kernel = rf"\ker {latex(self.matrix)} = \left\{{ {latex(self.basis)}\, t \right\}}"
        return displayed(kernel, unless(self.exceptional))


@carrying()
def minimal_basis(
    matrix: PolynomialMatrixLike, variable: str | Symbol | None = None
) -> MinimalBasis:
    r"""Find a minimal polynomial basis of the right null space of a polynomial matrix.

    .. math:: \{x : P x = 0\} = \{M t\}, \qquad \deg (M t) = \max_i\,(\deg t_i + \kappa_i)

    Parameters
    ----------
    matrix : polynomial matrix
        Anything :func:`polynomial_matrix` reads, of any shape; for the left null space give its
        transpose.
    variable : str or Symbol, optional
        As for :func:`polynomial_matrix`.

    Raises
    ------
    InputError, BudgetError
        If it is no polynomial matrix, or too large.

    Notes
    -----
    Where all numbers are rational, the null vectors are those of a pencil, by (x, s x, s^2 x, ...),
    and they come from Krylov chains. With symbols, and for high degrees, row operations that reduce
    the transpose leave the basis in the unimodular matrix; its rows are then reduced. Source: G. D.
    Forney, Minimal bases of rational vector spaces, SIAM J. Control 13 (1975); T. Kailath, Linear
    Systems (1980), Sections 6.4 and 6.5.4.

    Examples
    --------
    >>> from compensator_theory.forms import minimal_basis
    >>> basis = minimal_basis([["s**2 + 1", "s", "s**3"]])
    >>> print(basis, basis.indices)
    [[-s, -s], [1, s**2 + 1], [1, 0]] (1, 2)
    """
    P = polynomial_matrix(matrix, variable)
    are_rational = all(e.domain.is_QQ or e.domain.is_ZZ for row in P.rows for e in row)
    if are_rational and P.degree <= CHAINS:
        ask("degree", max(P.shape) * max(1, P.degree), "the polynomial matrix")
        return basis_of_pencil(P, _pencil(P).null_vectors())
    first = row_reduced_form(P.T)
    rank, size = first.rank, P.shape[1]
    if rank == size:
        return _none(P, first.exceptional)
    kernel = PolynomialMatrix(first.U.rows[rank:])
    second = row_reduced_form(kernel)
    opposite = PolynomialMatrix(tuple(row[rank:] for row in first.U_inverse.rows))
    inverse = opposite @ second.U_inverse
    order = sorted(range(size - rank), key=lambda i: second.row_degrees[i])
    M = PolynomialMatrix(tuple(second.form.rows[i] for i in order)).T
    W = PolynomialMatrix(tuple(tuple(row[i] for i in order) for row in inverse.rows)).T
    exceptional = exceptional_factors([*first.exceptional, *second.exceptional])
    indices = tuple(second.row_degrees[i] for i in order)
    return _proven(MinimalBasis(P, M, W, indices, exceptional))


def basis_of_pencil(P: PolynomialMatrix, vectors: NullVectors) -> MinimalBasis:
    r"""Return a minimal basis of P from that of its pencil, with a left inverse.

    The pencil is that of :math:`(x, s x, \ldots, s^{d-1} x)` for P of degree d. The coefficients of
    a minimal basis of a pencil are independent, all of them, so that a constant matrix sends those
    of s^0 to unit vectors and the others to zero.
    """
    if not vectors:
        return _none(P, ())
    s, m, d = P.variable, P.shape[1], max(1, P.degree)
    coefficients = flint.fmpz_mat([column for vector in vectors for column in vector])
    starts = [int(k == 0) for vector in vectors for k, _ in enumerate(vector)]
    target = flint.fmpz_mat(len(starts), len(vectors))
    for column, row in enumerate(k for k, start in enumerate(starts) if start):
        target[row, column] = 1
    digits = decimal_digits(max(int(x).bit_length() for x in coefficients.entries()))
    ask("entries", len(starts) ** 2 * (digits // 3), MEASURE)
    chosen = pivots(coefficients)
    if len(chosen) < len(starts):
        raise NoSolutionError("dependent coefficients in a minimal basis; please report it")
    square = flint.fmpz_mat([[row[j] for j in chosen] for row in coefficients.tolist()])
    solved = square.solve(target).transpose().tolist()
    inverse = [dict(zip(chosen, row, strict=True)) for row in solved]

    def poly(ascending: Iterable[flint.fmpz | flint.fmpq | int]) -> Poly:
        return from_flint_polynomial(flint.fmpq_poly(list(ascending)), s)

    W = [[poly(row.get(k * m + j, 0) for k in range(d)) for j in range(m)] for row in inverse]
    M = [[poly(column[j] for column in vector) for vector in vectors] for j in range(m)]
    w, basis = (PolynomialMatrix(tuple(map(tuple, grid))) for grid in (W, M))
    indices = tuple(len(vector) - d for vector in vectors)
    return _proven(MinimalBasis(P, basis, w, indices, ()))


def _pencil(P: PolynomialMatrix) -> Pencil:
    """Return the pencil of (x, s x, ..., s^(d-1) x) for a rational P of degree d."""
    (p, m), d = P.shape, max(1, P.degree)
    entries = [[to_flint_polynomial(entry) for entry in row] for row in P.rows]
    common = lcm(*(int(entry.denom()) for row in entries for entry in row))
    below = (d - 1) * m
    A, E = (flint.fmpz_mat(below + p, d * m) for _ in range(2))
    for k in range(below):
        E[k, k], A[k, m + k] = 1, 1
    for i, row in enumerate(entries):
        for j, entry in enumerate(row):
            for k, c in enumerate((entry * common).numer().coeffs()):
                if k < d:
                    A[below + i, k * m + j] = -c
                else:
                    E[below + i, below + j] = c
    return Pencil(A, E)


def _none(P: PolynomialMatrix, exceptional: tuple[Expr, ...]) -> MinimalBasis:
    return MinimalBasis(P, None, None, (), exceptional)


def _proven(result: MinimalBasis) -> MinimalBasis:
    proven(result.certificate, "basis")
    return result
