"""Greatest common divisor and cofactors from the null space of a Sylvester matrix."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.bezout._subresultant_chains import subresultants
from compensator_theory.bezout._sylvester import sylvester_m1
from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certificate, proven
from compensator_theory.matrices._flint_matrices import zero_matrix
from compensator_theory.matrices._linear_algebra import rank, solve_affine
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical, from_coefficients, monic, scaled
from compensator_theory.polynomials._reading import PolynomialLike, in_one_variable
from compensator_theory.polynomials._values import ExactValue

IDENTITY = "a = g abar, b = g bbar"


@dataclass(frozen=True)
class NullSpaceGCD(ExactValue):
    r"""A greatest common divisor and its cofactors, from the null space of a Sylvester matrix.

    .. math:: a = g\,\bar a, \quad b = g\,\bar b, \qquad a\,\bar b - b\,\bar a = 0

    Attributes
    ----------
    gcd : sympy.Poly
        g, monic.
    cofactors : tuple of sympy.Poly
        :math:`(\bar a, \bar b)`.
    nullity : int
        Dimension of the null space of the whole matrix, the degree of g.
    exceptional : tuple of sympy.Expr
        In the symbols: where one of them is zero, the degree of g may be larger. Empty without
        symbols.
    certificate : Certificate
        Both products, multiplied out.
    """

    gcd: Poly
    cofactors: tuple[Poly, Poly]
    nullity: int
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        a, b = map(format_polynomial, self.cofactors)
        return f"gcd = {format_polynomial(self.gcd)}, a = gcd*({a}), b = gcd*({b})"

    def _repr_latex_(self) -> str:
        a, b = self.cofactors
        return displayed(
            rf"\gcd(a, b) = g = {latex(self.gcd)}",
            rf"a = g \cdot \left({latex(a)}\right)",
            rf"b = g \cdot \left({latex(b)}\right)",
            unless(self.exceptional),
        )


@carrying()
def gcd_from_null_space(
    a: PolynomialLike, b: PolynomialLike, *, variable: str | Symbol | None = None
) -> NullSpaceGCD:
    r"""Find a greatest common divisor and the cofactors by linear algebra.

    .. math:: \mathcal M(a, b) \begin{bmatrix} \bar b \\ -\bar a \end{bmatrix} = 0

    Parameters
    ----------
    a, b : polynomial
        Neither zero nor both constant; with symbols, for generic values of them.
    variable : str or Symbol, optional
        Default: evident from the two together.

    Raises
    ------
    InputError
        If one is zero, or both are constant.

    Notes
    -----
    The nullity d of the Sylvester matrix is the degree of g; the matrix with d - 1 columns of each
    polynomial left out has a null space of dimension 1, which holds the cofactors.

    Examples
    --------
    >>> from compensator_theory.bezout import gcd_from_null_space
    >>> print(gcd_from_null_space("(s - 1)*(s - 2)*(s + 1)", "(s - 1)*(s - 2)*(s + 4)"))
    gcd = s**2 - 3*s + 2, a = gcd*(s + 1), b = gcd*(s + 4)
    """
    first, second = in_one_variable(a, b, variable=variable)
    if first.is_zero or second.is_zero:
        raise InputError("a and b must not be zero; every polynomial divides 0")
    k, l = int(first.degree()), int(second.degree())  # noqa: E741
    if k == l == 0:
        raise InputError("a and b are both constant; their Sylvester matrix would be empty")
    s = first.gen
    nullity = k + l - rank(sylvester_m1(first, second))
    exceptional = _where_it_grows(first, second, nullity)
    if nullity == 0:
        one = from_coefficients([1], s)
        return NullSpaceGCD(
            one, (first, second), 0, exceptional, _certificate(first, second, one, (first, second))
        )
    rows = k + l - nullity + 1
    columns = [(first, l - nullity + 1), (second, k - nullity + 1)]
    entries = [
        [p.coeff_monomial(s ** (power - shift)) if power >= shift else 0
         for p, count in columns for shift in range(count)]
        for power in range(rows)
    ]  # fmt: skip
    (vector,) = solve_affine(ImmutableMatrix(entries), zero_matrix(rows, 1)).nullspace
    coefficients = list(vector)
    b_bar = from_coefficients(coefficients[: l - nullity + 1][::-1], s)
    a_bar = from_coefficients([-c for c in coefficients[l - nullity + 1 :]][::-1], s)
    field = a_bar.unify(first)[0].domain.get_field()
    quotient = canonical(first.set_domain(field).quo(a_bar.set_domain(field)))
    g, leading = monic(quotient), quotient.LC()
    cofactors = (scaled(a_bar, leading), scaled(b_bar, leading))
    certificate = _certificate(first, second, g, cofactors)
    return NullSpaceGCD(g, cofactors, nullity, exceptional, certificate)


def _where_it_grows(first: Poly, second: Poly, nullity: int) -> tuple[Expr, ...]:
    """Return the factors of the principal subresultant coefficient of the gcd's degree."""
    if not (first.free_symbols_in_domain | second.free_symbols_in_domain):
        return ()
    upper, lower = (first, second) if first.degree() >= second.degree() else (second, first)
    minor = sympy.fraction(
        sympy.cancel(subresultants(upper, lower).principal_coefficients[nullity])
    )
    factors = [f for side in minor for f, _ in sympy.factor_list(side)[1] if not f.is_nonzero]
    return tuple(sorted(dict.fromkeys(factors), key=lambda f: (sympy.count_ops(f), str(f))))


def _certificate(a: Poly, b: Poly, g: Poly, cofactors: tuple[Poly, Poly]) -> Certificate:
    left = [canonical(g * x - y).as_expr() for x, y in zip(cofactors, (a, b), strict=True)]
    return proven(Certificate(IDENTITY, ImmutableMatrix([left])), "divisor")
