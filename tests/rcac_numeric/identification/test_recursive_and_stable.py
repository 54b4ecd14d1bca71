"""The recursion against the batch, covariances against independent formulas, stable models."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from rcac_numeric.identification import (
    NeweyWest,
    RecursiveMarkov,
    eigensystem_realisation,
    identify_markov_parameters,
)
from rcac_numeric.identification._noise_models import coefficient_covariance
from rcac_numeric.identification._regressors import regression
from tests.rcac_numeric.identification.records import COMPLEX, coloured, noisy


def fed(u, y, **settings):
    fit = RecursiveMarkov(l_u=u.shape[1], l_y=y.shape[1], **settings)
    for now in zip(u, y, strict=True):
        fit.update(*now)
    return fit


def mimo(seed, steps=120):
    rng = np.random.default_rng(seed)
    u = rng.standard_normal((steps, 2))
    y = np.roll(u, 1, axis=0) @ rng.normal(size=(2, 3)) + 0.3 * rng.standard_normal((steps, 3))
    return u, y


@given(st.integers(0, 2**32), st.integers(1, 4), st.integers(0, 2))
def test_the_recursion_is_the_batch(seed, mu, n_mod):
    u, y = mimo(seed)
    fit = fed(u, y, mu=mu, n_mod=n_mod, lags=2)
    assert pytest.approx(identify_markov_parameters(u, y, mu, n_mod).H, abs=1e-9) == fit.H
    assert fit.samples == 120 - mu - n_mod + 1


@given(st.integers(0, 2**32), st.floats(0.9, 0.999))
def test_forgetting_is_weighted_least_squares(seed, lambda_):
    u, y = mimo(seed)
    fit = fed(u, y, mu=2, n_mod=1, lambda_=lambda_, lags=2)
    regressors, present = regression(u, y, 2, 1)
    weights = np.sqrt(lambda_ ** np.arange(len(present))[::-1])[:, None]
    theta = np.linalg.lstsq(weights * regressors, weights * present, rcond=None)[0]
    assert pytest.approx(theta[:4].reshape(2, 2, 3).transpose(0, 2, 1), abs=1e-8) == fit.H


def test_the_recursion_follows_a_plant_that_changes():
    u = np.random.default_rng(0).standard_normal((800, 1))
    gain = np.where(np.arange(800) < 400, 1.0, -2.0)[:, None]
    y = gain * u + 0.01 * np.random.default_rng(1).standard_normal((800, 1))
    fit = fed(u, y, mu=2, n_mod=0, lambda_=0.95)
    assert fit.H.ravel() == pytest.approx([-2, 0], abs=0.01)


def test_recursive_errors_are_those_of_the_batch_in_long_records():
    u, y = noisy(COMPLEX, 3000, 0)
    fit = fed(u[:, None], y[:, None], mu=6, n_mod=3, lags=20)
    batch = identify_markov_parameters(u, y, 6, 3, NeweyWest(lags=20))
    assert fit.standard_error == pytest.approx(batch.standard_error, rel=0.15)


def kernel_sum(regressors, inverse, residual, lags):
    """The sandwich written out over all pairs of rows."""
    rows = len(residual)
    gap = np.abs(np.subtract.outer(np.arange(rows), np.arange(rows)))
    weight = np.maximum(1 - gap / (lags + 1), 0)
    scores = regressors * residual
    return inverse @ scores.T @ weight @ scores @ inverse


@pytest.mark.parametrize("lags", [0, 1, 7])
def test_newey_west_is_the_kernel_over_all_pairs(lags):
    rng = np.random.default_rng(0)
    X, e = rng.normal(size=(60, 3)), coloured(rng, 60, 0.7)[:, None]
    inverse = np.linalg.inv(X.T @ X)
    result = coefficient_covariance(X, inverse, e, 57, NeweyWest(lags)).reshape(3, 3)
    b = lags / 60
    expected = kernel_sum(X, inverse, e, lags) * 60 / 57 / (1 - b + b**2 / 3)
    assert result == pytest.approx(expected)
    assert np.linalg.eigvalsh(result).min() > -1e-15


def test_the_covariance_belongs_to_H_in_its_own_order():
    """Against the spread of H over 400 records of a 2 x 2 map: lags, outputs, inputs in C order."""
    draws, covariance = [], 0.0
    for seed in range(400):
        rng = np.random.default_rng(seed)
        u = rng.standard_normal((150, 2))
        noise = np.stack([coloured(rng, 150, 0.8), 3 * rng.standard_normal(150)], axis=1)
        noise[:, 1] += noise[:, 0]
        identified = identify_markov_parameters(u, u @ [[1.0, 2.0], [0.0, 1.0]] + noise, 2, 0)
        draws.append(identified.H.ravel())
        covariance = covariance + identified.covariance / 400
        assert np.sqrt(np.diag(identified.covariance)) == pytest.approx(
            identified.standard_error.ravel()
        )
    spread = np.cov(np.array(draws).T)
    scale = np.sqrt(np.outer(np.diag(spread), np.diag(spread)))
    # An entry of a correlation matrix from 400 draws is known to 1/20.
    assert np.abs((covariance - spread) / scale).max() < 0.25
    assert np.abs(spread / scale)[np.triu_indices(8, 1)].max() > 0.4, "there is something to see"


def test_markov_parameters_are_those_of_python_control():
    """An FIR plant, for which its least squares and (3.8) with n_mod = 0 are the same problem."""
    u = np.random.default_rng(0).standard_normal(200)
    y = np.convolve(u, [0.0, 1.0, -1.2, 0.4])[:200]
    theirs = control.markov(y, u, 4, truncate=True).ravel()
    ours = identify_markov_parameters(u, y, 4, 0)
    assert ours.H.ravel() == pytest.approx(theirs, abs=1e-9)


def test_a_realisation_of_two_inputs_and_outputs_is_that_of_python_control():
    """From identified parameters with noise; compared by frequency response, the basis is free."""
    rng = np.random.default_rng(0)
    u = rng.standard_normal((400, 2))
    x, y = np.zeros(3), []
    A, B, C = np.diag([0.8, 0.5, -0.3]), rng.normal(size=(3, 2)), rng.normal(size=(2, 3))
    for value in u:
        y.append(C @ x + 0.01 * rng.standard_normal(2))
        x = A @ x + B @ value
    H = identify_markov_parameters(u, y, 9, 3).H
    ours = eigensystem_realisation(H, 3)
    theirs, size = control.eigensys_realization(H.transpose(1, 2, 0), 3, m=4, n=4)
    assert ours.singular_values == pytest.approx(size[: len(ours.singular_values)])
    for q in np.exp(1j * np.linspace(0.1, 3, 5)):
        response = ours.C @ np.linalg.solve(q * np.eye(3) - ours.A, ours.B) + ours.D
        assert response == pytest.approx(theirs(q), abs=1e-9)


@given(st.integers(0, 2**32), st.integers(1, 4))
def test_a_stable_realisation_is_stable_whatever_the_data(seed, order):
    H = np.random.default_rng(seed).normal(size=(12, 2, 2)) * 2.0 ** np.arange(12)[:, None, None]
    model = eigensystem_realisation(H, order, stable=True)
    assert np.abs(np.linalg.eigvals(model.A)).max() < 1


def test_the_stable_realisation_is_the_usual_one_where_the_parameters_have_died_out():
    H = np.r_[0.0, 2 * 0.5 ** np.arange(60) + (-0.3) ** np.arange(60)]
    usual, stable = (eigensystem_realisation(H, 2, stable=s) for s in (False, True))
    for model in (usual, stable):
        assert np.sort(np.linalg.eigvals(model.A).real) == pytest.approx([-0.3, 0.5], abs=1e-8)
    short = eigensystem_realisation(H[:8], 2, stable=True)
    assert np.abs(np.sort(np.linalg.eigvals(short.A).real) - [-0.3, 0.5]).max() > 1e-3, "its price"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: RecursiveMarkov(1, 1, 2, 1).H, "0 equations do not determine the 4"),
        (lambda: fed(np.ones((50, 1)), np.ones((50, 1)), mu=2, n_mod=1).H, "do not determine"),
        (lambda: RecursiveMarkov(1, 1, 2, 1, lambda_=0), "lambda_ = 0"),
        (lambda: RecursiveMarkov(0, 1, 2, 1), "l_u = 0"),
        (lambda: RecursiveMarkov(1, 1, 2, 1).update([1, 2], [1]), "u has 2 entries"),
        (lambda: RecursiveMarkov(1, 1, 2, 1).update([np.nan], [1]), "u has the entry nan"),
    ],
)
def test_what_the_recursion_cannot_do_is_named(make, message):
    with pytest.raises(InputError, match=message):
        make()
