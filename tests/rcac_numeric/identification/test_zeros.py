"""Identified zeros: exact without noise, and inside their stated regions as often as stated."""

import numpy as np
import pytest
import scipy.signal
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from compensator_theory.errors import IllConditionedError
from rcac_numeric.gallery import aircraft_plant, aircraft_transition, plant_zeros
from rcac_numeric.identification import (
    NeweyWest,
    bootstrap_zeros,
    eigensystem_realisation,
    identified_zeros,
    identify_markov_parameters,
    identify_windows,
)
from rcac_numeric.identification._zero_gradients import realised_zeros, zeros_and_gradients
from rcac_numeric.plants._schedules import plant_at
from tests.rcac_numeric.identification.records import COMPLEX, REAL, noisy, simulated

ORDER = {COMPLEX: 3, REAL: 2}


def hankelised(seed, width, noise=0.1):
    rng = np.random.default_rng(seed)
    A, B, C = rng.normal(size=(3, 3)) / 2, rng.normal(size=(3, width)), rng.normal(size=(width, 3))
    H = [np.eye(width), *(C @ np.linalg.matrix_power(A, i) @ B for i in range(10))]
    return np.array(H) + noise * rng.normal(size=(11, width, width))


@given(st.integers(0, 2**32), st.integers(1, 2))
def test_the_zeros_are_those_of_the_realisation(seed, width):
    H = hankelised(seed, width)
    model = eigensystem_realisation(H, 3)
    expected = np.linalg.eigvals(model.A - model.B @ np.linalg.solve(model.D, model.C))
    result = realised_zeros(H, 3)
    scale = 1 + np.abs(expected).max()
    for zero in expected:
        assert np.abs(result - zero).min() < 1e-6 * scale


@pytest.mark.parametrize("width", [1, 2])
@pytest.mark.parametrize("seed", range(3))
def test_the_gradients_are_finite_differences(width, seed):
    H = hankelised(seed, width)
    zeros, gradients = zeros_and_gradients(H, 3)
    for index in np.ndindex(H.shape):
        step = np.zeros(H.shape)
        step[index] = 1e-6
        up, down = realised_zeros(H + step, 3), realised_zeros(H - step, 3)
        for zero, gradient in zip(zeros, gradients, strict=True):
            nearest = [other[np.abs(other - zero).argmin()] for other in (up, down)]
            numeric = (nearest[0] - nearest[1]) / 2e-6
            assert gradient[index] == pytest.approx(numeric, rel=1e-4, abs=1e-4)


def shows_the_zeros(estimate, plant):
    """Whether what a noise-free window gives holds every zero of the plant, and says it closely.

    What rounding of y leaves open is what its own uncertainty says: no noise but that is in it.
    """
    nearest = lambda zero: int(np.abs(estimate.zeros - zero).argmin())  # noqa: E731
    within = all(estimate.contains(nearest(z), z, level=1 - 1e-9) for z in plant_zeros(plant))
    return within and estimate.modulus_error.max() < 1e-4


def aircraft_error(plant, u, y):
    """The largest distance of a zero of the plant from those that a window gives."""
    markov = identify_markov_parameters(u, y, mu=10, n_mod=4)
    zeros = identified_zeros(markov, order=4)
    assert zeros.d_zu == 1 and len(zeros.zeros) == 3 and shows_the_zeros(zeros, plant)
    return max(np.abs(zeros.zeros - zero).min() for zero in plant_zeros(plant))


@pytest.mark.costly
@pytest.mark.parametrize("condition", ["nominal", "off-nominal"])
def test_noise_free_windows_at_mu_10_give_the_zeros_of_the_aircraft(condition):
    """Section 3.6: windows of 70, n_mod = 4; the sampling zero included.

    The rounding of y decides how closely: at the nominal condition least squares in 60 digits on
    the same float64 data misses by 5e-8 to 5e-7. A window is held to its own uncertainty, and to
    what one more rounding of its y does.
    """
    plant = aircraft_plant(condition)
    for seed in range(5):
        rng = np.random.default_rng(seed)
        u = rng.standard_normal(70)
        y = simulated(plant, u)
        error = aircraft_error(plant, u, y)
        rounded = [y * (1 + 2.0**-53 * rng.choice([-1, 1], y.shape)) for _ in range(10)]
        assert error < 10 * max(aircraft_error(plant, u, other) for other in rounded)


