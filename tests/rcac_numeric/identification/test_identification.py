"""Markov parameters and modelling information from data."""

import control
import numpy as np
import pytest
import scipy.signal
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from rcac_numeric import fir_target, standard_plant
from rcac_numeric.identification import (
    eigensystem_realisation,
    identify_markov_parameters,
    modelling_information_from_markov,
)
from rcac_numeric.targets import markov_parameters, markov_target, modelling_information
from tests.support.aircraft import OFF_NOMINAL, aircraft
from tests.support.strategies import plants, seeds

NMP = "2*(q - 1.2)*(q - 0.5)/((q - 0.9)*(q - 0.3)*(q**2 - q + 0.5))"


def record(plant, u):
    """z from rest."""
    x, z = np.zeros(plant.n), []
    for value in u:
        z.append(plant.E_1 @ x + plant.E_2 @ value)
        x = plant.A @ x + plant.B @ value
    return np.array(z)


def coloured(rng, steps, pole=0.9):
    return scipy.signal.lfilter([1.0], [1.0, -pole], rng.standard_normal(steps))


@given(plants(feedthrough=True), st.integers(1, 8), st.integers(0, 2), seeds)
def test_noise_free_data_give_the_parameters_of_any_plant(plant, mu, surplus, seed):
    """n_mod above the order makes a and b ambiguous, and H not."""
    u = np.random.default_rng(seed).standard_normal((250, plant.l_u))
    identified = identify_markov_parameters(u, record(plant, u), mu, plant.n + surplus)
    expected = markov_parameters(plant, mu)
    scale = np.abs(markov_parameters(plant, 51)).max()
    assert pytest.approx(expected, abs=1e-8 * scale) == identified.H
    assert np.abs(identified.residual).max() < 1e-8 * scale


@given(plants(l_u=st.just(1), l_z=st.just(1)), seeds)
def test_the_fitted_equation_is_3_8(plant, seed):
    """H, a, b and the residual reproduce y in every row, signs included."""
    rng = np.random.default_rng(seed)
    u = rng.standard_normal((120, 1))
    y = record(plant, u) + 0.1 * rng.standard_normal((120, 1))
    mu, n_mod = 3, 2
    identified = identify_markov_parameters(u, y, mu, n_mod)
    for row, k in enumerate(range(mu + n_mod - 1, 120)):
        value = sum(identified.H[j] @ u[k - j] for j in range(mu))
        for j in range(n_mod):
            value = value + identified.b[j] @ u[k - mu - j] - identified.a[j] @ y[k - mu - j]
        assert y[k] == pytest.approx(value + identified.residual[row])


@pytest.mark.costly
def test_the_error_shrinks_with_the_root_of_the_number_of_samples():
    """Section 3.6: white input, arbitrary (here strongly coloured) noise; H is consistent.

    Over 20 seeds a root mean square has a relative standard deviation of at most
    1/sqrt(2*20) = 0.16, a ratio of two 0.22; the other coefficients stay where the noise puts them.
    """
    plant = standard_plant("(2*q**2 + q - 1/2)/((q - 0.8)*(q - 0.5)*(q + 0.3))")
    H = markov_parameters(plant, 2)
    errors, others, scores = {}, {}, []
    for steps in (500, 8000):
        result = []
        for seed in range(20):
            rng = np.random.default_rng(seed)
            u = rng.standard_normal((steps, 1))
            y = record(plant, u) + 3 * coloured(rng, steps, -0.9)[:, None]
            result.append(identify_markov_parameters(u, y, mu=2, n_mod=3))
        gaps = np.array([f.H - H for f in result])
        errors[steps] = np.sqrt(np.mean(gaps**2))
        others[steps] = np.mean([f.a for f in result], axis=0)
        scores += [(f.H - H) / f.standard_error for f in result]
    assert errors[500] / errors[8000] == pytest.approx(4, rel=0.5)
    u = np.random.default_rng(0).standard_normal((500, 1))
    true = identify_markov_parameters(u, record(plant, u), mu=2, n_mod=3).a
    bias = np.linalg.norm(others[8000] - true)
    assert bias > 0.1
    assert np.linalg.norm(others[500] - true) == pytest.approx(bias, rel=0.5)
    assert np.std(scores) == pytest.approx(1, abs=0.15), "the standard errors are calibrated"


