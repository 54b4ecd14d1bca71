"""Compensators over a table, interpolated in the coefficients of their difference equation."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import FunctionFailedError, InputError

seeds = st.integers(0, 10_000)


def drawn(rng, n_c, l_u=1, l_in=2, strictly=True):
    """Coefficients whose absolute sums are below 1: poles inside, and between two such too."""
    P = rng.uniform(-0.9, 0.9, (n_c, l_u, l_u)) / max(n_c * l_u, 1)
    Q = rng.standard_normal((n_c + 1, l_u, l_in))
    Q[0] *= not strictly
    return rn.Compensator(past_u=P, past_y=Q)


@pytest.mark.costly
@given(
    seed=seeds, orders=st.lists(st.integers(0, 3), min_size=2, max_size=4), l_u=st.integers(1, 2)
)
def test_it_is_the_difference_equation_with_coefficients_between(seed, orders, l_u):
    """Written out with all of the past, the coefficients of a missing lag being zero."""
    rng = np.random.default_rng(seed)
    values = np.cumsum(0.1 + rng.random(len(orders)))
    table = [drawn(rng, n, l_u, 3, strictly=False) for n in orders]
    schedule = rn.GainSchedule(values, table, variable="r", l_r=1)
    controller, steps = schedule.started(), 30
    y = rng.standard_normal((steps, 2))
    r = rng.uniform(values[0] - 0.3, values[-1] + 0.3, (steps, 1))
    u = np.zeros((steps, l_u))
    for k in range(steps):
        s = np.clip(r[k, 0], values[0], values[-1])
        hats = [np.interp(s, values, unit) for unit in np.eye(len(values))]  # of linear splines
        for weight, one in zip(hats, table, strict=True):
            for i in range(min(one.n_c, k)):
                u[k] += weight * one.past_u[i] @ u[k - 1 - i]
            for i in range(min(one.n_c, k) + 1):
                u[k] += weight * one.past_y[i] @ np.append(y[k - i], r[k - i])
        assert controller.step(y[k], r[k]) == pytest.approx(u[k], rel=1e-10, abs=1e-10)
        assert controller.theta == r[k] and controller.k == k + 1
        frozen = schedule.at(r[k, 0])
        expected = np.sum([h * np.sum(one.past_y, axis=0) for h, one in zip(hats, table)], axis=0)  # noqa: B905
        assert np.sum(frozen.past_y, axis=0) == pytest.approx(expected, abs=1e-12)


PLANT = rn.servo_plant("(q - 0.5)/((q - 0.8)*(q - 0.9))")


def integral(gain, decay=1.0):
    return rn.Compensator(past_u=[[[decay]]], past_y=[[[0.0, 0.0]], [[-gain, gain]]])


def of_error(gain):
    """Integral action on y, which is the error of the servo problem."""
    return rn.Compensator(past_u=[[[1.0]]], past_y=[[[0.0, 0.0]], [[gain, 0.0]]])


@pytest.mark.costly
@pytest.mark.parametrize("value", [-1.0, 0.0, 2.0, 7.5, 10.0, 30.0])
def test_held_at_a_value_it_is_the_fixed_controller(value):
    schedule = rn.GainSchedule([0, 10], [of_error(0.001), of_error(0.004)], variable="r", l_r=1)
    w = rn.exogenous([rn.Step(value), rn.WhiteNoise(0.1), rn.WhiteNoise(0.01)], 400, seed=3)
    run = rn.simulate(PLANT, schedule, w)
    fixed = rn.simulate(PLANT, rn.FixedController(schedule.at(value), l_r=1), w)
    assert run.outcome == "completed"
    assert run.u == pytest.approx(fixed.u, rel=1e-9, abs=1e-12)
    assert run.z == pytest.approx(fixed.z, rel=1e-9, abs=1e-12)
    assert (run.theta == value).all()
    assert np.allclose(run.compensator.past_y, schedule.at(value).past_y)


def test_integral_action_does_not_bump_where_the_variable_jumps():
    """In a steady state with zero error u(k) = u(k-1), whatever the gains are."""
    at_y1 = [
        rn.Compensator(past_u=[[[1.0]]], past_y=[[[0.0, 0.0, 0.0]], [[-gain, 0.0, gain]]])
        for gain in (0.01, 0.06)
    ]
    schedule = rn.GainSchedule([0, 1], at_y1, variable="y", component=1, l_r=1)
    controller, x, errors = schedule.started(), 0.0, []
    u = np.zeros(1)
    for k in range(2000):
        s = 0.0 if k < 1000 else 1.0  # where the plant is, which jumps
        before, u = u, controller.step([x, s], [2.0])
        errors.append(abs(x - 2.0))
        if k == 1000:
            assert errors[-1] < 1e-9 and abs(u - before) < 1e-9
        x = 0.8 * x + 0.4 * float(u[0])
    assert errors[-1] < 1e-9


def test_it_stabilises_a_plant_that_no_single_gain_of_it_does():
    """x(k+1) = a(s) x + u with a from 1.5 to 4 needs u = -g x with |a - g| < 1."""
    static = [
        rn.Compensator(past_u=np.zeros((0, 1, 1)), past_y=[[[-gain, 0.0]]]) for gain in (1.5, 4.0)
    ]
    schedule = rn.GainSchedule([1.5, 4.0], static, variable="y", component=1)

    def run(gains, steps=400):
        controller, x = gains.started(), 1.0
        for k in range(steps):
            a = 2.75 - 1.25 * np.cos(2 * np.pi * k / steps)
            x = a * x + float(controller.step([x, a])[0]) + 0.1
            if abs(x) > 1e6:
                return np.inf
        return abs(x)

    assert run(schedule) < 1
    for one in static:
        assert run(rn.GainSchedule([1.5, 4.0], [one, one], variable="y", component=1)) == np.inf


def scheduled():
    return rn.GainSchedule([0, 2], [of_error(0.001), of_error(0.004)], variable="r", l_r=1)


@pytest.mark.costly
def test_a_run_is_resumed_shown_and_healthy(tmp_path):
    w = rn.exogenous([rn.Levels([0.0, 1.0, 2.0], hold=200), rn.Step(0.0), rn.Step(0.0)], 600)
    whole, first = rn.simulate(PLANT, scheduled(), w), rn.simulate(PLANT, scheduled(), w[:250])
    rest = rn.simulate(PLANT, scheduled(), w[250:], start=first.state)
    assert np.array_equal(whole.u[250:], rest.u) and np.array_equal(whole.theta[250:], rest.theta)
    assert abs(whole.z[-1, 0]) < 1e-3
    assert rn.loop_health(whole).is_stable
    assert "stable" in rn.loop_health(whole).report()
    assert whole.plot().axes
    with pytest.raises(InputError, match="does not support saturation"):
        rn.simulate(PLANT, scheduled(), w, saturation=rn.Saturation(low=-1, high=1))
    with pytest.raises(InputError, match="has no freeze"):
        rn.frozen_twin(whole, 10)
    with pytest.raises(InputError, match="`simulate` runs it"):
        rn.simulate_many([rn.SimulationCase(PLANT, scheduled(), w)])


@pytest.mark.parametrize("raised", [KeyboardInterrupt, ZeroDivisionError])
def test_a_run_that_is_stopped_in_a_function_keeps_the_steps_before(raised):
    def output(k, x, w):
        if k == 5:
            raise raised
        return x, x

    plant = rn.FunctionPlant(
        advance=lambda k, x, u, w: 0.5 * x + u + w, output=output, n=1, l_u=1, l_w=1, l_y=1, l_z=1
    )
    table = [of_error(0.001), of_error(0.002)]
    fixed = rn.Compensator(table[0].past_u, table[0].past_y[:, :, :1])
    with pytest.raises((rn.RunInterrupted, FunctionFailedError)) as stopped:
        rn.simulate(plant, rn.GainSchedule([0, 1], [fixed, fixed]), np.ones((20, 1)))
    run = stopped.value.run
    assert run.steps == 5 and run.state is None
    assert run.outcome == ("interrupted" if raised is KeyboardInterrupt else "plant failed")
    assert ("ZeroDivisionError" in run.failure) == (raised is ZeroDivisionError)


def test_beside_a_device_it_copies_and_hears_what_was_applied():
    rng = np.random.default_rng(4)
    schedule = rn.GainSchedule([-1, 1], [drawn(rng, 2), drawn(rng, 1)], l_r=1)
    one = schedule.started()
    for _ in range(5):
        one.step(rng.standard_normal(1), [1.0])
    other, third = copy.deepcopy(one), schedule.started()
    third.take_up(one.save())
    again = pickle.loads(pickle.dumps(one))
    y = rng.standard_normal((5, 1))
    u = [one.step(value, [1.0]) for value in y]
    for twin in (other, third, again):
        assert np.array_equal(u, [twin.step(value, [1.0]) for value in y])
    with pytest.raises(ValueError, match="do not fit"):
        one.take_up(np.zeros(3))
    # Held at its limit, an integrator that hears of it does not wind up.
    wound, message = (
        rn.GainSchedule([0, 2], [integral(0.1)] * 2, "r", l_r=1).started() for _ in "ab"
    )
    b = np.zeros(1)
    for _ in range(100):
        a = wound.step([0.0], [1.0])
        b = message.step([0.0], [1.0], u_applied=np.minimum(b, 1.0))
    assert a[0] > 9 and b[0] == pytest.approx(1.1)


@pytest.mark.parametrize("broken", [{"y": [np.nan]}, {"r": [np.inf]}, {"y": [1, 2]}, {"r": []}])
def test_a_step_that_is_refused_moves_nothing(broken):
    controller = scheduled().started()
    controller.step([0.3], [1.0])
    before = controller.save()
    with pytest.raises(InputError):
        controller.step(**{"y": [0.1], "r": [1.0], "u_applied": [5.0], **broken})
    assert np.array_equal(controller.save(), before)


WIDE = rn.Compensator(past_u=[[[1.0]]], past_y=[[[0.0]], [[1.0]]])
# (q - 0.9)^3 and (q + 0.9)^3: between them a pole at 1.5 or so
FAR = [
    rn.Compensator(
        past_u=np.reshape(-np.poly([pole] * 3)[1:], (3, 1, 1)), past_y=np.ones((4, 1, 2))
    )
    for pole in (0.9, -0.9)
]


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: rn.GainSchedule([0], [integral(1)]), "1 values and 1 compensators"),
        (lambda: rn.GainSchedule([0, 1, 2], [integral(1)] * 2), "3 values and 2 compensators"),
        (lambda: rn.GainSchedule([1, 0], [integral(1)] * 2), "must increase"),
        (lambda: rn.GainSchedule([0, 0], [integral(1)] * 2), "must increase"),
        (lambda: rn.GainSchedule([0, np.nan], [integral(1)] * 2), "values has the entry nan"),
        (lambda: rn.GainSchedule([0, 1], [integral(1), WIDE]), "interpolation needs equal sizes"),
        (lambda: rn.GainSchedule([0, 1], [integral(1), "PI"]), "'PI' is not a Compensator"),
        (lambda: rn.GainSchedule([0, 1], integral(1)), "must be a list"),
        (lambda: rn.GainSchedule([0, 1], [integral(1)] * 2, "u"), "variable = 'u' is not known"),
        (lambda: rn.GainSchedule([0, 1], [integral(1)] * 2, "r"), "read no r"),
        (
            lambda: rn.GainSchedule([0, 1], [integral(1)] * 2, "y", 2),
            "component = 2 must be at most 1",
        ),
        (lambda: rn.GainSchedule([0, 1], [integral(1)] * 2, l_r=3), "l_r = 3 must be at most 2"),
        (
            lambda: rn.GainSchedule([0, 1], FAR),
            r"between 0 and 1 the compensator has a pole of size 1",
        ),
        (lambda: scheduled().at(np.inf), "value has the entry inf"),
        (lambda: scheduled().compensator_of([]), "theta has 0 entries"),
        (
            lambda: rn.simulate(rn.standard_plant("1/(q - 0.5)"), scheduled(), np.zeros((5, 1))),
            "command with l_r = 1",
        ),
    ],
)
def test_what_is_wrong_is_named(make, says):
    with pytest.raises(InputError, match=says):
        make()


def test_what_lies_between_is_looked_at_where_an_integrator_is():
    """A common pole at 1 stays, and two stable compensators of order two have none outside."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        roots = rng.uniform(0, 0.999, 4) * np.exp(1j * rng.uniform(0, np.pi, 4))
        pair = [np.poly([root, root.conj()]).real for root in roots[:2]]
        rn.GainSchedule([0, 1], [
            rn.Compensator(past_u=np.reshape(-p[1:], (2, 1, 1)), past_y=np.ones((3, 1, 1)))
            for p in pair
        ])  # fmt: skip
    rn.GainSchedule([0, 1], [integral(1), integral(2)])
