"""Commands, disturbances and noise."""

import numpy as np
import pytest

from compensator_theory import InputError
from rcac_numeric import exogenous, harmonic, sequence, step, white_noise


def test_values():
    k = np.arange(50)
    signal = 2 * harmonic(0.3, amplitude=1.5, phase=0.2) + step(-1, start=10)
    expected = 3.0 * np.cos(0.3 * k + 0.2) - (k >= 10)
    assert signal.samples(50) == pytest.approx(expected)
    assert sequence([1, 2, 3], hold=2).samples(8).tolist() == [1, 1, 2, 2, 3, 3, 3, 3]


def test_noise_is_reproducible_and_channels_are_independent():
    w = exogenous([white_noise(2.0), white_noise(1.0)], 40_000, seed=3)
    assert np.array_equal(w, exogenous([white_noise(2.0), white_noise(1.0)], 40_000, seed=3))
    # Standard errors: std / sqrt(2 n) = 0.007, correlation 1 / sqrt(n) = 0.005.
    assert w.std(axis=0) == pytest.approx([2.0, 1.0], abs=0.04)
    assert abs(np.corrcoef(w.T)[0, 1]) < 0.025
    alone = exogenous([white_noise(2.0)], 40_000, seed=3)
    assert np.array_equal(alone[:, 0], w[:, 0])
    beside_a_step = exogenous([step(), white_noise(1.0)], 40_000, seed=3)
    assert np.array_equal(beside_a_step[:, 1], w[:, 1]), "a channel does not disturb the others"


@pytest.mark.parametrize(
    "make",
    [
        lambda: step(float("nan")),
        lambda: step(1.0, start=-1),
        lambda: harmonic("fast"),
        lambda: white_noise(-1.0),
        lambda: sequence([]),
        lambda: sequence([1.0], hold=0),
        lambda: step() * float("inf"),
    ],
)
def test_bad_input_is_named(make):
    with pytest.raises(InputError):
        make()
