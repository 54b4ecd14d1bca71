"""Step tests: intervals hold the true coefficients, units and signs do not matter, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import lfilter, lti
from scipy.signal import step as scipy_step

from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric import ControllerLog, design, pid, read_log
from rcac_numeric.identification import identify_step_response
from rcac_numeric.identification._box_jenkins import NoiseModel
from rcac_numeric.identification._process_records import process_record
from rcac_numeric.identification._step_intervals import step_samples
from rcac_numeric.identification._step_models import (
    EQUAL,
    FIRST,
    INTEGRATING,
    LAGGED,
    SECOND,
    SHIFT,
    StepErrors,
    forced,
    unit_step,
)

ROWS = 300
T = np.arange(ROWS)
AT = 40


def record(S=25.0, rho=0.0, L=6.3, *, gain=2.0, noise=0.02, integrates=False, seed=0, height=1.0):
    """A step of u from 3, and y from 20."""
    v = np.random.default_rng(seed).standard_normal(ROWS)
    response = unit_step(T - AT - L, S, rho, integrates)
    size = np.ptp(response)
    return 3 + height * (T >= AT), 20 + gain * height * (response + noise * size * v)


@given(
    S=st.floats(0.5, 200), rho=st.sampled_from([0.0, 1e-4, 0.1, 0.2499999, 0.25, 0.26, 2.0, 50.0])
)
def test_the_step_response_is_that_of_scipy(S, rho):
    t = np.linspace(0, 5 * S * (1 + rho), 200)
    other = scipy_step(lti([1.0], [rho * S**2, S, 1.0] if rho else [S, 1.0]), T=t)[1]
    # The responses of poles closer than 1e-3 are those of poles 1e-3 apart.
    assert np.abs(unit_step(t, S, rho, False) - other).max() < 1e-5


@given(
    structure=st.sampled_from([FIRST, EQUAL, SECOND, INTEGRATING, LAGGED]), S=st.floats(1.0, 40),
    rho=st.floats(0.01, 3), L=st.floats(0, 20), seed=st.integers(0, 99),
)  # fmt: skip
def test_the_sampled_plant_is_the_held_one_at_any_dead_time(structure, S, rho, L, seed):
    """The sum of the step responses of all moves of u."""
    u = np.random.default_rng(seed).standard_normal(60)
    u[0] = 0.0
    theta = np.array([*[np.log(S), np.log(rho + SHIFT)][: structure.shape], L])
    lag = structure.lag(theta)
    moves = np.diff(u, prepend=0.0)
    t = np.arange(60)
    y = sum(move * unit_step(t - k - L, *lag, structure.integrates) for k, move in enumerate(moves))
    scale = np.abs(y).max()
    assert np.abs(forced(structure, theta, u) - y).max() <= 1e-7 * scale


@pytest.mark.costly
def test_a_lag_from_an_integration_in_time():
    """T y' = K u(t - L) - y by an adaptive Runge-Kutta method."""
    u = np.where(T >= AT, 1.0, 0.0)
    solution = solve_ivp(
        lambda t, y: (2.0 * (t >= AT + 7.4) - y) / 30.0, (0, ROWS), [0.0], max_step=0.5, rtol=1e-8,
        t_eval=T,
    )  # fmt: skip
    step = identify_step_response(u, solution.y[0], sample_time=0.5)
    assert step.kind == "first order"
    assert step.gain == pytest.approx(2.0, rel=1e-3)
    assert step.time_constants[0][0] == pytest.approx(15.0, rel=1e-2)
    assert step.dead_time == pytest.approx(3.7, abs=0.1)


TRUE = {
    "first order": {"S": 25.0, "rho": 0.0, "L": 6.3},
    "second order": {"S": 30.0, "rho": 0.2, "L": 6.3},
    "oscillating": {"S": 8.0, "rho": 2.0, "L": 4.6},
    "integrating": {"S": 0.0, "rho": 0.0, "L": 8.4, "integrates": True, "gain": 0.05},
    "integrating with a lag": {"S": 15.0, "rho": 0.0, "L": 8.4, "integrates": True, "gain": 0.05},
}


def holds(interval, true, factor=2.0):
    """Whether a 95 % interval, wider by a factor, holds the true value: 4 standard deviations."""
    low, high = interval
    middle = (low + high) / 2
    return abs(true - middle) <= factor * (high - low) / 2


