"""The Smith form of a polynomial matrix, with the unimodular matrices that lead to it."""

from __future__ import annotations

from sympy import Symbol

from compensator_theory.forms._equivalence import Equivalence, elimination_of, equivalence_of
from compensator_theory.forms._polynomial_matrices import PolynomialMatrixLike, polynomial_matrix
from compensator_theory.matrices._diagonalisation import diagonalise
from compensator_theory.polynomials._carrying import carrying


@carrying()
def smith_form(matrix: PolynomialMatrixLike, variable: str | Symbol | None = None) -> Equivalence:
    r"""Bring a polynomial matrix to its Smith form.

    .. math:: U P V = S = \mathrm{diag}(\lambda_1, \ldots, \lambda_r, 0, \ldots), \qquad
              \lambda_i \mid \lambda_{i+1}, \\
              \lambda_1 \cdots \lambda_k = \text{the monic gcd of all } k \times k \text{ minors}

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
    >>> form = smith_form([["s", "a"], [0, "s"]])
    >>> print(form, form.exceptional)
    [[1, 0], [0, s**2]] (a,)
    """
    source = polynomial_matrix(matrix, variable)
    work = elimination_of(source)
    return equivalence_of(source, work, diagonalise(work))
