"""Conditions and gains of stability, root loci, dead time, norms."""

import numpy as np
import pytest
import sympy as sp
from numpy.polynomial import Polynomial

import compensator_theory as ct
from tests.support.world import case

oo, R = sp.oo, sp.Rational
X = Polynomial([0, 1])


def intervals(solution):
    return [(cell.lower, cell.upper) for cell in solution.intervals]


GAINS = [
    # Each by Routh's or Jury's table, by hand.
    case("textbook-three-lags", "1/(s*(s + 1)*(s + 2))", [(0, 6)]),
    case("NPTEL-Jury", "(0.368*z + 0.264)/(z**2 - 1.368*z + 0.368)", [(0, R(79, 33))]),
    case("manual-4.6.3.9", "(s + 3)/(s**2*(s + 2)*(s + 50))", []),
    case("tutorsglobe", "1/(s*(s**2 + 4*s + 8))", [(0, 32)]),
    case("brainmass", "1/((s + 1)*(s + 2)*(s + 3))", [(-6, 60)]),
    case("GATE-a", "1/(s*(s + 3)*(s + 10))", [(0, 390)]),
    case("GATE-b", "(s + 1)/(s**3 + 2*s**2 + 3*s + 1)", [(-1, oo)]),
    case("Routh-calculator", "1/(s**4 + 2*s**3 + 4*s**2 + 2*s)", [(0, 3)]),
    case("exam-unstable", "1/((s - 1)*(s + 2)*(s + 4))", [(8, 18)]),
    case("Youla-lag", "1/(s - 1)", [(1, oo)]),
    case("pc-87", "1e15/(1e1*s**2 + 1.01e7*s + 1e11)", [(R(-1, 10000), oo)]),
    case("numpy-Polynomial-lists", (Polynomial([1]), X * (X + 1) * (X + 2)), [(0, 6)]),
]


@pytest.mark.parametrize(("plant", "right"), GAINS)
def test_stabilising_gains(plant, right):
    """Negative feedback; of 4.6.3.9 a manual prints 4298.67, an arithmetic slip: Routh has none."""
    text = plant if isinstance(plant, str) else ""
    try:
        gains = ct.stabilising_gains(plant, feedback=-1, variable="z" if "z" in text else "s")
    except ct.CompensatorError:
        assert not text  # to refuse an ambiguous polynomial is right too
        return
    assert intervals(gains) == right


# The plant's own letter is the one that our gain has by default.
GAIN_K = [
    case("newcomer-S1", ("k/(s - 1)",), {"k": 2}, [(R(1, 2), oo)]),
    case("student-k", ("k/(s*(s + 1)*(s + 2))",), {"k": 2}, [(0, 3)]),
    case("student-k-compensator", ("1/(s*(s + 1)*(s + 2))", "k"), {"k": 2}, [(0, 3)]),
    case("student-zero", ("(s + k)/(s**2*(s + 2))",), {"k": 1}, [(0, oo)]),
    case("student-lag", ("k/(s*(tau*s + 1))",), {"k": 2, "tau": 1}, [(0, oo)]),
    case("student-discrete", ("k*(z + 2)/(z**2 - z)",), {"k": 1}, [(0, R(1, 2))]),
]


@pytest.mark.parametrize(("loop", "values", "right"), GAIN_K)
def test_the_gain_is_no_letter_of_the_plant(loop, values, right):
    """By Routh and Jury with numbers put in; a refusal or any other letter is right."""
    try:
        gains = ct.stabilising_gains(*loop, feedback=-1)
    except ct.CompensatorError:
        return
    letter = getattr(gains, "parameter", None)
    assert letter is None or str(letter) not in values
    spare = {str(v) for v in sp.sympify(gains.polynomial.as_expr()).free_symbols} - {
        *values,
        "s",
        "z",
    }
    assert spare  # the gain has a letter of its own
    inside = [R(a) + R(1, 100) if b == oo else (a + b) / 2 for a, b in right]
    variable = "z" if "z" in loop[0] else "s"
    for number in inside:
        poly = gains.polynomial.as_expr().subs(values).subs(dict.fromkeys(spare, number))
        assert ct.decide_stability(poly, variable).is_stable


@pytest.mark.parametrize(("loop", "values", "right"), GAIN_K)
def test_with_a_letter_that_is_given(loop, values, right):
    """The same, gain='g': where the numbers are put in, the interval is Routh's."""
    numbers = [sp.sympify(part).subs(values) for part in loop]
    assert intervals(ct.stabilising_gains(*numbers, feedback=-1, gain="g")) == right


