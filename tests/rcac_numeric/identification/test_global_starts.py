"""A search for models ends no worse than a fit that begins at the plant, and with no part more."""

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.signal import lfilter

from rcac_numeric.identification._box_jenkins import (
    ONE,
    NoiseModel,
    Start,
    disturbance,
    fitted,
    noise_start,
    start_of,
    weighted_fit,
    with_noise,
)
from rcac_numeric.identification._process import search_of
from rcac_numeric.identification._process_records import process_record
from rcac_numeric.identification._simpler_models import (
    _covariance,
    _parts,
    _with_a_pole_less,
    simpler_starts,
)
from tests.support.strategies import seeds


def behind(search, A, B, delay, *, noises, armax=False, sinusoid=0.0):
    """By how much the best BIC is larger than that of the best fit from the plant."""
    record = search.record
    scale = record.units[0] / record.units[1]
    none = NoiseModel(ONE, ONE, 0)
    start = Start(np.asarray(A), scale * np.asarray(B), delay, none, armax=armax, sinusoid=sinusoid)
    fits = [
        fitted(record, with_noise(start, noise_start(disturbance(record, start), orders)))
        for orders in noises
    ]
    fits.append(fitted(record, start, iterations=0))
    of_plant = [weighted_fit(record, one) if one.heavy else one for one in fits]
    return search.fits[0].bic - min(one.bic for one in of_plant)


def spiky_loop(seed):
    """Two spikes of y, 300 times the noise, which a proportional controller repeats in u."""
    rng, steps = np.random.default_rng(seed), 500
    d = 0.1 * rng.standard_normal(steps)
    d[rng.integers(0, steps, 2)] += 30.0 * rng.choice([-1, 1])
    dither = rng.choice([-1.0, 1.0], steps // 5).repeat(5)
    u, y, x = np.zeros(steps), np.zeros(steps), np.zeros(2)
    for k in range(steps):
        y[k] = x[0] + d[k]
        u[k] = dither[k] - y[k]
        x = np.array([[0.66, 1.0], [0.0, 0.4]]) @ x + 0.5 * u[k]
    return u, y


@pytest.mark.costly
@pytest.mark.parametrize("seed", [0, 5, 7, 8])
def test_spikes_that_a_controller_repeats_do_not_reach_the_model(seed):
    """Least squares spread them over all errors, which then have no heavy tails any more."""
    search = search_of(*spiky_loop(seed), None)
    best = search.fits[0]
    assert behind(search, np.poly([0.66, 0.4]), [0.5, 0.3], 0, noises=[(0, 0, 0)]) < 1.0
    gain = best.B.sum() / best.A.sum() * search.record.units[1] / search.record.units[0]
    assert gain == pytest.approx(0.8 / 0.34 / 0.6, rel=0.05)


def unstable_loop(seed, d, steps=1000, pole=1.1, delay=2, feedback=0.35):
    """x(k+1) = pole x(k) + 0.5 u(k - delay), held by u = dither - feedback (x + d)."""
    rng = np.random.default_rng(seed)
    dither = 0.25 * rng.choice([-1, 1], steps // 5).repeat(5)
    u, y, x = np.zeros(steps), np.zeros(steps), 0.0
    for k in range(steps):
        y[k] = x + d[k]
        u[k] = dither[k] - feedback * y[k]
        x = pole * x + 0.5 * (u[k - delay] if k >= delay else 0.0)
    return u, y


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(4))
def test_an_unstable_plant_beside_a_level_jump_is_where_a_fit_from_it_ends(seed):
    """Its noise is white beside one difference: a walk is none of it, nor white noise alone."""
    rng, rows = np.random.default_rng(100 + seed), np.arange(1000)
    d = rng.standard_normal(1000) + 3 * rng.choice([-1, 1]) * (rows > rng.integers(200, 800))
    search = search_of(*unstable_loop(seed, d), None)
    noises = [(1, 0, 0), (2, 0, 1)]
    assert behind(search, [1, -1.1], [0.5], 2, noises=noises, armax=True) < 1.0
    assert len(search.fits[0].B) == 1 and search.fits[0].order == 1


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(3))
def test_an_unstable_plant_beside_a_sinusoid_has_no_further_poles_for_it(seed):
    rng, rows = np.random.default_rng(200 + seed), np.arange(1000)
    omega = rng.uniform(0.02, 0.05)
    d = 0.3 * rng.standard_normal(1000) + 3 * np.sin(omega * rows + rng.uniform(0, 6))
    best = search_of(*unstable_loop(seed, d), None).fits[0]
    assert best.sinusoid == pytest.approx(omega, abs=2e-4)
    assert np.abs(best.poles).max() == pytest.approx(1.1, abs=0.02)


