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


def test_what_is_explained_is_the_rest_of_the_variance():
    u, y = record([1, -0.9], [0.2], 1, 2, 400, 0.5)
    identified = identify_output_error(u, y, orders=[1], delays=[0, 1])
    e = identified.residual
    # Rows before the longest order and delay need u before the record.
    assert len(e) == 400 - 2
    assert identified.explained == pytest.approx(1 - np.mean(e**2) / np.var(y[2:]), rel=1e-12)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_pole_at_1_is_imposed_where_only_the_noise_speaks_for_free_poles(seed):
    """The noise 0.1/(1 - 0.9 q^-1) is coloured: without a model of it free poles seem better."""
    u, y = record(np.poly([1.0, 0.5]), [0.2, 0.1], 0, seed, 500, 0.1, [-0.9])
    tried = {"orders": [1, 2], "delays": [0, 1], "integrators": (0, 1)}
    identified = identify_output_error(u + 0.3, y + 7, **tried)
    A = identified.denominator
    assert (identified.integrators, identified.order, identified.delay) == (1, 2, 0)
    assert np.abs(A - np.poly([1.0, 0.5])).max() < 0.1 and abs(A.sum()) < 1e-12
    assert identified.numerator == pytest.approx([0.2, 0.1], abs=0.03)
    _, y = record(np.poly([0.9, 0.5]), [0.2, 0.1], 0, seed, 500, 0.1, [-0.9])
    assert identify_output_error(u, y, **tried).integrators == 0


@pytest.mark.parametrize(("pole", "seed"), [(0.997, 2), (0.997, 5), (0.998, 4), (0.998, 3)])
def test_of_white_noise_the_bic_decides_on_a_pole_at_1(pole, seed):
    """N log(mean e^2) + (2 n - integrators) log N, where one parameter more is worth log N."""
    u, y = record([1, -pole], [0.3], 0, seed, 500, 2.0)
    models = [
        identify_output_error(u, y, orders=[1], delays=[0], integrators=tried)
        for tried in ((0,), (1,), (0, 1))
    ]
    free, imposed = (len(e) * np.log(np.mean(e**2)) for e in (m.errors(u, y) for m in models[:2]))
    gap = imposed - free - np.log(499)
    assert abs(gap) > 4  # what the model of the noise, a fit to white noise, may add
    assert models[2].integrators == (gap < 0)


def test_a_slope_of_y_is_fitted_where_a_pole_at_1_is_tried():
    u, y = record([1, -0.5], [1.0], 0, 3, 300, 0.1)
    y += np.linspace(-30, 30, 300)
    tried = {"orders": [1], "delays": [0]}
    fitted = identify_output_error(u, y, **tried, integrators=(0, 1))
    assert fitted.integrators == 0 and fitted.denominator[1] == pytest.approx(-0.5, abs=0.02)
    assert np.std(fitted.residual) < 0.11
    assert np.std(identify_output_error(u, y, **tried).residual) > 0.5


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