def test_figure_3_9_in_windows_that_move_through_the_transition():
    """The zeros before and after it; the window that holds it has a large residual."""
    schedule = aircraft_transition(start=7.0, duration=1.0)
    u = np.random.default_rng(0).standard_normal(280)
    x, y = np.zeros(4), []
    for k, value in enumerate(u):
        plant = plant_at(schedule, k)
        y.append(plant.E_1 @ x)
        x = plant.A @ x + plant.B[:, 0] * value
    windows = identify_windows(u, y, mu=10, n_mod=4, window=70, order=4)
    assert [(w.start, w.stop) for w in windows] == [(0, 70), (70, 140), (140, 210), (210, 280)]
    for index, condition in ((0, "nominal"), (2, "off-nominal"), (3, "off-nominal")):
        assert shows_the_zeros(windows[index].zeros, aircraft_plant(condition))
    residuals = [np.sqrt(np.mean(w.markov.residual**2)) for w in windows]
    assert residuals[1] > 1e6 * max(residuals[:1] + residuals[2:])
    pairs = identify_windows(u, y, mu=10, n_mod=4, window=70, step=35)
    assert len(pairs) == 7 and pairs[0].zeros is None


@pytest.mark.long
@pytest.mark.parametrize("zero", [COMPLEX, REAL])
@pytest.mark.parametrize("pole", [0.0, 0.8])
def test_the_zero_is_in_its_95_percent_region_in_93_to_97_percent_of_runs(zero, pole, in_full):
    """With white and with coloured noise; the reduced form allows four standard deviations."""
    runs = 400 if in_full else 16
    hits = 0
    for seed in range(runs):
        u, y = noisy(zero, 2000, seed, pole=pole)
        zeros = identified_zeros(
            identify_markov_parameters(u, y, 10, ORDER[zero]), order=ORDER[zero]
        )
        hits += zeros.contains(int(np.abs(zeros.zeros - zero).argmin()), zero)
    if in_full:
        assert 0.93 <= hits / runs <= 0.97
    else:
        assert hits >= 0.95 * runs - 4 * np.sqrt(runs * 0.95 * 0.05)


@pytest.mark.long
def test_white_standard_errors_are_not_honest_where_the_noise_is_coloured(in_full):
    """Markov parameters correlate through the noise: the 95 % regions of the textbook fail."""
    runs = 200 if in_full else 20
    white, honest = 0, 0
    for seed in range(runs):
        u, y = noisy(COMPLEX, 1500, seed, pole=0.9)
        for noise in (None, NeweyWest()):
            zeros = identified_zeros(identify_markov_parameters(u, y, 10, 3, noise), order=3)
            inside = zeros.contains(int(np.abs(zeros.zeros - COMPLEX).argmin()), COMPLEX)
            white, honest = (
                white + (inside and noise is None),
                honest + (inside and noise is not None),
            )
    assert white < 0.87 * runs, "five standard deviations below 95 % with 200 runs"
    assert honest > white
    assert honest >= 0.95 * runs - 4 * np.sqrt(runs * 0.95 * 0.05)


