"""Polynomials over rational functions: what the ring does is what substituted numbers do."""

import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import QQ, Poly, Rational
from sympy.abc import a, b, s

from compensator_theory.matrices._function_rings import FunctionRing
from compensator_theory.matrices._rational_functions import in_symbols
from compensator_theory.polynomials._poly import from_coefficients

VALUES = {a: Rational(7, 3), b: Rational(-5, 11)}
COEFFICIENTS = st.sampled_from(
    [sympy.Integer(k) for k in (-2, 0, 1)] + [a, b / 2 - 1, 1 / (a + b), a * b, (a - 1) / (3 * b)]
)
POLYNOMIALS = st.lists(COEFFICIENTS, min_size=1, max_size=4).map(lambda c: from_coefficients(c, s))
RING = FunctionRing(s, QQ.frac_field(a, b))


def at_numbers(poly):
    return Poly(poly.as_expr().subs(VALUES), s, domain="QQ")


@settings(max_examples=12)
@given(POLYNOMIALS, POLYNOMIALS)
def test_sums_products_and_quotients_are_those_of_numbers(p, q):
    one, two = RING.read(p), RING.read(q)
    assert RING.write(one) == p and (one == two) == (p == q) and bool(one) == (not p.is_zero)
    for built, expected in (
        (one + two, at_numbers(p) + at_numbers(q)),
        (one - two, at_numbers(p) - at_numbers(q)),
        (one * two, at_numbers(p) * at_numbers(q)),
    ):
        assert at_numbers(RING.write(built)) == expected
    if q:
        quotient, remainder = RING.divide(one, two)
        assert quotient * two + remainder == one and RING.degree(remainder) < RING.degree(two)
        monic = RING.reciprocal_of_leading(two) * two
        assert RING.coefficient(monic, RING.degree(two)) == RING.one


@settings(max_examples=12)
@given(POLYNOMIALS, POLYNOMIALS, POLYNOMIALS)
def test_identities_of_greatest_common_divisors(p, q, common):
    if not (p and q and common):
        return
    p, q = (RING.read(part) * RING.read(common) for part in (p, q))
    x, y, first, second = RING.identity(p, q)
    result = x * p + y * q
    assert x * first + y * second == RING.one
    assert result * first == p and result * second == q
    assert RING.degree(result) == RING.degree_of_gcd([p, q]) >= common.degree()


@settings(max_examples=12)
@given(st.lists(COEFFICIENTS, min_size=1, max_size=4))
def test_polynomials_are_written_in_canonical_form(coefficients):
    work = in_symbols(frozenset({a, b}))
    while len(coefficients) > 1 and coefficients[0] == 0:
        coefficients = coefficients[1:]
    assert work.polynomial([work.read(c) for c in coefficients], s) == from_coefficients(
        coefficients, s
    )