def test_from_noisy_data_to_the_target_model(in_full):
    """d_zu and H within their errors, the NMP zero within a percent, no spurious zero."""
    plant = standard_plant(NMP)
    truth = modelling_information(plant)
    for seed in range(20 if in_full else 4):
        rng = np.random.default_rng(seed)
        u = rng.standard_normal((4000, 1))
        y = record(plant, u) + 0.1 * coloured(rng, 4000)[:, None]
        identified = identify_markov_parameters(u, y, mu=20, n_mod=4)
        for order in (None, 4):
            known = modelling_information_from_markov(identified, order=order)
            assert known.d_zu == truth.d_zu == 2
            assert abs(known.H - 2) < 6 * identified.standard_error[2].item()
            assert len(known.nmp_zeros) == 1
            assert known.nmp_zeros[0] == pytest.approx(1.2, rel=0.01)
    assert fir_target(known).relative_degree == 2
    assert markov_target(identified.cleared()).relative_degree == 2


@pytest.mark.parametrize(
    "G",
    [
        NMP,
        "(q**2 - 2*q + 2)/(q*(q - 0.3)*(q + 0.4))",
        "-0.5*(q - 3)*(q + 2)/((q - 0.3)*(q + 0.4))",
        "1/(q - 0.5)**3",
        "(q - 0.5)/(q - 0.9)",
        "3/q",
        "(q - 1.5)/((q - 1.1)*(q - 0.5))",
    ],
)
def test_noise_free_modelling_information_is_that_of_the_plant(G):
    plant = standard_plant(G)
    truth = modelling_information(plant)
    u = np.random.default_rng(0).standard_normal((200, 1))
    by_data = identify_markov_parameters(u, record(plant, u), mu=14, n_mod=plant.n)
    for H in (by_data, markov_parameters(plant, 15)):
        known = modelling_information_from_markov(H)
        assert known.d_zu == truth.d_zu
        assert float(known.H) == pytest.approx(float(truth.H))
        key = lambda z: (-abs(z), -z.imag)  # noqa: E731
        zeros, expected = (sorted(map(complex, k.nmp_zeros), key=key) for k in (known, truth))
        assert zeros == pytest.approx(expected, abs=1e-6)


def test_the_identification_window_of_the_aircraft():
    """Section 3.6: 70 noise-free samples, n_mod = 4; mu = 10 shows both NMP zeros, 8 is too few."""
    plant = aircraft(OFF_NOMINAL, [[0, 0, 0, 1.0]])
    u = np.random.default_rng(1).standard_normal((70, 1))
    y = record(plant, u)
    modelling_information = modelling_information_from_markov(
        identify_markov_parameters(u, y, 10, 4), order=4
    )
    text = str(identify_markov_parameters(u, y, 10, 4))
    assert "H_1: 0.0124 +-" in text and "condition number" in text
    assert modelling_information.nmp_zeros == pytest.approx((1.1369, -1.0027), abs=1e-4)
    with pytest.raises(InputError, match=r"order = 4, but 7 Markov parameters.*larger mu"):
        modelling_information_from_markov(identify_markov_parameters(u, y, 8, 4), order=4)


@given(plants(feedthrough=True))
def test_the_realisation_has_the_given_parameters(plant):
    H = markov_parameters(plant, 2 * plant.n + 3)
    model = eigensystem_realisation(H, plant.n)
    x = model.B
    assert np.array_equal(model.D, H[0])
    for parameter in H[1:]:
        assert model.C @ x == pytest.approx(parameter, abs=1e-6 * np.abs(H).max())
        x = model.A @ x


