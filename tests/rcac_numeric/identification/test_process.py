"""Models of process records: right under drift, jumps, walks and spikes, and refused where open."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.signal import lfilter

from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric import Compensator
from rcac_numeric.compiled._box_jenkins import confined
from rcac_numeric.designing._log_gates import GateLoop, rivals_gate, rivals_of
from rcac_numeric.identification import identify_process
from rcac_numeric.identification._box_jenkins import (
    ONE,
    NoiseModel,
    ProcessFit,
    Start,
    fitted,
    start_of,
    value_before,
)
from rcac_numeric.identification._delay_scan import delay_scan
from rcac_numeric.identification._disturbance_parts import without_level_jumps
from rcac_numeric.identification._hidden_pairs import has_hidden_pair
from rcac_numeric.identification._prediction_error import ODDS, _odds_of_cause, leads
from rcac_numeric.identification._process import search_of
from rcac_numeric.identification._process_evidence import (
    KNOWN,
    OMEGA,
    feedthrough_gate,
    parameter_covariance,
    with_faster_pole,
)
from rcac_numeric.identification._process_records import (
    _gauss,
    _student,
    at_rest,
    likelihood_of,
    process_record,
    without_spikes,
)
from tests.support.strategies import seeds

STEPS = 1500
ROWS = np.arange(STEPS)
SLOW_DISTURBANCES = {
    "a level jump": lambda rng: 5.0 * (ROWS > 750),
    "a random walk": lambda rng: 0.1 * np.cumsum(rng.standard_normal(STEPS)),
    "a drift": lambda rng: 8.0 * ROWS / STEPS,
    "a sinusoid": lambda rng: 5 * np.sin(0.05 * ROWS),
    "a spike": lambda rng: 1000.0 * (ROWS == 700),
}


def lag(u, noise, rng, delay=0, pole=0.8, gain=0.5):
    """y(k) = pole y(k-1) + gain u(k-1-delay), with white noise."""
    y = lfilter(np.r_[np.zeros(delay + 1), gain], [1, -pole], u)
    return y + noise * rng.standard_normal(len(u))


def error_of(model, pole, gain, delay=0):
    """The largest relative error of the response at 0.1 to 0.5 rad/step."""
    past = np.exp(-1j * np.linspace(0.1, 0.5, 9))
    true = gain * past ** (delay + 1) / (1 - pole * past)
    top = np.polyval(model.numerator[::-1], past) * past ** (model.delay + 1)
    return np.max(np.abs(top / np.polyval(model.denominator[::-1], past) / true - 1))


@pytest.mark.costly
@pytest.mark.parametrize("name", SLOW_DISTURBANCES)
def test_slow_disturbances_and_spikes_do_not_reach_the_model(name):
    """The same plant without them: errors of noise of 0.01 alone are 0.001."""
    rng = np.random.default_rng(0)
    u = rng.standard_normal(STEPS)
    model = identify_process(u, lag(u, 0.01, rng) + SLOW_DISTURBANCES[name](rng))
    assert error_of(model, 0.8, 0.5) < 0.05 and not model.failed
    assert model.spikes == (name == "a spike")
    assert (
        any(one.delay <= 0 <= model.delay + 1 for one in (model, *model.rivals))
        and model.delay_interval[0] <= 0
    )


@pytest.mark.costly
@settings(max_examples=15)
@given(
    at=st.integers(3, 20), gain=st.sampled_from([-2.0, 0.5, 1e4]), offset=st.floats(-5, 5),
    seed=st.integers(0, 99),
)  # fmt: skip
def test_a_step_in_the_first_rows_counts(at, gain, offset, seed):
    rng = np.random.default_rng(seed)
    u = 1.0 * (np.arange(300) >= at) + offset
    y = gain * lag(u - offset, 0.01, rng, gain=1.0) + 3 * gain
    model = identify_process(u, y)
    low, high = model.gain_interval
    # A 95 % interval, twice as wide: 4 standard deviations.
    assert 2 * low - model.gain <= 5 * gain <= 2 * high - model.gain
    assert error_of(model, 0.8, gain) < 0.2


@pytest.mark.costly
@pytest.mark.parametrize("delay", [31, 200])
def test_long_dead_times_need_no_range(delay):
    rng = np.random.default_rng(3)
    u = np.repeat(rng.choice([-1.0, 1.0], 300), 10)
    walk = 0.02 * np.cumsum(rng.standard_normal(3000))
    model = identify_process(u, lag(u, 0.05, rng, delay, 0.9) + walk, sample_time=2.0)
    first, last = model.delay_interval
    assert first <= delay <= last + 1 and error_of(model, 0.9, 0.5, delay) < 0.1
    assert model.dead_time == 2.0 * model.delay
    slowest, low, high = model.time_constants[0]
    assert low < slowest < high and slowest == pytest.approx(-2 / np.log(0.9), rel=0.1)


@pytest.mark.costly
def test_an_unstable_plant_under_a_weak_dither_is_among_the_credible_models():
    """x(k+1) = 1.06 x(k) + 0.5 u(k); a stable model predicts nearly as well there."""
    for seed in range(5):
        rng = np.random.default_rng(seed)
        u, y, x = np.zeros(1500), np.zeros(1500), 0.0
        for k in range(1500):
            y[k] = x + 0.5 * rng.standard_normal()
            u[k] = 0.2 * rng.choice([-1, 1]) - 0.3 * y[k]
            x = 1.06 * x + 0.5 * u[k]
        search = search_of(u, y, None)
        poles = [np.abs(one.poles).max() for one in search.fits if search.credible(one)]
        assert any(1.0 < pole < 1.15 for pole in poles)


@given(seed=st.integers(0, 999), count=st.integers(1, 3), weighted=st.booleans())
def test_the_scan_of_delays_is_least_squares_at_each(seed, count, weighted):
    rng = np.random.default_rng(seed)
    u, y, free = rng.standard_normal((2, 80)), rng.standard_normal(80), rng.standard_normal((2, 80))
    weights = rng.uniform(0.5, 1, 80) if weighted else None
    scan = delay_scan(y, u, np.stack([free, free]), count, 6, weights)
    w = np.ones(80) if weights is None else weights
    for candidate in range(2):
        for delay in range(6):
            forced = [np.r_[np.zeros(delay + i), u[candidate, : 80 - delay - i]] * w
                      for i in range(1, count + 1)]  # fmt: skip
            X = np.stack([*forced, *free]).T
            theta, *_ = np.linalg.lstsq(X, y, rcond=None)
            assert scan.squares[candidate, delay] == pytest.approx(np.sum((y - X @ theta) ** 2))
            np.testing.assert_allclose(scan.numerators[candidate, delay], theta[:count], atol=1e-6)


@given(st.lists(st.floats(-3, 3), min_size=1, max_size=4))
def test_confined_roots_have_the_response_of_an_all_pass_beside(a):
    A = np.r_[1.0, a]
    within = confined(A, 0.999)
    assert np.abs(np.roots(within)).max(initial=0) <= 0.999 + 1e-6


@pytest.mark.costly
def test_units_and_offsets_change_nothing_but_units():
    rng = np.random.default_rng(5)
    u = np.repeat(rng.choice([-1.0, 1.0], 100), 5)
    y = lag(u, 0.1, rng, 4) + 0.05 * np.cumsum(rng.standard_normal(500))
    one, other = identify_process(u, y), identify_process(1e-6 * u + 7, 1e6 * y - 3e6)
    assert other.delay == one.delay and other.order == one.order
    np.testing.assert_allclose(other.numerator / 1e12, one.numerator, rtol=1e-5)
    np.testing.assert_allclose(other.gain_interval, np.multiply(1e12, one.gain_interval), rtol=1e-4)


@pytest.mark.costly
def test_a_minimum_beside_a_cancelled_pair_is_left():
    """Poles 0.75 and 1e-5 with b = 0: a start that has a pole and a zero too many."""
    rng = np.random.default_rng(0)
    u = rng.standard_normal(400)
    y = lfilter([0, 1.0], np.poly([0.75, 1e-5]), u)
    model = identify_process(u, y + 1e-6 * rng.standard_normal(400))
    assert error_of(model, 0.75, 1.0) < 1e-4


@pytest.mark.costly
def test_a_sinusoid_does_not_become_the_poles_of_an_integrating_plant():
    """0.008/((q - 1)(q - 0.8)) under a sinusoid of twice what u does, 500 steps."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        u = np.repeat(rng.choice([-1.0, 1.0], 100), 5)
        plant = lfilter([0, 0.008, 0.0075], np.poly([1.0, 0.8]), u)
        size = np.std(plant)
        wave = 2 * size * np.sin(0.0322 * np.arange(500) + seed)
        model = identify_process(u, plant + wave + 0.03 * size * rng.standard_normal(500))
        past = np.exp(-1j * np.linspace(0.02, 0.3, 9))
        true = (0.008 * past + 0.0075 * past**2) / ((1 - past) * (1 - 0.8 * past))
        top = np.polyval(model.numerator[::-1], past) * past ** (model.delay + 1)
        error = np.abs(top / np.polyval(model.denominator[::-1], past) / true - 1)
        assert error.max() < 0.5


