"""Several inputs and outputs, experiments and gaps: models, and what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import cholesky, solve_triangular, toeplitz
from scipy.signal import lfilter
from scipy.stats import binom

from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric import ControllerLog
from rcac_numeric.compiled._gaps import errors_with_gaps
from rcac_numeric.designing._matrix_logs import search_of_logs
from rcac_numeric.identification import _joint_stability, identify_process_matrix
from rcac_numeric.identification._box_jenkins import NoiseModel, without_sinusoid
from rcac_numeric.identification._joint_fits import Channel, JointStart, _JointErrors
from rcac_numeric.identification._joint_records import _smoothed, inputs_of, joint_record
from rcac_numeric.identification._joint_stability import (
    LIMIT,
    _Regression,
    largest_root,
    unstable_root,
)
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_matrix import matrix_search, process_matrix


def binary(rng, steps, hold):
    moves = np.repeat(rng.choice([-1.0, 1.0], steps // hold + 1), hold)[:steps]
    moves[:12] = 0.0  # a record that begins at rest
    return moves


def two_by_two(seed, steps=800, noise=0.1):
    """Gains ((1.5, -1), (2, 2)), delays ((3, 8), (1, 5))."""
    rng = np.random.default_rng(seed)
    u = np.stack([binary(rng, steps, 7), binary(rng, steps, 11)], 1)
    walk = 0.02 * np.cumsum(rng.standard_normal(steps))
    first = lfilter([0] * 4 + [0.3], [1, -0.8], u[:, 0])
    second = lfilter([0, 0, 0.1], [1, -0.95], u[:, 0])
    first += lfilter([0] * 9 + [-0.1], [1, -0.9], u[:, 1])
    second += lfilter([0] * 6 + [0.4], [1, -0.8], u[:, 1])
    y = np.stack([first, second + walk], 1)
    return u, y + noise * rng.standard_normal((steps, 2)) + [3.0, -5.0]


GAINS, DELAYS = np.array([[1.5, -1], [2, 2]]), np.array([[3, 8], [1, 5]])


@given(
    zeros=st.lists(st.floats(-0.9, 0.9), max_size=2),
    poles=st.lists(st.floats(-0.9, 1), max_size=3),
    seed=st.integers(0, 999), share=st.floats(0, 0.7),
)  # fmt: skip
def test_errors_with_gaps_are_those_of_the_covariance_of_what_is_there(zeros, poles, seed, share):
    """The lower Cholesky factor of the covariance is the innovations form (Cholesky, unique)."""
    rng = np.random.default_rng(seed)
    C, W = np.atleast_1d(np.poly(zeros)), np.atleast_1d(np.poly(poles))
    there = rng.random(40) >= share
    signals = rng.standard_normal((2, 40))
    errors, logarithm = errors_with_gaps(signals, W, C, there)
    response = toeplitz(lfilter(C, W, np.eye(1, 40)[0]), np.zeros(40))
    if not there.any():
        assert not errors.any() and logarithm == 0
        return
    factor = cholesky((response @ response.T)[np.ix_(there, there)], lower=True)
    expected = solve_triangular(factor, signals[:, there].T, lower=True).T
    # A Cholesky factor of a covariance of condition kappa has errors of kappa eps.
    size = np.linalg.cond(factor) ** 2 * 1e-13 * (1 + np.abs(expected).max())
    assert np.abs(errors[:, there] - expected).max() < 1e-9 + size
    assert not errors[:, ~there].any()
    assert abs(logarithm - 2 * np.log(np.diag(factor)).sum()) < 1e-8 + size


@settings(max_examples=25)
@given(
    seed=st.integers(0, 999), gaps=st.booleans(), parts=st.booleans(), slope=st.booleans(),
    differences=st.integers(0, 1), weighted=st.booleans(), sinusoid=st.sampled_from([0.0, 0.3]),
)  # fmt: skip
def test_the_gradient_is_that_of_the_prediction_errors(
    seed, gaps, parts, slope, differences, weighted, sinusoid
):
    rng = np.random.default_rng(seed)
    u, y = two_by_two(seed, 200)
    u = rng.standard_normal(u.shape)
    if gaps:
        y[rng.random(200) < 0.2, 0] = np.nan
    inputs = inputs_of(u, (0, 90) if parts else (0,))
    record = joint_record(inputs, y[:, 0], "y")
    noise = NoiseModel(np.array([1, -0.4, 0.1]), np.array([1, -0.6]), differences)
    channels = (Channel(0, np.array([1, -1.2, 0.4]), np.array([0.5, 0.1]), 1),
                Channel(1, np.array([1, -0.7]), np.array([0.2, 0.1]), 0, True))  # fmt: skip
    weights = 1 + 0.5 * np.sin(np.arange(200)) if weighted else None
    errors = _JointErrors(record, JointStart(channels, noise, slope, sinusoid), weights)
    theta = errors.joined([(one.A, one.B) for one in channels], noise)
    point, h = errors.at(theta), 1e-6
    J = point.jacobian()
    for k, row in enumerate(J):
        step = h * np.eye(len(theta))[k]
        difference = (errors.at(theta + step).e - errors.at(theta - step).e) / (2 * h)
        rest = difference - row
        for part, piece in zip(record.parts, point.pieces, strict=True):
            # Kaufman's: the part in the space of what is free is left out.
            rest[part] -= piece.Q @ (piece.Q.T @ rest[part])
        assert np.abs(rest).max() < 1e-4 * (1 + np.abs(row).max())


@given(
    seed=st.integers(0, 999), omega=st.floats(0.05, 2.5), off=st.floats(-0.9, 0.9),
    gaps=st.booleans(), parts=st.booleans(),
)  # fmt: skip
def test_the_frequency_of_a_sinusoid_beside_the_level(seed, omega, off, gaps, parts):
    """Each part has a phase and a level of its own; the search begins within half a bin."""
    rng = np.random.default_rng(seed)
    parts = [slice(0, 110), slice(110, 200)] if parts else [slice(0, 200)]
    v = 0.01 * rng.standard_normal(200)
    for part in parts:
        k = np.arange(part.stop - part.start)
        v[part] += rng.uniform(-3, 3) + np.sin(omega * k + rng.uniform(0, 6))
    observed = rng.random(200) > 0.2 * gaps
    longest = max(part.stop - part.start for part in parts)
    near = omega + off * np.pi / longest
    frequency, rest = without_sinusoid(np.where(observed, v, 99.0), near, parts, observed)
    # Least variance 24 s^2/(a^2 N^3) (Rife and Boorstyn): 6 deviations of the shorter part.
    assert abs(frequency - omega) < 6 * 0.01 * np.sqrt(24 / 70**3)
    assert np.std(rest[observed]) < 0.02


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(3))
def test_a_sinusoid_is_no_mode_of_a_channel(seed):
    """An oscillating channel fits it by its initial state: gains of the wrong sign at rest."""
    rng = np.random.default_rng(seed)
    u = rng.standard_normal((300, 2))
    y = lfilter([0] * 4 + [0.3], [1, -0.8], u[:, 0]) + lfilter([0, 0, 0.1], [1, -0.9], u[:, 1])
    y += 6 * np.sin(0.05 * np.arange(300)) + 0.01 * rng.standard_normal(300)
    model = identify_process_matrix(u, y)
    assert not model.failed
    assert np.abs(model.gain / [[1.5, 1.0]] - 1).max() < 0.05
    assert np.array_equal(model.delays, [[3, 1]])
    assert np.std(model.residuals[0]) == pytest.approx(6 / np.sqrt(2), rel=0.05)  # what is not u


def test_an_unstable_root_of_one_regression_alone_is_an_accident(monkeypatch):
    u, y = two_by_two(0, 200)
    record = joint_record(inputs_of(u, (0,)), y[:, 0], "y")

    def roots(places):
        def regression(_record, order, _is_whole):
            return _Regression(0.0, [(places.get(order, 0.5), 0.01)])

        monkeypatch.setattr(_joint_stability, "_regression", regression)
        return unstable_root(record, LIMIT)

    assert roots({16: 1.1}) is None
    assert roots({12: 1.2, 16: -1.2}) is None
    assert roots({12: 1.012, 16: 1.1}) is None
    assert roots({12: 1.11, 16: 1.1}) == 1.11
    assert roots({4: 1.0999, 16: 1.1}) == 1.1


@given(seed=st.integers(0, 999), share=st.floats(0.05, 0.6))
def test_missing_steps_of_u_minimise_the_errors_of_its_autoregression(seed, share):
    rng = np.random.default_rng(seed)
    A = np.poly(rng.uniform(-0.9, 0.9, 3))
    u, missing = rng.standard_normal(60), rng.random(60) < share
    filled = _smoothed(u, missing, A)
    np.testing.assert_array_equal(filled[~missing], u[~missing])
    error = np.convolve(filled, A)[:60]
    gradient = np.convolve(error[::-1], A)[:60][::-1]
    assert np.abs(gradient[missing]).max(initial=0) < 1e-9 * (1 + np.abs(filled).max())


@pytest.mark.costly
@pytest.mark.parametrize("kind", ["whole", "gaps", "experiments", "long gap"])
def test_two_inputs_and_two_outputs(kind):
    rng = np.random.default_rng(5)
    u, y = two_by_two(1)
    options = {}
    if kind == "gaps":
        lost = rng.random(800) < 0.1
        u[lost], y[lost] = np.nan, np.nan
    if kind == "long gap":
        u[300:360], y[300:360] = np.nan, np.nan
    if kind == "experiments":
        other, output = two_by_two(2)
        u, y = np.vstack([u, other]), np.vstack([y, output + 50.0])
        options = {"experiments": (800, 800)}
    model = identify_process_matrix(u, y, **options)
    assert model.shape == (2, 2) and not model.failed and not model.is_direct
    assert np.abs(model.gain / GAINS - 1).max() < 0.15
    omega = np.array([0.02, 0.1, 0.2])
    past = np.exp(-1j * omega)
    true = [
        [0.3 * past**4 / (1 - 0.8 * past), -0.1 * past**9 / (1 - 0.9 * past)],
        [0.1 * past**2 / (1 - 0.95 * past), 0.4 * past**6 / (1 - 0.8 * past)],
    ]
    true = np.moveaxis(np.array(true), 2, 0)
    assert np.abs(model.response(omega) / true - 1).max() < 0.2
    assert bool(model.assumptions) == ("gap" in kind)


@pytest.mark.costly
def test_an_input_without_effect_has_no_entry():
    u, y = two_by_two(3, 500)
    rng = np.random.default_rng(3)
    y[:, 0] = lfilter([0, 0.5], [1, -0.7], u[:, 0]) + 0.1 * rng.standard_normal(500)
    model = identify_process_matrix(u, y)
    assert model.entries[0][1] is None and model.gain[0, 1] == 0
    assert "u_2 to y_1 is 0" in model.assumptions[0] and "u_2 to y_1: no effect" in str(model)


@pytest.mark.costly
def test_direct_feedthrough_of_an_entry():
    """y(k) = 0.7 y(k-1) + 0.5 u_1(k) beside a delayed effect of u_2."""
    rng = np.random.default_rng(3)
    u = np.stack([binary(rng, 500, 4), binary(rng, 500, 9)], 1)
    y = lfilter([0.5], [1, -0.7], u[:, 0]) + lfilter([0, 0, 0.3], [1, -0.8], u[:, 1])
    model = identify_process_matrix(u, y + 0.05 * rng.standard_normal(500))
    ((first, second),) = model.entries
    assert model.is_direct and first.is_direct and not second.is_direct
    assert first.numerator[0] == pytest.approx(0.5, abs=0.05)
    assert np.abs(model.response(0.1)[0, 0, 0] / (0.5 / (1 - 0.7 * np.exp(-0.1j))) - 1) < 0.05


def stabilised(seed, pole, steps=500):
    """A loop with proportional gains of x_1(k+1) = pole x_1 + u_1 + 0.2 u_2, and a stable x_2."""
    rng = np.random.default_rng(seed)
    u, y, x = np.zeros((steps, 2)), np.zeros((steps, 2)), np.zeros(2)
    dither = np.stack([binary(rng, steps, 4), binary(rng, steps, 9)], 1)
    for k in range(steps):
        y[k] = x + 0.2 * rng.standard_normal(2)
        u[k] = dither[k] - [0.4, 0.1] * y[k]
        x = np.array([[pole, 0], [0, 0.8]]) @ x + np.array([[1, 0.2], [0.1, 0.5]]) @ u[k]
    return u + 2.0, y - 3.0


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("kind", ["2x2", "gaps", "experiments"])
def test_unstable_plants_are_refused(kind, seed):
    u, y = stabilised(seed, 1.02 + 0.01 * seed)
    options, rng = {}, np.random.default_rng(seed)
    if kind == "gaps":
        u, y = u[:, :1], y[:, :1]
        y[rng.random(500) < 0.1] = np.nan
        u[rng.random(500) < 0.05] = np.nan
    if kind == "experiments":
        other, output = stabilised(seed + 100, 1.02 + 0.01 * seed, 300)
        u, y = np.vstack([u, other]), np.vstack([y, output + 5.0])
        options = {"experiments": (500, 300)}
    with pytest.raises(UndecidedError, match=r"seems unstable.*identify_process"):
        identify_process_matrix(u, y, **options)


@pytest.mark.costly
@pytest.mark.parametrize("pole", [0.9, 1.0])
def test_loops_of_stable_and_integrating_plants_have_no_unstable_root(pole):
    """By the level of the test: at most 5 % of them."""
    count = 0
    for seed in range(40):
        u, y = stabilised(seed, pole)
        record = joint_record(inputs_of(u, (0,)), y[:, 0], "y")
        count += unstable_root(record, LIMIT) is not None
    assert count <= binom.isf(1e-3, 40, 0.05)


@pytest.mark.costly
def test_a_pole_near_1_needs_a_record_that_says_it_is_not_outside():
    """Loops with gaps and noise larger than the dither: refused, a failed gate, or integrating."""
    rows = {}
    for pole in (1.0, 1.03):
        rng = np.random.default_rng(3)
        u, y, x, noise = np.zeros(900), np.zeros(900), 0.0, 0.2 if pole == 1.0 else 3.0
        dither = binary(rng, 900, 4)
        for k in range(900):
            y[k] = x + noise * rng.standard_normal()
            u[k] = dither[k] - 0.2 * y[k]
            x = pole * x + u[k]
        y[rng.random(900) < 0.1] = np.nan
        record = joint_record(inputs_of(u[:, None], (0,)), y, "y")
        modulus, deviation = largest_root(record)
        assert abs(modulus - pole) < 4 * deviation
        rows[pole] = u, y
    model = identify_process_matrix(*rows[1.0])
    assert np.abs(np.roots(model.entries[0][0].denominator)).max() == pytest.approx(1, abs=0.01)
    assert "stability of y" in [gate.name for gate in model.gates] and not model.failed
    try:
        failed = [gate.name for gate in identify_process_matrix(*rows[1.03]).failed]
    except UndecidedError as error:
        assert "unstable" in str(error) or "no effect" in str(error)
    else:
        assert "stability of y" in failed


@pytest.mark.costly
def test_level_jumps_and_spikes_of_a_record_of_several_inputs():
    """Least squares from y as it is ends at delays of 20 to 80 steps and signs that are wrong."""
    u, y = two_by_two(6, noise=0.02)
    for k, size in ((150, 9.0), (300, -6.0), (450, 8.0), (600, -7.0)):
        y[k:] += [size, 0.0]
        y[k + 60 :] += [0.0, -size]
    rng = np.random.default_rng(1)
    y[rng.choice(800, 5, replace=False)] += 20.0
    y[rng.random(800) < 0.1] = np.nan
    model = identify_process_matrix(u, y)
    assert np.abs(np.array(model.delays) - DELAYS).max() <= 1 and not model.failed
    assert np.abs(model.gain / GAINS - 1).max() < 0.15


U, Y = two_by_two(4, 300)


@pytest.mark.parametrize(
    ("u", "y", "options", "words"),
    [
        (U[:, [0, 0]], Y, {}, r"u_2 follows from u_1|u_1 follows from u_2"),
        (np.c_[U[:, 0], np.roll(U[:, 0], 3)], Y, {}, "follows from"),
        (np.c_[U[:, 0], np.ones(300)], Y, {}, "u_2 is constant"),
        (U, np.c_[Y[:, 0], np.ones(300)], {}, "y_2 is constant"),
        (U, Y, {"experiments": (100, 100)}, "200 steps, and u has 300"),
        (U, Y[:200], {}, "equally long"),
        (U.T, Y, {}, "one row for each step"),
        (np.where(np.arange(300)[:, None] % 3, np.nan, U), Y, {}, "at most 50 %"),
        (U, np.where(np.arange(300)[:, None] % 3, np.nan, Y), {}, "half of them"),
        (U, Y, {"sample_time": 0.0}, "must be positive"),
        (np.full((300, 2), np.inf), Y, {}, "infinite"),
        ("text", Y, {}, "array of numbers"),
    ],
)  # fmt: skip
def test_records_that_show_no_plant_are_refused(u, y, options, words):
    with pytest.raises(InputError, match=words):
        identify_process_matrix(u, y, **options)


@pytest.mark.costly
def test_an_output_that_nothing_moves_is_refused():
    noise = np.random.default_rng(1).standard_normal(300)
    with pytest.raises(UndecidedError, match="no effect of u on y_2"):
        identify_process_matrix(U, np.c_[Y[:, 0], noise])


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(3))
def test_level_jumps_beside_a_long_gap(seed):
    """Fits with and without the jumps leave out as many steps after the gap: one BIC."""
    u, y = two_by_two(seed, 600, 0.02)
    y[200:, 0] += 6.0
    y[450:, 1] -= 9.0
    u[300:360] = y[300:360] = np.nan
    model = identify_process_matrix(u, y)
    assert not model.failed
    assert np.abs(np.array(model.delays) - DELAYS + 1).max() <= 1
    assert model.gain == pytest.approx(GAINS, rel=0.15)


@pytest.mark.costly
def test_a_slow_part_of_the_other_sign_is_a_credible_model():
    """Three experiments of a nonminimum-phase entry under a walk.

    From two poles the search ended at one, the inverse response alone, of the wrong sign at rest.
    """
    rng = np.random.default_rng(1007)
    records = []
    for _ in range(3):
        u = rng.standard_normal((200, 2))
        y = lfilter([0, 0, 0, -0.031, 0.0393], [1, -1.7351, 0.7525], u[:, 0])
        y += lfilter([0, 0, 0, 0, -0.0605, -0.0491], [1, -1.4708, 0.5357], u[:, 1])
        walk = np.cumsum(0.01 * rng.standard_normal(200))
        records.append((u, y + 0.3 * y.std() * (0.3 * rng.standard_normal(200) + walk)))
    u, y = (np.concatenate(rows) for rows in zip(*records, strict=True))
    model = identify_process_matrix(u, y, experiments=(200, 200, 200))
    entry = model.entries[0][0]
    at_rest = 0.0 if entry is None else np.real(model.response(0.02)[0, 0, 0])
    failed = [one.name for one in model.failed]
    assert at_rest > 0 or entry is None or "sign from u_1 to y" in failed


@pytest.mark.costly
def test_models_with_an_entry_that_was_left_out_are_rivals():
    """An effect below the odds is no entry; that it is 0 is not known, so the sign is tested."""
    rng = np.random.default_rng(5)
    u = rng.standard_normal((300, 2))
    u[:, 1] = 0.8 * u[:, 0] + 0.6 * u[:, 1]
    weak = lfilter([0, 0.04], [1, -0.69], u[:, 0]) + lfilter([0, 0.36], [1, -0.61], u[:, 1])
    y = np.c_[weak + 0.3 * rng.standard_normal(300), lfilter([0, 1], [1, -0.5], u[:, 0])]
    search = matrix_search(u, y + 0.01 * rng.standard_normal(y.shape)).searches[0]
    assert search.inputs == (1,) and search.larger
    best = min(one.bic for one in search.rivals)
    for one in search.larger:
        assert [channel.input for channel in one.channels] == [0, 1]
        assert one.bic < best + ODDS


@pytest.mark.costly
@pytest.mark.parametrize("count", [1, 2])
def test_the_u_before_each_experiment_does_not_reach_the_model(count):
    """u moved in the step in which the record begins: its dead time and lag bring that into y."""
    rng, past, steps = np.random.default_rng(4), 200, 400
    records = []
    for _ in range(count):
        u = np.stack([rng.choice([-1.0, 1.0], 40).repeat(10) for _ in range(2)], axis=1)
        whole = np.vstack([np.tile(-u[0], (past, 1)), u])
        y = lfilter([0] * 31 + [0.06], [1, -0.95], whole[:, 0])
        y += lfilter([0] * 16 + [0.2], [1, -0.9], whole[:, 1])
        records.append((u, y[past:] + 0.02 * rng.standard_normal(steps)))
    u, y = (np.concatenate(one) for one in zip(*records, strict=True))
    model = identify_process_matrix(u, y, experiments=(steps,) * count)
    np.testing.assert_allclose(model.gain, [[1.2, 2.0]], rtol=0.02)
    np.testing.assert_allclose(model.delays, [[30, 15]], atol=1)


@pytest.mark.costly
@pytest.mark.parametrize("seed", [2, 4])
def test_steps_of_two_inputs_beside_a_sinusoid(seed):
    """The first step and the sinusoid begin in the same rows; both inputs stand still there."""
    rng, rows = np.random.default_rng(seed), np.arange(700)
    u = np.stack([rows >= rng.integers(4, 16), rows >= 300], axis=1).astype(np.float64)
    omega, phase = rng.uniform(0.01, 0.06), rng.uniform(0, 6)
    y = lfilter([0] * 4 + [0.05], np.poly([0.9, 0.7]), u[:, 0])
    y += lfilter([0] * 8 + [-0.1], [1, -0.9], u[:, 1])
    y += 4 * np.sin(omega * rows + phase) + 0.1 * rng.standard_normal(700)
    model = identify_process_matrix(u, y)
    np.testing.assert_allclose(model.gain, [[5 / 3, -1.0]], rtol=0.15)


@pytest.mark.costly
def test_95_percent_of_the_intervals_hold_the_gain():
    """A tenth of the rows missing; of 40 entries fewer than 33 have probability 1e-3 at 95 %."""
    count = 0
    for seed in range(10):
        u, y = two_by_two(900 + seed, steps=500)
        y[np.random.default_rng(seed).random(500) < 0.1] = np.nan
        model = identify_process_matrix(u, y)
        for bounds, gains in zip(model.gain_intervals, GAINS, strict=True):
            for interval, gain in zip(bounds, gains, strict=True):
                assert interval is not None
                count += interval[0] <= gain <= interval[1]
    assert count >= binom.ppf(1e-3, 40, 0.95)


@pytest.mark.costly
def test_the_interval_of_an_entry_with_a_pole_at_1_is_that_of_its_slope():
    """Two experiments."""
    rng = np.random.default_rng(8)
    u = np.stack([rng.choice([-1.0, 1.0], 600), binary(rng, 600, 9)], axis=1)
    y = lfilter([0, 0.05], [1, -1], u[:, 0]) + lfilter([0, 0, 0.4], [1, -0.8], u[:, 1])
    y[300:] -= y[300]
    y += 0.02 * rng.standard_normal(600)
    search = matrix_search(u, y[:, None], (300, 300))
    fits = [one for one in search.searches[0].fits if one.channels[0].summed]
    model = process_matrix(search, fits[:1], (), 2.0)
    (slope, gain), words = model.gain_intervals[0], str(model).split("; ")
    assert slope is not None and slope[0] <= 0.025 <= slope[1] and slope[1] - slope[0] < 0.01
    assert gain is not None and gain[0] <= 2 <= gain[1]
    assert words[0].endswith(f"a pole at 1, slope {slope[0]:.4g} to {slope[1]:.4g} per second")
    assert words[1].endswith(f"({gain[0]:.4g} to {gain[1]:.4g})")


@pytest.mark.costly
def test_the_intervals_of_dead_times_hold_them_and_grow_by_the_skew():
    """Of 24 entries fewer than the quantile 1e-3 of 95 %."""
    count = 0
    for seed in range(6):
        u, y = two_by_two(700 + seed, steps=400)
        model = identify_process_matrix(u, y, sample_time=2.0)
        for i, row in enumerate(DELAYS):
            for j, delay in enumerate(row):
                low, high = model.dead_time_intervals[i][j]
                count += low <= 2.0 * (delay + 1) and 2.0 * delay <= high
    later = identify_process_matrix(u, y, sample_time=2.0, time_skew=(-0.5, 1.0))
    for i, row in enumerate(model.dead_time_intervals):
        for j, (low, high) in enumerate(row):
            widened = later.dead_time_intervals[i][j]
            assert widened == pytest.approx((max(low - 0.5, 0.0), high + 1.0))
    assert count >= binom.ppf(1e-3, 24, 0.95)


@pytest.mark.costly
def test_the_skew_of_several_experiments_is_the_widest():
    logs = [
        ControllerLog(*two_by_two(seed, steps=300), sample_time=2.0, time_skew=skew)
        for seed, skew in ((1, (-0.2, 0.1)), (2, (0.0, 0.5)))
    ]
    assert search_of_logs(logs, None, 0.0).time_skew == (-0.2, 0.5)
