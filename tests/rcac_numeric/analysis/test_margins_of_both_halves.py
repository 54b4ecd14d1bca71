"""Margins of the exact and of the numeric half, and of python-control where it can answer.

The two are independent: the one isolates roots of exact polynomials, the other computes eigenvalues
of a state space.
"""

import warnings
from fractions import Fraction

import control
import numpy as np
import pytest
import sympy
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import compensator_theory as exact
import rcac_numeric as rcac
from compensator_theory import InputError

BOTH = (exact, rcac)
MARGINS = ("gain_up", "gain_down", "phase_lag", "phase_lead", "phase", "delay")
CLOSE = {"rtol": 1e-5, "atol": 1e-7}

gains = st.builds(Fraction, st.integers(-40, 40).filter(bool), st.sampled_from([5, 10, 20, 40]))
zeros = st.lists(st.builds(Fraction, st.integers(-12, 12), st.sampled_from([4, 5, 8])), max_size=4)
poles = st.lists(
    st.builds(Fraction, st.integers(-10, 10), st.sampled_from([8, 9, 11])), min_size=1, max_size=4
)


@st.composite
def loops(draw, variable, gains=gains, poles=poles):
    """Numerator and denominator with rational zeros and poles, proper."""
    bottom = draw(poles)
    top = draw(zeros)[: len(bottom)]
    s = sympy.Symbol(variable)
    sides = ([s - sympy.Rational(r.numerator, r.denominator) for r in roots]
             for roots in (top, bottom))  # fmt: skip
    gain = draw(gains)
    N, D = (sympy.Mul(*side, sympy.Integer(1)) for side in sides)
    return sympy.Poly(N, s) * sympy.Rational(gain.numerator, gain.denominator), sympy.Poly(D, s)


def assert_agree(mine, theirs):
    """Exact margins and those of float64, unit by unit."""
    assert mine.is_stable == theirs.is_stable
    if not mine.is_stable:
        for name in (*MARGINS, "disk"):
            assert getattr(mine, name) is None and getattr(theirs, name) is None, name
        return
    for name in MARGINS:
        one, other = getattr(mine, name), getattr(theirs, name)
        assert np.isclose(float(one.value), other.value, **CLOSE), (name, one, other)
        assert one.is_reached == other.is_reached, (name, one, other)
        if one.is_reached:
            assert np.isclose(float(one.frequency), other.frequency, rtol=1e-5, atol=1e-5), name
    for name in ("alpha", "phase", "S_peak", "T_peak"):
        one, other = float(getattr(mine.disk, name)), getattr(theirs.disk, name)
        assert np.isclose(one, other, **CLOSE), (name, one, other)
    low, high = (float(end) for end in mine.disk.gain)
    assert np.isclose(low, theirs.disk.gain[0], **CLOSE)
    # Its inverse; where low is zero, rounding decides how large it is.
    assert np.isclose(high, theirs.disk.gain[1], **CLOSE) if low > 1e-7 else high > 1e7


@pytest.mark.costly
@settings(max_examples=60)
@given(loops("z"))
# abs(L(-1)) > 1: whole steps of delay decide, with and without a crossover in the step.
@example((sympy.Poly("2*z - 1/2", sympy.Symbol("z")) / 2, sympy.Poly("z - 1/9", sympy.Symbol("z"))))
@example((sympy.Poly("1/2", sympy.Symbol("z")), sympy.Poly("z - 1/2", sympy.Symbol("z"))))
@example((sympy.Poly("1/2", sympy.Symbol("z")), sympy.Poly("z + 1/2", sympy.Symbol("z"))))
def test_both_halves_agree_in_discrete_time(loop):
    """Where a root on the circle, a double one of D for instance, leaves the answer to rounding
    they need not: `is_stable` of float64 is that of its matrix."""
    N, D = loop
    try:
        mine = exact.stability_margins((N, D), feedback=-1)
    except exact.errors.ImproperError:  # 1 + L = 0 identically
        assume(False)
    assume(mine.closed_loop.boundary == 0 and mine.is_well_posed and not mine.is_all_pass)
    radii = np.abs(np.roots([float(c) for c in (N + D).all_coeffs()]))
    assume((np.abs(radii - 1) > 1e-4).all())
    ends = [m.value for m in (mine.gain_up, mine.gain_down) if m is not None and m.is_reached]
    assume(all(abs(float(end) - 1) > 1e-4 for end in ends))
    assert_agree(mine, rcac.stability_margins((N, D), feedback=-1))


@pytest.mark.costly
@settings(max_examples=40)
@given(loops("s", poles=st.lists(st.builds(Fraction, st.integers(-10, 3), st.sampled_from([2, 3])),
                                 min_size=1, max_size=4)))  # fmt: skip
