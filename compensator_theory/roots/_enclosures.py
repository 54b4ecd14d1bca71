"""Real numbers and polynomials known to lie in balls with rational centres and radii."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

import flint
import sympy
from sympy import Expr, Poly, Rational, Symbol

from compensator_theory._latex import displayed, latex
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import quoted, repr_of
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._numbers import exact_number
from compensator_theory.polynomials._values import ExactValue

MOST_DIGITS = 20


@dataclass(frozen=True, repr=False)
class Enclosure(ExactValue):
    r"""A real number x with :math:`|x - \mathrm{centre}| \le \mathrm{radius}`, certified.

    Attributes
    ----------
    centre, radius : sympy.Rational
        Both exact; a radius of 0 means that x is known exactly.

    Examples
    --------
    >>> from sympy import Rational
    >>> from compensator_theory.results import Enclosure
    >>> third = Enclosure(Rational(333, 1000), Rational(1, 1000))
    >>> third
    0.333 ± 1.0e-3
    >>> Rational(1, 3) in third, Rational(1, 4) in third
    (True, False)
    """

    centre: Rational
    radius: Rational

    @property
    def lower(self) -> Rational:
        """Left end of the ball."""
        return self.centre - self.radius

    @property
    def upper(self) -> Rational:
        """Right end of the ball."""
        return self.centre + self.radius

    def __contains__(self, number: object) -> bool:
        value = exact_number(number)
        if not value.is_Rational:
            raise InputError(
                f"{quoted(value)} is not a rational number, so it cannot be compared exactly"
            )
        return bool(abs(value - self.centre) <= self.radius)

    def __float__(self) -> float:
        return int(self.centre.p) / int(self.centre.q)

    def __repr__(self) -> str:
        if self.radius == 0:
            return text(self.centre)
        first = _decade(abs(self.centre) + self.radius)
        last = max(_decade(self.radius), first - MOST_DIGITS)
        error = self.radius + (Rational(10) ** last / 2 if last > _decade(self.radius) else 0)
        scaled = self.centre / Rational(10) ** last
        rounded = round(Fraction(int(scaled.p), int(scaled.q)))
        centre = Decimal(int(rounded)).scaleb(last)
        written = str(centre) if rounded else f"{centre:f}"  # not 0E-13
        return f"{written} ± {Decimal(float(error)):.1e}"

    def _repr_latex_(self) -> str:
        return displayed(self.latex())

    def latex(self) -> str:
        """Return the LaTeX of the printed text, without the dollars."""
        return repr(self).replace("±", r"\pm")


@dataclass(frozen=True, repr=False)
class PolynomialEnclosure(ExactValue):
    r"""A real polynomial whose coefficients are certified by :class:`Enclosure`.

    .. math:: a(s) = a_k s^k + \cdots + a_0, \qquad
              |a_i - \mathrm{centre}_i| \le \mathrm{radius}_i

    Attributes
    ----------
    coefficients : tuple of Enclosure
        Descending powers, the leading one known not to be zero.
    variable : sympy.Symbol

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots import enclose_split_at_unit_circle
    >>> inside, outside = enclose_split_at_unit_circle(polynomial("q**2 - 3*q + 1"))
    >>> print(inside)
    q - 0.38196601125010515180
    >>> inside.degree, polynomial("q - 1/2") in inside
    (1, False)
    """

    coefficients: tuple[Enclosure, ...]
    variable: Symbol

    @property
    def degree(self) -> int:
        """Exact degree."""
        return len(self.coefficients) - 1

    @property
    def centre(self) -> Poly:
        """Polynomial of the centres."""
        return Poly([c.centre for c in self.coefficients], self.variable, domain=sympy.QQ)

    @property
    def radius(self) -> Rational:
        """Largest radius of a coefficient."""
        return max(c.radius for c in self.coefficients)

    def __contains__(self, poly: object) -> bool:
        if not isinstance(poly, Poly):
            raise InputError(f"{repr_of(poly)} is not a sympy.Poly; make one with polynomial()")
        same_shape = poly.degree() == self.degree and poly.gen == self.variable
        return same_shape and all(
            value in ball for value, ball in zip(poly.all_coeffs(), self.coefficients, strict=True)
        )

    def __str__(self) -> str:
        digits = min(max(3, -_decade(self.radius)), MOST_DIGITS) if self.radius else MOST_DIGITS
        written = ""
        for power, ball in zip(range(self.degree, -1, -1), self.coefficients, strict=True):
            if ball.centre == 0 and ball.radius == 0:
                continue
            size = abs(ball.centre)
            number = text(size) if ball.radius == 0 else str(sympy.N(size, digits))
            unit = {0: "", 1: str(self.variable)}.get(power, f"{self.variable}**{power}")
            factors = [part for part in (number if number != "1" or not unit else "", unit) if part]
            written += f" {'-' if ball.centre < 0 else '+'} {'*'.join(factors)}"
        return written[3:] if written.startswith(" +") else "-" + written[3:]

    def __repr__(self) -> str:
        return f"PolynomialEnclosure({self}, radius {text(sympy.N(self.radius, 2))})"

    def _repr_latex_(self) -> str:
        return displayed(self.latex())

    def latex(self) -> str:
        """Return the LaTeX of the centres, exact ones as they are and others to eight digits."""
        terms = (
            (c.centre if c.radius == 0 else sympy.N(c.centre, 8)) * self.variable**k
            for k, c in enumerate(reversed(self.coefficients))
        )
        return latex(sum(terms))


def text_of(polynomial: Poly | None, enclosure: PolynomialEnclosure) -> str:
    """Write a polynomial where it is rational, and its enclosure where it is not."""
    return str(enclosure) if polynomial is None else format_polynomial(polynomial)


def latex_of(polynomial: Poly | None, enclosure: PolynomialEnclosure) -> str:
    """Return the LaTeX of a polynomial or of its enclosure."""
    return latex(enclosure if polynomial is None else polynomial)


def enclosure_of_ball(ball: flint.arb) -> Enclosure:
    """Return the exact data of a python-flint real ball."""
    if not ball.is_finite():
        raise InputError(f"the ball {ball} is not finite; raise the number of digits")
    return Enclosure(_dyadic(ball.mid()), _dyadic(ball.rad()))


def ball_of_number(number: Expr) -> flint.arb:
    """A python-flint real ball, at its working precision, that contains a rational number."""
    return flint.arb(flint.fmpq(int(number.p), int(number.q)))


def ball_of_enclosure(enclosure: Enclosure) -> flint.arb:
    """Return a python-flint real ball, at its working precision, that contains an enclosure."""
    error = flint.arb(0, ball_of_number(enclosure.radius))
    return ball_of_number(enclosure.centre) + error


def _dyadic(value: flint.arf) -> Rational:
    mantissa, exponent = value.man_exp()
    return sympy.Integer(int(mantissa)) * Rational(2) ** int(exponent)


def _decade(number: Rational) -> int:
    """Return the exponent of a positive number in scientific notation."""
    exponent = (int(number.p).bit_length() - int(number.q).bit_length()) * 30103 // 100000
    while number >= Rational(10) ** (exponent + 1):
        exponent += 1
    while number < Rational(10) ** exponent:
        exponent -= 1
    return exponent