def test_level_jumps_of_a_loop_are_those_of_its_innovations():
    """Two jumps of 100 standard deviations of the noise; the command moves y by as much."""
    rng = np.random.default_rng(3)
    u, y, x = np.zeros(800), np.zeros(800), 0.0
    jumps = np.zeros(800)
    jumps[300], jumps[500] = 2.0, -1.5
    level, command = np.cumsum(jumps), np.repeat(rng.uniform(-2, 2, 20), 40)
    for k in range(800):
        y[k] = x + level[k] + 0.02 * rng.standard_normal()
        u[k] = -0.3 * (y[k] - command[k])
        x = 1.03 * x + 0.5 * u[k]
    record = process_record(u, y)
    removed = np.diff(record.y - without_level_jumps(record), prepend=0.0) * record.units[1]
    # A jump is known to a few standard deviations of the innovations, and none is invented.
    assert np.abs(removed - jumps).max() < 0.2


@given(
    st.lists(st.floats(0, 0.9), min_size=1, max_size=2), st.floats(-1.4, 1.4),
    st.sampled_from([0.9, 1.0]),
)  # fmt: skip
def test_only_a_polynomial_with_a_root_outside_the_circle_is_changed(inner, last, radius):
    assume(abs(abs(last) - radius) > 1e-3 and abs(max(inner) - radius) > 1e-3)
    A = np.poly([*inner, last])
    is_changed = not np.array_equal(confined(A, radius), A)
    assert is_changed == (max(*inner, abs(last)) > radius)


