"""Spectral factorisation on the unit circle: rational where it is, certified where it is not."""

from dataclasses import dataclass

import flint
from sympy import Poly, Symbol

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.latex import displayed, latex
from compensator_theory.polynomials.ball_precision import ball_precision
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.poly import canonical
from compensator_theory.polynomials.reading import PolynomialLike
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.roots.counts import require_rational
from compensator_theory.roots.enclosures import (
    Enclosure,
    PolynomialEnclosure,
    ball_of_enclosure,
    ball_of_number,
    enclosure_of_ball,
    latex_of,
    text_of,
)
from compensator_theory.roots.reflections import reciprocal_polynomial, spectrum_of, weighted_pair
from compensator_theory.roots.unit_circle import split_at_unit_circle
from compensator_theory.roots.unit_circle_enclosures import (
    enclose_split_at_unit_circle,
    exact_enclosure,
    working_bits,
)


@dataclass(frozen=True)
class SpectralFactor(ExactValue):
    r"""A monic Schur polynomial and a constant with the given product on the unit circle.

    .. math:: c\,\chi(z)\,\chi(1/z) = N(z) N(1/z) + r\, D(z) D(1/z) = z^{-m} p(z)

    Attributes
    ----------
    palindrome : sympy.Poly
        :math:`p = z^m (\ldots)`, of degree at most 2m.
    degree : int
        Degree of :math:`\chi`; what the right side lacks are roots at 0.
    polynomial : sympy.Poly or None
        :math:`\chi` if it is rational, else None.
    enclosure : PolynomialEnclosure
        :math:`\chi`, certified; radius 0 if it is rational.
    constant : Enclosure
        c, certified; radius 0 if :math:`\chi` is rational.

    Examples
    --------
    >>> from compensator_theory import spectral_factor
    >>> print(spectral_factor("z - 2", "z", 3))
    χ = z - 0.26794919243112270647
    c = 7.46410161513775458705 ± 5.0e-21
    """

    palindrome: Poly
    degree: int
    polynomial: Poly | None
    enclosure: PolynomialEnclosure
    constant: Enclosure

    @property
    def is_rational(self) -> bool:
        """Whether the factor has rational coefficients."""
        return self.polynomial is not None

    @property
    def residual(self) -> tuple[Enclosure, ...]:
        r"""Coefficients of :math:`c\,\chi\chi^* - z^{n-m}p`, computed anew; each contains 0."""
        finest = max(int(c.centre.q).bit_length() for c in self.enclosure.coefficients)
        with ball_precision(64 + 2 * finest):
            descending = [ball_of_enclosure(c) for c in self.enclosure.coefficients]
            product = flint.arb_poly(descending) * flint.arb_poly(descending[::-1])
            spectrum = [ball_of_number(c) for c in reversed(self.palindrome.all_coeffs())]
            shift = self.degree - self._half
            shifted = [flint.arb(0)] * max(shift, 0) + spectrum[max(-shift, 0) :]
            difference = ball_of_enclosure(self.constant) * product - flint.arb_poly(shifted)
            return tuple(enclosure_of_ball(c) for c in reversed(difference.coeffs()))

    @property
    def _half(self) -> int:
        """The m of the definition: the palindrome's centre."""
        terms = [int(power) for (power,) in self.palindrome.as_dict()]
        return (max(terms) + min(terms)) // 2

    def __str__(self) -> str:
        return f"χ = {text_of(self.polynomial, self.enclosure)}\nc = {self.constant!r}"

    def _repr_latex_(self) -> str:
        body = latex_of(self.polynomial, self.enclosure)
        return displayed(rf"\chi = {body}", f"c = {latex(self.constant)}")


