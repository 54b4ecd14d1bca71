"""Polynomials from everywhere, certified roots, and the split at the unit circle."""

from collections import Counter

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Poly

from compensator_theory import InputError, certified_roots, monic, polynomial, polynomial_from_roots
from compensator_theory.errors import NoSolutionError, UnitCircleError
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.roots import split_at_unit_circle
from compensator_theory.strategies import polynomials, spectra

a, b, q, s = sympy.symbols("a b q s")


@given(polynomials())
def test_all_descriptions_agree(p):
    assert polynomial(p) == p
    assert polynomial(p.as_expr(), "s") == p
    assert polynomial(str(p.as_expr()), "s") == p
    assert polynomial([0, *p.all_coeffs()], "s") == p
    assert polynomial(format_polynomial(p), "s") == p
    assert monic(p) == p.monic()


def test_symbols_and_domains():
    assert polynomial("a*s + s - a*s").domain == sympy.QQ
    assert polynomial(Poly(a * q + b, q)) == polynomial("b + a*q", "q")
    assert monic(polynomial("2*a*s + b")) == monic(polynomial("4*a*s + 2*b"))
    assert format_polynomial(polynomial("-s**2 + (a - 1)*s - a", "s")) == "-s**2 + (a - 1)*s - a"


@pytest.mark.parametrize(
    ("obj", "variable"),
    [("1/s", None), ("sqrt(s)", None), ("s + 1j", None), ("s*z", None), ("a + b", None),
     ("3", None),
     ([], "s"), ([1, 2], None), ([s, 1], "s"), ([[1], [2]], "s"), ([float("nan")], "s"),
     (Poly(s), "q"), (Poly(s * q), None), ("s", "2*s")],
)  # fmt: skip
def test_not_a_polynomial(obj, variable):
    with pytest.raises(InputError):
        polynomial(obj, variable)


@given(st.integers(0, 6).flatmap(spectra))
def test_certified_roots_of_planted_spectrum(planted):
    result = certified_roots(polynomial_from_roots(planted, "s"))
    expected = Counter(planted)
    assert sorted(root.multiplicity for root in result) == sorted(expected.values())
    for exact, multiplicity in expected.items():
        near = [r for r in result if abs(r.value - complex(exact)) <= r.radius + 1e-13]
        assert [(r.multiplicity, r.is_real) for r in near] == [(multiplicity, exact.is_real)]


def test_order_and_special_cases_of_roots():
    assert certified_roots(polynomial(7, "s")) == ()
    roots = certified_roots(polynomial("s**2*(s - 1)*(s**2 + 2*s + 2)*(s**2 + 1)"))
    assert [r.value for r in roots] == [0, 1, -1 + 1j, -1 - 1j, 1j, -1j]
    assert all(r.value.conjugate() in [x.value for x in roots] for r in roots)
    for poly in (polynomial(0, "s"), polynomial("s + a")):
        with pytest.raises(InputError):
            certified_roots(poly)


def test_radius_covers_an_irrational_root():
    root = certified_roots(polynomial("s**2 - 2"))[1]
    error = abs(sympy.sqrt(2) - sympy.Rational(*root.value.real.as_integer_ratio()))
    assert error < sympy.Rational(*root.radius.as_integer_ratio())
    assert root.radius < 1e-15


def test_lonely_root_is_named():
    with pytest.raises(InputError, match="1 - 2"):
        polynomial_from_roots(["1-2j", -1], "s")
    with pytest.raises(InputError, match="lacks"):
        polynomial_from_roots(["1-2j", "1-2j", "1+2j"], "s")
    p, w = sympy.symbols("p w")
    assert polynomial_from_roots([p + sympy.I * w, p - sympy.I * w], "s") == polynomial(
        "s**2 - 2*p*s + p**2 + w**2", "s"
    )


@given(st.integers(0, 5).flatmap(spectra))
def test_split_of_planted_spectrum(planted):
    poly = polynomial_from_roots(planted, "q")
    size = [sympy.expand(root * root.conjugate()) for root in planted]
    if 1 in size:
        with pytest.raises(UnitCircleError):
            split_at_unit_circle(poly)
        return
    inside, outside = split_at_unit_circle(3 * poly)
    sized = list(zip(planted, size, strict=True))
    assert inside == polynomial_from_roots([root for root, m in sized if m < 1], "q")
    assert outside == polynomial_from_roots([root for root, m in sized if m > 1], "q")


@pytest.mark.parametrize(
    ("text", "error"),
    [("q - 1", UnitCircleError), ("q + 1", UnitCircleError), ("q**2 + 3*q/2 + 1", UnitCircleError),
     ("q**10 + q**9 - q**7 - q**6 - q**5 - q**4 - q**3 + q + 1", UnitCircleError),  # Lehmer, Salem
     ("q**2 - 3*q + 1", NoSolutionError), ("q**3 - 3*q + 1", NoSolutionError),
     ("(q - 1/2)*(q**4 - 5*q**2 + 1)", NoSolutionError), ("0", InputError), ("q - a", InputError)],
)  # fmt: skip
def test_what_cannot_be_split(text, error):
    with pytest.raises(error):
        split_at_unit_circle(polynomial(text, "q"))


def test_a_root_next_to_the_circle_needs_no_tolerance():
    near = polynomial([10**60, -(10**60) - 1], "q")
    inside, outside = split_at_unit_circle(near * polynomial([10**60, -(10**60) + 1], "q"))
    assert (inside.degree(), outside.degree()) == (1, 1)
    assert outside == monic(near)


def test_what_cancels_is_zero():
    assert polynomial("a - a + 0*s", "s").is_zero and polynomial("a*s - s*a", "s").is_zero