@pytest.mark.parametrize("unit", [1e300, 1e-300])
def test_the_order_does_not_depend_on_the_unit(unit):
    """1/(q - 1) and 1/(q - 1/2) in parallel; the squares of these numbers leave float64."""
    H = unit * np.r_[0.0, 1 + 0.5 ** np.arange(9)]
    model = eigensystem_realisation(H)
    assert np.sort(np.linalg.eigvals(model.A)) == pytest.approx([0.5, 1.0], rel=1e-9)


def test_it_is_the_realisation_of_python_control():
    H = markov_parameters(standard_plant(NMP), 9)
    ours = eigensystem_realisation(H, 3)
    theirs, singular_values = control.eigensys_realization(H.ravel(), 3, m=4, n=4)
    assert ours.singular_values == pytest.approx(singular_values[: len(ours.singular_values)])
    points = np.exp(1j * np.linspace(0.1, 3, 5))
    response = [
        (ours.C @ np.linalg.solve(q * np.eye(3) - ours.A, ours.B) + ours.D).item() for q in points
    ]
    assert response == pytest.approx(theirs(points))


u_white = np.random.default_rng(0).standard_normal(100)


def closed_loop():
    """u(k) = -0.3 y(k-1) + r(k) with r = 0 from some step on: data made by the feedback alone."""
    u, y = np.zeros(100), np.zeros(100)
    y[0] = 1.0
    for k in range(1, 100):
        u[k] = -0.3 * y[k - 1]
        y[k] = 0.99 * y[k - 1] + u[k - 1] + 0.5 * np.sin(k**2)
    return u, y


@pytest.mark.parametrize(
    ("u", "y", "mu", "n_mod", "message"),
    [
        (np.ones(100), np.ones(100), 3, 2, "exciting of order 1 only; mu . n_mod = 5"),
        (np.cos(np.arange(100)), np.ones(100), 3, 2, "exciting of order 2 only"),
        (np.zeros(100), np.ones(100), 3, 2, "exciting of order 0 only"),
        (*closed_loop(), 2, 2, "not determined: a linear relation .* feedback"),
        (u_white, np.ones(99), 3, 2, "u has 100 steps and y has 99"),
        (u_white[:8], u_white[:8], 3, 2, "4 equations for 7 .* at least 11 samples"),
        (u_white[:2], u_white[:2], 3, 2, "0 equations for 7"),
        (u_white, u_white, 0, 2, "mu = 0"),
        (u_white, u_white, 2, -1, "n_mod = -1"),
        (np.ones((2, 2, 2)), u_white, 2, 1, r"u has shape \(2, 2, 2\)"),
        (np.r_[u_white[:99], np.nan], u_white, 2, 1, "u has the entry nan"),
    ],
)
def test_data_that_do_not_determine_the_parameters_are_refused(u, y, mu, n_mod, message):
    with pytest.raises(InputError, match=message):
        identify_markov_parameters(u, y, mu, n_mod)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: modelling_information_from_markov(np.zeros(5)), "none of the 5"),
        (
            lambda: modelling_information_from_markov(
                identify_markov_parameters(u_white, np.roll(u_white, 50), 5, 0)
            ),
            "none of the 5",
        ),
        (lambda: modelling_information_from_markov([0, 0, 1.0, 0.5]), "only 1 .* follow .* H_2"),
        (lambda: modelling_information_from_markov(np.ones((5, 2, 1))), "scalar z and u"),
        (lambda: modelling_information_from_markov([0, 1.0, 0.5, 0.25], order=3), "order = 3"),
        (lambda: modelling_information_from_markov(5), "H = 5 is a number"),
        (lambda: eigensystem_realisation(np.ones(9), error=-1), "a standard error is at least 0"),
        (lambda: eigensystem_realisation(np.ones(9), error=[1, 2]), r"error has shape \(2,\)"),
        (lambda: eigensystem_realisation([0, 1.0]), "at least H_0, H_1, H_2"),
        (lambda: eigensystem_realisation([0, 0, 0, 0, 0.0], order=1), "has rank 0"),
    ],
)
def test_parameters_that_say_too_little_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
