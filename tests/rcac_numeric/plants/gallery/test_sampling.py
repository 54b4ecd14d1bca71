"""Exact sampling against a 50-digit exponential, and the sampling zeros of Example 1.3."""

import control
import mpmath
import numpy as np
import pytest
import scipy.signal
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from rcac_numeric.gallery import (
    BoostConverter,
    CartPendulum,
    ContinuousPlant,
    MassSpringDamper,
    aircraft,
    critical_period,
    limited_delay_margin,
    no_guaranteed_margins,
    plant_zeros,
    rohrs_plant,
    sampling_zeros,
)
from rcac_numeric.plants._zero_order_hold import zero_order_hold

boost, pendulum = BoostConverter(), CartPendulum()
GALLERY = {
    "nominal": (aircraft("nominal"), 0.1),
    "off-nominal": (aircraft("off-nominal"), 0.1),
    "margins": (no_guaranteed_margins(), 0.01),
    "delay margin": (limited_delay_margin(), 0.1),
    "rohrs": (rohrs_plant(), 0.04),
    "boost": (boost.linearised(boost.operating_point(0.5)), 2e-5),
    "pendulum": (pendulum.linearised(pendulum.operating_point("upright")), 0.02),
    "mass": (MassSpringDamper().continuous(), 0.1),
}


def exponential(A, B, h):
    """exp of the generator with 50 digits, entries and h read as their shortest decimals."""
    with mpmath.workdps(60):
        n, m = B.shape
        generator = mpmath.zeros(n + m)
        for i in range(n):
            for j, entry in enumerate([*A[i], *B[i]]):
                generator[i, j] = mpmath.mpf(repr(float(entry))) * mpmath.mpf(repr(h))
        whole = mpmath.expm(generator, method="taylor")
        # mpmath rounds to float64 correctly.
        rows = [[float(whole[i, j]) for j in range(n + m)] for i in range(n)]
    return np.array(rows)[:, :n], np.array(rows)[:, n:]


@pytest.mark.exact_data
@pytest.mark.parametrize("name", GALLERY)
def test_sampling_is_the_50_digit_exponential_rounded_once(name):
    plant, h = GALLERY[name]
    A, B = exponential(plant.A, plant.B, h)
    sampled = plant.sampled(h)
    assert np.array_equal(sampled.A, A) and np.array_equal(sampled.B, B)
    servo = plant.servo(h)
    assert np.array_equal(servo.A, A) and np.array_equal(servo.B, B)
    assert np.array_equal(servo.E_1, -plant.C)


@pytest.mark.exact_data
@given(st.integers(0, 2**32), st.integers(1, 4), st.integers(1, 2), st.floats(1e-6, 10))
def test_random_plants_against_the_50_digit_exponential_and_scipy(seed, n, m, h):
    M = np.random.default_rng(seed).normal(size=(n, n + m)).round(3)
    A, B = M[:, :n], M[:, n:]
    sampled = zero_order_hold(A, B, h)
    for ours, exact in zip(sampled, exponential(A, B, h), strict=True):
        assert np.allclose(ours, exact, rtol=1e-15, atol=0)
    theirs = scipy.signal.cont2discrete((A, B, np.eye(n), np.zeros((n, m))), h)
    scale = max(np.abs(sampled[0]).max(), np.abs(sampled[1]).max())
    assert np.allclose(sampled[0], theirs[0], atol=1e-9 * scale)
    assert np.allclose(sampled[1], theirs[1], atol=1e-9 * scale)


def test_two_short_periods_make_a_long_one():
    plant = aircraft("off-nominal")
    (A, B), (AA, BB) = (zero_order_hold(plant.A, plant.B, h) for h in (0.05, 0.1))
    assert np.allclose(A @ A, AA, atol=1e-14) and np.allclose(A @ B + B, BB, atol=1e-14)


@pytest.mark.parametrize(
    ("A", "B", "h", "message"),
    [
        ([[1.0]], [[1.0]], 0.0, "h = 0 must be positive"),
        ([[1.0]], [[1.0]], float("nan"), "h"),
        ([[1e6]], [[1.0]], 1.0, "the fastest growing mode of A is 1e.06 per second"),
        ([[1.0, 0.0]], [[1.0]], 1.0, "A has shape"),
        ([[1.0]], [[1.0], [2.0]], 1.0, "B has shape"),
    ],
)
def test_what_cannot_be_sampled_is_refused(A, B, h, message):
    with pytest.raises(InputError, match=message):
        zero_order_hold(A, B, h)


def test_zeros_are_those_of_python_control():
    for plant, _ in GALLERY.values():
        theirs = control.ss(plant.A, plant.B, plant.C, plant.D).zeros()
        # As polynomials: the order of conjugates hangs on the last digit of their real parts.
        ours, theirs = np.poly(plant.zeros()), np.poly(theirs)
        assert ours == pytest.approx(theirs, abs=1e-6 * np.abs(ours).max())


def test_sampling_zeros_approach_those_of_euler_and_frobenius():
    """Astrom, Hagander and Sternby 1984: z^2 + 4z + 1 for relative degree 3, linearly in h."""
    limits = np.roots([1, 4, 1])
    gaps = [np.abs(z - limits).max() for z in sampling_zeros(rohrs_plant(), [0.004, 0.002, 0.001])]
    assert gaps[0] / gaps[1] == pytest.approx(2, rel=0.1)
    assert gaps[1] / gaps[2] == pytest.approx(2, rel=0.1)


@pytest.mark.costly
def test_the_zero_of_example_1_3_leaves_the_disk_below_a_period_of_about_0_2_s():
    h = critical_period(rohrs_plant(), 0.05, 0.5)
    assert h == pytest.approx(0.2, abs=0.005)
    inside, outside = sampling_zeros(rohrs_plant(), [h * 1.001, h * 0.999])
    assert np.abs(inside).max() < 1 < np.abs(outside).max()
    assert len(inside) == 2, "relative degree 3 gives two sampling zeros"
    theirs = control.c2d(control.tf([458], np.polymul([1, 1], [1, 30, 229])), h).zeros()
    assert np.abs(theirs).max() == pytest.approx(1, abs=1e-6)
    lag = ContinuousPlant([[-1.0]], [[2.0]], [[1.0]])
    assert plant_zeros(lag.sampled(0.1)).size == 0, "T_0 alone has none"
    with pytest.raises(InputError, match=r"sampled at 0.3 s and at 0.5 s .* minimum phase"):
        critical_period(rohrs_plant(), 0.3, 0.5)


def test_the_delay_margin_of_example_1_1():
    """No controller tolerates a delay above 2/p for a real unstable pole p."""
    poles = limited_delay_margin().poles()
    unstable = poles[poles.real > 0]
    assert len(unstable) == 1 and unstable[0].imag == 0
    assert unstable[0].real == pytest.approx(0.1081, abs=5e-5)
    assert 2 / unstable[0].real == pytest.approx(18.51, abs=0.015)
    assert (limited_delay_margin().zeros().real < 0).all(), "minimum phase, as the text says"


def test_names_are_counted():
    with pytest.raises(InputError, match=r"states = .*: 1 names are needed"):
        ContinuousPlant([[1.0]], [[1.0]], [[1.0]], states=["a", "b"])
    assert ContinuousPlant([[1.0]], [[1.0]], [[1.0]]).outputs == ("output 1",)
