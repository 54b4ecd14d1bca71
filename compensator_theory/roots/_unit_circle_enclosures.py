"""The split at the unit circle where it is not rational: certified balls for the coefficients."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from functools import reduce

import flint
from sympy import Poly, Rational, Symbol

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.polynomials._ball_precision import (
    at_growing_precision,
    ball_precision,
)
from compensator_theory.polynomials._budget import integer
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.roots._certified import decided_balls
from compensator_theory.roots._counts import require_rational
from compensator_theory.roots._enclosures import (
    Enclosure,
    PolynomialEnclosure,
    ball_of_enclosure,
    enclosure_of_ball,
)
from compensator_theory.roots._reflections import monic_reciprocal_polynomial
from compensator_theory.roots._unit_circle import (
    is_inside,
    require_none_on_circle,
    split_at_unit_circle,
)

MAX_DIGITS = 10_000


@refusing
def enclose_split_at_unit_circle(
    poly: PolynomialLike, variable: str | Symbol | None = None, *, digits: int = 30
) -> tuple[PolynomialEnclosure, PolynomialEnclosure]:
    r"""Enclose the two monic factors of a rational polynomial at the unit circle.

    .. math:: N = N_k\, N_s\, N_u, \qquad N_s(\lambda)=0 \Rightarrow |\lambda|<1, \qquad
              N_u(\lambda)=0 \Rightarrow |\lambda|>1

    Parameters
    ----------
    poly : polynomial
        Rational coefficients, not zero.
    digits : int
        Every radius is at most :math:`10^{-\mathrm{digits}}`.
    variable : str or Symbol, optional
        Default: evident; a list of coefficients shows none.

    Returns
    -------
    tuple of PolynomialEnclosure
        :math:`(N_s, N_u)`; with radii 0 where the split is rational.

    Raises
    ------
    UnitCircleError
        If a root has modulus exactly 1, decided without a tolerance.
    InputError
        If the polynomial is zero or has symbolic coefficients, or `digits` is no positive integer.

    Notes
    -----
    :func:`split_at_unit_circle` gives the same factors as polynomials where they are rational, and
    refuses where they are not.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.roots import enclose_split_at_unit_circle
    >>> inside, outside = enclose_split_at_unit_circle(polynomial("q**2 - 4*q + 1"), digits=12)
    >>> print(inside, "|", outside)
    q - 0.26794919243112270647 | q - 3.7320508075688772935
    """
    poly = require_rational(polynomial(poly, variable))
    bits = working_bits(digits)
    try:
        return tuple(exact_enclosure(factor) for factor in split_at_unit_circle(poly))  # type: ignore[return-value]
    except NoSolutionError:
        pass
    require_none_on_circle(poly)

    def attempt(bits: int) -> tuple[PolynomialEnclosure, PolynomialEnclosure] | None:
        balls = decided_balls(poly, is_inside, bits)  # none is on the circle
        inner, outer = (
            product_of_roots(((ball, m) for ball, m, inside in balls if inside is side), poly.gen)
            for side in (True, False)
        )
        small = max(inner.radius, outer.radius) <= Rational(1, 10**digits)
        return (inner, outer) if small else None

    return at_growing_precision(attempt, bits, f"a factor with {digits} digits")


def product_of_roots(
    balls: Iterable[tuple[flint.acb, int]], variable: Symbol
) -> PolynomialEnclosure:
    """Multiply out the monic polynomial with the given balls as roots, conjugates included."""
    roots = [ball for ball, multiplicity in balls for _ in range(multiplicity)]
    ascending = flint.acb_poly.from_roots(roots).coeffs()
    return PolynomialEnclosure(
        tuple(enclosure_of_ball(c.real) for c in reversed(ascending)), variable
    )


def exact_enclosure(poly: Poly) -> PolynomialEnclosure:
    """Return a rational polynomial as an enclosure of radius 0."""
    return PolynomialEnclosure(
        tuple(Enclosure(c, Rational(0)) for c in poly.all_coeffs()), poly.gen
    )


def working_bits(digits: int) -> int:
    """Return the bits of precision to begin with for so many decimal digits."""
    return 32 + 4 * integer(digits, "digits", at_least=1, at_most=MAX_DIGITS)


def multiply_enclosures(*factors: PolynomialEnclosure) -> PolynomialEnclosure:
    """Multiply enclosures of polynomials in one variable."""
    if all(factor.radius == 0 for factor in factors):
        return exact_enclosure(reduce(operator.mul, (factor.centre for factor in factors)))
    finest = max(int(c.centre.q).bit_length() for factor in factors for c in factor.coefficients)
    with ball_precision(64 + 2 * finest):
        product = flint.arb_poly([1])
        for factor in factors:
            product *= flint.arb_poly([ball_of_enclosure(c) for c in reversed(factor.coefficients)])
        coefficients = tuple(enclosure_of_ball(c) for c in reversed(product.coeffs()))
    return PolynomialEnclosure(coefficients, factors[0].variable)


def monic_reciprocal_enclosure(factor: PolynomialEnclosure) -> PolynomialEnclosure:
    """Enclose the monic polynomial with the reciprocals of the roots."""
    last = factor.coefficients[-1]
    if 0 in last:
        raise InputError(f"the constant term of {factor} may be zero; raise the number of digits")
    if factor.radius == 0:
        return exact_enclosure(monic_reciprocal_polynomial(factor.centre))
    finest = max(int(c.centre.q).bit_length() for c in factor.coefficients)
    with ball_precision(64 + finest):
        divisor = ball_of_enclosure(last)
        rest = tuple(
            enclosure_of_ball(ball_of_enclosure(c) / divisor) for c in factor.coefficients[-2::-1]
        )
    return PolynomialEnclosure((Enclosure(Rational(1), Rational(0)), *rest), factor.variable)