def white_record(seed, steps=800):
    """y of 0.5 q^-4/(1 - 0.8 q^-1) beside white noise; u is binary, and 0 at first."""
    rng = np.random.default_rng(seed)
    u = np.concatenate([np.zeros(8), rng.choice([-1.0, 1.0], steps // 4).repeat(4)])
    y = lfilter([0, 0, 0, 0, 0.5], [1, -0.8], u) + 0.1 * rng.standard_normal(len(u))
    return u, y


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(4))
def test_a_first_order_plant_beside_white_noise_has_three_parameters(seed):
    best = search_of(*white_record(seed), None).fits[0]
    assert (best.order, len(best.B), best.delay, best.noise.orders) == (1, 1, 3, (0, 0, 0))


@settings(max_examples=20)
@given(seed=seeds)
def test_bic_falls_without_a_part_as_the_test_of_wald_says(seed):
    """By log N less the square over its variance, to the first order of a deviation over sqrt N."""
    record = process_record(*white_record(seed))
    scale = record.units[0] / record.units[1]
    full = Start(
        np.array([1, -0.8]), scale * np.array([0.0, 0.5, 0.0]), 2,
        NoiseModel(np.array([1.0, 0.1]), ONE, 0),
    )  # fmt: skip
    fit = fitted(record, full)
    by_name = {one.name: one for one in _parts(fit, False)}
    smaller = {
        "first of B": lambda s: Start(s.A, s.B[1:], s.delay + 1, s.noise),
        "last of B": lambda s: Start(s.A, s.B[:-1], s.delay, s.noise),
        "last of C": lambda s: Start(s.A, s.B, s.delay, NoiseModel(ONE, ONE, 0)),
    }
    assert set(by_name) == set(smaller)
    for name, without in smaller.items():
        row, value = by_name[name].row, by_name[name].value
        square = value**2 / (row @ _covariance(fit) @ row)
        change = fitted(record, without(start_of(fit))).bic - fit.bic
        assert change == pytest.approx(square - np.log(record.steps), abs=0.1 + 0.3 * square)


@settings(max_examples=50)
@given(seed=seeds)
def test_a_pole_and_its_zero_leave_the_response(seed):
    rng = np.random.default_rng(seed)
    kept, pole = rng.uniform(-0.9, 0.9), rng.uniform(-0.9, 0.9)
    A, B = np.poly([kept, pole]), rng.choice([-2.0, 3.0]) * np.poly([pole])
    start = Start(A, B, 1, NoiseModel(ONE, ONE, 0))
    responses = [
        np.polydiv(one.B, one.A)[0].size == 1
        and np.allclose(one.B.sum() / one.A.sum(), B.sum() / A.sum())
        and np.allclose(one.A, [1, -kept]) and len(one.B) == 1
        for one in _with_a_pole_less(start)
    ]  # fmt: skip
    assert any(responses)


def test_simpler_models_keep_a_known_delay():
    record = process_record(*white_record(1))
    scale = record.units[0] / record.units[1]
    full = Start(np.array([1, -0.8]), scale * np.array([0.0, 0.5]), 2, NoiseModel(ONE, ONE, 0))
    fit = fitted(record, full)
    assert {one.delay for one in simpler_starts(fit, is_known=True)} <= {2}
    assert any(one.delay == 3 for one in simpler_starts(fit, is_known=False))


def running_loop(seed, steps=450, delay=50, before=137):
    """A PI controller with a command, and 137 rows that were not logged."""
    rng, count = np.random.default_rng(seed), steps + before
    r = rng.uniform(-1, 1, count // 90 + 1).repeat(90)[:count]
    d = 0.01 * np.cumsum(rng.standard_normal(count)) + 0.02 * rng.standard_normal(count)
    u, y, x, total = np.zeros(count), np.zeros(count), np.zeros(2), 0.0
    for k in range(count):
        y[k] = x[0] + d[k]
        total += r[k] - y[k]
        u[k] = 0.3 * (r[k] - y[k]) + 0.012 * total
        x = np.array([[0.87, 1.0], [0.0, 0.6]]) @ x
        x[1] += 0.05 * (u[k - delay] if k >= delay else 0.0)
    return u[before:], y[before:]


@pytest.mark.costly
def test_a_wrong_best_model_does_not_hide_the_u_before_the_record():
    """A model of another kind shows it; without that one the delay came out as 45."""
    best = search_of(*running_loop(13), None).fits[0]
    assert 50 <= best.delay <= 53
