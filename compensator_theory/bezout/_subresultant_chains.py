"""Subresultants: the whole chain between a resultant and a greatest common divisor."""

from __future__ import annotations

from dataclasses import dataclass

import sympy
from sympy import Expr, Matrix, Poly, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory.bezout._sylvester import holds_while_degrees_do
from compensator_theory.errors import InputError
from compensator_theory.matrices._linear_algebra import determinant
from compensator_theory.polynomials._budget import ask
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import from_coefficients
from compensator_theory.polynomials._reading import PolynomialLike, in_one_variable
from compensator_theory.polynomials._values import ExactValue


@dataclass(frozen=True)
class Subresultants(ExactValue):
    r"""The subresultants of two polynomials.

    Attributes
    ----------
    a, b : sympy.Poly
        As given, deg a >= deg b.
    chain : tuple of sympy.Poly
        :math:`S_0, S_1, \ldots, S_{\deg b}`; :math:`S_0` is the resultant.
    """

    a: Poly
    b: Poly
    chain: tuple[Poly, ...]

    @property
    def principal_coefficients(self) -> tuple[Expr, ...]:
        """The coefficient of s**k in S_k. The first that is not zero has k = deg gcd(a, b)."""
        s = self.a.gen
        return tuple(sympy.sympify(poly.coeff_monomial(s**k)) for k, poly in enumerate(self.chain))

    @property
    def gcd(self) -> Poly:
        """The greatest common divisor as a subresultant; with symbols, the generic one."""
        for poly, coefficient in zip(self.chain, self.principal_coefficients, strict=True):
            if coefficient != 0:
                return poly
        return self.b  # b = 0 has been refused, and S_deg(b) has a nonzero leading coefficient

    def __str__(self) -> str:
        return ", ".join(f"S_{k} = {format_polynomial(p)}" for k, p in enumerate(self.chain))

    def _repr_latex_(self) -> str:
        return displayed(*(f"S_{{{k}}} = {latex(poly)}" for k, poly in enumerate(self.chain)))


@holds_while_degrees_do
@carrying()
def subresultants(
    a: PolynomialLike, b: PolynomialLike, *, variable: str | Symbol | None = None
) -> Subresultants:
    r"""Return the chain of subresultants of two polynomials, as determinants.

    .. math:: S_k = \sum_{j=0}^{k} \det M_{k,j}\, s^j

    :math:`M_{k,j}` are the rows for :math:`s^{m+n-k-1}, \ldots, s^{k+1}` and for :math:`s^j` of the
    Sylvester matrix with n - k columns of a and m - k of b.

    Parameters
    ----------
    a, b : polynomial
        Of degrees m >= n, b not zero; anything :func:`polynomial` reads; symbols allowed.
    variable : str or Symbol, optional
        Default: evident from the two together.

    Raises
    ------
    InputError
        If b is zero, or a has the lower degree: exchange them, which changes signs.

    Notes
    -----
    Signs are those of the determinants, with no normalisation: psc_0 is :func:`resultant`. Source:
    G. E. Collins, Journal of the ACM 14 (1967); W. S. Brown and J. F. Traub, ibid. 18 (1971).

    Examples
    --------
    >>> from compensator_theory.bezout import subresultants
    >>> chain = subresultants("(s - 1)*(s - 2)*(s - 3)*(s + 1)", "(s - 1)*(s - 2)*(s + 4)")
    >>> chain.principal_coefficients, chain.gcd
    ((0, 0, 21, 1), Poly(21*s**2 - 63*s + 42, s, domain='QQ'))
    """
    first, second = in_one_variable(a, b, variable=variable)
    if second.is_zero or first.is_zero:
        raise InputError("the polynomials must not be zero")
    m, n = int(first.degree()), int(second.degree())
    if m < n:
        raise InputError(
            f"a has degree {m} and b has degree {n}; exchange them (signs of subresultants change)"
        )
    ask("entries", (m + n) ** 2 * (n + 1) ** 2, "the chain of subresultants")
    return Subresultants(
        first, second, tuple(_subresultant(first, second, k) for k in range(n + 1))
    )


def _subresultant(first: Poly, second: Poly, k: int) -> Poly:
    s, m, n = first.gen, int(first.degree()), int(second.degree())
    size = m + n - 2 * k
    if size == 0:  # both of degree k
        return second
    a, b = (list(reversed(p.all_coeffs())) for p in (first, second))

    def row(power: int) -> list[Expr]:
        entries = []
        for coefficients, count in ((a, n - k), (b, m - k)):
            for shift in range(count - 1, -1, -1):
                index = power - shift
                inside = 0 <= index < len(coefficients)
                entries.append(coefficients[index] if inside else sympy.Integer(0))
        return entries

    upper = [row(power) for power in range(m + n - k - 1, k, -1)]
    descending = [determinant(Matrix([*upper, row(j)])) for j in range(k, -1, -1)]
    return from_coefficients(descending, s)
