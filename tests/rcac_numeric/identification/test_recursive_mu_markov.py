"""Recursive mu-Markov: the batch least squares, coverage of its errors, forgetting, refusals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from compensator_theory import InputError
from compensator_theory.errors import DivergedError
from rcac_numeric.identification import (
    RecursiveMuMarkov,
    identified_zeros,
    identify_markov_parameters,
)
from rcac_numeric.identification._recursive_mu_markov import WHITE
from rcac_numeric.identification._zeros_of_arx import whiteness
from tests.support.strategies import seeds

# (q - 0.3)(q - 1.2)/((q - 0.5)(q^2 - 1.2 q + 0.52)), the plant of the notes
B = np.r_[0, np.poly([0.3, 1.2])]
A = np.poly([0.5, 0.6 + 0.4j, 0.6 - 0.4j]).real
IMPULSE = lfilter(B, A, np.r_[1, np.zeros(11)])


def data(steps, seed, size=0.3, pole=0.0):
    u, e = np.random.default_rng(seed).standard_normal((2, steps))
    return u, lfilter(B, A, u) + size * lfilter([1], [1, -pole], e)


def fitted(mu, n_mod, u, z, **settings):
    fit = RecursiveMuMarkov(mu, n_mod, **settings)
    fit.update(u, z)
    return fit


def coefficients(fit):
    return np.r_[fit.H, fit.b, fit.a]


@given(st.integers(1, 8), st.integers(0, 4), st.floats(1e-3, 10), seeds)
def test_it_is_the_batch_least_squares(mu, n_mod, R_theta, seed):
    """Of (3.8), written out row by row, with R_theta as rows of their own."""
    u, z = data(80, seed)
    fit = RecursiveMuMarkov(mu, n_mod, R_theta=R_theta)
    fit.update(u[:17], z[:17])
    fit.update(u[17:, None], z[17:])
    window = mu + n_mod
    rows = [
        [*(u[k - j] for j in range(window)), *(-z[k - j] for j in range(mu, window))]
        for k in range(window - 1, 80)
    ]
    Phi = np.vstack([rows, np.sqrt(R_theta) * np.eye(window + n_mod)])
    target = np.r_[z[window - 1 :], np.zeros(window + n_mod)]
    theta, *_ = np.linalg.lstsq(Phi, target, rcond=None)
    P = np.linalg.inv(Phi.T @ Phi)
    sign = np.r_[np.ones(window), -np.ones(n_mod)]
    assert np.allclose(coefficients(fit), theta, rtol=0, atol=1e-10 * np.abs(theta).max())
    assert np.allclose(fit.P * np.outer(sign, sign), P, rtol=0, atol=1e-10 * np.abs(P).max())
    assert fit.samples == 81 - window
    left = float(np.sum((target - Phi @ theta) ** 2))
    assert fit.variance * fit.samples == pytest.approx(left, rel=1e-10)


@given(st.integers(1, 8), st.integers(0, 4), seeds)
def test_with_a_small_R_theta_it_is_identify_markov_parameters(mu, n_mod, seed):
    """With its covariance for a white residual; the pull of R_theta = 1e-9 is of that order."""
    u, z = data(80, seed)
    fit = fitted(mu, n_mod, u, z, R_theta=1e-9).parameters()
    batch = identify_markov_parameters(u, z, mu, n_mod, noise=None)
    assert fit.freedom == batch.freedom and fit.H.shape == batch.H.shape
    size = max(np.abs(value).max(initial=0.0) for value in (batch.H, batch.a, batch.b))
    for name in ("H", "a", "b"):
        assert np.allclose(getattr(fit, name), getattr(batch, name), rtol=0, atol=1e-7 * size)
    assert np.allclose(fit.covariance / batch.covariance.max(),
                       batch.covariance / batch.covariance.max(), rtol=0, atol=1e-7)  # fmt: skip
    # The regressors of H are delays of one signal: of 80 values a few differ in length.
    assert fit.condition_number == pytest.approx(batch.condition_number, rel=0.3)


@given(st.integers(1, 199), st.sampled_from([1.0, 0.99, 0.9]), seeds)
def test_cut_and_resumed_it_is_the_same_bit_for_bit(cut, lambda_, seed):
    u, z = data(200, seed)
    one = fitted(5, 2, u[:cut], z[:cut], lambda_=lambda_)
    other = RecursiveMuMarkov(5, 2, lambda_=lambda_)
    other.restore(one.state)
    other.update(u[cut:], z[cut:])
    whole = fitted(5, 2, u, z, lambda_=lambda_)
    assert other.state.tobytes() == whole.state.tobytes() and other.k == 200
    assert coefficients(other).tobytes() == coefficients(whole).tobytes()


def test_without_noise_the_parameters_are_within_what_they_say_of_a_generous_order_too():
    u, z = data(1000, 1, size=0.0)
    for n_mod in (3, 4, 6):
        fit = fitted(12, n_mod, u, z)
        result = fit.parameters()
        assert (np.abs(result.H[:, 0, 0] - IMPULSE) <= result.standard_error[:, 0, 0]).all()
        assert result.standard_error.max() < 1e-5
        assert fit.zeros(order=3).phases() == ("nonminimum phase", "minimum phase")


def test_the_zeros_cover_what_they_say_in_white_noise_and_are_refused_in_coloured(in_full):
    """Nominal 95 %: three standard errors of the count. Coloured, the regions are too small."""
    runs = 400 if in_full else 60
    inside, accepted = {0.0: 0, 0.8: 0}, 0
    for seed in range(runs):
        for pole in inside:
            fit = fitted(12, 3, *data(2000, seed, 0.1, pole))
            if pole:
                with pytest.raises(InputError, match="not white"):
                    fit.zeros(order=3)
            elif whiteness(fit.parameters().residual[:, 0]) >= WHITE:
                accepted += 1
                assert fit.zeros(order=3) == identified_zeros(fit.parameters(), order=3)
            zeros = identified_zeros(fit.parameters(), order=3)
            inside[pole] += zeros.contains(int(np.argmin(np.abs(zeros.zeros - 1.2))), 1.2)
    assert accepted >= 0.95 * runs
    slack = 3 * np.sqrt(0.95 * 0.05 / runs)
    assert abs(inside[0.0] / runs - 0.95) <= slack
    assert inside[0.8] / runs < 0.95 - slack


@given(seeds)
def test_it_follows_a_plant_that_changes_a_hundred_times_closer_than_without_forgetting(seed):
    """What is hardly excited is hardly forgotten, so that a share of the old plant stays."""
    u = np.random.default_rng(seed + 1).standard_normal(1500)
    error = {}
    for lambda_ in (1.0, 0.98):
        fit = fitted(12, 3, *data(1500, seed, size=0.0), lambda_=lambda_)
        fit.update(u, 2 * lfilter(B, A, u))
        error[lambda_] = np.abs(fit.H - 2 * IMPULSE).max()
    assert error[0.98] < 0.01 * error[1.0]


@pytest.mark.parametrize("size", [0.0, 1e-9])
def test_it_does_not_wind_up_at_rest(size):
    """Exponential forgetting would have divided the information by 0.98^20000 = 1e-175."""
    rng = np.random.default_rng(6)
    u = np.r_[rng.standard_normal(1500), np.zeros(20000)]
    z = lfilter(B, A, u) + size * rng.standard_normal(21500)
    fit = fitted(12, 3, u[:1500], z[:1500], lambda_=0.98)
    excited = fit.excitation()
    fit.update(u[1500:], z[1500:])
    assert fit.excitation() <= 2 * excited
    assert np.linalg.eigvalsh(fit.P)[-1] * fit.R_theta <= len(fit.P)
    if size == 0:
        assert np.allclose(fit.H, IMPULSE, rtol=0, atol=1e-6)


@pytest.mark.parametrize("lambda_", [0.998, 0.99])
def test_with_forgetting_the_errors_are_on_the_safe_side(lambda_, in_full):
    runs, inside = (200 if in_full else 20), []
    for seed in range(runs):
        fit = fitted(12, 3, *data(1000, seed, 0.1), lambda_=lambda_).parameters()
        inside.append(np.abs(fit.H - IMPULSE[:, None, None]) <= 1.96 * fit.standard_error)
    assert np.mean(inside) >= 0.95


def test_poor_data_and_settings_are_refused_by_name():
    u, z = data(2000, 2)
    with pytest.raises(InputError, match="do not determine 18 coefficients"):
        fitted(12, 3, u[:20], z[:20]).parameters()
    with pytest.raises(InputError, match="excite"):
        fitted(4, 0, np.zeros(500), z[:500]).parameters()
    with pytest.raises(InputError, match="excite"):  # each H_j by itself would pass at 0.1
        fitted(40, 0, np.sign(np.sin(np.arange(2000) * np.pi / 20 + 0.1)), z).parameters()
    with pytest.raises(InputError, match="no effect of u"):
        fitted(6, 2, u, np.random.default_rng(3).standard_normal(2000)).zeros()
    wrong = {"mu": (0, 1001, 1.5), "n_mod": (-1, 501), "R_theta": (0, np.nan), "lambda_": (0, 1.1)}
    for name, value in ((name, value) for name, values in wrong.items() for value in values):
        with pytest.raises(InputError):
            RecursiveMuMarkov(**({"mu": 3, "n_mod": 2} | {name: value}))


def test_a_refused_sample_or_state_changes_nothing():
    u, z = data(100, 3)
    fit = fitted(3, 2, u, z)
    before = fit.state.tobytes()
    for pair in (([1.0], [1.0, 2.0]), ([np.nan], [1.0]), ([1.0], [np.inf]), ("x", [1.0])):
        with pytest.raises(InputError):
            fit.update(*pair)
    broken = np.full(fit.state.shape, np.nan)
    for state in (np.zeros(3), RecursiveMuMarkov(3, 3).state, broken, "x", None):
        with pytest.raises(InputError, match="not the `state`"):
            fit.restore(state)
    assert fit.state.tobytes() == before


def test_what_left_float64_is_said_so_by_everything_afterwards():
    u, z = data(100, 3)
    fit = fitted(3, 2, u, z)
    with pytest.raises(DivergedError, match="scale"):
        fit.update(1e200 * u, 1e200 * z)
    for ask in (fit.parameters, fit.zeros, fit.excitation):
        with pytest.raises(DivergedError, match="start anew"):
            ask()
