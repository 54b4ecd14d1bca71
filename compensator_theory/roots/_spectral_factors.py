"""Spectral factorisation on the boundary of stability: rational where it is, certified if not."""

from __future__ import annotations

from dataclasses import dataclass

import flint
from sympy import Integer, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._certificates import Certificate, evaluated
from compensator_theory.polynomials._ball_precision import (
    at_growing_precision,
    ball_precision,
)
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import ask_for_coefficients, canonical, monic
from compensator_theory.polynomials._reading import PolynomialLike
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import Time, agreed_time
from compensator_theory.roots._certified import decided_balls
from compensator_theory.roots._counts import count_roots, require_rational
from compensator_theory.roots._enclosures import (
    Enclosure,
    PolynomialEnclosure,
    ball_of_enclosure,
    ball_of_number,
    enclosure_of_ball,
    latex_of,
    text_of,
)
from compensator_theory.roots._reflections import reciprocal_polynomial, spectrum_of, weighted_pair
from compensator_theory.roots._regions import is_left_of_axis
from compensator_theory.roots._unit_circle import split_at_unit_circle
from compensator_theory.roots._unit_circle_enclosures import (
    enclose_split_at_unit_circle,
    exact_enclosure,
    product_of_roots,
    working_bits,
)


@dataclass(frozen=True)
class SpectralFactor(ExactValue):
    r"""A monic stable polynomial and a constant with the given product on the stability boundary.

    .. math:: c\,\chi(s)\,\chi(-s) = p(s), \qquad c\,\chi(z)\,\chi(1/z) = z^{-m} p(z)

    Attributes
    ----------
    spectrum : sympy.Poly
        p: even in continuous time, palindromic in discrete time, of degree at most 2m.
    degree : int
        Degree of :math:`\chi`; in discrete time the missing roots of p are at 0.
    time : {"continuous", "discrete"}
        Whether :math:`\chi` is Hurwitz or Schur.
    polynomial : sympy.Poly or None
        :math:`\chi` if it is rational, else None.
    enclosure : PolynomialEnclosure
        :math:`\chi`, certified; radius 0 if it is rational.
    constant : Enclosure
        c, certified; radius 0 in continuous time and if :math:`\chi` is rational.

    Examples
    --------
    >>> from compensator_theory import spectral_factor
    >>> print(spectral_factor("z - 2", "z", 3, time="discrete"))
    χ = z - 0.26794919243112270647
    c = 7.46410161513775458705 ± 5.0e-21
    """

    spectrum: Poly
    degree: int
    time: Time
    polynomial: Poly | None
    enclosure: PolynomialEnclosure
    constant: Enclosure

    @property
    def is_rational(self) -> bool:
        """Whether the factor has rational coefficients."""
        return self.polynomial is not None

    @property
    def certificate(self) -> Certificate | None:
        """The product of the definition, multiplied out anew; None where it is irrational."""
        chi = self.polynomial
        if chi is None:
            return None
        mirrored = spectrum_of(chi, self.degree, self.time).mul_ground(self.constant.centre)
        power = Poly(chi.gen, chi.gen)
        shift = 0 if self.time == "continuous" else self.degree - self.half
        sides = [p * power ** max(k, 0) for p, k in ((mirrored, -shift), (self.spectrum, shift))]
        lacking = Integer(self.degree - int(chi.degree()))
        return evaluated("c χ χ* = p", [canonical(sides[0] - sides[1]), [lacking]])

    @property
    def residual(self) -> tuple[Enclosure, ...]:
        r"""Coefficients of the product minus p, computed anew; each contains 0."""
        finest = max(int(c.centre.q).bit_length() for c in self.enclosure.coefficients)
        with ball_precision(64 + 2 * finest):
            descending = [ball_of_enclosure(c) for c in self.enclosure.coefficients]
            coefficients = [ball_of_number(c) for c in reversed(self.spectrum.all_coeffs())]
            factor, mirrored = descending, descending[::-1]
            if self.time == "continuous":
                factor = descending[::-1]
                mirrored = [-c if k % 2 else c for k, c in enumerate(factor)]
            else:
                shift = self.degree - self.half
                coefficients = [flint.arb(0)] * max(shift, 0) + coefficients[max(-shift, 0) :]
            product = flint.arb_poly(factor) * flint.arb_poly(mirrored)
            difference = ball_of_enclosure(self.constant) * product - flint.arb_poly(coefficients)
            return tuple(enclosure_of_ball(c) for c in reversed(difference.coeffs()))

    @property
    def half(self) -> int:
        """The m of the definition: the centre of a palindrome."""
        terms = [int(power) for (power,) in self.spectrum.as_dict()]
        return (max(terms) + min(terms)) // 2

    def __str__(self) -> str:
        return f"χ = {text_of(self.polynomial, self.enclosure)}\nc = {self.constant!r}"

    def _repr_latex_(self) -> str:
        body = latex_of(self.polynomial, self.enclosure)
        return displayed(rf"\chi = {body}", f"c = {latex(self.constant)}")


