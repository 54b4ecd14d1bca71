"""R_theta by what it is worth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_numeric import (
    UD,
    ControllerSettings,
    DataDriven,
    PriorSamples,
    TargetModel,
    exogenous,
    feedforward,
    fir_integrator,
    iir,
    pid,
    servo_plant,
    simulate,
)
from rcac_numeric.controllers._settings import FLOOR
from rcac_numeric.signals._waveforms import Step, WhiteNoise

TARGET = TargetModel([0, 2, 1], [1, -0.5, 0])


def weight_of(structure, prior, target=TARGET):
    made = ControllerSettings(structure=structure, target=target, update=UD(R_theta=prior))
    return made.update.R_theta


@pytest.mark.costly
@pytest.mark.parametrize("structure", [iir(3), pid("PD"), feedforward(2)])
def test_sizes_are_those_of_a_white_record(structure):
    """The mean over 2e5 samples: within 5 standard errors of what it estimates."""
    rng = np.random.default_rng(0)
    steps, sizes = 200_000, {"y": 2.0, "u": 0.3, "r": 1.5}
    record = {name: size * rng.standard_normal(steps) for name, size in sizes.items()}
    found = weight_of(structure, PriorSamples(1, **record))
    exact = weight_of(structure, PriorSamples(1, **sizes))
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    # Products of signals that G_f, of 10 samples' memory, has correlated.
    assert np.abs((found - exact) / scale).max() < 5 * np.sqrt(2 * 10 / steps)


def test_it_is_the_mean_of_the_regressor_by_hand():
    rng = np.random.default_rng(1)
    u, y = rng.standard_normal((2, 50))
    delayed = TargetModel([0, 0, 3.0])
    phi = np.zeros((50, 2))
    phi[3:, 0], phi[3:, 1] = 3 * u[:-3], 3 * y[:-3]
    wanted = 20 * phi.T @ phi / 50
    wanted += FLOOR * np.diag(np.diag(wanted))
    assert np.allclose(weight_of(iir(1), PriorSamples(20, y, u), delayed), wanted)


def test_sizes_of_a_target_of_one_lag_by_hand():
    """White signals behind 3/q: their mean squares, 9 times, with nothing beside the diagonal."""
    delayed, sizes = TargetModel([0, 3.0]), [0.25] * 2 + [4.0] * 2
    found = weight_of(iir(2), PriorSamples(1, y=2.0, u=0.5), delayed)
    assert np.allclose(found, 9 * np.diag(sizes) * (1 + FLOOR), rtol=1e-12, atol=1e-12)


@settings(max_examples=10)
@given(u=st.floats(-6, 6), y=st.floats(-6, 6))
def test_units_change_nothing(u, y):
    """The same loop in other units: theta is the same but for its own."""
    u, y = 10.0**u, 10.0**y
    plant, steps = servo_plant("0.2/(q - 0.9)"), 60
    other = servo_plant(f"{0.2 * y / u!r}/(q - 0.9)")
    w = exogenous([Step(1.0), WhiteNoise(0.1), WhiteNoise(0.01)], steps, seed=1)
    thetas = []
    for one, scale, H in ((plant, np.ones(3), 1.0), (other, np.array([y, u, y]), y / u)):
        made = ControllerSettings(
            structure=iir(2), target=TargetModel([0, -0.2 * H]),
            update=UD(PriorSamples(10, y=0.5 * scale[0])),
        )  # fmt: skip
        run = simulate(one, made, w * scale)
        thetas.append(run.theta_final / np.array([1, 1, 1 / H, 1 / H]))
    assert np.allclose(*thetas, rtol=1e-6, atol=1e-9)


def test_an_integral_counts_as_a_slow_lag():
    found = weight_of(fir_integrator(2), PriorSamples(1, y=1.0))
    assert np.isfinite(found).all() and np.linalg.eigvalsh(found).min() > 0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PriorSamples(0, 1.0), "must be positive"),
        (lambda: PriorSamples(10, 0.0), "neither the size"),
        (lambda: PriorSamples(10, np.ones(100)), "u is not"),
        (lambda: PriorSamples(10, np.ones(100), np.ones(99)), "u is not"),
        (lambda: UD(1.0, process_noise=PriorSamples(10, 1.0)), "in the place of R_theta alone"),
        (lambda: weight_of(iir(2), PriorSamples(10, [1.0, 2.0])), "2 components"),
        (lambda: weight_of(feedforward(2), PriorSamples(10, 1.0)), "reads r"),
        (lambda: weight_of(iir(2), PriorSamples(10, 1.0), DataDriven(order=5)), "from the start"),
    ],
)
def test_what_it_cannot_be_is_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()
