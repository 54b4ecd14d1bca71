"""Tests of stability, intervals, regions of parameters."""

import pytest
import sympy

import compensator_theory as ct
from compensator_theory.roots import hurwitz_determinants, reflection_coefficients
from tests.support.exercises import equal


def intervals(solution):
    return [(cell.lower, cell.upper) for cell in solution.intervals]


def test_routh_for_a_cubic():
    """When is s^3 + a s^2 + b s + c stable?"""
    assert set(ct.stability_conditions("s**3 + a*s**2 + b*s + c")) == {
        *sympy.sympify("a, c, a*b - c")
    }


def test_hurwitz_determinants_of_a_quartic():
    """The third Hurwitz determinant of s^4 + a s^3 + b s^2 + c s + d."""
    result = hurwitz_determinants("s**4 + a*s**3 + b*s**2 + c*s + d", variable="s")
    assert equal(result[2], "a*b*c - c**2 - a**2*d")


def test_roots_in_the_right_half_plane():
    """How many roots of s^5 + 2 s^4 + 3 s^3 + 6 s^2 + 5 s + 3 are unstable?"""
    poly = "s**5 + 2*s**4 + 3*s**3 + 6*s**2 + 5*s + 3"
    roots = sympy.Poly(poly).nroots(n=50)
    counts = ct.count_roots(poly, time="continuous")
    assert counts.unstable == sum(bool(sympy.re(root) > 0) for root in roots) == 2
    assert counts.boundary == 0


def test_row_of_zeros():
    """Count the roots of s^6 + 2 s^5 + 8 s^4 + 12 s^3 + 20 s^2 + 16 s + 16."""
    counts = ct.count_roots(
        "s**6 + 2*s**5 + 8*s**4 + 12*s**3 + 20*s**2 + 16*s + 16", time="continuous"
    )
    # (s^2 + 2)(s^2 + 4)(s^2 + 2 s + 2)
    assert (counts.stable, counts.boundary, counts.unstable) == (2, 4, 0)


def test_triangle_of_jury():
    """When is z^2 + a z + b stable?"""
    conditions = ct.stability_conditions("z**2 + a*z + b")
    assert set(conditions) == {*sympy.sympify("1 - b, 1 + a + b, 1 - a + b")}


def test_reflection_coefficients_of_an_autoregression():
    """The absolute reflection coefficients of z^2 + z + 1/3."""
    coefficients = reflection_coefficients("z**2 + z + 1/3")
    assert [abs(c) for c in coefficients] == [
        sympy.Rational(1, 3),
        sympy.Rational(3, 4),
    ]  # b, a/(1 + b)


@pytest.mark.parametrize(
    ("poly", "stable"),
    [("z**3 - z/2 + 1/4", True), ("z**3 + z**2 + z + 1", False), ("2*z**2 - 3*z + 2", False)],
)
def test_schur_stability(poly, stable):
    """Are all roots inside the unit circle?"""
    roots = sympy.Poly(poly).nroots(n=50)
    # |z| < 1 for the first; roots -1, i, -i and a product 1 for the others
    assert ct.decide_stability(poly, time="discrete").is_stable is stable
    assert all(abs(root) < 1 - sympy.Float(10) ** -9 for root in roots) is stable


def test_gain_of_an_integrator_and_two_lags():
    """For which k is k/(s (s + p)(s + q)) stable under unity feedback, p = 2, q = 5?"""
    assert intervals(ct.stabilising_gains("1/(s*(s + 2)*(s + 5))", feedback=-1)) == [(0, 2 * 5 * 7)]


def test_gain_with_a_parameter():
    """For which k, in terms of a, is k/(s (s + 1)(s + a)) stable under unity feedback?"""
    gains = ct.stabilising_gains("1/(s*(s + 1)*(s + a))", feedback=-1, variable="s")
    for a, top in ((1, 2), (3, 12), ("1/2", "3/4")):  # a (a + 1)
        low, high = (
            sympy.Rational(top) * sympy.Rational(99, 100),
            sympy.Rational(top) * sympy.Rational(101, 100),
        )
        assert (a, low) in gains
        assert (a, high) not in gains
    assert ("-1", 1) not in gains


def test_conditional_stability():
    """For which k is k (s + 2)^2/s^3 stable under unity feedback?"""
    gains = ct.stabilising_gains("(s + 2)**2/s**3", feedback=-1)
    assert intervals(gains) == [(1, sympy.oo)]  # s^3 + k s^2 + 4 k s + 4 k: 4 k^2 > 4 k


def test_integrator_with_one_step_delay():
    """For which k is k/(z (z - 1)) stable under unity feedback?"""
    assert intervals(ct.stabilising_gains("1/(z*(z - 1))", feedback=-1)) == [
        (0, 1)
    ]  # product of roots k


def test_degree_of_stability():
    """For which k have all roots of s^2 + 4 s + k real parts below -1?"""
    result = ct.stability_intervals("(s - 1)**2 + 4*(s - 1) + k", "k")
    assert intervals(result) == [(3, sympy.oo)]  # s^2 + 2 s + k - 3


@pytest.mark.parametrize(("last", "stable"), [("39/10", True), (4, False)])
def test_kharitonov_for_a_cubic(last, stable):
    """Are all s^3 + [2, 3] s^2 + [2, 5] s + [1, c] Hurwitz?"""
    decision = ct.decide_interval_stability([1, (2, 3), (2, 5), (1, last)])
    assert decision.is_stable is stable  # the worst: 2 * 2 > c


def test_all_pi_controllers():
    """All PI controllers k_p + k_i/s that stabilise 1/(s + 1)^3."""
    region = ct.stability_region("s*(s + 1)**3 + k_p*s + k_i", "k_p", "k_i")
    for k_p in range(8):
        limit = sympy.Rational((8 - k_p) * (1 + k_p), 9)  # Routh
        assert (k_p, limit * sympy.Rational(99, 100)) in region
        assert (k_p, limit) not in region
        assert (k_p, 0) not in region
    assert (8, "1/1000") not in region


def test_all_pid_controllers_of_a_double_integrator():
    """All PID controllers that stabilise 1/s^2."""
    region = ct.stability_region("s**3 + k_d*s**2 + k_p*s + k_i", "k_d", "k_p", "k_i")
    for point in ((1, 2, 1), (1, 2, "5/2"), (-1, 2, 1), (3, "1/2", "7/5"), (3, "1/2", "8/5")):
        k_d, k_p, k_i = map(sympy.Rational, point)
        assert (point in region) is bool(k_d > 0 and k_i > 0 and k_d * k_p > k_i)


def test_leading_coefficient_may_vanish():
    """Is a s^2 + b s + 1 stable at a = 0, b = 1?"""
    assert (0, 1) in ct.stability_region("a*s**2 + b*s + 1", "a", "b")  # it is s + 1
