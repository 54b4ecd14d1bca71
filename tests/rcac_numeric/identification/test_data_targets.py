"""Targets from data against those of the plant itself, and what the data cannot carry."""

import numpy as np
import pytest
import scipy.signal

from compensator_theory import InputError
from rcac_numeric import fir_target, modelling_information, standard_plant, target_from_data
from rcac_numeric.gallery import aircraft_plant
from tests.rcac_numeric.identification.records import COMPLEX, REAL, noisy, simulated


@pytest.mark.parametrize("condition", ["nominal", "off-nominal"])
def test_the_target_of_the_aircraft_from_a_noise_free_window(condition):
    plant = aircraft_plant(condition)
    u = np.random.default_rng(0).standard_normal(70)
    found = target_from_data(u, simulated(plant, u), mu=10, n_mod=4, order=4)
    truth = fir_target(modelling_information(plant))
    assert found.target.numerator == pytest.approx(truth.numerator, abs=1e-6)


@pytest.mark.parametrize("G", ["2*(q - 0.5)/((q - 0.9)*(q - 0.3))", "1/((q - 0.9)*(q - 0.3))"])
def test_without_nmp_zeros_it_is_2_49(G):
    plant = standard_plant(G)
    u = np.random.default_rng(0).standard_normal(100)
    found = target_from_data(u, simulated(plant, u), mu=10, n_mod=2, order=2)
    truth = fir_target(modelling_information(plant))
    assert found.target.numerator == pytest.approx(truth.numerator, abs=1e-6)


def test_with_coloured_noise_it_is_near_that_of_the_plant():
    for seed in range(5):
        u, z = noisy(COMPLEX, 3000, seed, noise=0.05)
        found = target_from_data(u, z, mu=10, n_mod=3, order=3)
        expected = np.r_[0, np.poly([COMPLEX, np.conj(COMPLEX)]).real]
        # Six standard errors of the zeros, to which the coefficients are first-order equal.
        room = 6 * 2 * np.abs(COMPLEX) * found.zeros.modulus_error.max()
        assert np.abs(found.target.numerator.ravel() - expected).max() < room
        assert "nonminimum phase" in str(found)


U, Z = noisy(REAL, 400, 0)
CONSTANT = np.ones(400)


@pytest.mark.parametrize(
    ("u", "z", "options", "message"),
    [
        (*noisy(1.02, 300, 0), {}, "do not say whether it is inside .* Keep the target"),
        (U, Z, {"largest_error": 1e-4}, "more than 0.0001 of it. Keep the target"),
        (CONSTANT, Z, {}, "persistently exciting of order 1"),
        (U[:12], Z[:12], {}, "equations for"),
        (U, np.random.default_rng(5).standard_normal(400), {}, "none of the 10 Markov"),
        (U, scipy.signal.lfilter([0, 1], [1, -0.5], U), {"order": 6}, "order = 6, but"),
        (U, np.stack([Z, Z], axis=1), {}, "is 2 x 1; this target model is for scalar"),
    ],
)
def test_data_that_cannot_carry_a_target_are_refused(u, z, options, message):
    with pytest.raises(InputError, match=message):
        target_from_data(u, z, **{"mu": 10, "n_mod": 2, "order": 2, **options})