@pytest.mark.parametrize(("steps", "hidden"), [(200, True), (20000, False)])
def test_a_pair_that_the_record_does_not_resolve_is_hidden(steps, hidden):
    """A pole at 1 and a zero at 1.006: 2 pi/200 is 0.03, 2 pi/20000 is 0.0003."""
    fit = SimpleNamespace(
        poles=np.array([1.0, 0.94]), B=np.poly([1.006]), e=np.zeros(steps)
    )  # fmt: skip
    assert has_hidden_pair(fit) == hidden


@pytest.mark.costly
def test_jumps_that_look_like_the_answer_to_one_step_fail_the_gate():
    """Three level jumps, the first of them near the only step of u, to which y does not respond."""
    rng = np.random.default_rng(2)
    k = np.arange(600)
    y = 4.0 * (k > 310) - 3.0 * (k > 450) + 0.05 * rng.standard_normal(600)
    try:
        model = identify_process(1.0 * (k >= 300), y)
    except UndecidedError:
        return
    assert "level jumps" in {gate.name for gate in model.failed}


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(4))
def test_a_jump_in_the_row_in_which_the_response_begins_leaves_the_sign_open(seed):
    """A level jump against the response to the only step of u, with the largest of its errors."""
    rng = np.random.default_rng(seed)
    row, delay, pole = int(rng.integers(50, 100)), int(rng.integers(3, 12)), rng.uniform(0.85, 0.95)
    k = np.arange(300)
    y = lag(1.0 * (k >= row), 0.02, rng, delay, pole, 1 - pole) - 4.0 * (k >= row + delay + 1)
    model = identify_process(1.0 * (k >= row), y)
    assert {"sign", "level jumps"} & {gate.name for gate in model.failed}


