"""Plants with dead time: sampled exactly, varied as the uncertainty says, read from every form."""

from fractions import Fraction

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from compensator_theory.errors import ImproperError, InputError, NoSolutionError
from compensator_theory.sampling import zero_order_hold
from rcac_numeric import (
    PlantChange,
    PlantSchedule,
    Uncertainty,
    plant_of,
    servo_plant,
    standard_plant,
)
from rcac_numeric.designing._plants import (
    DesignPlant,
    Variation,
    read_plant,
    slower_plant,
    variations,
)
from rcac_numeric.gallery import BoostConverter


def step_response(plant, steps):
    """y_0 of the servo problem for a step of u, without control."""
    x, result = np.zeros((plant.n, 1)), []
    for _ in range(steps):
        result.append(-(plant.C @ x).item())
        x = plant.A @ x + plant.B
    return np.array(result)


@given(tau=st.floats(0.5, 20), late=st.floats(0, 6), h=st.floats(0.2, 1.5), gain=st.floats(0.5, 2))
def test_a_dead_time_of_any_length_is_sampled_exactly(tau, late, h, gain):
    plant = read_plant(f"{gain!r}/({tau!r}*s + 1)", h, late)
    t = np.arange(30) * h - late
    exact = np.where(t > 0, gain * -np.expm1(-np.maximum(t, 0) / tau), 0.0)
    # A dead time within 2e-9 of a period of a whole one counts as whole.
    assert np.abs(step_response(plant.servo(), 30) - exact).max() < 1e-8 * gain * (1 + h / tau)


@pytest.mark.parametrize("late", ["5/2", "3"])
def test_a_dead_time_in_the_text_is_that_of_the_option(late):
    written, option = (
        read_plant(f"2*exp(-{late}*s)/(10*s + 1)", 1.0, 0.0),
        read_plant("2/(10*s + 1)", 1.0, float(Fraction(late))),
    )
    assert np.array_equal(step_response(written.servo(), 20), step_response(option.servo(), 20))
    assert read_plant(f"2*exp(-{late}*s)/(10*s + 1)", 1.0, float(Fraction(late))).delay == (
        option.delay
    )


@pytest.mark.parametrize("late", [2.0, [[3.0]]])
def test_two_dead_times_are_refused(late):
    with pytest.raises(InputError, match="give one of them"):
        read_plant("2*exp(-3*s)/(10*s + 1)", 1.0, late)


@given(
    late=st.sampled_from(["1/3", "1/2", "1", "9/4", "3"]), h=st.sampled_from([0.5, 1.0, 0.75]),
    G=st.sampled_from(["2/(10*s + 1)", "(s + 3)/(s + 1)", "1/s**2", "1/(s**2 + s + 4)"]),
)  # fmt: skip
def test_a_plant_with_dead_time_has_the_exact_response(late, h, G):
    """Beside the exact half's modified z-transform; and the sample time and zoh are needed."""
    text = f"exp(-{late}*s)*{G}"
    plant, sampled = plant_of(text, sample_time=h), zero_order_hold(text, h)
    H, meaning = sampled.transfer_function, dict(sampled.exponentials)
    z = np.exp(1j * np.array([0.3, 1.1, 2.9]))
    N, D = ([float(c.subs(meaning)) for c in p.all_coeffs()] for p in (H.numerator, H.denominator))
    theirs = np.polyval(N, z) / np.polyval(D, z)
    ours = [(plant.C @ np.linalg.solve(x * np.eye(plant.n) - plant.A, plant.B)).item() for x in z]
    assert np.allclose(ours, theirs, rtol=1e-8, atol=1e-12)
    with pytest.raises(InputError, match="sample time"):
        plant_of(text)
    with pytest.raises(InputError, match="zoh"):
        plant_of(text, sample_time=h, method="bilinear")


