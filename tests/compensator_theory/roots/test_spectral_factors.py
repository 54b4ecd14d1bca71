"""Spectral factors and enclosures: residuals, planted roots, and NumPy's roots."""

import numpy as np
import pytest
import sympy
from hypothesis import assume, example, given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import NoSolutionError, UnitCircleError
from compensator_theory.results import Enclosure
from compensator_theory.roots import (
    enclose_split_at_unit_circle,
    monic_reciprocal_polynomial,
    split_at_unit_circle,
)
from compensator_theory.roots._spectral_factors import factor_spectrum
from compensator_theory.strategies import polynomials, rationals

ONE_TENTH = sympy.Rational(1, 10)


@given(polynomials("z", max_degree=4), polynomials("z", max_degree=4), rationals())
def test_the_product_is_the_spectrum(N, D, r):
    try:
        factor = ct.spectral_factor(N, D, abs(r), time="discrete")
    except UnitCircleError:
        assume(False)
    assert factor.degree == max(N.degree(), D.degree()) == factor.enclosure.degree
    assert all(0 in ball for ball in factor.residual)
    assert max(factor.enclosure.radius, factor.constant.radius) < ONE_TENTH**20
    assert np.all(np.abs(np.roots([float(c) for c in factor.enclosure.coefficients])) < 1 + 1e-9)
    if factor.is_rational:
        chi, z = factor.polynomial, N.gen
        spectrum = sum(
            weight * p.as_expr() * p.as_expr().subs(z, 1 / z) for p, weight in ((N, 1), (D, abs(r)))
        )
        product = factor.constant.centre * chi.as_expr() * chi.as_expr().subs(z, 1 / z)
        assert sympy.cancel(product - spectrum) == 0
        assert ct.decide_stability(chi, time="discrete").by_roots


@given(polynomials("z", max_degree=5))
@example(ct.polynomial("(z**2 + 1)*(z**2 - 2*z - 2)"))
def test_without_weight_it_reflects_the_roots_outside(N):
    try:
        inside, outside = split_at_unit_circle(N)
    except UnitCircleError:
        with pytest.raises(UnitCircleError):
            ct.spectral_factor(N, time="discrete")
        return
    except NoSolutionError:
        try:
            assert not ct.spectral_factor(N, time="discrete").is_rational
        except UnitCircleError:  # of another factor: both refusals are true
            assert any(abs(abs(complex(r.value)) - 1) < 1e-12 for r in ct.certified_roots(N))
        return
    factor = ct.spectral_factor(N, time="discrete")
    assert factor.polynomial == inside * monic_reciprocal_polynomial(outside)
    # B'PB = H^2 times the squares of the nonminimum-phase zeros.
    assert factor.constant.centre == (N.LC() * outside.TC()) ** 2
    assert factor.constant.radius == 0


@given(polynomials("z", min_degree=1, max_degree=6), st.sampled_from([5, 40]))
def test_enclosed_splits(N, digits):
    try:
        inside, outside = enclose_split_at_unit_circle(N, digits=digits)
    except UnitCircleError:
        assume(False)
    assert max(inside.radius, outside.radius) <= ONE_TENTH**digits
    difference = inside.centre * outside.centre - N.monic()
    size = 1 + max(abs(c) for p in (inside, outside) for c in p.centre.all_coeffs())
    assert all(abs(c) <= ONE_TENTH**digits * 30 * size for c in difference.all_coeffs())
    try:
        exact = split_at_unit_circle(N)
    except NoSolutionError:
        return
    assert exact[0] in inside and exact[1] in outside and inside.radius == 0


def test_an_irrational_split_is_where_the_radicals_are():
    inside, outside = enclose_split_at_unit_circle(ct.polynomial("q**2 - 3*q + 1"), digits=50)
    for ball, root in ((inside, (3 - sympy.sqrt(5)) / 2), (outside, (3 + sympy.sqrt(5)) / 2)):
        assert abs(sympy.N(ball.coefficients[1].centre + root, 80)) < ONE_TENTH**49
    assert ct.polynomial("q - 0.38") not in inside


def test_they_print():
    factor = ct.spectral_factor("(z - 2)*(z - 1/2)", "z**2", 3, time="discrete")
    assert str(factor).startswith("χ = z**2 - 0.507179")
    for item in (
        factor,
        ct.spectral_factor("z - 2", time="discrete"),
        factor.enclosure,
        factor.constant,
    ):
        assert item._repr_latex_().startswith(r"$\displaystyle")
    assert repr(Enclosure(sympy.Rational(1, 3), sympy.Integer(0))) == "1/3"
    assert repr(Enclosure(sympy.Integer(0), sympy.Rational(1, 1000))) == "0.000 ± 1.0e-3"


def test_bad_input():
    with pytest.raises(NoSolutionError):
        ct.spectral_factor(ct.polynomial(0, "z"), time="discrete")
    for arguments in (("z - 1",), ("z**2 + 1", "z**2 + 1", 2)):
        with pytest.raises(UnitCircleError):
            ct.spectral_factor(*arguments, time="discrete")
    for arguments in (("z - a",), ("z", "z - 2", -1), ("z", "s"), ("z", "z", "a"), ("1/z",),
                      ("z", "z", float("nan"))):  # fmt: skip
        with pytest.raises(ct.InputError):
            ct.spectral_factor(*arguments, time="discrete")
    for digits in (0, -1, 2.5, True, 10**6):
        with pytest.raises(ct.InputError):
            ct.spectral_factor("z - 2", digits=digits, time="discrete")
        with pytest.raises(ct.InputError):
            enclose_split_at_unit_circle(ct.polynomial("z - 2"), digits=digits)
    for bad, degree in (("z**2 - 2", 2), ("z**2 - 3*z + 1", 0)):
        with pytest.raises(ct.InputError):
            factor_spectrum(ct.polynomial(bad), degree, "discrete")
    for bad in (ct.polynomial(0, "z"), ct.polynomial("z - a", "z"), "1/z"):
        with pytest.raises(ct.InputError):
            enclose_split_at_unit_circle(bad)
    with pytest.raises(ct.InputError):
        assert "a" in Enclosure(sympy.Integer(0), sympy.Integer(1))
    with pytest.raises(ct.InputError):
        assert 3 in enclose_split_at_unit_circle(ct.polynomial("z - 2"))[0]