@pytest.mark.costly
@pytest.mark.parametrize("drift", [-4.0, 4.0])
def test_a_slope_beside_an_early_step_is_no_pole_at_1(drift):
    """From the step on, a slope and a ramp of the response to u are one signal."""
    rng = np.random.default_rng(3)
    u, k = 1.0 * (np.arange(1500) >= 3), np.arange(1500)
    y = lfilter([0, -0.037, 0.0472], np.poly([0.9, 0.89]), u) + drift * k / 1500
    search = search_of(u, y + 0.02 * rng.standard_normal(1500), None)
    sloped = [one for one in search.distinct if one.slope and not one.summed]
    assert any(np.abs(one.poles).max() < 0.95 for one in sloped)


@pytest.mark.parametrize("seed", [8, 11, 23])
def test_after_one_early_step_an_integrating_plant_is_credible_beside_a_slope(seed):
    """A plant with a pole at 1: a controller for a slope of the disturbance may lose it."""
    rng, steps = np.random.default_rng(seed), 1000
    u = np.asarray(np.arange(steps) >= 10, dtype=np.float64)
    y = lfilter([0, 0.05, 0.04], np.convolve([1, -1], [1, -0.53]), u)
    y += 0.5 * rng.standard_normal(steps)
    spikes = rng.choice(steps, steps // 200, replace=False)
    y[spikes] += 15 * rng.standard_normal(len(spikes))
    search = search_of(u, y, None)
    assert any(one.summed or np.abs(one.poles).max() > 1 - 1e-4 for one in search.distinct)


@pytest.mark.parametrize(
    ("gain", "deviation", "passes"),
    [(0.051, 1e-6, False), (0.3, 1e-6, True), (0.3, 0.05, True), (0.3, 0.2, False)],
)
def test_a_credible_unstable_model_must_be_held_with_a_margin(gain, deviation, passes):
    """x(k+1) = 1.05 x(k) + u(k): a gain just above 0.05 holds it, one of 0.3 robustly.

    And with a pole two standard deviations farther out: 1.15 minus 0.3, and not 1.45.
    """
    record = process_record(np.arange(40.0) % 7, np.arange(40.0) % 5)
    e = np.ones(40)
    jacobian = np.zeros((2, 40))
    jacobian[0, 0], jacobian[1, 1] = 1 / deviation, 1e6
    one = ProcessFit(
        np.array([1, -1.05]), ONE * record.units[0] / record.units[1], 0, NoiseModel(ONE, ONE, 0),
        False, False, True, 0.0, 0, e, jacobian, 2, 0.0, False,
    )  # fmt: skip
    search = SimpleNamespace(
        record=record, fits=[one], jumped=[], credible=lambda fit: True, is_known=True
    )
    fit = SimpleNamespace(armax=True, B=one.B, denominator=np.array([1, -0.5]), delay=0)
    K = Compensator(np.zeros((0, 1, 1)), [[[gain]]])
    loop = GateLoop(K, np.ones(len(OMEGA)), 0.1)
    assert rivals_gate(loop, rivals_of(search, fit, None, 1)).passed is passes


@given(seed=seeds)
def test_a_faster_pole_is_that_of_the_likeliest_coefficients_with_it(seed):
    """Of draws from the covariance those with the pole at the end of its interval, on average."""
    rng = np.random.default_rng(seed)
    record = process_record(np.arange(40.0) % 7, np.arange(40.0) % 5)
    size = 1e3 * np.exp(rng.uniform(-1, 1, (3, 1)))
    fit = ProcessFit(
        np.array([1, -1.02 - 0.5, 1.02 * 0.5]), np.array([0.3]), 0, NoiseModel(ONE, ONE, 0),
        False, False, True, 0.0, 0, np.ones(40), size * rng.standard_normal((3, 40)), 3, 0.0, False,
    )  # fmt: skip
    covariance = parameter_covariance(record, fit)
    draws = rng.multivariate_normal(np.r_[fit.A[1:], fit.B], covariance, 4000)
    poles = np.array([np.roots([1, *one[:2]]).real.max() for one in draws])
    end = poles.mean() + 2 * poles.std()
    moved = with_faster_pole(record, fit)
    assert np.roots(moved.A).max() == pytest.approx(end, abs=0.2 * poles.std())
    slope = np.cov(draws.T, poles)[:3, 3] / poles.var()  # regression on the pole
    expected = np.r_[fit.A[1:], fit.B] + 2 * poles.std() * slope
    spread = np.sqrt(np.diag(covariance))
    assert np.abs((np.r_[moved.A[1:], moved.B] - expected) / spread).max() < 0.2


@given(
    seed=st.integers(0, 99), scale=st.floats(0.03, 30), quantum=st.sampled_from([0.5, 1.0, 3.0])
)  # fmt: skip
def test_the_likelihood_of_a_rounded_output_is_that_of_its_cells(seed, scale, quantum):
    e = scale * quantum * np.random.default_rng(seed).standard_t(4, 300)
    low, high = np.abs(e) - quantum / 2, np.abs(e) + quantum / 2
    for log_share, law in ((_gauss, stats.norm), (_student, stats.t(4))):
        spread = max(scale, 0.3) * quantum
        share = law.sf(low / spread) - law.sf(high / spread)
        resolved = share > 1e-9  # below it the difference of two tails has no digits
        ours = log_share(low / spread, high / spread)
        assert ours[resolved] == pytest.approx(np.log(share[resolved]), rel=1e-5, abs=1e-6)
    fine = likelihood_of(e, quantum * 1e-5)
    assert fine[0] == pytest.approx(likelihood_of(e, 0.0)[0], abs=1e-2)
    assert fine[1] == pytest.approx(likelihood_of(e, 0.0)[1], abs=1e-2)


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(3))
def test_a_binary_u_shows_its_effect_on_a_coarsely_rounded_output(seed):
    """Steps of half of the deviation of y: without u most rows repeat the one before."""
    rng = np.random.default_rng(seed)
    u = np.repeat(rng.choice([-1.0, 1.0], 75), 20)
    y = lfilter([0, 0.005], np.poly([0.9, 0.95]), u)
    quantum = 0.5 * np.std(y)
    y = quantum * np.round((y + 0.03 * np.std(y) * rng.standard_normal(1500)) / quantum)
    model = identify_process(u, y)
    assert model.gain == pytest.approx(1.0, rel=0.15) and not model.failed


