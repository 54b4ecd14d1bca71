"""Quotients and products modulo a polynomial whose coefficients are functions of symbols."""

import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import QQ, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.matrices._quotients_modulo import product_modulo, quotient_modulo
from compensator_theory.polynomials._poly import over_coefficient_field
from tests.support.work import at_most

s, a, b = sympy.symbols("s a b")
FIELD = QQ.frac_field(a, b)
coefficients = st.sampled_from([0, 1, -2, a, b, 1 / a, a * b - 1, (a + b) / (a - 3), b**2 / 3])


def polys(at_least, at_most):
    lists = st.lists(coefficients, min_size=at_least + 1, max_size=at_most + 1)
    return lists.map(lambda descending: Poly(descending, s, domain=FIELD))


@given(polys(1, 3), polys(0, 3), polys(0, 4))
def test_a_quotient_and_a_product_are_those_of_sympy(factor, top, bottom):
    assume(factor.degree() > 0)
    assert product_modulo(factor, top, bottom) == (top * bottom).rem(factor)
    if bottom.gcd(factor).degree() > 0 or bottom.is_zero:
        with pytest.raises(InputError, match="common factor"):
            quotient_modulo(factor, top, bottom)
        return
    quotient = quotient_modulo(factor, top, bottom)
    assert quotient.domain == FIELD and quotient.degree() < factor.degree()
    assert (quotient * bottom - top).rem(factor).is_zero


def test_four_symbols_leave_no_swollen_remainder_sequence():
    names = sympy.symbols("a b c d")
    factor = sum(x * s**k for k, x in enumerate(names)) + s**4 + 3 * s**3 + 1
    field = QQ.frac_field(*names)
    p = Poly(factor, s, domain=field)
    with at_most(400_000):  # SymPy's remainder sequence takes 50 times as many
        quotient = quotient_modulo(p, Poly(1, s, domain=field), p.diff())
    point = dict(zip(names, (2, -3, 5, 7), strict=True))
    p, q = (Poly(side.as_expr().subs(point), s, domain="QQ") for side in (p, quotient))
    assert (q * p.diff() - 1).rem(p).is_zero


def test_surds_beside_symbols_are_left_to_sympy():
    factor, bottom = over_coefficient_field(
        Poly(s**2 + sympy.sqrt(2) * s + a, s), Poly(s + sympy.sqrt(2), Symbol("s"))
    )
    quotient = quotient_modulo(factor, factor.one, bottom)
    assert (quotient * bottom - 1).rem(factor).is_zero
