"""Intercalation and observer-based compensators."""

import pytest
import sympy

import compensator_theory as ct
from compensator_theory.loops import target_characteristic_polynomial
from compensator_theory.observers import (
    count_observer_forms,
    is_lqg_suboptimal,
    pair_is_observer_based,
    realisation_is_observer_based,
    transfer_function_is_observer_based,
    youla_forms,
)
from tests.support.exercises import equal

s, q = sympy.symbols("s q")
PLANT = [[-1, 4], [0, -3]], [[0], [1]], [[1, 0]]  # of Example 7.1


def test_intercalated_transfer_function():
    """The intercalated transfer function of (q - 1/2)/((q - 1)(q - 2)) with u = -3/q y."""
    result = ct.intercalated_transfer_function(
        ct.standard_problem("(q - 1/2)/((q - 1)*(q - 2))"), -3, "q"
    )
    # N q^n_c/(D D_c - N N_c), n_c = 1
    assert equal(result, "(q - 1/2)*q/((q - 1)*(q - 2)*q + 3*(q - 1/2))")


def test_positive_feedback():
    """The closed-loop polynomial of 1/(q - 2) with u = -(3/2) y."""
    assert equal(
        ct.closed_loop_polynomial(ct.standard_problem("1/(q - 2)"), "-3/2", "1"), "q - 1/2"
    )


def test_target_fixes_the_loop():
    """Which loop of 2 (q - 1/2)/((q - 1)(q - 2)), n_c = 3, has the intercalated map 2/(q - 1/4)?"""
    plant = ct.standard_problem("2*(q - 1/2)/((q - 1)*(q - 2))")
    polynomial = target_characteristic_polynomial(plant, 3, "2/(q - 1/4)")
    # N q^3/D~ = 2/(q - 1/4): D~ = (q - 1/2) q^3 (q - 1/4)
    assert equal(polynomial, "(q - 1/2)*q**3*(q - 1/4)")


def test_high_authority_target_of_a_nonminimum_phase_plant():
    """The target of high-authority LQG for (q - 3)/(q (q + 1/2))."""
    result = ct.high_authority_target(ct.standard_problem("(q - 3)/(q*(q + 1/2))"))
    # regulator and estimator each (q - 1/3) q: N q^2/((q - 1/3) q)^2
    assert equal(result.transfer_function, "(q - 3)/(q - 1/3)**2")


def test_design_and_recognise():
    """Which of the observer forms of a compensator is the design that made it?"""
    compensator = ct.observer_based_compensator(PLANT, [-5, -4], [-2, -6], variable="s")
    forms = ct.observer_forms(PLANT, compensator.compensator, variable="s")
    assert len(forms.forms) == 6  # two of four distinct closed-loop poles for the regulator
    assert [compensator.K, compensator.F] in [[form.K, form.F] for form in forms.forms]


@pytest.mark.parametrize(
    ("loop", "n", "number"),
    [
        ("(s + 1)*(s + 2)*(s + 3)*(s + 4)*(s + 5)*(s + 6)", 3, 20),  # 6 over 3
        ("(s**2 + 2*s + 2)*(s**2 + 2*s + 5)", 2, 2),  # a pair stays together
        ("(s**2 + 2*s + 2)*(s**2 + 2*s + 5)", 1, 0),
        ("(s + 1)**4", 2, 1),
        ("(s + 1)**2*(s**2 + 1)", 2, 2),
    ],
)
def test_number_of_forms(loop, n, number):
    """How many real regulators of order n divide the closed loop?"""
    assert count_observer_forms(loop, n) == number


def test_odd_plant_without_a_real_closed_loop_pole():
    """Is a compensator of order 3 observer-based whose loop has three pairs of poles?"""
    # D D_c + N N_c = (s^2 + 2 s + 2)(s^2 + 2 s + 5)(s^2 + 4 s + 5) for 1/s^3
    target = sympy.Poly(sympy.expand(sympy.sympify("(s**2+2*s+2)*(s**2+2*s+5)*(s**2+4*s+5)")), s)
    D_c, N_c = sympy.div(target, sympy.Poly(s**3, s))
    result = pair_is_observer_based("1/s**3", (N_c, D_c), feedback=-1)
    assert result.answer is False
    assert equal(result.characteristic_polynomial, target)


def test_transfer_function_of_low_order():
    """Is a compensator of order 1 the transfer function of an observer of order 3?"""
    # 1/s^3 with (3 s^2 + 3 s + 1)... a common factor of degree 2 is free
    result = transfer_function_is_observer_based(
        "1/(s**3 + 3*s**2 + 3*s + 1)", "1/(s + 1)", feedback=-1
    )
    assert result.answer is True


def test_hidden_mode_of_a_compensator():
    """Is a compensator observer-based that has a mode neither reached nor seen?"""
    plant = [[0, 1], [-2, -3]], [[0], [1]], [[1, 0]]
    answer = realisation_is_observer_based(
        plant, ([[-6, 0], [0, -7]], [[1], [0]], [[12, 0]]), variable="s"
    )
    assert (
        answer.answer is False
    )  # -7 is a mode of the loop once, of A + B K and A - F C it would be twice


def test_optimal_for_some_weights():
    """Is a compensator with an observer form suboptimal for every LQG problem?"""
    answer = is_lqg_suboptimal(
        "4/(s**2 + 4*s + 3)", "(33*s/4 + 93/4)/(s**2 + 13*s + 49)", feedback=-1
    )
    assert answer.answer is False  # it is optimal for the cost |u - K x|^2 of any of its forms


def test_youla_form_of_a_large_compensator():
    """Write a compensator of order 2 of 1/(s - 1) as a regulator, an observer and a parameter."""
    G_c = ct.realisation("-24/(s**2 + 7*s + 18)")
    forms = youla_forms("1/(s - 1)", G_c)
    # (s - 1)(s^2 + 7 s + 18) + 24 = (s + 1)(s + 2)(s + 3): ordered pairs of three poles
    assert len(forms) == 6
    assert equal(
        sympy.expand(sympy.sympify("(s - 1)*(s**2 + 7*s + 18) + 24")), "(s + 1)*(s + 2)*(s + 3)"
    )