@given(
    late=st.lists(st.integers(0, 7), min_size=4, max_size=4),
    tau=st.lists(st.floats(1, 20), min_size=4, max_size=4),
    time=st.floats(0.5, 2), more=st.integers(0, 2), h=st.sampled_from([0.5, 1.0, 3.0]),
)  # fmt: skip
def test_dead_times_by_entry_are_those_of_sampled_lags(late, tau, time, more, h):
    late, tau = np.reshape(late, (2, 2)), np.reshape(tau, (2, 2))
    G = [[f"{i + 2 * j + 1}/({float(tau[i, j])!r}*s + 1)" for j in range(2)] for i in range(2)]
    plant = read_plant(G, h, late * h)
    z = np.exp(1j * np.array([0.01, 0.5, 2.0]))[:, None, None]
    poles = np.exp(-h / (tau * time))
    exact = np.array([[1, 3], [2, 4]]) * (1 - poles) / (z - poles) * z ** -(late + more)
    servo = plant.servo(Variation(time=time, delay=more))
    result = -servo.C @ np.linalg.solve(z * np.eye(servo.n) - servo.A, servo.B[None])
    assert np.allclose(result, exact, rtol=1e-9, atol=1e-12)
    if time == 1 and not more:
        assert np.allclose(plant.response([0.01, 0.5, 2.0]), exact, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("G", "late", "words"),
    [
        ("1/(s + 1)", [[1.0]], "rows of transfer functions in s"),
        ([["1/(q - 0.5)"]], [[1.0]], "in q it stands in the entries"),
        ([["1/(s + 1)"]], [[1.0, 2.0]], "1 x 1 entries"),
        ([["1/(s + 1)"]], [[-1.0]], "negative"),
        ([["1/(s + 1)"]], [[0.3]], "whole steps"),
        ([["s/(s + 1)"]], [[1.0]], "strictly proper"),
    ],
)
def test_dead_times_by_entry_that_cannot_be_taken_are_refused(G, late, words):
    with pytest.raises((InputError, ImproperError), match=words):
        read_plant(G, 1.0, late)


def test_an_integrator_that_outputs_share_is_refused_and_in_q_is_not():
    with pytest.raises(NoSolutionError, match="Give the plant in q"):
        read_plant([["1/s", "1/(s + 2)"], ["2/s", "1/(s + 3)"]], 0.5, [[0.5, 1.0], [0.0, 0.5]])
    in_q = [["0.5/(q*(q - 1))", "6/(q**2*(q - 0.3))"], ["1/(q - 1)", "5/(q*(q - 0.2))"]]
    whole = read_plant(in_q, None, 0.0)
    assert np.sum(np.abs(np.linalg.eigvals(whole.A) - 1) < 1e-6) == 1


@given(time=st.floats(0.5, 2), late=st.integers(0, 3))
def test_time_constants_are_varied_in_continuous_time(time, late):
    A, B = np.array([[-0.2, 1.0], [-0.3, -0.5]]), np.array([[0.0], [1.0]])
    C = np.array([[1.0, 0.5]])
    sampled = control.c2d(control.ss(A, B, C, 0), 0.5)
    for plant in (
        read_plant(control.ss(A, B, C, 0), 0.5, 0.5 * late),
        read_plant(sampled, None, 0.5 * late),
    ):
        result = plant.servo(Variation(time=time))
        whole = expm(np.block([[A, B], [np.zeros((1, 3))]]) * 0.5 / time)
        x, exact = np.zeros((2, 1)), [0.0] * late
        for _ in range(20):
            exact.append((C @ x).item())
            x = whole[:2, :2] @ x + whole[:2, 2:]
        assert np.allclose(step_response(result, 20), exact[:20], rtol=1e-7, atol=1e-9)


def test_what_may_be_instead_is_one_change_at_a_time():
    plant = read_plant("1/(10*s + 1)", 1.0, 2.0)
    result = variations(plant, Uncertainty(gain=(0.5, 3.0), delay=3, time=1.5, noise=2.0))
    assert [one.name for one in result] == [
        "nominal", "gain x 0.5", "gain x 3", "delay + 3", "delay - 2", "time constants x 1.5",
        "time constants / 1.5", "noise x 2",
    ]  # fmt: skip
    later, nominal = (step_response(plant.servo(result[i]), 20) for i in (3, 0))
    assert np.allclose(later[3:], nominal[:-3]) and not later[:6].any()
    assert np.allclose(step_response(plant.servo(result[2]), 20), 3 * nominal)
    exactly = Uncertainty(gain=(1, 1), delay=0, time=1, noise=1)
    assert variations(plant, exactly) == (Variation(),)


def test_a_pole_that_no_plant_in_continuous_time_has_is_left_out():
    plant = read_plant("1/((q - 0.9)*(q + 0.5))", None, 0)
    assert not [one for one in variations(plant, Uncertainty()) if "time" in one.name]
    with pytest.raises(NoSolutionError, match="negative axis"):
        plant.servo(Variation(time=2.0))


