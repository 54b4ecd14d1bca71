"""Output-error models: exact without noise, efficient with white noise, refused without a cause."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from compensator_theory.errors import InputError
from rcac_numeric.identification import identify_output_error


def record(A, B, delay, seed, steps=400, noise=0.0, colour=()):
    """u and y of q^-delay B/A from rest."""
    rng = np.random.default_rng(seed)
    u = rng.standard_normal(steps)
    y = lfilter(np.r_[np.zeros(delay + 1), B], A, u)
    return u, y + noise * lfilter([1.0], [1.0, *colour], rng.standard_normal(steps))


@pytest.mark.costly
@settings(max_examples=20)
@given(
    poles=st.tuples(st.floats(0.5, 0.8), st.floats(-0.6, 0.3)), b=st.floats(-0.4, 0.4),
    delay=st.integers(0, 4), gain=st.sampled_from([-1e6, -1.0, 1e-6]), seed=st.integers(0, 99),
)  # fmt: skip
def test_without_noise_the_plant_itself(poles, b, delay, gain, seed):
    A, B = np.poly(poles), gain * np.array([1.0, b])
    u, y = record(A, B, delay, seed)
    # A zero beside a pole, nearer than 0.1, would leave a model of order 1 as good as this one.
    identified = identify_output_error(u, y + 7 * abs(gain), orders=[2], delays=range(6))
    ours = lfilter(
        np.r_[np.zeros(identified.delay + 1), identified.numerator], identified.denominator, u
    )
    assert np.abs(ours - y).max() < 1e-6 * np.abs(y).max()
    assert identified.explained > 1 - 1e-9


def test_orders_and_delays_are_found():
    A, B = np.poly([0.9, 0.6]), [0.2, 0.1]
    for seed in range(3):
        data = record(A, B, 3, seed, 1000, 0.1, [-0.8])
        identified = identify_output_error(*data, orders=range(1, 4), delays=range(6))
        assert (identified.order, identified.delay) == (2, 3)


def test_white_noise_is_left_as_it_was():
    A, B, noise = np.poly([0.9, 0.6]), [0.2, 0.1], 0.5
    identified = identify_output_error(
        *record(A, B, 1, 2, 4000, noise), orders=[2], delays=[0, 1, 2]
    )
    # chi^2: the relative standard deviation of a variance of 4000 samples is sqrt(2/4000).
    assert abs(np.var(identified.residual) / noise**2 - 1) < 5 * np.sqrt(2 / 4000)


@pytest.mark.costly
def test_the_estimate_is_as_good_as_cramer_and_rao_allow():
    """100 records of y(k) = 0.8 y(k-1) + u(k-1), in white noise of the output."""
    steps, noise, a, b = 500, 0.5, 0.8, 1.0
    errors = []
    for seed in range(100):
        u, y = record([1, -a], [b], 0, seed, steps, noise)
        identified = identify_output_error(u, y, orders=[1], delays=[0])
        errors.append([-identified.denominator[1] - a, identified.numerator[0] - b])
    # d y_0/da = q^-1 y_0/(1 - a q^-1), d y_0/db = q^-1 u/(1 - a q^-1), with white u of variance 1.
    impulse = np.r_[1.0, np.zeros(400)]
    to_b = lfilter([0, 1.0], [1, -a], impulse)
    to_a = lfilter([0, b], [1, -a], to_b)
    slopes = np.stack([to_a, to_b])
    bound = np.linalg.inv(slopes @ slopes.T) * noise**2 / steps
    spread = np.mean(np.square(errors), axis=0) / np.diag(bound)
    # chi^2 of 100: 5 standard deviations, and 5 % for 500 steps and the offset that is fitted too.
    assert (spread < 1.05 + 5 * np.sqrt(2 / 100)).all() and (
        spread > 1 - 5 * np.sqrt(2 / 100)
    ).all()


@pytest.mark.parametrize(
    ("u", "y", "words"),
    [
        (np.zeros(500), np.ones(500), "is constant"),
        (np.arange(500.0), np.ones(500), "y is constant"),
        (np.ones(20), np.ones(20), "at least"),
        (np.ones(500), np.ones(400), "equally long"),
        (np.ones((500, 2)), np.ones(500), "2 columns"),
        (*np.random.default_rng(1).standard_normal((2, 500)), "no effect of u"),
    ],
)
def test_a_record_of_nothing_is_refused(u, y, words):
    with pytest.raises(InputError, match=words):
        identify_output_error(u, y)