@pytest.mark.parametrize("zero", [COMPLEX, REAL])
def test_bootstrap_and_delta_method_agree_where_errors_are_small(zero):
    u, y = noisy(zero, 2000, 0, noise=0.05)
    result = bootstrap_zeros(u, y, 10, ORDER[zero], order=ORDER[zero], seed=1, replicates=100)
    index = int(np.abs(result.delta.zeros - zero).argmin())
    # 100 draws know a standard error to 7 %; both estimates share the data.
    assert result.error_ratio[index] == pytest.approx(1, abs=0.3)
    low, high = result.modulus_interval(index)
    half = scipy.stats.norm.ppf(0.975) * result.delta.modulus_error[index]
    assert (high - low) / 2 == pytest.approx(half, rel=0.35)
    once, again = (
        bootstrap_zeros(u, y, 10, ORDER[zero], order=ORDER[zero], seed=1, replicates=10)
        for _ in range(2)
    )
    assert once == again


def test_phases_are_believed_only_beyond_their_errors():
    u, y = noisy(REAL, 2000, 3, noise=0.05)
    good = identified_zeros(identify_markov_parameters(u, y, 10, 2), order=2)
    assert good.phases() == ("nonminimum phase",)
    assert "nonminimum phase" in str(good) and "order 2, relative degree 1" in str(good)
    u, y = noisy(1.02, 300, 0)
    close = identified_zeros(identify_markov_parameters(u, y, 8, 2), order=2)
    assert close.phases() == ("undecided",)
    u, y = noisy(REAL, 80, 0, noise=3.0)
    with pytest.raises(InputError, match="singular value of H_1 is"):
        identified_zeros(identify_markov_parameters(u, y, 8, 2), order=2, d_zu=1)


def markov(u, y, mu=6, n_mod=1):
    return identify_markov_parameters(u, y, mu, n_mod)


rng = np.random.default_rng(0)
WIDE = rng.standard_normal((200, 2))
U, Y = noisy(REAL, 200, 0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: identified_zeros(markov(WIDE, WIDE[:, 0])), "the identified map is 1 x 2"),
        (lambda: identified_zeros(markov(U, rng.standard_normal(200))), "none of the 6 Markov"),
        (lambda: identified_zeros(markov(U, Y), order=4), "order = 4, but 5 Markov .* larger mu"),
        (
            lambda: identified_zeros(markov(U, Y), d_zu=0),
            "of H_0 is .* its possible error",
        ),
        (lambda: identified_zeros(markov(U, Y), d_zu=4), "only 1 Markov parameters follow H_4"),
        (lambda: identified_zeros(markov(U, Y), order=2).contains(0, 1, 2.0), "level = 2"),
        (lambda: identified_zeros(markov(U, Y), order=1).contains(0, 1), "the model has 0 zeros"),
        (lambda: bootstrap_zeros(U, Y, 6, 2, order=2, seed=0, block=60), "fewer than four blocks"),
        (lambda: identify_windows(U, Y, 6, 2, window=300), "200 samples, fewer than a window"),
        (lambda: identify_windows(U, Y[1:], 6, 2), "u has 200 steps and y has 199"),
        (lambda: identify_windows(U, Y, 0, 2), "mu = 0"),
        (lambda: NeweyWest(lags=-1), "lags = -1"),
    ],
)
def test_what_cannot_be_had_from_the_data_is_named(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_window_that_says_nothing_does_not_stop_the_others():
    u = np.concatenate([U[:70], np.zeros(70)])
    windows = identify_windows(u, np.concatenate([Y[:70], np.zeros(70)]), 6, 2, order=2)
    assert windows[0].refusal == "" and windows[0].zeros is not None
    assert "persistently exciting of order 0" in windows[1].refusal and windows[1].markov is None
    short = identify_windows(U, Y, 30, 4, window=70)
    assert all("equations for" in w.refusal for w in short)


def test_coinciding_zeros_have_no_first_order():
    """(q - 1)^2/(q - 0.5)^2 exactly: the derivative of a double zero is infinite."""
    impulse = np.eye(1, 9).ravel()
    H = scipy.signal.lfilter([1, -2, 1], [1, -1, 0.25], impulse).reshape(-1, 1, 1)
    try:
        _, gradients = zeros_and_gradients(H, 2)
    except IllConditionedError:
        return
    assert np.abs(gradients).max() > 1e5, "or so large that every region says so"
