"""Plants from closed loops: exact without noise, efficient with it, refused where they hide."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from compensator_theory.errors import InputError
from rcac_numeric.identification import identify_in_closed_loop, identify_output_error
from rcac_numeric.identification._prediction_error import answers, excitation


def looped(A, B, gain, delay=0, steps=600, noise=0.0, seed=0, dither=1.0, colour=()):
    """u = r - gain y and y = q^-delay B/A u + e/colour, from rest; also r and e."""
    rng = np.random.default_rng(seed)
    r, e = dither * rng.standard_normal(steps), noise * rng.standard_normal(steps)
    v = lfilter([1.0], [1.0, *colour], e)
    u, x, y = np.zeros((3, steps))
    for k in range(steps):
        for i in range(1, len(A)):
            x[k] -= A[i] * x[k - i] if k >= i else 0.0
        for i, b in enumerate(B):
            x[k] += b * u[k - 1 - delay - i] if k > delay + i else 0.0
        y[k] = x[k] + v[k]
        u[k] = r[k] - gain * y[k]
    return u, y, r, e


@pytest.mark.costly
@settings(max_examples=15)
@given(
    poles=st.tuples(st.floats(1.02, 1.3), st.floats(-0.5, 0.6)), b=st.floats(-0.2, 0.2),
    unit=st.sampled_from([1e-6, 1.0, 1e6]), seed=st.integers(0, 99),
)  # fmt: skip
def test_without_noise_the_unstable_plant_itself(poles, b, unit, seed):
    A, B = np.poly(poles), np.array([1.0, b])
    u, y, *_ = looped(A, B, 0.6 if sum(poles) < 1.5 else 0.9, seed=seed)
    assume(np.abs(y).max() < 1e3)  # where the gain stabilises it
    identified = identify_in_closed_loop(u, unit * y, orders=[2], delays=range(3))
    omega = np.exp(1j * np.linspace(0.05, np.pi, 20))

    def response(B, A, delay):
        return np.polyval(np.r_[B], omega) / np.polyval(A, omega) * omega**-delay

    ours = response(identified.numerator, identified.denominator, identified.delay)
    theirs = unit * response(B, A, 0)
    assert np.abs(ours - theirs).max() < 1e-5 * np.abs(theirs).max()


@pytest.mark.costly
def test_orders_delays_and_the_unstable_pole_are_found():
    for seed in range(3):
        u, y, *_ = looped(np.poly([1.06, 0.6]), [0.3, 0.1], 0.3, 2, 2000, 0.1, seed, 1.0, [-0.8])
        identified = identify_in_closed_loop(u, y, orders=range(1, 4), delays=range(5))
        assert (identified.order, identified.delay) == (2, 2)
        assert np.abs(np.roots(identified.denominator)).max() == pytest.approx(1.06, abs=0.01)
        assert identified.correlation < 4 and identified.explained > 0.9


@pytest.mark.costly
def test_the_estimate_is_as_good_as_cramer_and_rao_allow():
    """40 records of y(k) = 1.1 y(k-1) + 0.5 u(k-1) + e(k) - 0.6 e(k-1), u = r - 0.8 y."""
    a, b, c, noise, steps, ratios = -1.1, 0.5, -0.6, 0.5, 500, []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        r, e = rng.standard_normal(steps), noise * rng.standard_normal(steps)
        u, y = np.zeros((2, steps))
        for k in range(steps):
            y[k] = e[k] + (-a * y[k - 1] + b * u[k - 1] + c * e[k - 1] if k else 0.0)
            u[k] = r[k] - 0.8 * y[k]
        identified = identify_in_closed_loop(u, y, orders=[1], delays=[0])
        # The gradients of the prediction error at the truth, of which Fisher's information is made.
        late = [np.r_[0.0, s[:-1]] for s in (-y, u, e)]
        slopes = np.stack([lfilter([1.0], [1.0, c], s) for s in (*late, np.ones(steps))])
        bound = noise**2 * np.linalg.inv(slopes @ slopes.T)
        errors = identified.denominator[1] - a, identified.numerator[0] - b
        ratios.append(np.square(errors) / np.diag(bound)[:2])
    # chi^2 of 40: 5 standard deviations.
    assert (np.mean(ratios, axis=0) < 1 + 5 * np.sqrt(2 / 40)).all()


def test_the_noise_of_the_output_is_left_in_its_size():
    u, y, *_ = looped([1.0, -1.1], [0.5], 0.8, steps=4000, noise=0.3)
    identified = identify_in_closed_loop(u, y, orders=[1], delays=[0])
    # White noise of the output; chi^2 of 4000, and the transient of C beside it.
    assert np.var(identified.residual) == pytest.approx(0.09, rel=5 * np.sqrt(2 / 4000) + 0.02)


@pytest.mark.costly
def test_a_pole_at_1_is_imposed_where_the_record_has_one():
    u, y, *_ = looped(np.poly([1.0, 0.7]), [0.2, 0.1], 0.2, steps=1500, noise=0.1)
    identified = identify_in_closed_loop(u, y, orders=[1, 2], delays=[0, 1], integrators=(0, 1))
    assert (
        identified.integrators == 1 and np.abs(np.roots(identified.denominator) - 1).min() < 1e-12
    )
    u, y, *_ = looped(np.poly([1.1, 0.7]), [0.2, 0.1], 0.5, steps=1500, noise=0.1)
    identified = identify_in_closed_loop(u, y, orders=[1, 2], delays=[0, 1], integrators=(0, 1))
    assert identified.integrators == 0


def test_in_a_loop_an_output_error_model_is_led_astray():
    """What the direct method is for: noise comes back through u."""
    u, y, *_ = looped([1.0, -0.9], [0.5], 0.8, steps=3000, noise=1.0, dither=0.3, colour=[-0.9])
    direct = identify_in_closed_loop(u, y, orders=[1], delays=[0])
    naive = identify_output_error(u, y, orders=[1], delays=[0])
    assert abs(direct.numerator[0] - 0.5) < 0.1 < abs(naive.numerator[0] - 0.5)


def test_what_u_answers_to():
    rng = np.random.default_rng(5)
    for seed in range(5):
        assert answers(*looped([1.0, -1.1], [0.5], 0.8, noise=0.3, seed=seed)[:2])
    white = rng.standard_normal(2000)
    kinds = {
        "white": white, "coloured": lfilter([1.0], [1.0, -0.95], white),
        "held": np.repeat(np.sign(rng.standard_normal(100)), 20),
        "step": np.repeat([0.0, 1.0], 1000),
        "sinusoids": np.sin(0.1 * np.arange(2000)) + np.sin(0.37 * np.arange(2000)),
    }  # fmt: skip
    for u in kinds.values():
        y = lfilter([0, 0.1, 0.05], np.poly([0.9, 0.6]), u) + 0.05 * rng.standard_normal(2000)
        assert not answers(u, y)


def test_the_excitation_is_what_was_added():
    u, y, r, _ = looped([1.0, -1.1], [0.5], 0.8, noise=0.3, steps=3000)
    result = excitation(u, y)
    # 41 of 3000 coefficients are fitted: what they take is 1.4 % of its variance.
    assert np.corrcoef(result, r[-len(result) :])[0, 1] > 0.98


NOISE = np.random.default_rng(1).standard_normal((2, 500))


@pytest.mark.parametrize(
    ("u", "y", "words"),
    [
        (-0.5 * NOISE[0], NOISE[0], "u is determined by y.*dither"),
        (*NOISE, "no effect of u"),
        (1.0 * (np.arange(500) > 5), NOISE[0], "its own past.*identify_output_error"),
        (np.sin(0.3 * np.arange(500)), NOISE[0], "its own past.*identify_output_error"),
        (np.ones(500), NOISE[0], "u is constant"),
        (NOISE[0], np.ones(500), "y is constant"),
        (NOISE[0][:20], NOISE[1][:20], "at least"),
        (NOISE[0], NOISE[1][:400], "equally long"),
        (NOISE.T, NOISE[0], "2 columns"),
    ],
)
def test_a_record_of_nothing_is_refused(u, y, words):
    with pytest.raises(InputError, match=words):
        identify_in_closed_loop(u, y)


def test_the_noise_of_the_loop_alone_shows_the_controller():
    u, y, *_ = looped([1.0, -1.1], [0.5], 0.8, noise=0.3, dither=0.0)
    with pytest.raises(InputError, match="the controller, not the plant"):
        identify_in_closed_loop(u, y)
