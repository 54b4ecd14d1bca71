"""Spectral factorisation on the imaginary axis: rational where it is, certified where not."""

from dataclasses import dataclass

import flint
from sympy import Expr, Poly, Rational, Symbol

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.latex import displayed, latex
from compensator_theory.polynomials.ball_precision import ball_precision
from compensator_theory.polynomials.formatting import format_polynomial
from compensator_theory.polynomials.poly import canonical, monic
from compensator_theory.polynomials.reading import PolynomialLike
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.printing import text
from compensator_theory.roots.certified import decided_balls
from compensator_theory.roots.counts import count_half_plane_roots, require_rational
from compensator_theory.roots.enclosures import (
    Enclosure,
    PolynomialEnclosure,
    ball_of_enclosure,
    ball_of_number,
    enclosure_of_ball,
    latex_of,
    text_of,
)
from compensator_theory.roots.reflections import even_spectrum, weighted_pair
from compensator_theory.roots.unit_circle_enclosures import (
    exact_enclosure,
    product_of_roots,
    working_bits,
)


@dataclass(frozen=True)
class HalfPlaneFactor(ExactValue):
    r"""A monic Hurwitz polynomial and a constant with the given product on the imaginary axis.

    .. math:: c\,\chi(s)\,\chi(-s) = p(s)

    Attributes
    ----------
    spectrum : sympy.Poly
        p, even, of degree 2m.
    polynomial : sympy.Poly or None
        :math:`\chi` of degree m if it is rational, else None.
    enclosure : PolynomialEnclosure
        :math:`\chi`, certified; radius 0 if it is rational.
    constant : sympy.Rational
        c, exact.

    Examples
    --------
    >>> from compensator_theory import continuous_spectral_factor
    >>> print(continuous_spectral_factor("s - 1", "s**2"))
    χ = s + 1
    c = 1
    """

    spectrum: Poly
    polynomial: Poly | None
    enclosure: PolynomialEnclosure
    constant: Expr

    @property
    def is_rational(self) -> bool:
        """Whether the factor has rational coefficients."""
        return self.polynomial is not None

    @property
    def residual(self) -> tuple[Enclosure, ...]:
        r"""Coefficients of :math:`c\,\chi(s)\chi(-s) - p(s)`, computed anew; each contains 0."""
        finest = max(int(c.centre.q).bit_length() for c in self.enclosure.coefficients)
        with ball_precision(64 + 2 * finest):
            ascending = [ball_of_enclosure(c) for c in reversed(self.enclosure.coefficients)]
            mirrored = [-c if k % 2 else c for k, c in enumerate(ascending)]
            product = flint.arb_poly(ascending) * flint.arb_poly(mirrored)
            given = flint.arb_poly([ball_of_number(c) for c in self.spectrum.all_coeffs()[::-1]])
            difference = ball_of_number(self.constant) * product - given
            return tuple(enclosure_of_ball(c) for c in reversed(difference.coeffs()))

    def __str__(self) -> str:
        return f"χ = {text_of(self.polynomial, self.enclosure)}\nc = {text(self.constant)}"

    def _repr_latex_(self) -> str:
        body = latex_of(self.polynomial, self.enclosure)
        return displayed(rf"\chi = {body}", f"c = {latex(self.constant)}")


def continuous_spectral_factor(
    N: PolynomialLike,
    D: PolynomialLike | None = None,
    r: object = 0,
    *,
    digits: int = 30,
    variable: str | Symbol | None = None,
) -> HalfPlaneFactor:
    r"""Find the monic Hurwitz polynomial with a prescribed spectrum on the imaginary axis.

    .. math:: c\,\chi(s)\,\chi(-s) = N(s) N(-s) + r\, D(s) D(-s)

    Parameters
    ----------
    N, D : polynomial
        Rational coefficients; D may be left out.
    r : number
        At least 0.
    digits : int
        Where the factor is not rational, every radius is at most :math:`10^{-\mathrm{digits}}`.
    variable : str or Symbol, optional
        Default: evident from N or D.

    Returns
    -------
    HalfPlaneFactor
        Of the degree of D if r > 0 and :math:`\deg N \le \deg D`: the closed-loop polynomial of the
        regulator with :math:`R_2 = r`. For r = 0 the roots of N, those of the right half plane
        reflected: where the finite ones of its poles go as :math:`r \to 0`.

    Raises
    ------
    NoSolutionError
        If the right side is zero, or vanishes on the imaginary axis, so that no factor is Hurwitz.
    InputError
        If r is negative or a coefficient is symbolic.

    Notes
    -----
    The counterpart of :func:`spectral_factor` for continuous time.

    Examples
    --------
    >>> from compensator_theory import continuous_spectral_factor
    >>> found = continuous_spectral_factor("1", "s**2", "1/4")
    >>> found.polynomial.as_expr(), found.constant
    (s**2 + 2*s + 2, 1/4)
    >>> print(continuous_spectral_factor("s", "s**2 - 3", 1).enclosure)
    s**2 + 3.6055512754639892931*s + 3.0000000000000000000
    """
    first, second, weight = weighted_pair(N, D, r, variable)
    spectrum = canonical(even_spectrum(first) + even_spectrum(second).mul_ground(weight))
    return factor_even(spectrum, digits)


def factor_even(spectrum: Poly, digits: int = 30) -> HalfPlaneFactor:
    r"""Take the roots of the left half plane out of an even polynomial.

    Parameters
    ----------
    spectrum : sympy.Poly
        Rational, p(s) = p(-s).
    digits : int
        As for :func:`continuous_spectral_factor`.

    Raises
    ------
    NoSolutionError
        If the polynomial is zero or has a root on the imaginary axis.
    InputError
        If it is not even or has symbolic coefficients.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots.half_plane_factors import factor_even
    >>> factor_even(polynomial("4 - s**2")).polynomial.as_expr()
    s + 2
    """
    bits = working_bits(digits)
    if spectrum.is_zero:
        raise NoSolutionError("the spectrum to be factored is zero everywhere, and no factor is")
    spectrum = require_rational(spectrum)
    if any(c != 0 for c in spectrum.all_coeffs()[-2::-2]):
        raise InputError(f"{format_polynomial(spectrum)} is not even")
    counted = count_half_plane_roots(spectrum)
    if counted.boundary:
        raise NoSolutionError(
            f"{format_polynomial(spectrum)} has {counted.boundary} root(s) on the imaginary axis, "
            "so that no factor of it has all its roots to the left"
        )
    half = int(spectrum.degree()) // 2
    constant = spectrum.LC() * (-1) ** half
    exact = _rational_factor(spectrum, half)
    if exact is not None:
        return HalfPlaneFactor(spectrum, exact, exact_enclosure(exact), constant)
    while True:
        balls = decided_balls(spectrum, _is_left, bits)
        with ball_precision(bits):
            left = product_of_roots(((b, m) for b, m, inside in balls if inside), spectrum.gen)
        if left.radius <= Rational(1, 10**digits):
            return HalfPlaneFactor(spectrum, None, left, constant)
        bits *= 2


def _rational_factor(spectrum: Poly, half: int) -> Poly | None:
    """Multiply the irreducible factors that are Hurwitz, if these are half of the polynomial."""
    chosen = canonical(Poly(1, spectrum.gen))
    for factor, multiplicity in spectrum.factor_list()[1]:
        if factor.degree() and count_half_plane_roots(canonical(factor)).unstable == 0:
            chosen = canonical(chosen * factor**multiplicity)
    return monic(chosen) if chosen.degree() == half else None


def _is_left(ball: flint.acb) -> bool | None:
    return True if ball.real < 0 else False if ball.real > 0 else None
