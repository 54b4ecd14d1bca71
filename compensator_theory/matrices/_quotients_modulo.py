"""Quotients of polynomials modulo another one, over the rational functions of symbols too."""

from __future__ import annotations

from sympy import Poly

from compensator_theory.errors import InputError
from compensator_theory.matrices._function_rings import FunctionRing
from compensator_theory.polynomials._budget import quoted, unlimited


def quotient_modulo(factor: Poly, top: Poly, bottom: Poly) -> Poly:
    """Return a quotient as a polynomial that has its values at the roots of a coprime factor.

    SymPy's ``invert`` (1.14), which python-flint computes over Q, takes a constant that it did not
    normalise, over Q(sqrt(2))(a) for instance, for a divisor of zero. Over functions of symbols
    the fractions of its remainder sequence swell; linear equations have none.
    """
    if factor.domain.is_QQ and bottom.domain.is_QQ:
        return (top * bottom.invert(factor)).rem(factor)
    if _share_functions_of_symbols(factor, top, bottom):
        return _with_symbols(factor, top, bottom)
    inverse, divisor = bottom.half_gcdex(factor)
    if divisor.degree() > 0:
        raise _common_factor(factor, bottom)
    return (top * inverse).rem(factor)


def product_modulo(factor: Poly, a: Poly, b: Poly) -> Poly:
    """Return the remainder of a product, over one field."""
    if not _share_functions_of_symbols(factor, a, b):
        return (a * b).rem(factor)
    with unlimited():
        ring = FunctionRing(factor.gen, factor.domain)
        first, second, modulus = (ring.read(p) for p in (a, b, factor))
        return ring.write(ring.divide(first * second, modulus)[1]).set_domain(factor.domain)


def _share_functions_of_symbols(factor: Poly, *others: Poly) -> bool:
    field = factor.domain
    return bool(
        factor.degree() > 0
        and field.is_FractionField
        and FunctionRing.serves(field)
        and all(other.domain == field for other in others)
    )


def _with_symbols(factor: Poly, top: Poly, bottom: Poly) -> Poly:
    with unlimited():  # as long as the answer, which SymPy's way has no limit for either
        ring = FunctionRing(factor.gen, factor.domain)
        modulus, above, below = (ring.read(p) for p in (factor, top, bottom))
        if ring.degree(below) >= ring.degree(modulus):
            below = ring.divide(below, modulus)[1]
        if not below:
            raise _common_factor(factor, bottom)
        inverse, _, rest, _ = ring.identity(below, modulus)
        if ring.degree(rest) < ring.degree(below):
            raise _common_factor(factor, bottom)
        if rest != below:
            inverse = -inverse  # their greatest common divisor is -1
        quotient = ring.divide(above * inverse, modulus)[1]
        return ring.write(quotient).set_domain(factor.domain)


def _common_factor(factor: Poly, bottom: Poly) -> InputError:
    return InputError(f"{quoted(bottom)} and {quoted(factor)} have a common factor")