@refusing
def spectral_factor(
    N: PolynomialLike,
    D: PolynomialLike | None = None,
    r: object = 0,
    *,
    time: Time | None = None,
    digits: int = 30,
    variable: str | Symbol | None = None,
) -> SpectralFactor:
    r"""Find the monic stable polynomial with a prescribed spectrum on the boundary of stability.

    .. math:: c\,\chi\,\chi^* = N N^* + r\, D D^*, \qquad
              N^*(s) = N(-s) \text{ or } N^*(z) = N(1/z)

    Parameters
    ----------
    N, D : polynomial
        Rational coefficients; D may be left out.
    r : number
        At least 0.
    time : {"continuous", "discrete"}, optional
        Whether the boundary is the imaginary axis or the unit circle; default as for
        :func:`decide_stability`.
    digits : int
        Where the factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.
    variable : str or Symbol, optional
        Default: evident from N or D.

    Returns
    -------
    SpectralFactor
        In discrete time :math:`\chi` has the larger of the two degrees. In continuous time it has
        that of D if r > 0 and :math:`\deg N \le \deg D`, and that of N for r = 0.

    Raises
    ------
    UnitCircleError
        If the right side vanishes on the unit circle, so that no factor is Schur.
    NoSolutionError
        If the right side is zero, or vanishes on the imaginary axis, so that no factor is Hurwitz.
    InputError
        If r is negative, a coefficient is symbolic, or `time` is missing or not that of the
        variable.

    Notes
    -----
    With N and D of degree n or less over one denominator D it is the closed-loop polynomial of an
    LQ regulator with :math:`R_2 = r`, and c is :math:`R_2`, in discrete time :math:`R_2 + B^T P B`.
    For r = 0 the factor consists of the stable roots of N and the reflections of the others: where
    the finite poles go as :math:`r \to 0`. In discrete time n - deg N roots are at 0, and a root of
    N at 0 stays there.

    Examples
    --------
    >>> from compensator_theory import spectral_factor
    >>> high_authority = spectral_factor("3*(z - 2)*(z - 1/2)", "z**3")
    >>> high_authority.polynomial.as_expr(), high_authority.constant
    (z**3 - z**2 + z/4, 36)
    >>> factor = spectral_factor("1", "s**2", "1/4")
    >>> factor.polynomial.as_expr(), factor.constant
    (s**2 + 2*s + 2, 1/4)
    >>> print(spectral_factor("s", "s**2 - 3", 1).enclosure)
    s**2 + 3.6055512754639892931*s + 3.0000000000000000000
    """
    first, second, weight = weighted_pair(N, D, r, variable)
    time = agreed_time(time, first.gen)
    size = int(max(first.degree(), second.degree(), 0))
    spectrum = canonical(
        spectrum_of(first, size, time) + spectrum_of(second, size, time).mul_ground(weight)
    )
    return factor_spectrum(spectrum, size, time, digits)


def factor_spectrum(spectrum: Poly, degree: int, time: Time, digits: int = 30) -> SpectralFactor:
    r"""Take the stable roots out of a polynomial that is even, or palindromic in discrete time.

    .. math:: p(s) = p(-s), \qquad p(z) = z^{2m} p(1/z)
    """
    bits = working_bits(digits)
    if spectrum.is_zero:
        raise NoSolutionError("the spectrum is zero, so that it has no spectral factor")
    spectrum = require_rational(spectrum)
    if time == "continuous":
        return _factor_even(spectrum, digits, bits)
    return _factor_palindrome(spectrum, degree, digits, bits)


def _factor_even(spectrum: Poly, digits: int, bits: int) -> SpectralFactor:
    if any(c != 0 for c in spectrum.all_coeffs()[-2::-2]):
        raise InputError(f"{format_polynomial(spectrum)} is not even")
    counted = count_roots(spectrum, time="continuous")
    if counted.boundary:
        raise NoSolutionError(
            f"{format_polynomial(spectrum)} has {counted.boundary} root(s) on the imaginary axis, "
            "so that no factor of it has all its roots to the left"
        )
    half = int(spectrum.degree()) // 2
    constant = Enclosure(spectrum.LC() * (-1) ** half, Rational(0))
    chi = _rational_hurwitz_factor(spectrum, half)
    if chi is not None:
        return SpectralFactor(spectrum, half, "continuous", chi, exact_enclosure(chi), constant)

    def attempt(bits: int) -> PolynomialEnclosure | None:
        balls = decided_balls(spectrum, is_left_of_axis, bits)  # none is on the axis
        left = product_of_roots(((b, m) for b, m, inside in balls if inside), spectrum.gen)
        return left if left.radius <= Rational(1, 10**digits) else None

    left = at_growing_precision(attempt, bits, f"a factor with {digits} digits")
    return SpectralFactor(spectrum, half, "continuous", None, left, constant)


def _rational_hurwitz_factor(spectrum: Poly, half: int) -> Poly | None:
    """Multiply the irreducible factors that are Hurwitz, if these are half of the polynomial."""
    chosen = canonical(Poly(1, spectrum.gen))
    for factor, multiplicity in spectrum.factor_list()[1]:
        if factor.degree() and count_roots(canonical(factor), time="continuous").unstable == 0:
            chosen = canonical(chosen * factor**multiplicity)
    return monic(chosen) if chosen.degree() == half else None


def _factor_palindrome(palindrome: Poly, degree: int, digits: int, bits: int) -> SpectralFactor:
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
    ask_for_coefficients(stripped, int(stripped.degree()) // 2, "the spectral factor", 480)
    try:
        inside, _ = split_at_unit_circle(stripped)
    except NoSolutionError:
        pass
    else:
        chi = canonical(inside * power)
        constant = Enclosure(stripped.LC() / inside.TC(), Rational(0))
        return SpectralFactor(palindrome, degree, "discrete", chi, exact_enclosure(chi), constant)
    enclosed, _ = enclose_split_at_unit_circle(stripped, digits=digits)
    with ball_precision(2 * bits):
        constant_ball = ball_of_number(stripped.LC()) / ball_of_enclosure(enclosed.coefficients[-1])
        zeros = exact_enclosure(power).coefficients[1:]
        chi_ball = PolynomialEnclosure(enclosed.coefficients + zeros, palindrome.gen)
        constant = enclosure_of_ball(constant_ball)
    return SpectralFactor(palindrome, degree, "discrete", None, chi_ball, constant)