MOVES = {
    "few values": lambda rng: np.repeat(rng.choice([-1.0, 1.0], 200), 3),
    "white": lambda rng: rng.standard_normal(600),
}


@pytest.mark.costly
@pytest.mark.parametrize("kind", MOVES)
def test_direct_feedthrough_is_part_of_the_model(kind):
    """y(k) = 0.8 y(k-1) + 0.5 u(k) + 0.2 u(k-1)."""
    rng = np.random.default_rng(4)
    u = MOVES[kind](rng)
    y = lfilter([0.5, 0.2], [1, -0.8], u) + 0.05 * rng.standard_normal(600)
    model = identify_process(u, y)
    assert model.is_direct and (model.delay, model.delay_interval) == (0, (0, 0))
    assert not model.failed and model.numerator[0] == pytest.approx(0.5, abs=0.05)
    z = np.exp(0.3j)
    top, bottom = (np.polyval(one, z) for one in model.transfer_function)
    assert abs(top / bottom / ((0.5 + 0.2 / z) / (1 - 0.8 / z)) - 1) < 0.05
    with pytest.raises(InputError, match=r"y\(k\) responds to u\(k\)"):
        identify_process(u, y, delay=0)
    assert not identify_process(u[1:], y[:-1]).is_direct
    search = search_of(u[1:], y[:-1], None)
    gate = feedthrough_gate(search, search.fits[0])
    assert gate.passed and gate.limit == ODDS and KNOWN < 1 and not search.is_direct


@pytest.mark.parametrize("seed", [4, 10, 13])
def test_a_sinusoid_from_the_first_row_is_no_oscillation_that_an_early_step_excites(seed):
    """A step of size 1.7 in y beside a sinusoid of 4: both begin in the same rows."""
    rng, rows = np.random.default_rng(seed), np.arange(600)
    u = np.asarray(rows >= rng.integers(4, 16), dtype=np.float64)
    omega, phase = rng.uniform(0.01, 0.06), rng.uniform(0, 6)
    B = [0.0] * (1 + int(rng.integers(0, 10))) + [0.05]
    y = lfilter(B, np.poly([0.9, 0.7]), u) + 4 * np.sin(omega * rows + phase)
    best = search_of(u, y + 0.1 * rng.standard_normal(600), None).fits[0]
    assert best.sinusoid == pytest.approx(omega, abs=1e-3)
    assert np.abs(best.poles[best.poles.imag > 1e-3]).max(initial=0) < 0.99