@pytest.mark.costly
@pytest.mark.parametrize("kind", TRUE)
def test_the_true_coefficients_are_in_the_intervals(kind):
    case = TRUE[kind]
    for seed in range(3):
        u, y = record(**case, noise=0.01, seed=seed)
        step = identify_step_response(u, y, sample_time=2.0)
        assert kind in dict(step.credible_kinds)
        gain = case.get("gain", 2.0) / (2.0 if case.get("integrates") else 1.0)
        assert holds(step.gain_interval, gain)
        assert holds(step.dead_time_interval, 2 * case["L"])
        assert holds(step.residence_time[1:], 2 * (case["L"] + case["S"]))
        if step.damping is not None:
            assert holds(step.damping[1:], 1 / (2 * np.sqrt(case["rho"])))
            omega = 1 / (2 * case["S"] * np.sqrt(case["rho"]))
            assert holds(step.natural_frequency[1:], omega)
        assert step.operating_point == pytest.approx((3, 20), abs=0.1)
        assert np.abs(step.y - step.response).std() < 2 * step.residual


@pytest.mark.parametrize("kinds", [(INTEGRATING, FIRST), (FIRST, LAGGED), (SECOND, INTEGRATING)])
def test_the_model_that_is_handed_out_is_among_the_samples(kinds):
    """However incredible by AIC beside others: its coefficients have intervals."""
    u, y = record(noise=0.1)
    values = process_record(u, y)
    starts = {0: [6.0], 1: [3.0, 6.0], 2: [3.0, -1.5, 6.0]}
    first, other = (
        StepErrors(values, kind).fit(
            np.array(starts[kind.shape]), NoiseModel(np.ones(1), np.ones(1), 0)
        )
        for kind in kinds
    )
    rivals = [replace(other, bic=first.bic - 60.0, jumps=(100 + k,)) for k in range(8)]
    samples = step_samples(values, [first, *rivals])
    of_first = samples.among(samples.integrates == kinds[0].integrates)
    assert of_first.gain_interval()[0] <= first.gain <= of_first.gain_interval()[1]


@pytest.mark.costly
@settings(max_examples=6)
@given(
    seed=st.integers(0, 99), of_u=st.sampled_from([1e-5, 3.0, -1.0]),
    of_y=st.sampled_from([1e6, 0.7, -1.0]), h=st.sampled_from([1e-3, 60.0]),
    u_0=st.floats(-5, 5), y_0=st.floats(-50, 50),
)  # fmt: skip
def test_units_signs_and_operating_point_do_not_matter(seed, of_u, of_y, h, u_0, y_0):
    u, y = record(seed=seed)
    one = identify_step_response(u, y, sample_time=1.0)
    two = identify_step_response(of_u * (u + u_0), of_y * (y + y_0), sample_time=h)
    assert two.kind == one.kind
    assert two.gain == pytest.approx(one.gain * of_y / of_u, rel=1e-4)
    scaled = sorted(of_y / of_u * np.array(one.gain_interval))
    width = abs(scaled[1] - scaled[0])
    assert two.gain_interval == pytest.approx(scaled, abs=0.05 * width)
    assert two.dead_time == pytest.approx(h * one.dead_time, rel=1e-2)
    for T_two, T_one in zip(two.time_constants, one.time_constants, strict=True):
        assert T_two[0] == pytest.approx(h * T_one[0], rel=1e-2)
    assert two.operating_point == pytest.approx(
        (of_u * (one.operating_point[0] + u_0), of_y * (one.operating_point[1] + y_0)),
        rel=1e-3, abs=1e-3 * abs(of_y),
    )  # fmt: skip


@pytest.mark.costly
def test_a_level_jump_beside_the_step_is_found():
    u, y = record()
    step = identify_step_response(u, y + 0.7 * (T >= 200), sample_time=1.0)
    ((time, size),) = step.jumps
    assert time == 200.0 and size == pytest.approx(0.7, abs=0.1)
    assert holds(step.gain_interval, 2.0) and holds(step.dead_time_interval, 6.3)


@pytest.mark.costly
def test_noise_of_a_measured_u_is_averaged():
    u, y = record()
    noisy = u + 0.01 * np.random.default_rng(5).standard_normal(ROWS)
    step = identify_step_response(noisy, y)
    assert step.u_noise == pytest.approx(0.01, rel=0.2) and step.moves == 1
    assert holds(step.gain_interval, 2.0) and holds(step.time_constants[0][1:], 25.0)


@pytest.mark.costly
def test_a_response_that_has_not_settled_leaves_the_gain_open():
    u, y = record(S=400.0, noise=0.02)
    low, high = identify_step_response(u, y).gain_interval
    assert low < 2.0 < high and high > 1.5 * low


@pytest.mark.costly
def test_a_jump_of_the_disturbance_is_no_step_response():
    rng = np.random.default_rng(2)
    y = 2.0 * (T >= AT + 3) + 0.2 * rng.standard_normal(ROWS)
    with pytest.raises(UndecidedError, match="level jumps"):
        identify_step_response(1.0 * (T >= AT), y)


def test_a_record_that_begins_after_its_step_is_refused():
    u, y = record()
    with pytest.raises(InputError, match="before the step"):
        identify_step_response(u[AT:], y[AT:])


@pytest.mark.costly
def test_noise_alone_is_refused():
    y = np.random.default_rng(0).standard_normal(ROWS)
    with pytest.raises(UndecidedError, match="effect of u"):
        identify_step_response(1.0 * (T >= AT), y)