def test_python_control_agrees_in_continuous_time(loop):
    """And the numeric half says who answers."""
    N, D = loop
    with pytest.raises(InputError, match=r"compensator_theory\.stability_margins"):
        rcac.stability_margins((N, D), feedback=-1)
    try:
        mine = exact.stability_margins((N, D), feedback=-1)
    except exact.errors.ImproperError:
        assume(False)
    assume(not mine.is_all_pass and not mine.is_real)
    L = control.tf(*([float(c) for c in p.all_coeffs()] for p in (N, D)))
    poles_of_loop = np.roots(np.polyadd(L.num[0][0], L.den[0][0]))
    assume(mine.is_well_posed and (np.abs(poles_of_loop.real) > 1e-6).all())
    assert mine.is_stable == bool((poles_of_loop.real < 0).all())
    if not mine.is_stable:
        assert all(getattr(mine, name) is None for name in (*MARGINS, "disk"))
        return
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            GM, PM, _, w_pc, w_gc, _ = control.stability_margins(L, returnall=True)
        except (UserWarning, RuntimeWarning):
            assume(False)
    for w, degrees in zip(w_gc, PM, strict=True):
        if w > 1e-6 and abs(abs(L(1j * w)) - 1) < 1e-9:
            assert float(mine.phase.value) <= abs((degrees + 180) % 360 - 180) * (1 + 1e-6) + 1e-6
            lag = degrees % 360
            if abs(L(1e9j)) < 1:
                assert float(mine.delay.value) <= np.radians(lag) / w * (1 + 1e-6)
    for gain in GM[w_pc > 1e-6]:
        if 1e-6 < gain < 1e6:
            assert not 1 < gain < float(mine.gain_up.value) * (1 - 1e-6)
            assert not float(mine.gain_down.value) * (1 + 1e-6) < gain < 1
    alpha, low, high = mine.disk.alpha, *mine.disk.gain
    sampled = np.abs([(1 - L(1j * w)) / (1 + L(1j * w)) for w in np.geomspace(1e-3, 1e3, 400)])
    assert 2 / sampled.max() >= float(alpha) * (1 - 1e-9)
    # At every end of a margin a root of the polynomial D + k N is on the axis.
    for k in (mine.gain_up, mine.gain_down):
        if k.is_reached and k.frequency != sympy.oo:
            edge = np.roots(np.polyadd(float(k.value) * L.num[0][0], L.den[0][0]))
            assert np.abs(edge.real).min() < 1e-4 * max(1, np.abs(edge).max())
    assert float(low) >= float(mine.gain_down.value) * (1 - 1e-9)
    assert float(high) <= float(mine.gain_up.value) * (1 + 1e-9)


z = sympy.Symbol("z")
SAME_LOOP = {
    "text": (("1/(2*(z - 1))",), {}),
    "expression": ((1 / (2 * (z - 1)),), {}),
    "pair of coefficients": ((([0.5], [1, -1]),), {"variable": "z"}),
    "transfer function of ours": ((exact.transfer_function("1/(2*(z - 1))"),), {}),
    "realisation": ((exact.realisation("1/(2*(z - 1))"),), {}),
    "tf of python-control": ((control.tf([0.5], [1, -1], True),), {}),
    "ss of python-control": ((control.ss(1, 1, 0.5, 0, True),), {}),
    "plant and compensator as text": (("1/(z - 1)", "1/2"), {}),
    "plant and a number": (("1/(z - 1)", 0.5), {}),
    "plant and compensator with a mode that is cancelled": (
        ("(z - 1/3)/(z - 1)", "1/(2*(z - 1/3))"), {},
    ),
    "systems of python-control": (
        (control.ss(1, 1, 1, 0, True), control.tf([0.5], [1], True)), {},
    ),
    "a system of python-control and a number": ((control.tf([1], [1, -1], True), 0.5), {}),
}  # fmt: skip


@pytest.mark.parametrize("name", SAME_LOOP)
def test_both_halves_read_the_same_loops(name):
    """L = 1/(2(z - 1)) by hand: 1 + kL = 0 at z = -1 for k = 4; |L| = 1 at 2 sin(w/2) = 1/2, where
    arg(-L) is (pi - w)/2."""
    arguments, options = SAME_LOOP[name]
    omega = 2 * np.arcsin(1 / 4)
    for half in BOTH:
        margins = half.stability_margins(*arguments, feedback=-1, **options)
        assert margins.is_stable
        assert float(margins.gain_up.value) == pytest.approx(4)
        assert float(margins.gain_up.frequency) == pytest.approx(np.pi)
        assert not margins.gain_down.is_reached and float(margins.gain_down.value) == 0
        assert float(margins.phase.value) == pytest.approx(np.degrees((np.pi - omega) / 2))
        assert float(margins.phase.frequency) == pytest.approx(omega)
        assert float(margins.delay.value) == pytest.approx((np.pi - omega) / 2 / omega)
        # S - T = (z - 3/2)/(z - 1/2) is largest at z = -1: 5/3.
        assert float(margins.disk.alpha) == pytest.approx(6 / 5)
        assert [float(end) for end in margins.disk.gain] == pytest.approx([1 / 4, 4])


