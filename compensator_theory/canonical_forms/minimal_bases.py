"""Minimal polynomial bases of the null spaces of polynomial matrices (Forney)."""

from dataclasses import dataclass

from sympy import Expr, ImmutableMatrix, Symbol

from compensator_theory.canonical_forms.row_forms import row_reduced_form
from compensator_theory.latex import displayed, latex, unless
from compensator_theory.matrices.certificates import Certificate, certificate_of
from compensator_theory.polynomial_matrices.exceptional_factors import exceptional_factors
from compensator_theory.polynomial_matrices.polynomial_matrices import (
    PolynomialMatrix,
    PolynomialMatrixLike,
    polynomial_matrix,
)
from compensator_theory.polynomials.values import ExactValue

IDENTITY = "P M = 0, W M = I"


@dataclass(frozen=True)
class MinimalBasis(ExactValue):
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
    certificate : Certificate
        Both products, multiplied out anew.
    """

    matrix: PolynomialMatrix
    basis: PolynomialMatrix | None
    left_inverse: PolynomialMatrix | None
    indices: tuple[int, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        return "0" if self.basis is None else str(self.basis)

    def _repr_latex_(self) -> str:
        if self.basis is None:
            return displayed(rf"\ker {latex(self.matrix)} = 0", unless(self.exceptional))
        kernel = rf"\ker {latex(self.matrix)} = \left\{{ {latex(self.basis)}\, t \right\}}"
        return displayed(kernel, unless(self.exceptional))


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
    Row operations that reduce the transpose leave the basis in the unimodular matrix; its rows are
    then reduced themselves. Source: G. D. Forney, Minimal bases of rational vector spaces, SIAM J.
    Control 13 (1975); T. Kailath, Linear Systems (1980), Section 6.5.4.

    Examples
    --------
    >>> from compensator_theory import minimal_basis
    >>> found = minimal_basis([["s**2 + 1", "s", "s**3"]])
    >>> print(found, found.indices)
    [[-s, 0], [1, -s**2], [1, 1]] (1, 2)
    """
    P = polynomial_matrix(matrix, variable)
    first = row_reduced_form(P.T)
    rank, size = first.rank, P.shape[1]
    if rank == size:
        residual = ImmutableMatrix.zeros(1, 1)
        return MinimalBasis(P, None, None, (), first.exceptional, Certificate(IDENTITY, residual))
    kernel = PolynomialMatrix(first.U.rows[rank:])
    second = row_reduced_form(kernel)
    opposite = PolynomialMatrix(tuple(row[rank:] for row in first.U_inverse.rows))
    inverse = opposite @ second.U_inverse
    order = sorted(range(size - rank), key=lambda i: second.row_degrees[i])
    M = PolynomialMatrix(tuple(second.form.rows[i] for i in order)).T
    W = PolynomialMatrix(tuple(tuple(row[i] for i in order) for row in inverse.rows)).T
    exceptional = exceptional_factors([*first.exceptional, *second.exceptional])
    indices = tuple(second.row_degrees[i] for i in order)
    return MinimalBasis(P, M, W, indices, exceptional, _certificate(P, M, W))


def _certificate(P: PolynomialMatrix, M: PolynomialMatrix, W: PolynomialMatrix) -> Certificate:
    size = M.shape[1]
    product = (W @ M).as_matrix() - ImmutableMatrix.eye(size)
    return certificate_of(IDENTITY, [(P @ M).as_matrix(), product], "basis")
