"""The Smith form of a polynomial matrix, with the unimodular matrices that lead to it."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.forms._equivalence import by_rows_and_columns, elimination_of
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    PolynomialMatrixLike,
    polynomial_matrix,
)
from compensator_theory.matrices._certificates import Certificate
from compensator_theory.matrices._diagonalisation import diagonalise
from compensator_theory.polynomials._values import ExactValue

IDENTITY = "U P V = S, U U^-1 = I, V V^-1 = I"


@dataclass(frozen=True)
class SmithForm(ExactValue):
    r"""The diagonal form of a polynomial matrix under unimodular row and column operations.

    .. math:: U P V = S = \mathrm{diag}(\lambda_1, \ldots, \lambda_r, 0, \ldots), \qquad
              \lambda_i \mid \lambda_{i+1}

    Attributes
    ----------
    matrix, form : PolynomialMatrix
        P and S, both p x m; the invariant polynomials are monic.
    U, V, U_inverse, V_inverse : PolynomialMatrix
        p x p and m x m, unimodular: their inverses are polynomial too. S is unique, they are not.
    rank : int
        The normal rank r.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the form holds where none of them is zero, and
        there may be another one where one is. Empty without symbols.
    certificate : Certificate
        U P V - S and the products with the inverses, multiplied out anew.
    """

    matrix: PolynomialMatrix
    form: PolynomialMatrix
    U: PolynomialMatrix
    V: PolynomialMatrix
    U_inverse: PolynomialMatrix
    V_inverse: PolynomialMatrix
    rank: int
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def invariant_polynomials(self) -> tuple[Poly, ...]:
        """The nonzero diagonal entries, each a divisor of the next."""
        return tuple(self.form[i, i] for i in range(self.rank))

    @property
    def elementary_divisors(self) -> tuple[tuple[Poly, int], ...]:
        """Powers of irreducible polynomials: all factors of all invariant polynomials."""
        return tuple(
            (factor.monic(), power)
            for invariant in self.invariant_polynomials
            for factor, power in invariant.factor_list()[1]
        )

    def __str__(self) -> str:
        return str(self.form)

    def _repr_latex_(self) -> str:
        parts = latex(self.U_inverse) + latex(self.form) + latex(self.V_inverse)
        return displayed(
            rf"P = {latex(self.matrix)} = U^{{-1}} S\, V^{{-1}} = {parts}", unless(self.exceptional)
        )


def smith_form(matrix: PolynomialMatrixLike, variable: str | Symbol | None = None) -> SmithForm:
    r"""Bring a polynomial matrix to its Smith form.

    .. math:: \lambda_1 \cdots \lambda_k = \text{the monic gcd of all } k \times k \text{ minors}

    Parameters
    ----------
    matrix : polynomial matrix
        Anything :func:`polynomial_matrix` reads, of any shape.
    variable : str or Symbol, optional
        As for :func:`polynomial_matrix`.

    Raises
    ------
    InputError, BudgetError
        If it is no polynomial matrix, or too large.

    Notes
    -----
    With symbols, the form is that for generic values of them, and it jumps: that of
    [[s, a], [0, s]] is diag(1, s**2), and at a = 0 diag(s, s). So `exceptional` lists what U, V and
    their inverses are divided by: elsewhere the certificate proves the form. Euclid's algorithm
    lets the numbers in U and V grow fast beyond 6 x 6.

    Source: H. J. S. Smith (1861); T. Kailath, Linear Systems (1980), Section 6.3.

    Examples
    --------
    >>> from compensator_theory.forms import smith_form
    >>> print(smith_form([["s*(s + 1)", 0], [0, "s*(s + 2)"]]))
    [[s, 0], [0, s**3 + 3*s**2 + 2*s]]
    >>> found = smith_form([["s", "a"], [0, "s"]])
    >>> print(found, found.exceptional)
    [[1, 0], [0, s**2]] (a,)
    """
    source = polynomial_matrix(matrix, variable)
    work = elimination_of(source)
    rank = diagonalise(work)
    found = by_rows_and_columns(work, IDENTITY)
    return SmithForm(
        source,
        found.form,
        found.U,
        found.V,
        found.U_inverse,
        found.V_inverse,
        rank,
        found.exceptional,
        found.certificate,
    )