def test_every_form_is_the_same_plant():
    G = "1/((q - 0.5)*(q - 0.25))"
    late = "1/(q**3*(q - 0.5)*(q - 0.25))"
    same = [
        read_plant(G, None, 3),
        read_plant(standard_plant(G), None, 3),
        read_plant(servo_plant(G), None, 3),
        read_plant(control.tf([1], [1, -0.75, 0.125], True), None, 3),
        read_plant(
            PlantSchedule([PlantChange(start=0, plant=standard_plant(G), delay=3)]), None, 0
        ),
        read_plant(late, None, 0),
    ]
    responses = step_response(same[0].servo(), 15)
    for plant in same:
        assert np.allclose(step_response(plant.servo(), 15), responses, rtol=1e-12)
    boost = BoostConverter()
    model = boost.linearised(boost.operating_point(0.5))
    result = step_response(read_plant(model, 2e-5, 0.0).servo(), 10)
    assert np.allclose(result, step_response(model.servo(2e-5), 10), rtol=1e-12)


@pytest.mark.parametrize(
    ("G", "sign"),
    [
        ("1/(q - 0.5)", "+"),
        ("(1.5 - q)/((q - 0.9)*(q - 0.5))", "+"),
        ("-1/(q - 1.02)", "-"),
        ("1/(q - 3)", "+"),
        ("-1/((q - 1)*(q - 0.5))", "-"),
    ],
)
def test_the_sign_is_where_y_goes_in_the_end(G, sign):
    assert read_plant(G, None, 0).sign == sign


@pytest.mark.parametrize(
    ("plant", "arguments", "error", "words"),
    [
        ("1/(s + 1)", (None, 0), InputError, "by sample_time"),
        ("1/(s + 1)", (-1.0, 0), InputError, "positive"),
        ("1/(s + 1)", (1.0, -1), InputError, "negative"),
        ("1/(s + 1)", (0.01, 5), InputError, "500 steps"),
        ("1/(q - 0.5)", (None, 0.4), InputError, "whole number"),
        ("(s + 2)/(s + 1)", (1.0, 0), ImproperError, "strictly proper"),
        ("q/(q - 0.5)", (None, 0), ImproperError, "strictly proper"),
        (control.ss(-np.eye(2), np.eye(2), [[1, 1]], 0), (1.0, 0), InputError, "2 inputs"),
        ("0/(q - 0.5)", (None, 0), InputError, "has gain 0"),
    ],
)
def test_what_is_no_plant_for_design_is_refused(plant, arguments, error, words):
    with pytest.raises(error, match=words):
        read_plant(plant, *arguments)


@pytest.mark.parametrize("gain", [(1.2, 2.0), (0.5,), (0.0, 1.0)])
def test_an_uncertainty_is_around_1(gain):
    with pytest.raises((InputError, ValueError)):
        Uncertainty(gain=gain)


@given(
    every=st.integers(1, 9), delay=st.integers(0, 20), pole=st.floats(-0.9, 1.0),
    seed=st.integers(0, 99),
)  # fmt: skip
def test_a_controller_that_skips_steps_has_the_plant_with_u_held(every, delay, pole, seed):
    """Every n-th output of the plant itself, with each control repeated n times."""
    rng = np.random.default_rng(seed)
    A = np.array([[pole, 1.0], [0.0, 0.5]])
    plant = DesignPlant(A, np.array([[0.2], [1.0]]), np.array([[1.0, 0.3]]), delay, sample_time=0.5)
    slow = slower_plant(plant, every)
    assert slow.sample_time == 0.5 * every
    u = rng.standard_normal(12)

    def outputs(one, controls):
        servo, y = one.servo(), []
        x = np.zeros(servo.n)
        for value in controls:
            y.append((-servo.C @ x).item())
            x = servo.A @ x + servo.B[:, 0] * value
        return np.array(y)

    expected = outputs(plant, np.repeat(u, every))[::every]
    np.testing.assert_allclose(outputs(slow, u), expected, atol=1e-9 * (1 + np.abs(expected).max()))


@pytest.mark.parametrize(
    "G", ["1e-300/(s + 1)", "1e300/(s + 1)", "1/(1e300*s + 1)", "1/((1e150*s + 1)*(1e-150*s + 1))"]
)
def test_gains_near_the_ends_of_float64(G):
    with pytest.raises(InputError, match=r"the plant has a gain of .*Give u and y in units of"):
        read_plant(G, 0.1, 0.0)


@pytest.mark.parametrize("G", ["1/((1e30*s + 1)*(1e-30*s + 1))", "1/(q**2 - 2*q + 2)"])
def test_plants_of_extreme_numbers_that_are_read(G):
    plant = read_plant(G, 0.1, 0.0)
    assert np.isfinite(plant.response(0.5)).all() and plant.low_gain > 0