CONDITIONS = [
    case(
        "SymPy-27717", "a*s**2 + b*s + c", [{"a": 1, "b": 2, "c": 3}], [{"a": 1, "b": -2, "c": 3}]
    ),
    case(
        "SymPy-28176",
        "a*s**3 + b*s**2 + c*s + d",
        [{"a": 1, "b": 2, "c": 3, "d": 5}],
        [{"a": 1, "b": 2, "c": 3, "d": 7}],
    ),
    case(
        "SymPy-28176b",
        "s**4 + a*s**3 + b*s**2 + c*s + 1",
        [{"a": 2, "b": 4, "c": 2}],
        [{"a": 1, "b": 1, "c": 1}],
    ),
]


@pytest.mark.parametrize(("poly", "stable", "unstable"), CONDITIONS)
def test_conditions(poly, stable, unstable):
    """Lienard and Chipart; numbers on either side, whose roots NumPy finds."""
    conditions = ct.stability_conditions(poly, variable="s")
    for values, right in [(v, True) for v in stable] + [(v, False) for v in unstable]:
        roots = np.roots(
            [float(c) for c in sp.Poly(sp.sympify(poly).subs(values), sp.Symbol("s")).all_coeffs()]
        )
        assert bool(roots.real.max() < 0) is right  # the question itself
        assert all(sp.sympify(c).subs(values) > 0 for c in conditions) is right


OF_SYMBOLS = [
    case("pendulum-coefficients", lambda s, S, C: s**2 + C * s + S + 2),
    case("root-coefficient", lambda s, S, C: s**2 + sp.sqrt(sp.Symbol("a")) * s + 1),
]


@pytest.mark.parametrize("of", OF_SYMBOLS)
def test_conditions_with_functions_are_answered_or_refused(of):
    theta = sp.Symbol("theta")
    try:
        conditions = ct.stability_conditions(
            of(sp.Symbol("s"), sp.sin(theta), sp.cos(theta)), variable="s"
        )
    except ct.CompensatorError:
        return
    assert len(list(conditions)) >= 1


DELAYS = [
    # (s + a) + b exp(-s tau), b > a > 0: stable up to arccos(-a/b)/sqrt(b^2 - a^2).
    case("EE.SE-381078", ["s + 1", "2"], np.arccos(-0.5) / np.sqrt(3)),
    case("pc-628", ["s + 1", "5"], np.arccos(-0.2) / np.sqrt(24)),
    case("SymPy-24836", ["s", "1"], np.pi / 2),
]


@pytest.mark.parametrize(("coefficients", "right"), DELAYS)
def test_the_longest_dead_time(coefficients, right):
    """By hand: where the roots reach the imaginary axis first."""
    (window,) = ct.stability_delays(coefficients, "s").windows
    assert float(window[1]) == pytest.approx(right, rel=1e-12)


MARGINS = [
    case("pc-784", "2/(s*(s + 1)*(s + 2))", 3, 32.6131),
    case("pc-1105", "200/(s**3 + 21*s**2 + 20*s)", R(21, 10), None),
    case("pc-61", "1e15/(1e1*s**2 + 1.01e7*s + 1e11)", oo, 5.78),
]


@pytest.mark.parametrize(("loop", "gain", "phase"), MARGINS)
def test_margins(loop, gain, phase):
    """By hand: a second-order loop has no phase crossover, whatever float64 finds at 1e15."""
    margins = ct.stability_margins(loop, feedback=-1, variable="s")
    assert margins.is_stable and margins.gains.upper == gain
    if phase is not None:
        least = min(float(c.phase_margin) for c in margins.gain_crossovers)
        assert np.degrees(least) == pytest.approx(phase, rel=1e-3)


HIDDEN = [
    case("notch-on-resonance", ("100/((s**2 + 1)*(s + 1))", "(s**2 + 1)/(s + 5)**2"), "s"),
    case("common-factor-s", ("2*(s**2 + 1)/((s**2 + 1)*(s + 1))",), "s"),
    case("common-factor-z", ("2*(z**2 + 1)/((z**2 + 1)*z)",), "z"),
    case("common-factor-1", ("2*(z - 1)/((z - 1)*z)",), "z"),
]


@pytest.mark.parametrize(("loop", "variable"), HIDDEN)
def test_a_factor_on_the_boundary_that_cancels_stays_a_pole(loop, variable):
    """By hand: it is a root of D + N for every gain, so the loop is not stable."""
    assert not ct.stability_margins(*loop, feedback=-1, variable=variable).is_stable
    assert intervals(ct.stabilising_gains(*loop, feedback=-1, variable=variable)) == []


ILL_POSED = [
    case("ill-posed-z", "(3/5 - z)/(z - 1/2)"),
    case("ill-posed-s", "-(s + 1)/(s + 2)"),
]


