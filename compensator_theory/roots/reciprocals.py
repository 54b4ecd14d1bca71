"""The polynomial with the reflected roots."""

from sympy import Poly

from compensator_theory.errors import InputError
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.poly import canonical, monic, require_poly


def reciprocal_polynomial(poly: Poly) -> Poly:
    r"""Reverse the coefficients, which reflects every root across the unit circle.

    .. math:: a^*(z) = z^k a(1/z) = a_0 z^k + a_1 z^{k-1} + \cdots + a_k

    Parameters
    ----------
    poly : sympy.Poly
        Degree k, not zero, symbols allowed. Each root 0 lowers the degree of the result by one.

    Raises
    ------
    InputError
        If the polynomial is zero.

    Examples
    --------
    >>> from compensator_theory import polynomial, reciprocal_polynomial
    >>> reciprocal_polynomial(polynomial("z - 6/5"))
    Poly(-6/5*z + 1, z, domain='QQ')
    """
    poly = require_poly(poly)
    if poly.is_zero:
        raise InputError("the zero polynomial has no degree and thus no reciprocal polynomial")
    return canonical(Poly(poly.all_coeffs()[::-1], poly.gen))


def monic_reciprocal_polynomial(poly: Poly) -> Poly:
    r"""Return the monic polynomial whose roots are the reciprocals of the given ones.

    .. math:: \frac{z^k a(1/z)}{a_0} = \prod_i (z - 1/\lambda_i)

    Parameters
    ----------
    poly : sympy.Poly
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
    >>> from compensator_theory import monic_reciprocal_polynomial, polynomial
    >>> monic_reciprocal_polynomial(polynomial("z - 6/5"))
    Poly(z - 5/6, z, domain='QQ')
    """
    poly = require_poly(poly)
    if poly.is_zero or poly.TC() == 0:
        raise InputError(
            f"{format_polynomial(poly)} is zero at 0, and the reciprocal of 0 is no number; divide "
            f"by the power of {poly.gen} first"
        )
    return monic(reciprocal_polynomial(poly))