@pytest.mark.parametrize("limit", [0.4, 0.8])
def test_a_sensor_at_its_limit_is_refused(limit):
    u, y = record()
    with pytest.raises(UndecidedError, match="limit of the sensor"):
        identify_step_response(u, np.minimum(y, 20 + 2 * limit))


@pytest.mark.costly
@pytest.mark.parametrize("quantum", [0.02, 0.1, 0.3])
def test_rounding_is_no_limit(quantum):
    u, y = record(noise=0.01)
    step = identify_step_response(u, quantum * np.round(y / quantum))
    assert holds(step.gain_interval, 2.0)


def test_a_closed_loop_is_refused():
    rng = np.random.default_rng(0)
    u, y, x = np.zeros(400), np.zeros(400), 0.0
    for k in range(400):
        y[k] = x + 0.1 * rng.standard_normal()
        u[k] = (k > 50) - 0.5 * y[k]
        x = 0.9 * x + 0.3 * u[k]
    with pytest.raises(InputError, match="closed loop"):
        identify_step_response(u, y)


@pytest.mark.costly
def test_a_log_brings_its_sample_time():
    u, y = record()
    log = read_log({"t": 5.0 * T, "u": u, "y": y})
    step, same = identify_step_response(log), identify_step_response(u, y, sample_time=5.0)
    assert step == same and step.sample_time == 5.0
    gaps = read_log({"t": 5.0 * np.delete(T, 100), "u": np.delete(u, 100), "y": np.delete(y, 100)})
    with pytest.raises(InputError, match="missing"):
        identify_step_response(gaps)


@pytest.mark.parametrize(
    ("arguments", "options", "words"),
    [
        ((np.ones(100), np.arange(100)), {}, "u is constant"),
        ((np.arange(100.0), np.ones(100)), {}, "y is constant"),
        ((np.arange(20.0), np.arange(20.0)), {}, "at least 30"),
        ((np.arange(100.0), np.arange(99.0)), {}, "equally long"),
        ((np.eye(100), np.arange(100.0)), {}, "columns"),
        ((np.arange(100.0),), {}, "read_log"),
        (record(), {"sample_time": 0.0}, "positive"),
        (record(), {"sample_time": -1.0}, "positive"),
        ((np.where(T > 3, np.nan, 0.0), T), {}, "u"),
    ],
)
def test_bad_input_is_refused(arguments, options, words):
    with pytest.raises(InputError, match=words):
        identify_step_response(*arguments, **options)


def test_a_table_is_read_by_read_log_first():
    pandas = pytest.importorskip("pandas")
    u, y = record()
    with pytest.raises(InputError, match="read_log"):
        identify_step_response(pandas.DataFrame({"u": u, "y": y}))


@given(seed=st.integers(0, 99), L=st.floats(0.5, 30), S=st.floats(3, 60))
@settings(max_examples=20)
def test_the_projected_errors_are_orthogonal_to_what_is_free(seed, L, S):
    u, y = record(seed=seed)
    data = process_record(u, y)
    errors = StepErrors(data, FIRST, slope=True, jumps=(200,))
    noise = NoiseModel(np.array([1.0, 0.3]), np.array([1.0, -0.7]), 0)
    theta = np.array([np.log(S), L])
    point = errors.at(theta, noise)
    white = lfilter(noise.D, noise.C, data.y - errors.deterministic(theta, point.free))
    assert np.abs(white - point.e).max() < 1e-6 * np.abs(point.e).max()
    assert np.abs(point.basis.T @ point.e).max() < 1e-8 * np.linalg.norm(point.e)


@pytest.mark.costly
def test_a_step_test_is_designed_for():
    u, y = record(S=80.0, L=20.0)
    step = identify_step_response(u, y, sample_time=1.0)
    designed = design(step, structure=pid("PI"), u_limits=(-20, 20), seeds=1, steps=500)
    assert designed.model.sample_time == step.control_period
    assert 20 <= step.residence_time[0] / step.control_period < 26
    # `plant` has six digits.
    assert designed.model.gain_at_rest == pytest.approx(step.gain, rel=1e-5)
    low, high = designed.uncertainty.gain
    assert low <= step.gain_factors[0] and high >= step.gain_factors[1]


@pytest.mark.costly
def test_a_controller_log_is_a_record():
    u, y = record()
    step = identify_step_response(ControllerLog(u, y))
    assert step == identify_step_response(u, y) and step.unit == "steps"


@pytest.mark.costly
def test_the_report_has_five_lines_and_the_picture_the_record():
    u, y = record()
    step = identify_step_response(u, y, sample_time=1.0)
    section = step._sheet().sections[0]
    assert len(section.blocks) == 5
    figure = step.plot()
    assert np.array_equal(figure.axes[0].lines[0].get_ydata(), step.y)