@pytest.mark.parametrize("loop", ILL_POSED)
def test_an_ill_posed_loop_is_not_stable(loop):
    """1 + L is zero at infinity: u is not determined."""
    try:
        margins = ct.stability_margins(loop, feedback=-1)
    except ct.CompensatorError as error:
        assert "well posed" in str(error) or "ill" in str(error)
        return
    assert not margins.is_stable


def test_an_unstable_loop_is_said_first():
    """JL #961: 50 times a third-order lag; Routh: stable for gains below 11.8."""
    margins = ct.stability_margins(
        "50/(5*s**3 + 10.25*s**2 + 6.25*s + 1)", feedback=-1, variable="s"
    )
    assert not margins.is_stable and "not stable" in str(margins)


BREAKS = [
    case("pc-306", "1/(s*(s + 1)*(s + 2))", {-1 + 1 / np.sqrt(3): 2 * np.sqrt(3) / 9}),
    case("pc-1063", "1/(s*(s + 4))", {-2.0: 4.0}),
    case("JL-156", "(s + 1)/(s**2*(s + 9))", {-3.0: 27.0}),
    case(
        "SymPy-25251",
        "(s + 3)/(s*(s + 2))",
        {-3 + np.sqrt(3): 4 - 2 * np.sqrt(3), -3 - np.sqrt(3): 4 + 2 * np.sqrt(3)},
    ),
]


@pytest.mark.parametrize(("loop", "right"), BREAKS)
def test_where_branches_meet(loop, right):
    """By hand: the derivative of the gain, set to zero; positive gains."""
    result = {
        b.value.real: float(b.gain) if isinstance(b.gain, sp.Expr | int) else float(b.gain.value)
        for b in ct.root_locus(loop, feedback=-1).breaks
    }
    for at, gain in right.items():
        near = min(result, key=lambda value: abs(value - at))
        assert near == pytest.approx(at) and result[near] == pytest.approx(gain)


HURWITZ = [
    case("pc-1102", "(s + 5)*(s + 10) + 500*s", "s", True),
    case("forum-quartic", "s**4 + 2*s**3 + 3*s**2 + 4*s + 5", "s", False),
    case("Wikipedia-Routh", "s**3 + 2*s**2 + 3*s + 7", "s", False),
    case("Jury-text", "z**3 - 1.3*z**2 - 0.08*z + 0.24", "z", False),
    case("Jury-text-b", "z**2 - z + 0.5", "z", True),
]


@pytest.mark.parametrize(("poly", "variable", "right"), HURWITZ)
def test_decisions(poly, variable, right):
    """NumPy's roots, far from the boundary."""
    assert ct.decide_stability(poly, variable).is_stable is right
    coefficients = sp.Poly(sp.sympify(poly), sp.Symbol(variable)).all_coeffs()
    roots = np.roots([float(c) for c in coefficients])
    far = roots.real if variable == "s" else np.abs(roots) - 1
    assert bool(far.max() < -1e-6) is right


NORMS = [
    case("JL-584", "1/(s**2 + 0.1*s + 1)", 200 * sp.sqrt(399) / 399),
    case("textbook-lag", "3/(s + 2)", R(3, 2)),
    case("pc-num-den", [["1/(s + 1)", "1/(s + 1)"]], sp.sqrt(2)),
]


@pytest.mark.parametrize(("G", "right"), NORMS)
def test_h_infinity_norms(G, right):
    """By hand: 1/(2 zeta sqrt(1 - zeta^2)), and values at 0."""
    assert sp.simplify(ct.h_infinity_norm(G, "s").value - right) == 0


def test_h2_norm_of_a_biproper_system():
    """JL #59: 1 + sum of squares of (1/2 + 1/3) (1/3)^k: 57/32, not infinite."""
    right = 1 + R(5, 6) ** 2 / (1 - R(1, 9))
    assert ct.gramians("(z + 1/2)/(z - 1/3)", "z").norm_squared == right == R(57, 32)


def test_strong_stabilisability():
    """Youla: between the zeros 1 and infinity of (s-1)/((s-2)(s+1)) lies one pole: not strongly."""
    assert not ct.decide_strong_stabilisability(
        "(s - 1)/((s - 2)*(s + 1))", "s"
    ).is_strongly_stabilisable
    assert ct.decide_strong_stabilisability("1/(s - 2)", "s").is_strongly_stabilisable


def test_interval_polynomials_whose_degree_may_drop():
    """arXiv 2502.14754: Kharitonov's theorem asks for a leading coefficient that is not zero."""
    with pytest.raises(ct.CompensatorError, match="degree"):
        ct.decide_interval_stability([(0, 1), (1, 2), (1, 2)])
