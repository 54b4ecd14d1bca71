"""How often an answer has no rational form: as often as a square root is irrational."""

import math
from collections import Counter

import numpy as np
import pytest
import sympy
from sympy import Rational

import compensator_theory as exact

R_2 = sympy.Symbol("R_2")
WEIGHTS = [Rational(k, 4) for k in range(33)]


def is_square(number):
    number = Rational(number)
    return number >= 0 and all(math.isqrt(x) ** 2 == x for x in (int(number.p), int(number.q)))


@pytest.mark.costly
def test_spectral_factors_of_weights():
    """(z - 2)(1/z - 2) + r has the root of x^2 - (5 + r)/2 x + 1; in s the root is sqrt(4 + r)."""
    counts = Counter()
    for r in WEIGHTS:
        inside = exact.spectral_factor("z - 2", "z", r, time="discrete")
        left = exact.spectral_factor("s - 2", "1", r, time="continuous")
        for name, result, radicand in (
            ("circle", inside, (5 + r) ** 2 / 4 - 4),
            ("axis", left, 4 + r),
        ):
            assert result.is_rational is is_square(radicand) is (result.polynomial is not None)
            assert all(0 in c for c in result.residual)
            counts[name] += result.polynomial is None
    assert counts == {"circle": 31, "axis": 30}


def noise(k):
    """Integers whose squares add up to k."""
    parts = []
    while k:
        parts.append(math.isqrt(k))
        k -= parts[-1] ** 2
    return parts


@pytest.mark.costly
def test_lqg_in_continuous_time():
    """An integrator with process noise of intensity k: the pole of the estimator is -sqrt(k)."""
    counts = Counter()
    for k in range(1, 17):
        parts = noise(k)
        plant = exact.StandardProblem(
            A=[[0]], B=[[1]], C=[[1]], D_1=[[*parts, 0]], D_0=None,
            D_2=[[*(0 for _ in parts), 1]], E_1=[[2], [0]], E_2=[[0], [1]], E_0=None, variable="s",
        )  # fmt: skip
        result, poles = exact.lqg_controller(plant), exact.lqg_poles(plant)
        answers = [result.polynomial, poles.polynomial, result.estimator.factor.polynomial]
        assert {answer is not None for answer in answers} == {is_square(k)}
        assert result.is_rational is is_square(k)
        root = sympy.sqrt(k)
        assert sympy.Matrix([[-root]]) == result.estimator.K
        assert result.realisation == tuple(sympy.Matrix([[x]]) for x in (-2 - root, root, -2))
        assert result.compensator.numerator.as_expr() == -2 * root
        assert abs(float(result.estimator.K_enclosure[0][0]) + math.sqrt(k)) < 1e-12
        counts[result.polynomial is None] += 1
    assert counts == {True: 12, False: 4}


@pytest.mark.costly
def test_high_authority_lqg_in_discrete_time():
    """N = q^2 - 3 q + c splits where 9 - 4 c is a square, or no root is outside of the circle."""
    counts = Counter()
    for c in (Rational(k, 4) for k in range(-8, 13)):
        if c in (-4, 2):
            continue  # a zero on the unit circle
        plant = exact.standard_problem(f"(q**2 - 3*q + {c})/(q**3 - 5)")
        result, target = exact.lqg_controller(plant), exact.high_authority_target(plant)
        moduli = abs(np.roots([1, -3, float(c)]))
        splits = bool(is_square(9 - 4 * c) or min(moduli) > 1)
        answers = [result.polynomial, target.transfer_function, exact.lqg_poles(plant).polynomial]
        assert {answer is not None for answer in answers} == {splits}
        assert result.is_exact and result.is_rational is splits
        if not splits:
            assert result.regulator.K.free_symbols == set() and result.regulator.field.degree == 2
        counts[result.polynomial is None] += 1
    assert counts == {True: 13, False: 7}


@pytest.mark.costly
def test_closed_forms_in_discrete_time():
    """Up to order 2 they are the certified polynomials, and above it there is none."""
    for N, D in (
        ("1", "z - 2"), ("z - 3", "z - 2"), ("z - 2", "(z - 1/2)*(z - 1/3)"), ("z + 3", "z**2"),
        ("1", "z**2 - 3*z + 1"), ("3*z**2 + z - 1", "z**2 + z + 4"), ("2", "(z + 2)*(z - 3)"),
    ):  # fmt: skip
        locus = exact.regulator_locus(N, D)
        for weight in (Rational(1, 9), 1, 7):
            result = locus.at(weight).enclosure.coefficients
            for form, ball in zip(locus.closed_form, result, strict=True):
                assert abs(form.subs(R_2, weight).evalf(40) - ball.centre) < 1e-25
    for above in (("s + 1", "s**3"), ("z + 2", "z**3")):
        assert exact.regulator_locus(*above).closed_form is None
