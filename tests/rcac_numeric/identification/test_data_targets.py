"""Targets from data against those of the plant itself, and what the data cannot carry."""

import numpy as np
import pytest
import scipy.signal

from compensator_theory import InputError
from rcac_numeric import fir_target, standard_plant, target_from_data
from rcac_numeric.gallery import aircraft_plant
from rcac_numeric.targets import modelling_information
from tests.rcac_numeric.identification.records import COMPLEX, REAL, noisy, simulated


@pytest.mark.parametrize("condition", ["nominal", "off-nominal"])
def test_the_target_of_the_aircraft_from_a_noise_free_window(condition):
    plant = aircraft_plant(condition)
    u = np.random.default_rng(0).standard_normal(70)
    data_target = target_from_data(u, simulated(plant, u), mu=10, n_mod=4, order=4)
    truth = fir_target(modelling_information(plant))
    assert data_target.target.numerator == pytest.approx(truth.numerator, abs=1e-6)


@pytest.mark.parametrize("G", ["2*(q - 0.5)/((q - 0.9)*(q - 0.3))", "1/((q - 0.9)*(q - 0.3))"])
def test_without_nmp_zeros_it_is_2_49(G):
    plant = standard_plant(G)
    u = np.random.default_rng(0).standard_normal(100)
    data_target = target_from_data(u, simulated(plant, u), mu=10, n_mod=2, order=2)
    truth = fir_target(modelling_information(plant))
    assert data_target.target.numerator == pytest.approx(truth.numerator, abs=1e-6)


def test_with_coloured_noise_it_is_near_that_of_the_plant():
    for seed in range(5):
        u, z = noisy(COMPLEX, 3000, seed, noise=0.05)
        data_target = target_from_data(u, z, mu=10, n_mod=3, order=3)
        expected = np.r_[0, np.poly([COMPLEX, np.conj(COMPLEX)]).real]
        # Six standard errors of the zeros, to which the coefficients are first-order equal.
        room = 6 * 2 * np.abs(COMPLEX) * data_target.zeros.modulus_error.max()
        assert np.abs(data_target.target.numerator.ravel() - expected).max() < room
        assert "nonminimum phase" in str(data_target.zeros)


U, Z = noisy(REAL, 400, 0)
CONSTANT = np.ones(400)


@pytest.mark.parametrize(
    ("u", "z", "options", "message"),
    [
        (*noisy(1.02, 300, 0), {}, "do not decide whether it is inside .* Keep the target"),
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


def logged(B, A, ratio, seed, steps=1500):
    """u and y in coloured noise, and the order, dead time counted."""
    rng = np.random.default_rng(seed)
    u = rng.standard_normal(steps)
    y = scipy.signal.lfilter(B, A, u)
    e = scipy.signal.lfilter([1.0], [1.0, -0.8], rng.standard_normal(steps))
    return u, y + e * y.std() / e.std() / ratio


def test_facts_that_the_data_show_are_sure():
    u, z = logged([0, 0, -2.0, 3.0], np.poly([0.6, 0.3]), 30, 0)
    data_target = target_from_data(u, z, mu=12, n_mod=3, order=3)
    assert [(fact.name, fact.value) for fact in data_target.facts] == [
        ("relative degree", "2"), ("sign", "-"), ("NMP zeros", "1")
    ]  # fmt: skip
    assert all(fact.is_sure for fact in data_target.facts) and "NOT sure" not in str(data_target)


def test_a_relative_degree_that_is_late_is_marked():
    """Three slow lags: the first steps of the answer are lost in the noise."""
    A, late = np.poly([0.95, 0.9, 0.8]), 0
    for seed in range(20):
        u, z = logged([0, 0.01, 0.03, 0.01], A, 10, seed)
        try:
            data_target = target_from_data(u, z, mu=15, n_mod=3, order=3)
        except InputError:
            continue
        assert int(data_target.facts[0].value) == 1 or not any(
            fact.is_sure for fact in data_target.facts
        )
        late += int(data_target.facts[0].value) > 1
    assert late > 5


def test_what_is_sure_is_right():
    """Of a few; of 200 in benchmarks/data_facts.py."""
    sure = 0
    for seed in range(20):
        rng = np.random.default_rng([seed, 5])
        late, A = int(rng.integers(0, 4)), np.poly(rng.uniform(0.1, 0.9, 2))
        zero = float(rng.choice([0.5, 1.5]))
        B = np.r_[np.zeros(late + 1), rng.choice([-1.0, 1.0]) * np.array([1.0, -zero])]
        u, z = logged(B, A, np.exp(rng.uniform(*np.log([3, 100]))), seed)
        try:
            data_target = target_from_data(u, z, mu=20, n_mod=2 + late, order=2 + late)
        except InputError:
            continue
        truth = (str(late + 1), "+" if B[late + 1] > 0 else "-", str(int(zero > 1)))
        sure += sum(fact.is_sure for fact in data_target.facts)
        assert all(
            fact.value == true
            for fact, true in zip(data_target.facts, truth, strict=True)
            if fact.is_sure
        )
    assert sure > 10


def test_the_probability_is_that_of_the_parameter_before():
    """By a million draws of the Markov parameter; 5 standard deviations of the share."""
    u, z = logged([0, 0, 1.0, -4.0], np.poly([0.6, 0.3]), 3, 3, 600)
    data_target = target_from_data(u, z, mu=12, n_mod=3, order=3, largest_error=1.0)
    d, markov = data_target.zeros.d_zu, data_target.markov
    H, error = markov.H.ravel(), markov.standard_error.ravel()
    drawn = H[d - 1] + error[d - 1] * np.random.default_rng(0).standard_t(markov.freedom, 10**6)
    share = np.mean(np.abs(drawn) < abs(H[d]) / (2**3 - 1))
    assert 0.01 < share < 0.999
    assert data_target.facts[0].probability == pytest.approx(share, abs=5 * 0.5e-3)
