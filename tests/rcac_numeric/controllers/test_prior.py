"""R_theta by what it is worth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_numeric.controllers._settings import FLOOR
from rcac_numeric.signals._waveforms import Step, WhiteNoise

TARGET = rn.TargetModel([0, 2, 1], [1, -0.5, 0])


def weight_of(structure, prior, target=TARGET):
    settings = rn.ControllerSettings(
        structure=structure, target=target, update=rn.UD(R_theta=prior)
    )
    return settings.update.R_theta


@pytest.mark.costly
@pytest.mark.parametrize("structure", [rn.iir(3), rn.pid("PD"), rn.feedforward(2)])
def test_sizes_are_those_of_a_white_record(structure):
    """The mean over 2e5 samples: within 5 standard errors of what it estimates."""
    rng = np.random.default_rng(0)
    steps, sizes = 200_000, {"y": 2.0, "u": 0.3, "r": 1.5}
    record = {name: size * rng.standard_normal(steps) for name, size in sizes.items()}
    weight = weight_of(structure, rn.PriorSamples(1, **record))
    exact = weight_of(structure, rn.PriorSamples(1, **sizes))
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    # Products of signals that G_f, of 10 samples' memory, has correlated.
    assert np.abs((weight - exact) / scale).max() < 5 * np.sqrt(2 * 10 / steps)


def test_it_is_the_mean_of_the_regressor_by_hand():
    rng = np.random.default_rng(1)
    u, y = rng.standard_normal((2, 50))
    delayed = rn.TargetModel([0, 0, 3.0])
    phi = np.zeros((50, 2))
    phi[3:, 0], phi[3:, 1] = 3 * u[:-3], 3 * y[:-3]
    expected = 20 * phi.T @ phi / 50
    expected += FLOOR * np.diag(np.diag(expected))
    assert np.allclose(weight_of(rn.iir(1), rn.PriorSamples(20, y, u), delayed), expected)


def test_sizes_of_a_target_of_one_lag_by_hand():
    """White signals behind 3/q: their mean squares, 9 times, with nothing beside the diagonal."""
    delayed, sizes = rn.TargetModel([0, 3.0]), [0.25] * 2 + [4.0] * 2
    weight = weight_of(rn.iir(2), rn.PriorSamples(1, y=2.0, u=0.5), delayed)
    assert np.allclose(weight, 9 * np.diag(sizes) * (1 + FLOOR), rtol=1e-12, atol=1e-12)


@settings(max_examples=10)
@given(u=st.floats(-6, 6), y=st.floats(-6, 6))
def test_units_change_nothing(u, y):
    """The same loop in other units: theta is the same but for its own."""
    u, y = 10.0**u, 10.0**y
    plant, steps = rn.servo_plant("0.2/(q - 0.9)"), 60
    other = rn.servo_plant(f"{0.2 * y / u!r}/(q - 0.9)")
    w = rn.exogenous([Step(1.0), WhiteNoise(0.1), WhiteNoise(0.01)], steps, seed=1)
    thetas = []
    for one, scale, H in ((plant, np.ones(3), 1.0), (other, np.array([y, u, y]), y / u)):
        settings = rn.ControllerSettings(
            structure=rn.iir(2), target=rn.TargetModel([0, -0.2 * H]),
            update=rn.UD(rn.PriorSamples(10, y=0.5 * scale[0])),
        )  # fmt: skip
        run = rn.simulate(one, settings, w * scale)
        thetas.append(run.theta_final / np.array([1, 1, 1 / H, 1 / H]))
    assert np.allclose(*thetas, rtol=1e-6, atol=1e-9)


def test_an_integral_counts_as_a_slow_lag():
    weight = weight_of(rn.fir_integrator(2), rn.PriorSamples(1, y=1.0))
    assert np.isfinite(weight).all() and np.linalg.eigvalsh(weight).min() > 0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: rn.PriorSamples(0, 1.0), "must be positive"),
        (lambda: rn.PriorSamples(10, 0.0), "neither the size"),
        (lambda: rn.PriorSamples(10, np.ones(100)), "u is not"),
        (lambda: rn.PriorSamples(10, np.ones(100), np.ones(99)), "u is not"),
        (
            lambda: rn.UD(1.0, process_noise=rn.PriorSamples(10, 1.0)),
            "in place of R_theta alone",
        ),
        (lambda: weight_of(rn.iir(2), rn.PriorSamples(10, [1.0, 2.0])), "2 components"),
        (lambda: weight_of(rn.feedforward(2), rn.PriorSamples(10, 1.0)), "reads r"),
        (
            lambda: weight_of(rn.iir(2), rn.PriorSamples(10, 1.0), rn.DataDriven(order=5)),
            "from the start",
        ),
    ],
)
def test_what_it_cannot_be_is_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()
