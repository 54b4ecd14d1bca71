"""Responses of systems with a dead time: those without, later."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import (
    DelayedTransferFunction,
    InputError,
    impulse_response,
    step_response,
    time_response,
    transfer_function,
)
from compensator_theory.strategies import strictly_proper_plants

t, s = sympy.symbols("t s")


@given(
    strictly_proper_plants(max_order=3),
    st.sampled_from([sympy.Rational(1, 2), 3]),
    st.sampled_from([0, sympy.Rational(1, 7), 1, 5]),
    st.sampled_from([step_response, impulse_response]),
)
def test_a_response_comes_later(G, delay, since, respond):
    late, prompt = respond(DelayedTransferFunction(G, delay)), respond(G)
    assert late.is_verified and late.delay == delay
    assert late(delay + since) == prompt(since)
    assert late(delay / 2) == 0 and late.initial_value == 0
    difference = late.expression.subs(late.time, delay + since + 1) - prompt(since + 1)
    assert abs(complex(difference)) < 1e-9


def test_characteristics():
    late, prompt = step_response("2*exp(-3*s)/(s**2 + s + 1)"), step_response("2/(s**2 + s + 1)")
    assert late.settling_time().centre == prompt.settling_time().centre + 3
    assert late.rise_time() == prompt.rise_time() and late.overshoot() == prompt.overshoot()
    assert late.final_value == 2


@pytest.mark.costly
def test_sympy_transforms_it_back():
    y = step_response("exp(-2*s)/(s + 1)")
    time = sympy.Symbol("t", positive=True)
    expression = y.expression.subs(y.time, time)
    transform = sympy.laplace_transform(expression, time, s, noconds=True)
    assert sympy.simplify(transform - sympy.exp(-2 * s) / (s * (s + 1))) == 0


def test_impulses_come_late_too():
    y = impulse_response("exp(-2*s)*(s + 2)/(s + 1)")
    assert y.expression.coeff(sympy.DiracDelta(y.time - 2)) == 1


def test_dead_times_of_system_and_input_add():
    both = time_response("exp(-s)/(s + 1)", "exp(-s)/s**2")
    assert both.delay == 2
    assert both(3) == time_response("1/(s + 1)", "1/s**2")(1)


def test_symbols():
    y = step_response("k*exp(-theta*s)/(s + a)")
    value = y.expression.subs({"k": 2, "theta": 1, "a": 3, y.time: 2})
    assert sympy.simplify(value - 2 * (1 - sympy.exp(-3)) / 3) == 0
    with pytest.raises(InputError):
        step_response("exp(-theta*s)/(s + 1)").settling_time()
    sine = step_response("sin(a)*exp(-2*s)/(s + 1)")
    assert abs(sine.expression.subs({"a": 1, sine.time: 3}).evalf() - 0.531911) < 1e-5


@pytest.mark.costly
def test_pictures():
    pytest.importorskip("matplotlib")
    figure = transfer_function("2*exp(-3*s)/(10*s + 1)").plot()
    (line, *_) = figure.axes[0].get_lines()
    times, values = line.get_data()
    assert (values[times < 3] == 0).all() and (values[times > 3.5] > 0).all()
    assert len(figure.axes) == 5
    with pytest.raises(InputError):
        transfer_function("exp(-theta*s)/(s + 1)").plot()
