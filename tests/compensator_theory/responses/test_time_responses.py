"""Closed forms in time against mpmath, long division, SciPy and the text of textbooks."""

import math

import mpmath
import numpy as np
import pytest
import scipy.linalg
import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.strategies import hurwitz_spectra, matrices, polynomials, schur_spectra

t = sympy.Symbol("t")
ZETA = st.fractions(min_value="1/20", max_value="19/20", max_denominator=20)


def systems(variable="s"):
    """Proper systems with simple, multiple and irrational poles."""
    factors = st.lists(
        st.tuples(
            polynomials(variable, min_degree=1, max_degree=3, is_monic=True), st.integers(1, 2)
        ),
        min_size=1,
        max_size=2,
    )

    def build(top, parts):
        bottom = sympy.prod([p**k for p, k in parts])
        return ct.TransferFunction(top.rem(bottom * bottom.gen), bottom)

    return st.builds(build, polynomials(variable, max_degree=4), factors)


def stable_systems(variable, spectra):
    """Strictly proper systems that settle at 1."""

    def build(roots):
        bottom = ct.polynomial_from_roots(roots, variable)
        return ct.TransferFunction(bottom.eval(0 if variable == "s" else 1) * bottom.one, bottom)

    return st.integers(1, 3).flatmap(spectra).map(build)


@given(systems())
def test_the_transform_of_the_closed_form_is_the_source(G):
    y = ct.step_response(G)
    assert y.is_verified
    # Talbot's method knows nothing of partial fractions.
    Y = sympy.lambdify(G.variable, y.transform.as_expr(), "mpmath")
    with mpmath.workdps(60):
        for time in (0.3, 1.1):
            expected = mpmath.invertlaplace(Y, time, method="talbot", degree=60)
            value = mpmath.mpmathify(y.expression.subs(t, sympy.Rational(str(time))).evalf(30))
            assert abs(value - expected) < 1e-12 * (1 + abs(expected))


@pytest.mark.costly
@given(systems())
def test_the_derivatives_at_zero_are_markov_parameters(G):
    y = ct.impulse_response(G)
    parameters = ct.markov_parameters(G, 4)
    assert y.impulses.as_expr() == parameters[0]
    assert y.initial_value == parameters[1]
    form = y.expression.replace(sympy.DiracDelta, lambda *_: sympy.Integer(0))
    for k in (1, 2, 3):
        value = complex(sympy.diff(form, t, k - 1).subs(t, 0).evalf(30))
        assert abs(value - float(parameters[k])) <= 1e-12 * (1 + abs(float(parameters[k])))


@given(systems("z"))
def test_a_sequence_is_the_long_division(G):
    y = ct.step_response(G)
    assert y.is_verified
    samples = np.cumsum([float(h) for h in ct.markov_parameters(G, 9)])
    size = max(1.0, *np.abs(samples))
    for k, sample in enumerate(samples):
        assert abs(float(y(k)) - sample) <= 1e-12 * size
        assert abs(complex(y.expression.subs(y.time, k).evalf(30)) - sample) <= 1e-12 * size


