"""Greatest common divisors, with the identity that certifies them."""

from __future__ import annotations

from dataclasses import dataclass

import flint
import sympy
from sympy import Expr, Poly

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certified
from compensator_theory.matrices._flint_polynomials import (
    flint_polynomial_pair,
    from_flint_polynomial,
)
from compensator_theory.matrices._function_rings import FunctionRing
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._letters import fresh, names_in_all
from compensator_theory.polynomials._poly import canonical, monic, over_one_field
from compensator_theory.polynomials._reading import PolynomialLike, in_one_variable
from compensator_theory.polynomials._values import ExactValue


@dataclass(frozen=True)
class BezoutIdentity(Certified, ExactValue):
    r"""A greatest common divisor and its certificate.

    .. math:: x\,a + y\,b = g, \qquad a = g\,\bar a, \quad b = g\,\bar b

    Attributes
    ----------
    a, b : sympy.Poly
        As given.
    gcd : sympy.Poly
        g, monic. It divides a and b by `quotients`, and every common divisor divides it by the
        identity.
    x, y : sympy.Poly
        The multipliers; with symbols, fractions of them occur in the coefficients.
    quotients : tuple of sympy.Poly
        :math:`(\bar a, \bar b)`.

    Examples
    --------
    >>> from compensator_theory import bezout_identity
    >>> print(bezout_identity("(s + 1)*(s + 2)", "(s + 1)*s"))
    gcd = s + 1 = (1/2)*a + (-1/2)*b
    """

    identity = "x a + y b = g, a = g a', b = g b'"

    a: Poly
    b: Poly
    gcd: Poly
    x: Poly
    y: Poly
    quotients: tuple[Poly, Poly]

    @property
    def is_coprime(self) -> bool | None:
        """Whether a and b share no root; None if that depends on the value of a symbol."""
        if self.gcd.degree() > 0:
            return False
        if self.a.domain.is_QQ and self.b.domain.is_QQ:
            return True
        decided: bool | None = sympy.sympify(self.a.resultant(self.b)).is_nonzero
        return decided

    @property
    def exceptional(self) -> tuple[Expr, ...]:
        """Irreducible polynomials in the symbols; the identity holds where none of them is zero.

        As g divides a and b there, too, it is their greatest common divisor.
        """
        parts = (self.x, self.y, self.gcd, *self.quotients)
        coefficients = (c for p in parts if not p.domain.is_QQ for c in p.all_coeffs())
        bottoms = {sympy.fraction(sympy.cancel(c))[1] for c in coefficients}
        factors = {f for b in bottoms for f, _ in sympy.factor_list(b)[1] if not f.is_nonzero}
        return tuple(sorted(factors, key=lambda f: (sympy.count_ops(f), text(f))))

    @property
    def residual(self) -> Poly:
        """The residual x a + y b - g, recomputed; zero."""
        return self._residuals()[0]

    def _residuals(self) -> list[Poly]:
        x, y, a, b, gcd, *parts = over_one_field(
            self.x, self.y, self.a, self.b, self.gcd, *self.quotients
        )
        left = x * a + y * b - gcd, a - gcd * parts[0], b - gcd * parts[1]
        return [canonical(poly) for poly in left]

    def __str__(self) -> str:
        gcd, x, y = (format_polynomial(p) for p in (self.gcd, self.x, self.y))
        names = names_in_all(self)
        return f"gcd = {gcd} = ({x})*{fresh(names, 'a')} + ({y})*{fresh(names, 'b')}"

    def _repr_latex_(self) -> str:
        gcd, x, y, a, b = map(latex, (self.gcd, self.x, self.y, self.a, self.b))
        return displayed(f"({x})({a}) + ({y})({b}) = {gcd}", unless(self.exceptional))


@carrying()
def bezout_identity(
    a: PolynomialLike, b: PolynomialLike, *, variable: str | sympy.Symbol | None = None
) -> BezoutIdentity:
    r"""Find the greatest common divisor of two polynomials and the identity that proves it.

    .. math:: x\,a + y\,b = \gcd(a, b)

    Parameters
    ----------
    a, b : polynomial
        Anything :func:`polynomial` reads, in one variable, not both zero. With symbols, for generic
        values of them.
    variable : str or Symbol, optional
        Default: evident from the two together, as :func:`shared_variable` decides.

    Raises
    ------
    InputError
        If both are zero, or the variable is not evident.

    Examples
    --------
    >>> from compensator_theory import bezout_identity
    >>> identity = bezout_identity("s**2 + 1", "s + 2")
    >>> identity.is_coprime, identity.residual.is_zero
    (True, True)
    >>> identity = bezout_identity("s + a", "s + b", variable="s")
    >>> identity.is_coprime is None, identity.exceptional
    (True, (a - b,))
    """
    first, second = in_one_variable(a, b, variable=variable)
    if (pair := flint_polynomial_pair(first, second)) is not None and pair[0] and pair[1]:
        return _of_rationals(first, second, *pair)
    if first.is_zero and second.is_zero:
        raise InputError("a and b are both zero; every polynomial divides them")
    one, two = over_one_field(first, second)
    field = one.unify(two)[0].domain.get_field()
    if FunctionRing.serves(field) and not first.is_zero and not second.is_zero:
        return _of_functions(first, second, FunctionRing(first.gen, field))
    over_field = [p.set_domain(field) for p in (one, two)]
    x, y, gcd = over_field[0].gcdex(over_field[1])
    leading = gcd.LC()
    gcd = monic(canonical(gcd))
    quotients = (canonical(over_field[0].quo(gcd)), canonical(over_field[1].quo(gcd)))
    x, y = (canonical(p.set_domain(p.domain.get_field()).quo_ground(leading)) for p in (x, y))
    return BezoutIdentity(first, second, gcd, x, y, quotients)


def _of_rationals(
    first: Poly, second: Poly, a: flint.fmpq_poly, b: flint.fmpq_poly
) -> BezoutIdentity:
    gcd, x, y = a.xgcd(b)
    s = first.gen
    divisor, left, right = (from_flint_polynomial(p, s) for p in (gcd, x, y))
    quotients = first, second
    if gcd.degree() > 0:
        quotients = from_flint_polynomial(a // gcd, s), from_flint_polynomial(b // gcd, s)
    return BezoutIdentity(first, second, divisor, left, right, quotients)


def _of_functions(first: Poly, second: Poly, ring: FunctionRing) -> BezoutIdentity:
    """Compute over the rational functions of symbols, by elimination in python-flint."""
    a = ring.read(first)
    x, y, *quotients = ring.identity(a, ring.read(second))
    if ring.degree(quotients[1]) == 0:  # b alone: both quotients have the same roots
        x, y = ring.zero, ring.reciprocal_of_leading(quotients[1])
    gcd, _ = ring.divide(a, quotients[0])
    leading, scale = ring.coefficient(gcd, ring.degree(gcd)), ring.reciprocal_of_leading(gcd)
    divisor, left, right = (canonical(ring.write(p * scale)) for p in (gcd, x, y))
    one, two = (canonical(ring.write(p * leading)) for p in quotients)
    return BezoutIdentity(first, second, divisor, left, right, (one, two))
