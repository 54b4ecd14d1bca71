"""Smoothing beside least squares over the whole record, and the flow of the Nile."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import IllConditionedError, InputError
from rcac_numeric.estimation import EKF, UKF, LinearModel, estimate, smooth
from tests.support.nile import NILE


def batch(settings, y, u):
    """All states at once by least squares over the prior, the dynamics and what was measured."""
    model, steps = settings.model, len(y)
    n = model.n
    H, b, W = [], [], []

    def rows(block, k, value, covariance):
        row = np.zeros((len(value), steps * n))
        for j, matrix in block.items():
            row[:, j * n : (j + 1) * n] = matrix
        H.append(row), b.append(value), W.append(np.linalg.inv(np.linalg.cholesky(covariance)))

    rows({0: np.eye(n)}, 0, settings.x_0, settings.P_0)
    for k in range(steps):
        there = ~np.isnan(y[k])
        if there.any():
            known = y[k][there] - model.D[there] @ u[k]
            rows({k: model.C[there]}, k, known, settings.R[np.ix_(there, there)])
        if k + 1 < steps:
            rows({k: -model.A, k + 1: np.eye(n)}, k, model.B @ u[k], settings.Q)
    A = np.vstack([w @ h for w, h in zip(W, H, strict=True)])
    rhs = np.concatenate([w @ v for w, v in zip(W, b, strict=True)])
    x = np.linalg.lstsq(A, rhs, rcond=None)[0].reshape(steps, n)
    P = np.linalg.inv(A.T @ A)
    return x, np.array([P[k * n : (k + 1) * n, k * n : (k + 1) * n] for k in range(steps)])


def drawn(seed, steps=12):
    rng = np.random.default_rng(seed)
    n, l_y, l_u = (int(rng.integers(1, 4)) for _ in range(3))
    A = rng.standard_normal((n, n))
    A /= max(np.abs(np.linalg.eigvals(A)).max(), 1.0)
    model = LinearModel(
        A=A, C=rng.standard_normal((l_y, n)), B=rng.standard_normal((n, l_u)),
        D=rng.standard_normal((l_y, l_u)),
    )  # fmt: skip
    q, r = rng.standard_normal((n, n)), rng.standard_normal((l_y, l_y))
    settings = EKF(model, Q=q @ q.T + 0.1 * np.eye(n), R=r @ r.T + 0.1 * np.eye(l_y), P_0=2.0)
    y = rng.standard_normal((steps, l_y))
    y[rng.random(y.shape) < 0.3] = np.nan
    return settings, y, rng.standard_normal((steps, l_u))


@given(seed=st.integers(0, 2**32 - 1))
def test_it_is_least_squares_over_the_whole_record(seed):
    settings, y, u = drawn(seed)
    smoothed = smooth(settings, y, u)
    x, P = batch(settings, y, u)
    assert smoothed.x == pytest.approx(x, rel=1e-6, abs=1e-7)
    assert pytest.approx(P, rel=1e-6, abs=1e-7) == smoothed.P


@given(seed=st.integers(0, 2**32 - 1), lag=st.integers(0, 4))
def test_a_fixed_lag_is_the_record_cut_off_there(seed, lag):
    settings, y, u = drawn(seed, steps=8)
    smoothed = smooth(settings, y, u, lag=lag)
    for k in range(8):
        cut = smooth(settings, y[: k + lag + 1], u[: k + lag + 1])
        assert smoothed.x[k] == pytest.approx(cut.x[k], rel=1e-8, abs=1e-9)
        assert smoothed.P[k] == pytest.approx(cut.P[k], rel=1e-8, abs=1e-9)


@pytest.mark.filterwarnings("ignore::rcac_numeric.estimation.UnobservableWarning")
@given(seed=st.integers(0, 2**32 - 1))
def test_its_filter_is_that_of_estimate(seed):
    settings, y, u = drawn(seed)
    result, kalman = smooth(settings, y, u), estimate(settings, y, u)
    assert result.filtered == pytest.approx(kalman.x, rel=1e-8, abs=1e-9)
    assert result.log_likelihood == pytest.approx(kalman.log_likelihood, rel=1e-8, abs=1e-8)
    assert result.x[-1] == pytest.approx(result.filtered[-1])


def nile():
    return EKF(LinearModel(A=1, C=1), Q=1469.1, R=15099.0, P_0=1e7)


def test_the_level_of_the_nile():
    """Variances 15099 and 1469.1 (Durbin, Koopman 2012, 2.2): the stationary ones, and a drop."""
    result = smooth(nile(), NILE)
    q, r = 1469.1, 15099.0
    predicted = (q + np.sqrt(q * q + 4 * q * r)) / 2  # 5501.3
    filtered = predicted * r / (predicted + r)
    gain = filtered / predicted
    smoothed = (filtered - gain**2 * predicted) / (1 - gain**2)
    assert result.P[-1, 0, 0] == pytest.approx(filtered, rel=1e-9)
    assert result.P[50, 0, 0] == pytest.approx(smoothed, rel=1e-6)
    assert result.x[20:27].mean() > 1050 and result.x[32:100].max() < 950  # the dam of 1899


def test_the_nile_beside_statsmodels():
    structural = pytest.importorskip("statsmodels.tsa.statespace.structural")
    gappy = np.array(NILE, dtype=float)
    gappy[20:40] = np.nan
    for y in (np.array(NILE, dtype=float), gappy):
        model = structural.UnobservedComponents(y, "local level")
        model.ssm.initialize_known(np.zeros(1), np.array([[1e7]]))
        model.loglikelihood_burn = 0
        other = model.smooth([15099.0, 1469.1])
        smoothed = smooth(nile(), y)
        assert smoothed.x[:, 0] == pytest.approx(other.smoothed_state[0], rel=1e-9)
        assert smoothed.P[:, 0, 0] == pytest.approx(other.smoothed_state_cov[0, 0], rel=1e-8)
        assert smoothed.log_likelihood == pytest.approx(other.llf, rel=1e-10)


def test_what_cannot_be_smoothed_is_refused():
    model = LinearModel(A=1, C=[[1], [1]])
    with pytest.raises(InputError, match="EKF with a LinearModel"):
        smooth(UKF(model, Q=1, R=1), [[1, 1]])
    with pytest.raises(IllConditionedError, match="singular at step 0"):
        smooth(EKF(model, Q=1, R=0), [[1.0, 1.0]])
    with pytest.raises(InputError, match="inputs"):
        smooth(EKF(LinearModel(A=1, C=1, B=1), Q=1, R=1), [1.0])
    with pytest.raises(InputError, match="lag"):
        smooth(EKF(LinearModel(A=1, C=1), Q=1, R=1), [1.0], lag=-1)