@pytest.mark.costly
@given(matrices(3, 3) | matrices(2, 2), st.sampled_from("sz"))
def test_transition_matrices(A, variable):
    E = ct.transition_matrix(A, variable)
    assert E.is_verified
    M = np.array(A.tolist(), dtype=float)
    if variable == "s":
        expected = scipy.linalg.expm(M * 0.7)
        at = sympy.Rational(7, 10)
    else:
        expected, at = np.linalg.matrix_power(M, 5), sympy.Integer(5)
    value = np.array(E.expression.subs(E.time, at).evalf(25).tolist(), dtype=complex)
    assert np.allclose(value, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    assert E(0) == sympy.eye(A.rows) or variable == "s"


@pytest.mark.parametrize(
    ("transform", "signal"),
    [
        # Ogata, Modern Control Engineering, table 2-1.
        ("1/s**2", "t"),
        ("w/(s**2 + w**2)", "sin(w*t)"),
        ("s/(s**2 + w**2)", "cos(w*t)"),
        ("1/(s + a)**2", "t*exp(-a*t)"),
        ("(s + a)/((s + a)**2 + w**2)", "exp(-a*t)*cos(w*t)"),
        ("1/((s + a)*(s + b))", "(exp(-a*t) - exp(-b*t))/(b - a)"),
        ("w**2/(s**2 + 2*x*w*s + w**2)", "w/sqrt(1 - x**2)*exp(-x*w*t)*sin(w*sqrt(1 - x**2)*t)"),
        ("w**3/(s**2*(s**2 + w**2))", "w*t - sin(w*t)"),
        ("2*w**3/(s**2 + w**2)**2", "sin(w*t) - w*t*cos(w*t)"),
    ],
)
def test_table_of_laplace_transforms(transform, signal):
    y = ct.impulse_response(transform, "s")
    expected = sympy.sympify(signal)
    positive = {x: sympy.Symbol(x.name, positive=True) for x in expected.free_symbols}
    difference = (y.expression - expected).xreplace(positive)
    values = {x: sympy.Rational(k + 2, 7) for k, x in enumerate(sorted(positive.values(), key=str))}
    assert sympy.simplify(difference) == 0 or abs(difference.subs(values).evalf(30)) < 1e-25


@given(ZETA, st.fractions(min_value="1/10", max_value=10, max_denominator=10))
def test_a_second_order_system_as_in_every_textbook(zeta, w):
    """Overshoot exp(-pi zeta/sqrt(1 - zeta^2)), whatever the frequency is."""
    y = ct.step_response(f"({w})**2/(s**2 + 2*({zeta})*({w})*s + ({w})**2)")
    z = float(zeta)
    overshoot = y.overshoot()
    assert abs(float(overshoot) - math.exp(-math.pi * z / math.sqrt(1 - z**2))) < 1e-11
    slower = ct.step_response(f"1/(s**2 + 2*({zeta})*s + 1)")
    scaled = float(w) * float(y.settling_time())
    assert math.isclose(scaled, float(slower.settling_time()), rel_tol=1e-9)
    assert math.isclose(float(w) * float(y.rise_time()), float(slower.rise_time()), rel_tol=1e-7)


@given(stable_systems("s", hurwitz_spectra))
def test_characteristics_hold_on_a_grid(G):
    y = ct.step_response(G)
    settling, rise = y.settling_time(), y.rise_time()
    horizon = 3 * float(settling.upper)
    times = np.linspace(0, horizon, 301)[1:]
    form = sympy.lambdify(y.time, y.expression, "mpmath")
    values = np.array([complex(form(mpmath.mpf(float(x)))).real for x in times])
    over, under = y.overshoot(), y.undershoot()
    assert values.max() - 1 <= float(over.upper) + 1e-9
    assert -values.min() <= float(under.upper) + 1e-9
    late = values[times > float(settling.upper)]
    assert np.abs(late - 1).max(initial=0) <= 0.02 + 1e-9
    before = float(settling.lower)
    edge = complex(form(mpmath.mpf(before))).real
    assert abs(abs(edge - 1) - 0.02) < 1e-6 or before == 0
    assert values[times >= float(rise.upper)].size


@given(stable_systems("z", schur_spectra))
def test_characteristics_of_sequences(G):
    y = ct.step_response(G)
    settled = int(y.settling_time().centre)
    values = [float(y(k)) for k in range(settled + 20)]
    assert all(abs(v - 1) <= 0.02 + 1e-12 for v in values[settled:])
    assert settled == 0 or abs(values[settled - 1] - 1) > 0.02 - 1e-12
    assert max(0, max(values) - 1) <= float(y.overshoot().upper) + 1e-12
    first = next(k for k, v in enumerate(values) if v >= 0.1 - 1e-12)
    second = next(k for k, v in enumerate(values) if v >= 0.9 - 1e-12)
    assert y.rise_time().centre == second - first


def test_a_sample_on_the_edge_of_the_band():
    """1 - 2**-k is within 1/8 from step 3 on and reaches 7/8 there, exactly."""
    y = ct.step_response("1/(2*z - 1)")
    assert y.settling_time("1/8").centre == 3
    assert y.rise_time("1/2", "7/8").centre == 2


def test_symbols_keep_their_exceptional_set():
    y = ct.step_response("1/((s + a)*(s + b))")
    assert set(y.exceptional) == {sympy.Symbol("a"), sympy.Symbol("b"), sympy.sympify("a - b")}
    assert y.final_value == sympy.sympify("1/(a*b)")
    named = ct.impulse_response("1/(s + t)", "s")
    assert named.time.name != "t"


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: ct.step_response("z"), ImproperError),
        (lambda: ct.step_response("1/(x + 1)"), InputError),
        (lambda: ct.step_response("1/(z - 2)")(0.5), InputError),
        (lambda: ct.step_response("1/(s - 1)").final_value, NoSolutionError),
        (lambda: ct.step_response("1/s").overshoot(), NoSolutionError),
        (lambda: ct.step_response("s/(s + 1)").overshoot(), InputError),
        (lambda: ct.step_response("1/(s + a)").settling_time(), InputError),
        (lambda: ct.step_response("1/(s + 1)").settling_time(2), InputError),
        (lambda: ct.step_response("1/(s + 1)").rise_time("0.9", "0.1"), InputError),
        (lambda: ct.time_response("1/(s + 1)", "1/z"), InputError),
        (lambda: ct.transition_matrix([[1, 2]]), InputError),
        (lambda: ct.transition_matrix([["s"]]), InputError),
    ],
)
def test_refusals(call, error):
    with pytest.raises(error):
        call()


@given(systems())
def test_there_is_a_final_value_where_the_reduced_system_is_stable(G):
    y = ct.step_response(G)
    reduced = G.reduced()
    poles = ct.count_roots(reduced.denominator)
    if poles.stable == poles.total:
        assert y.final_value == reduced(0)
    elif reduced.numerator.eval(0) != 0 or poles.unstable:
        with pytest.raises(NoSolutionError, match="no final value"):
            _ = y.final_value