def spectral_factor(
    N: PolynomialLike,
    D: PolynomialLike | None = None,
    r: object = 0,
    *,
    digits: int = 30,
    variable: str | Symbol | None = None,
) -> SpectralFactor:
    r"""Find the monic Schur polynomial with a prescribed spectrum on the unit circle.

    .. math:: c\,\chi(z)\,\chi(1/z) = N(z) N(1/z) + r\, D(z) D(1/z)

    Parameters
    ----------
    N, D : polynomial
        Rational coefficients; D may be left out. :math:`\chi` has the larger of the two degrees.
    r : number
        At least 0.
    digits : int
        Where the factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.
    variable : str or Symbol, optional
        Default: evident from N or D.

    Returns
    -------
    SpectralFactor

    Raises
    ------
    UnitCircleError
        If the right side vanishes on the unit circle, so that no factor is Schur.
    NoSolutionError
        If the right side is zero.
    InputError
        If r is negative or a coefficient is symbolic.

    Notes
    -----
    With N and D over one denominator D of degree n it is the closed-loop polynomial of an LQ
    regulator with :math:`R_2 = r`, and c is :math:`R_2 + B^T P B`. For r = 0 the factor consists of
    the roots of N inside the circle and the reflections of those outside, and of n - deg N roots
    at 0. A root of N at 0 stays there.

    Examples
    --------
    >>> from compensator_theory import spectral_factor
    >>> high_authority = spectral_factor("3*(z - 2)*(z - 1/2)", "z**3")
    >>> high_authority.polynomial.as_expr(), high_authority.constant
    (z**3 - z**2 + z/4, 36)
    """
    first, second, weight = weighted_pair(N, D, r, variable)
    size = int(max(first.degree(), second.degree(), 0))
    palindrome = spectrum_of(first, size) + spectrum_of(second, size).mul_ground(weight)
    return factor_palindrome(canonical(palindrome), size, digits)


def factor_palindrome(palindrome: Poly, degree: int, digits: int = 30) -> SpectralFactor:
    r"""Take the roots inside the unit circle out of a palindromic polynomial.

    .. math:: p(z) = z^{2m} p(1/z), \qquad z^{-m} p(z) = c\,\chi(z)\,\chi(1/z)

    Parameters
    ----------
    palindrome : sympy.Poly
        Rational, equal to its reciprocal up to a power of z.
    degree : int
        Degree of the factor; at least half the number of nonzero roots.
    digits : int
        As for :func:`spectral_factor`.

    Raises
    ------
    NoSolutionError
        If the polynomial is zero.
    UnitCircleError
        If it has a root on the unit circle.
    InputError
        If it is not palindromic, has symbolic coefficients, or the degree is too small.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots.spectral_factors import factor_palindrome
    >>> factor_palindrome(polynomial("2*z**2 - 5*z + 2"), 2).polynomial.as_expr()
    z**2 - z/2
    """
    bits = working_bits(digits)
    if palindrome.is_zero:
        raise NoSolutionError("the spectrum to be factored is zero everywhere, and no factor is")
    palindrome = require_rational(palindrome)
    stripped = reciprocal_polynomial(reciprocal_polynomial(palindrome))
    if stripped != reciprocal_polynomial(stripped):
        raise InputError(f"{format_polynomial(palindrome)} is not palindromic")
    at_origin = degree - int(stripped.degree()) // 2
    if at_origin < 0:
        raise InputError(
            f"{format_polynomial(palindrome)} has {stripped.degree()} nonzero roots; its factor "
            f"has at least degree {int(stripped.degree()) // 2}, not {degree}"
        )
    power = Poly(palindrome.gen**at_origin, palindrome.gen)
    try:
        inside, _ = split_at_unit_circle(stripped)
    except NoSolutionError:
        pass
    else:
        chi = canonical(inside * power)
        constant = exact_enclosure(Poly(stripped.LC() / inside.TC(), palindrome.gen))
        return SpectralFactor(
            palindrome, degree, chi, exact_enclosure(chi), constant.coefficients[0]
        )
    enclosed, _ = enclose_split_at_unit_circle(stripped, digits)
    with ball_precision(2 * bits):
        constant_ball = ball_of_number(stripped.LC()) / ball_of_enclosure(enclosed.coefficients[-1])
        zeros = exact_enclosure(power).coefficients[1:]
        chi_ball = PolynomialEnclosure(enclosed.coefficients + zeros, palindrome.gen)
        return SpectralFactor(palindrome, degree, None, chi_ball, enclosure_of_ball(constant_ball))
