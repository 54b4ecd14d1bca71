"""Sampling: holds, Tustin's rule, matched poles and zeros, sampling zeros."""

import sympy
from sympy import Rational, exp, log, pi

from compensator_theory import is_controllable
from compensator_theory.sampling import (
    first_order_hold,
    matched,
    sampling_zero_polynomial,
    tustin,
    zero_order_hold,
)
from tests.support.exercises import equal

z, h = sympy.symbols("z h")


def with_exponentials(sampled):
    """The sampled transfer function with its exponentials written out."""
    return sampled.transfer_function.as_expr().subs(sampled.exponentials)


def test_sampled_integrator():
    """1/s with a zero-order hold."""
    assert equal(zero_order_hold("1/s").transfer_function, "h/(z - 1)")


def test_sampled_double_integrator():
    """1/s^2 with a zero-order hold."""
    assert equal(zero_order_hold("1/s**2").transfer_function, "h**2*(z + 1)/(2*(z - 1)**2)")


def test_sampled_lag():
    """1/(s + a) with a zero-order hold."""
    result = with_exponentials(zero_order_hold("1/(s + a)"))
    a = sympy.Symbol("a")
    assert equal(result, (1 - exp(-a * h)) / (a * (z - exp(-a * h))))


def test_sampled_double_pole():
    """1/(s + 1)^2 with a zero-order hold."""
    result, x = with_exponentials(zero_order_hold("1/(s + 1)**2")), exp(-h)
    # the step response 1 - (1 + t) e^-t at h and 2 h
    assert equal(result, ((1 - x - h * x) * z + x * (x - 1 + h)) / (z - x) ** 2)


def test_sampled_oscillator():
    """1/(s^2 + 1) with a zero-order hold and a step of a quarter of the period."""
    assert equal(zero_order_hold("1/(s**2 + 1)", pi / 2).transfer_function, "(z + 1)/(z**2 + 1)")


def test_pathological_step():
    """Half a period of s^2 + 1 as the step: is the sampled plant controllable?"""
    sampled = zero_order_hold("1/(s**2 + 1)", pi).realisation
    assert is_controllable(sampled.A, sampled.B) is False  # z = -1 twice, one of them hidden
    assert equal(sampled.transfer_function().reduced(), "2/(z + 1)")


def test_irrational_step():
    """1/((s + 1)(s + 2)) with a zero-order hold and the step log(3)."""
    sampled = zero_order_hold("1/((s + 1)*(s + 2))", log(3)).transfer_function
    # (1 - 1/3)/(z - 1/3) - (1 - 1/9)/2/(z - 1/9)
    assert equal(
        sampled, Rational(2, 3) / (z - Rational(1, 3)) - Rational(4, 9) / (z - Rational(1, 9))
    )


def test_first_order_hold_of_a_double_integrator():
    """1/s^2 with a first-order hold."""
    result = first_order_hold("1/s**2").transfer_function
    assert equal(result, "h**2*(z**2 + 4*z + 1)/(6*(z - 1)**2)")  # the cubes of the ramp


def test_tustin_of_a_lag():
    """Tustin's rule for 1/(s + a)."""
    sampled = tustin("1/(s + a)").transfer_function
    assert equal(sampled, "h*(z + 1)/((2 + a*h)*z - (2 - a*h))")


def test_tustin_of_a_pi_controller():
    """Tustin's rule for k_p + k_i/s: the trapezoidal rule."""
    sampled = tustin("k_p + k_i/s", variable="s").transfer_function
    assert equal(sampled, "k_p + k_i*h*(z + 1)/(2*(z - 1))")


def test_matched_lead():
    """Match the pole and the zero of (s + 1)/(s + 3) with the step log(2)."""
    sampled = matched("(s + 1)/(s + 3)", log(2)).transfer_function
    # zero 1/2, pole 1/8, gain at rest 1/3
    assert equal(
        sampled,
        Rational(1, 3)
        * (1 - Rational(1, 8))
        / (1 - Rational(1, 2))
        * (z - Rational(1, 2))
        / (z - Rational(1, 8)),
    )


def test_sampling_zeros_of_euler_and_frobenius():
    """The limiting sampling zeros of an excess of four poles."""
    # Eulerian numbers 1, 11, 11, 1
    assert equal(sampling_zero_polynomial(4), "z**3 + 11*z**2 + 11*z + 1")


def test_zeros_of_a_sampled_triple_integrator():
    """The zeros of 1/s^3 with a zero-order hold, for any step."""
    sampled = zero_order_hold("1/s**3").transfer_function
    assert equal(sampled, "h**3*(z**2 + 4*z + 1)/(6*(z - 1)**3)")
