"""The Bezout matrix of two polynomials: its rank, its determinant and its signature."""

from __future__ import annotations

from itertools import pairwise

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory.bezout._sylvester import holds_while_degrees_do
from compensator_theory.errors import InputError
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying, refusing
from compensator_theory.polynomials._poly import is_rational, way_to_rational
from compensator_theory.polynomials._reading import PolynomialLike, in_one_variable


@holds_while_degrees_do
@carrying()
def bezout_matrix(
    a: PolynomialLike, b: PolynomialLike, *, variable: str | Symbol | None = None
) -> ImmutableMatrix:
    r"""Return the Bezout matrix of two polynomials.

    .. math:: \frac{a(x)\,b(y) - a(y)\,b(x)}{x - y} = \sum_{i,j=0}^{n-1} B_{ij}\, x^i y^j,
              \qquad n = \max(\deg a, \deg b)

    Parameters
    ----------
    a, b : polynomial
        Anything :func:`polynomial` reads, in one variable, not both constant; symbols allowed.
    variable : str or Symbol, optional
        Default: evident from the two together.

    Returns
    -------
    sympy.ImmutableMatrix
        n x n, symmetric, its first row that of the constant terms. Its rank is n less the degree
        of the greatest common divisor; its determinant is
        :math:`(-1)^{n(n-1)/2} a_n^{n - \deg b}\,\mathrm{Res}(a, b)` where n = deg a.

    Raises
    ------
    InputError
        If both are constant, or the variable is not evident.

    Notes
    -----
    By the recurrence :math:`B_{ij} = B_{i+1,j-1} + a_{i+1}b_j - a_j b_{i+1}`. Other texts order it
    the other way round or take the other sign. Source: U. Helmke and P. A. Fuhrmann, Bezoutians,
    Linear Algebra and its Applications 122-124 (1989).

    Examples
    --------
    >>> from compensator_theory.bezout import bezout_matrix
    >>> bezout_matrix("s**2 + 3*s + 2", "s + 5")
    Matrix([
    [13, 5],
    [ 5, 1]])
    """
    first, second = in_one_variable(a, b, variable=variable)
    n = max(_degree(first), _degree(second))
    if n == 0:
        raise InputError("a and b are both constant; their Bezout matrix would be empty")
    ask("entries", n * n, "the Bezout matrix")
    over = first.unify(second)
    domain = over[0].domain
    top, bottom = ([*reversed(p.rep.to_list()), *[domain.zero] * (n + 1)][: n + 1] for p in over)
    rows = [[domain.zero] * n for _ in range(n)]
    for j in range(n):
        for i in range(n):
            value = top[i + 1] * bottom[j] - top[j] * bottom[i + 1]
            rows[i][j] = value
    for i in range(n - 2, -1, -1):
        for j in range(1, n):
            rows[i][j] += rows[i + 1][j - 1]
    return ImmutableMatrix([[domain.to_sympy(entry) for entry in row] for row in rows])


@refusing
def cauchy_index(
    numerator: PolynomialLike, denominator: PolynomialLike, *, variable: str | Symbol | None = None
) -> int:
    r"""Return the Cauchy index of a rational function on the real axis.

    .. math:: I_{-\infty}^{\infty} \frac ND = \text{jumps from } -\infty \text{ to } +\infty
              \text{ less those from } +\infty \text{ to } -\infty

    Parameters
    ----------
    numerator, denominator : polynomial
        N and D with rational coefficients, D not zero; common factors do not matter.
    variable : str or Symbol, optional
        Default: evident from the two together.

    Raises
    ------
    InputError
        If a coefficient is symbolic or D is zero.

    Notes
    -----
    It is the signature of the Bezout matrix of D and N, here by Descartes' rule, which counts
    exactly because a symmetric matrix has real eigenvalues. Source: C. Hermite (1856); F. R.
    Gantmacher, The Theory of Matrices, vol. 2, XV.

    Examples
    --------
    >>> from compensator_theory.bezout import cauchy_index
    >>> cauchy_index("2*s", "s**2 - 1"), cauchy_index("s + 5", "s**2 + 3*s + 2")
    (2, 0)
    """
    N, D = in_one_variable(numerator, denominator, variable=variable)
    if D.is_zero:
        raise InputError("the denominator is zero")
    if not (is_rational(N) and is_rational(D)):
        raise InputError(f"the Cauchy index needs rational coefficients; {way_to_rational(N, D)}")
    rest = N.rem(D)  # the polynomial part has no jumps
    if rest.is_zero:
        return 0
    s = D.gen
    target = characteristic_polynomial(bezout_matrix(D, rest), s)
    return _sign_changes(target) - _sign_changes(target.compose(Poly(-s, s)))


def _sign_changes(poly: Poly) -> int:
    values: list[Expr] = [c for c in poly.all_coeffs() if c != 0]
    return sum(bool((x > 0) != (y > 0)) for x, y in pairwise(map(sympy.sympify, values)))


def _degree(poly: Poly) -> int:
    return 0 if poly.is_zero else int(poly.degree())
