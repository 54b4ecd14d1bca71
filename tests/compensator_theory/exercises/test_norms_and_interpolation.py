"""H-infinity norms, positive realness, Nevanlinna and Pick, model matching."""

import pytest
import sympy
from sympy import Rational, sqrt

from compensator_theory import decide_bounded_real, decide_positive_real, h_infinity_norm
from compensator_theory.errors import CompensatorError
from compensator_theory.interpolation import nevanlinna_pick
from tests.support.exercises import equal

s = sympy.Symbol("s")


def least(solution):
    """The square of the least bound, a root of the polynomial that is found or a number."""
    return sympy.sympify(solution.least_squared)


def test_norm_of_a_lag():
    """The H-infinity norm of 3/(s + 2)."""
    assert h_infinity_norm("3/(s + 2)").value == Rational(3, 2)  # at rest


@pytest.mark.parametrize(
    ("damping", "peak"), [("1/2", 2 / sqrt(3)), ("1/4", 8 / sqrt(15)), ("4/5", 1)]
)
def test_resonance(damping, peak):
    """The resonant peak of 1/(s^2 + 2 d s + 1)."""
    norm = h_infinity_norm(f"1/(s**2 + 2*({damping})*s + 1)").value
    assert equal(norm, peak)  # 1/(2 d sqrt(1 - d^2)) where 2 d^2 < 1, else at rest


def test_norm_of_an_all_pass():
    """The H-infinity norm of (s - 1)(s - 3)/((s + 1)(s + 3))."""
    assert h_infinity_norm("(s - 1)*(s - 3)/((s + 1)*(s + 3))").value == 1


def test_norm_of_a_row():
    """The H-infinity norm of (1/(s + 1), 2/(s + 1))."""
    assert h_infinity_norm([["1/(s + 1)", "2/(s + 1)"]]).value == sqrt(5)


def test_norm_of_a_discrete_lag():
    """The H-infinity norm of 1/(z + 1/2)."""
    assert h_infinity_norm("1/(z + 1/2)").value == 2  # at z = -1


def test_norm_of_an_unstable_plant():
    """Has 1/(s - 1) an H-infinity norm?"""
    with pytest.raises(CompensatorError):
        h_infinity_norm("1/(s - 1)")


def test_bounded_real():
    """Is k/(s + 1) a contraction for k = 1 and for k = 1001/1000?"""
    assert decide_bounded_real("1/(s + 1)").holds
    assert not decide_bounded_real("(1001/1000)/(s + 1)").holds


@pytest.mark.parametrize(("zero", "passive"), [(2, True), ("21/10", False)])
def test_positive_real_lag(zero, passive):
    """Is (s + a)/(s^2 + 2 s + 5) positive real?"""
    # the real part has the numerator 5 a + (2 - a) w^2
    assert decide_positive_real(f"(s + {zero})/(s**2 + 2*s + 5)").holds is passive


def test_lossless_circuit():
    """Is the impedance s/(s^2 + 1) of a capacitor and a coil positive real?"""
    assert decide_positive_real("s/(s**2 + 1)").holds
    assert not decide_positive_real("-s/(s**2 + 1)").holds  # a negative residue


def test_schwarz_lemma():
    """The least norm of a stable f with f(1) = 0 and f(2) = 1/2."""
    interpolation = nevanlinna_pick([1, 2], [0, "1/2"])
    assert equal(least(interpolation), Rational(3, 2) ** 2)  # f = g (s - 1)/(s + 1), g(2) = 3/2
    assert not interpolation.is_feasible


def test_pick_matrix_of_two_points():
    """The least norm of a stable f with f(1) = 1 and f(2) = -1."""
    # det of [(x - 1)/2, (x + 1)/3; (x + 1)/3, (x - 1)/4]: 9 (x - 1)^2 = 8 (x + 1)^2
    assert equal(least(nevanlinna_pick([1, 2], [1, -1])), (3 + 2 * sqrt(2)) ** 2)


def test_interpolation_at_a_pair_of_points():
    """The least norm of a stable real f with f(1) = 0 and f(1 + i) = 1."""
    interpolation = nevanlinna_pick([1, "1 + j", "1 - j"], [0, 1, 1])
    # f = g (s - 1)/(s + 1), g(1 + i) = 1 - 2 i: 2 (x - 5)^2 = |x + 3 + 4 i|^2
    assert equal(least(interpolation), 25)


def test_derivative_data():
    """The least norm of a stable f with f(1) = 0 and f'(1) = 1."""
    interpolation = nevanlinna_pick([1], [[0, 1]], 3)
    assert equal(least(interpolation), 4)  # f = g (s - 1)/(s + 1), f'(1) = g(1)/2
    f = interpolation.interpolant().as_expr()
    assert (f.subs(s, 1), sympy.diff(f, s).subs(s, 1)) == (0, 1)
    assert decide_bounded_real(interpolation.interpolant() / 3).holds


def test_sensitivity_with_an_unstable_pole_and_zero():
    """The least norm of the sensitivity of a plant with the zero 2 and the pole 1."""
    interpolation = nevanlinna_pick([2, 1], [1, 0])  # S = 1 at zeros, 0 at poles
    assert equal(least(interpolation), 3**2)  # |z + p|/|z - p|


def test_model_matching_with_one_zero():
    """The least norm of 1/(s + 2) - (s - 1)/(s + 1) Q over stable Q."""
    assert equal(least(nevanlinna_pick([1], ["1/3"])), Rational(1, 9))  # what Q cannot change


def test_model_matching_with_two_zeros():
    """The least norm of 1/(s + 2) - (s - 1)(s - 2)/(s + 3)^2 Q over stable Q."""
    interpolation = nevanlinna_pick([1, 2], ["1/3", "1/4"])
    # det of the Pick matrix: x^2 - 11 x/48 + 1/144 = 0
    assert equal(least(interpolation), (11 + sqrt(57)) / 96)


def test_discrete_interpolation():
    """The least norm of an f analytic outside the unit circle with f(2) = 0 and f(4) = 1."""
    # f = g (z - 2)/(2 z - 1), which is 2/7 at 4
    assert equal(least(nevanlinna_pick([2, 4], [0, 1], variable="z")), Rational(7, 2) ** 2)
