"""Polynomials with reflected roots, and the spectra that they make with the given ones."""

from __future__ import annotations

from sympy import QQ, Expr, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._numbers import exact_number
from compensator_theory.polynomials._poly import canonical, monic
from compensator_theory.polynomials._reading import PolynomialLike, in_one_variable, polynomial
from compensator_theory.polynomials._variables import Time
from compensator_theory.roots._counts import require_rational


@carrying()
def reciprocal_polynomial(poly: PolynomialLike, variable: str | Symbol | None = None) -> Poly:
    r"""Reverse the coefficients, which reflects every root across the unit circle.

    .. math:: a^*(z) = z^k a(1/z) = a_0 z^k + a_1 z^{k-1} + \cdots + a_k

    Parameters
    ----------
    poly : polynomial
        Degree k, not zero, symbols allowed. Each root 0 lowers the degree of the result by one.

    Raises
    ------
    InputError
        If the polynomial is zero.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots import reciprocal_polynomial
    >>> reciprocal_polynomial(polynomial("z - 6/5"))
    Poly(-6/5*z + 1, z, domain='QQ')
    """
    poly = polynomial(poly, variable)
    if poly.is_zero:
        raise InputError("the zero polynomial has no degree and thus no reciprocal polynomial")
    return canonical(Poly(poly.all_coeffs()[::-1], poly.gen))


@carrying()
def monic_reciprocal_polynomial(poly: PolynomialLike, variable: str | Symbol | None = None) -> Poly:
    r"""Return the monic polynomial whose roots are the reciprocals of the given ones.

    .. math:: \frac{z^k a(1/z)}{a_0} = \prod_i (z - 1/\lambda_i)

    Parameters
    ----------
    poly : polynomial
        Not zero, and not zero at 0.

    Raises
    ------
    InputError
        If 0 is a root, whose reflection is at infinity.

    Notes
    -----
    Source: (A.15)-(A.17), (4.24), which write :math:`N_u(z^{-1})`, a rational function with a pole
    of order deg N_u at 0. The polynomial meant is this one, and without the division by
    :math:`a_0` the leading coefficient of (4.24) is not :math:`H_{d_{zu}}`.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots import monic_reciprocal_polynomial
    >>> monic_reciprocal_polynomial(polynomial("z - 6/5"))
    Poly(z - 5/6, z, domain='QQ')
    """
    poly = polynomial(poly, variable)
    if poly.is_zero or poly.TC() == 0:
        raise InputError(
            f"{format_polynomial(poly)} is zero at 0, and the reciprocal of 0 is no number; divide "
            f"by the power of {poly.gen} first"
        )
    return monic(reciprocal_polynomial(poly))


def spectrum_of(poly: Poly, size: int, time: Time) -> Poly:
    r"""Return a(s) a(-s), or :math:`z^k a(z) a(1/z)` for a polynomial a of at most degree k."""
    if time == "continuous":
        return poly * poly.compose(Poly([-1, 0], poly.gen, domain=QQ))
    if poly.is_zero:
        return poly
    degree = int(poly.degree())
    backwards = Poly(poly.all_coeffs()[::-1], poly.gen)
    return poly * backwards * Poly(poly.gen ** (size - degree), poly.gen)


def weighted_pair(
    N: PolynomialLike, D: PolynomialLike | None, r: object, variable: str | Symbol | None
) -> tuple[Poly, Poly, Expr]:
    """Read N and D of N N* + r D D*; without D it is zero."""
    weight = exact_number(r)
    if not (weight.is_Rational and weight >= 0):
        raise InputError(f"r = {weight} must be a rational number of at least 0")
    read = in_one_variable(N, 0 if D is None else D, variable=variable)
    first, second = (p if p.is_zero else require_rational(p) for p in read)
    return first, second, weight