@pytest.mark.costly
@pytest.mark.parametrize("seed", [9, 27])
def test_a_sinusoid_of_a_loop_is_seen_whatever_plant_the_search_has(seed):
    """Its frequency is a root on the circle of a long regression; a wrong plant hides it."""
    rng, steps, delay = np.random.default_rng(seed), 1000, 8
    omega, r = rng.uniform(0.02, 0.06), rng.uniform(-1, 1, 12).repeat(84)[:steps]
    d = 3 * np.sin(omega * np.arange(steps)) + 0.03 * rng.standard_normal(steps)
    u, y, x, total = np.zeros(steps), np.zeros(steps), np.zeros(2), 0.0
    for k in range(steps):
        y[k] = x[0] + d[k]
        total += r[k] - y[k]
        u[k] = 1.6 * (r[k] - y[k]) + 0.1 * total
        x = np.array([[0.9, 1.0], [0.0, 0.88]]) @ x
        x[1] += 0.004 * u[max(k - delay, 0)]
    best = search_of(u, y, None).fits[0]
    assert best.sinusoid == pytest.approx(omega, abs=1e-4)


@pytest.mark.parametrize("integrates", [False, True])
@given(seed=st.integers(0, 999), before=st.floats(-3, 3), delay=st.integers(5, 40))
def test_the_u_before_a_record_is_seen_in_its_first_rows(integrates, seed, before, delay):
    """The model is that of the record itself; from zero the first rows would be errors."""
    rng, steps, first = np.random.default_rng(seed), 400, 400
    u = np.concatenate([np.full(first, before), rng.choice([-1.0, 1.0], 40).repeat(10)])
    B, A = [0.0] * (delay + 1) + [0.3], np.poly([0.9, 1.0] if integrates else [0.9])
    start = before if integrates else 0.0  # of a plant that integrates, u - before is at rest
    y = lfilter(B, A, u - start)[first:] + 0.01 * rng.standard_normal(steps)
    record = process_record(u[first:], y)
    true = (before - at_rest(u[first:])) / record.units[0]
    B_1 = np.array([0.3, 0.0][: 1 + integrates]) * record.units[0] / record.units[1]
    noise = NoiseModel(ONE, ONE, 0)
    model = Start(np.array([1.0, -0.9]), B_1, delay, noise, summed=integrates)
    total = 0.0
    for _ in range(4):  # the first rows are outliers of the first fit
        fit = fitted(record, model, iterations=0)
        assume(fit is not None)
        pays, value = value_before(record, fit)
        assert pays >= -np.log(steps) * (1 + 1e-9)
        record, total = record.counted_from(value), total + value
        moved = fitted(record, model, iterations=0)
        if not fit.heavy:  # then it is least squares, and pays is what they gain
            ratio = (moved.e @ moved.e) / (fit.e @ fit.e)
            assert steps * np.log(ratio) + np.log(steps) == pytest.approx(-pays, abs=1e-6)
    slope = moved.e - fitted(record.counted_from(1.0), model, iterations=0).e
    deviation = 0.01 / record.units[1] / np.linalg.norm(slope)
    assert abs(total - true) < 6 * deviation


def test_the_u_before_a_record_does_not_reach_the_model():
    rng = np.random.default_rng(3)
    u = np.concatenate([np.zeros(60), rng.choice([-1.0, 1.0], 60).repeat(10)])
    y = lfilter([0.0] * 31 + [0.04], [1, -0.98], u) + 0.01 * rng.standard_normal(660)
    model = identify_process(u[60:], y[60:])
    assert not model.failed and model.delay == 30 and error_of(model, 0.98, 0.04, 30) < 0.02
    assert model.u_before == pytest.approx(0, abs=0.05)


@pytest.mark.costly
def test_a_controller_that_reads_y_of_the_row_is_no_feedthrough():
    """By the reverse: u(k) responds to y(k), with and without a state, and a white dither."""
    for seed in range(6):
        rng = np.random.default_rng(seed)
        u, y, x, state = np.zeros(1000), np.zeros(1000), 0.0, 0.0
        noise = lfilter([1.0], [1, -0.6 * (seed % 2)], 0.3 * rng.standard_normal(1000))
        for k in range(1000):
            y[k] = x + noise[k]
            u[k] = rng.standard_normal() - 0.5 * y[k] - 0.1 * state
            state += y[k] if seed % 3 else 0.0
            x = 0.9 * x + 0.5 * u[k]
        assert not search_of(u, y, None).is_direct