LOOP = exact.place_poles("1/(z - 2)", ["1/2", "1/3"], 1, feedback=1)


@pytest.mark.parametrize(
    ("arguments", "options", "words"),
    [
        (("1/(z - 1)", LOOP.compensator), {"feedback": -1}, r"designed for feedback = \+1"),
        (("1/(z - 1)", "1/q"), {"feedback": -1}, "same variable"),
        (("a/(z - 1)",), {"feedback": -1, "variable": "z"}, "substitute|symbol"),
        (("sqrt(2)/(z + 3)",), {"feedback": -1}, "rational number"),
        (("1/(z - 1)",), {"feedback": 2}, "feedback"),
    ],
)
def test_both_halves_refuse_the_same_loops(arguments, options, words):
    for half in BOTH:
        with pytest.raises(InputError, match=words):
            half.stability_margins(*arguments, **options)


PLANT = rcac.standard_plant("1/(q - 2)")
ONE = rcac.Compensator(past_u=[[[-1.0]]], past_y=[[[0.0]], [[-2.5]]])


@pytest.mark.parametrize(
    ("arguments", "options"),
    [
        ((PLANT, ONE), {}),
        ((PLANT, ONE), {"feedback": 1}),
        (("1/(q - 2)", ONE), {}),
        ((PLANT, "5/(2*(q + 1))"), {"feedback": -1}),
        ((PLANT, "-5/(2*(q + 1))"), {"feedback": 1}),
        (("1/(q - 2)", "5/(2*(q + 1))"), {"feedback": -1}),
        ((rcac.ClosedLoop(PLANT, ONE),), {}),
    ],
)
def test_a_plant_and_a_compensator_of_the_numeric_half(arguments, options):
    """q^2 - q - 2 + 2.5 k is stable for 0.8 < k < 1.2."""
    margins = rcac.stability_margins(*arguments, **options)
    assert (margins.gain_down.value, margins.gain_up.value) == pytest.approx((0.8, 1.2))


@pytest.mark.parametrize(
    ("arguments", "options", "words"),
    [
        ((PLANT, ONE), {"feedback": -1}, r"feedback = \+1"),
        ((PLANT, "5/(2*(q + 1))"), {}, "needs the sign of feedback"),
        ((PLANT, LOOP.compensator), {"feedback": -1}, r"designed for feedback = \+1"),
        ((rcac.ClosedLoop(PLANT, ONE), ONE), {}, "contains its compensator"),
        ((rcac.ClosedLoop(PLANT, ONE),), {"feedback": 1}, "leave feedback out"),
        ((PLANT,), {"feedback": -1}, "is not a loop"),
    ],
)
def test_a_loop_that_is_no_loop_of_the_numeric_half(arguments, options, words):
    with pytest.raises(InputError, match=words):
        rcac.stability_margins(*arguments, **options)


@pytest.mark.parametrize("compensator", [None, "1/2", "(z - 9/10)/(z - 1)", 0.5])
@pytest.mark.parametrize("plant", ["2*exp(-3*s)/(10*s + 1)", "2/(10*s + 1)", "exp(-7/4*s)/s"])
def test_a_plant_in_s_is_sampled_with_a_hold(plant, compensator):
    """The exact margins of the exactly sampled plant, its exponentials as numbers."""
    mine = rcac.stability_margins(plant, compensator, feedback=-1, sample_time=0.5, disk=False)
    sampled = exact.sampling.zero_order_hold(plant, "1/2")
    options = {} if compensator is None else {"compensator": compensator}
    if options and not isinstance(compensator, str):
        options = {"compensator": str(compensator)}
    theirs = exact.stability_margins(sampled, **options, feedback=-1)
    assert mine.is_stable == theirs.is_stable
    for name in ("gain_up", "gain_down", "phase_lag", "phase_lead"):
        one, other = getattr(mine, name), getattr(theirs, name)
        assert (one is None) == (other is None)
        if one is not None:
            expected = float(other.value)
            assert one.value == pytest.approx(expected, rel=1e-6) or expected == float("inf")


def test_a_dead_time_without_a_sample_time_is_refused():
    with pytest.raises(InputError, match="sample_time"):
        rcac.stability_margins("exp(-s)/s", feedback=-1)
    with pytest.raises(InputError, match="continuous"):
        rcac.stability_margins("exp(-s)/s", "1/(s + 1)", feedback=-1, sample_time=0.1)
