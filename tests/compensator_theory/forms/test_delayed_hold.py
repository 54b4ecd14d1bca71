"""Sampling with a dead time that is no multiple of the step: SciPy's step responses, identities."""

import numpy as np
import pytest
import scipy.linalg
import scipy.signal
import sympy
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import DelayedTransferFunction, InputError, transfer_function
from compensator_theory.sampling import zero_order_hold

PLANTS = st.sampled_from([
    "1/s", "2/(10*s + 1)", "(s + 3)/(s + 1)", "1/s**2", "1/((s + 1)*(s + 2))", "(s - 1)/(s + 2)**2",
    "(s + 3)/(s**2 + s + 1)", "1/(s*(s**2 + 4))", "3/(s - 1)",
])  # fmt: skip
DELAYS = st.sampled_from(["1/10", "1/3", "1/2", "1", "5/4", "2"])
STEPS = st.sampled_from(["1/4", "1/2", "2/3", "1"])


def floats(poly, meaning):
    return [float(c.subs(meaning)) for c in poly.all_coeffs()]


def step_values(G, times):
    """The step response of the rational part, by SciPy, 0 before 0."""
    N, D = ([float(c) for c in p.all_coeffs()] for p in (G.numerator, G.denominator))
    A, B, C, direct = scipy.signal.tf2ss(N, D)
    values = []
    for t in times:
        if t < -1e-12:
            values.append(0.0)
            continue
        whole = np.block([[A, B], [np.zeros((1, len(A) + 1))]]) * max(t, 0.0)
        state = scipy.linalg.expm(whole)[:-1, -1]
        values.append(float((C @ state)[0] + direct[0, 0]))
    return np.array(values)


@given(PLANTS, DELAYS, STEPS)
def test_a_pulse_of_one_step(plant, delay, step):
    """Its samples are differences of the step response, dead time and step apart."""
    G = transfer_function(plant)
    sampled = zero_order_hold(DelayedTransferFunction(G, delay), step)
    meaning = dict(sampled.exponentials)
    H = sampled.transfer_function
    N, D = floats(H.numerator, meaning), floats(H.denominator, meaning)
    count = 15
    pulse = np.r_[1.0, np.zeros(count - 1)]
    response = scipy.signal.lfilter([0.0] * (len(D) - len(N)) + N, D, pulse)
    theta, h = (float(sympy.Rational(x)) for x in (delay, step))
    times = np.arange(count) * h - theta
    expected = step_values(G, times) - step_values(G, times - h)
    np.testing.assert_allclose(response, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())
    assert sampled.certificate.holds and H.sample_time == sympy.Rational(step)


@given(PLANTS, st.integers(1, 4), STEPS)
def test_whole_steps_are_powers_of_z(plant, d, step):
    G = transfer_function(plant)
    late = zero_order_hold(DelayedTransferFunction(G, d * sympy.Rational(step)), step)
    prompt = zero_order_hold(G, step)
    assert late.exponentials == prompt.exponentials
    shifted = (prompt.transfer_function / f"z**{d}").reduced()
    assert sympy.simplify(late.transfer_function.as_expr() - shifted.as_expr()) == 0


def test_a_first_order_plant_by_hand():
    """By hand: x' = -x + u(t - theta), theta = 1/4 and h = 1."""
    sampled = zero_order_hold("exp(-s/4)/(s + 1)", 1)
    ((x, meaning),) = sampled.exponentials
    assert meaning == sympy.exp(sympy.Rational(-1, 4))
    z = sampled.realisation.variable
    numerator = (1 - x**3) * z + x**3 - x**4
    value = sampled.transfer_function.as_expr() - numerator / (z * (z - x**4))
    assert sympy.simplify(value) == 0


def test_the_symbol_of_the_step():
    G = transfer_function("exp(-3*h/2*s)/(s + 1)", "s")
    numbers = zero_order_hold("exp(-3/2*s)/(s + 1)", 1)
    symbols = zero_order_hold(G, "h")
    assert symbols.exponentials[0][1].subs("h", 1) == numbers.exponentials[0][1]
    assert str(symbols.transfer_function) == str(numbers.transfer_function)


@pytest.mark.parametrize(
    ("plant", "step"),
    [("exp(-s)/(s + 1)", None), ("exp(-theta*s)/(s + 1)", 1), ("exp(-s)/(s + 1)", sympy.log(2)),
     ("exp(-s)/(s + 1)", 0), ("exp(-10000000*s)/s", 1), ("exp(-1/1000003*s)/(s + 1)", 1)],
)  # fmt: skip
def test_refused_steps(plant, step):
    with pytest.raises(InputError):
        zero_order_hold(plant, step)