@pytest.mark.costly
def test_a_coloured_input_leaves_the_direction_of_a_step_undecided():
    """The controller 1/G would make this u of white y. Paired as the error says, it is decided."""
    rng = np.random.default_rng(4)
    u = lfilter([1.0], [1, -0.9], rng.standard_normal(600))
    y = lfilter([0.5, 0.2], [1, -0.8], u) + 0.05 * rng.standard_normal(600)
    with pytest.raises(UndecidedError, match=r"y\[:-1\] with u\[1:\]"):
        identify_process(u, y)
    model = identify_process(u[1:], y[:-1])
    assert not model.failed and model.delay == 0
    assert model.numerator[0] == pytest.approx(0.5, abs=0.05)
    assert not search_of(u, y, None, is_commanded=True).is_direct


@given(
    seed=st.integers(0, 2**32 - 1), noise=st.floats(0.5, 3), hold=st.integers(1, 8),
    direct=st.floats(0.2, 0.8), integral=st.floats(0.0, 0.05), root=st.floats(0.7, 0.95),
)  # fmt: skip
def test_noise_through_a_controller_shows_no_open_loop(seed, noise, hold, direct, integral, root):
    """u repeats noise larger than the dither: past y tells of it nothing that past u does not."""
    rng = np.random.default_rng(seed)
    steps = 400
    e, dither = noise * rng.standard_normal(steps), rng.choice([-1.0, 1.0], steps).repeat(hold)
    u, y, x, total = np.zeros(steps), np.zeros(steps), 0.0, 0.0
    for k in range(steps):
        y[k] = x + e[k]
        total += y[k]
        u[k] = dither[k] - direct * y[k] - integral * total
        x = root * x + (1 - root) * u[k]
    assert leads(u, y) is not True


@given(seed=st.integers(0, 999), gain=st.floats(0.2, 0.8), binary=st.booleans())
def test_a_proportional_controller_of_white_noise_shows_no_open_loop(seed, gain, binary):
    """u is white, as one that is drawn: the plant answers later than any lag that is tried."""
    rng, steps, delay = np.random.default_rng(seed), 600, 25
    dither = rng.choice([-1.0, 1.0], steps) if binary else rng.standard_normal(steps)
    e, u, y = 2 * rng.standard_normal(steps), np.zeros(steps), np.zeros(steps)
    for k in range(steps):
        y[k] = e[k] + (0.2 * u[k - delay] if k >= delay else 0.0)
        u[k] = dither[k] - gain * y[k]
    assert leads(u, y) is not True


@given(
    seed=st.integers(0, 999), noise=st.floats(0.5, 3), gain=st.floats(0.3, 2), binary=st.booleans()
)  # fmt: skip
def test_distributions_show_which_value_of_a_row_moves_the_other(seed, noise, gain, binary):
    """u = dither + gain y: of two values the dither shows that u responds; Gaussian it does not."""
    rng = np.random.default_rng(seed)
    y = noise * rng.standard_normal(1000)
    dither = rng.choice([-1.0, 1.0], 1000) if binary else rng.standard_normal(1000)
    past = rng.standard_normal((1000, 3))
    odds = _odds_of_cause(y, dither + gain * y, past)
    assert odds == pytest.approx(-_odds_of_cause(dither + gain * y, y, past), abs=1e-6)
    assert odds > ODDS if binary else abs(odds) < ODDS
    assert _odds_of_cause(y, gain * y, past) == _odds_of_cause(past @ [1, 2, 3], y, past) == 0


@given(
    seed=st.integers(0, 999), width=st.sampled_from([1, 2]), gap=st.sampled_from([1, 2, 30]),
    size=st.sampled_from([-30.0, 5.0, 100.0]),
)  # fmt: skip
def test_spikes_are_replaced_and_a_peak_of_the_response_is_not(seed, width, gap, size):
    """Spikes of one row beside each other, or one of two rows; a response that rises in 3 rows."""
    rng = np.random.default_rng(seed)
    k = np.arange(500)
    smooth = 3 * np.exp(-(((k - 250) / 3.0) ** 2)) + 0.05 * rng.standard_normal(500)
    rows = [100, 101] if width == 2 else [100, 101 + gap]
    y = smooth.copy()
    y[rows] += size
    cleaned, count = without_spikes(y)
    assert count == 2
    assert np.abs(cleaned - smooth).max() < 0.6
    assert without_spikes(smooth)[1] == 0


@pytest.mark.costly
@pytest.mark.parametrize("pole", [1.05, 1.1])
def test_an_unstable_plant_without_controller_is_named(pole):
    rng = np.random.default_rng(2)
    u = rng.choice([-1.0, 1.0], 60).repeat(5)
    y = lfilter([0, 0.3], [1, -pole], u) + 0.1 * rng.standard_normal(300)
    with pytest.raises(UndecidedError, match=r"unstable, in an open loop.*record that loop"):
        identify_process(u, y)


@pytest.mark.costly
def test_y_of_two_rows_later_is_refused():
    rng = np.random.default_rng(1)
    rng.standard_normal(1500)
    u = np.repeat(rng.choice([-1.0, 1.0], 150), 10)
    y = lfilter([0.5, 0.2], [1, -0.8], u) + 0.1 * rng.standard_normal(1500)
    with pytest.raises(InputError, match="two steps or more"):
        identify_process(u[:-1], y[1:])


@pytest.mark.parametrize(
    ("u", "y", "options", "words"),
    [
        (np.ones(300), np.arange(300.0), {}, "begin before the step"),
        (np.arange(300.0), np.ones(300), {}, "y is constant"),
        (np.ones(20), np.ones(20), {}, "at least 30"),
        (np.ones(300), np.ones(200), {}, "equally long"),
        (np.ones((300, 2)), np.ones(300), {}, "2 columns"),
        (np.arange(300.0), np.arange(300.0), {"sample_time": 0.0}, "must be positive"),
        (np.arange(300.0) % 7, np.arange(300.0) % 5, {"delay": 200}, "more than half"),
        (*np.random.default_rng(1).standard_normal((2, 500)), {}, "no effect of u"),
    ],
)
def test_a_record_of_nothing_is_refused(u, y, options, words):
    with pytest.raises(InputError, match=words):
        identify_process(u, y, **options)


@pytest.mark.costly
def test_the_interval_of_the_gain_holds_the_gain():
    """40 records of y(k) = 0.8 y(k-1) + u(k-1) in white noise: gain 5."""
    covered = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        u = rng.standard_normal(500)
        low, high = identify_process(u, lag(u, 0.5, rng, gain=1.0), delay=0).gain_interval
        covered += low <= 5.0 <= high
    # 95 % each: binomial, four standard deviations.
    assert covered >= 40 * 0.95 - 4 * np.sqrt(40 * 0.95 * 0.05)


def test_a_fit_is_where_a_fit_that_begins_there_stays():
    rng = np.random.default_rng(6)
    u = rng.standard_normal(500)
    record = process_record(u, lag(u, 0.5, rng))
    noise = NoiseModel(np.array([1, -0.1]), np.array([1, -0.2]), 0)
    fit = fitted(record, Start(np.array([1, -0.5]), np.array([0.3]), 0, noise))
    again = fitted(record, start_of(fit))
    assert 0 <= 1 - again.e @ again.e / (fit.e @ fit.e) < 1e-4


@given(seeds, st.sampled_from([0.01, 0.03, 3.11, 3.14]))
@settings(max_examples=10)
def test_the_frequency_of_a_sinusoid_is_below_the_nyquist_frequency(seed, omega):
    """A walk draws a slow frequency below 0, where it is the same sinusoid."""
    rng = np.random.default_rng(seed)
    u = rng.standard_normal(200)
    y = lag(u, 0.5, rng) + np.cumsum(rng.standard_normal(200)) * (1 if omega < 1 else 0.0)
    noise = NoiseModel(np.ones(1), np.ones(1), 0)
    start = Start(np.array([1, -0.5]), np.array([0.3]), 0, noise, sinusoid=omega)
    fit = fitted(process_record(u, y), start)
    assert fit is None or 0 < fit.sinusoid <= np.pi
