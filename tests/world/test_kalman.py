"""Kalman filters, their missing data, and masks."""

from contextlib import suppress

import mpmath
import numpy as np
import pytest

from compensator_theory import CompensatorError
from rcac_numeric import (
    UD,
    Controller,
    ControllerLog,
    ControllerSettings,
    SupervisionWarning,
    TargetModel,
    iir,
    solve_riccati,
)
from rcac_numeric.estimation import EKF, UKF, LinearModel, NonlinearModel, estimate, smooth
from tests.support.nile import NILE
from tests.support.world import case

LEVEL = LinearModel(A=1, C=1)
CV = LinearModel(A=[[1, 0.1], [0, 1]], C=[[1, 0]])
WALK = np.cumsum(np.sin(np.arange(50.0) ** 2))


def textbook(A, C, Q, R, P, y):
    """x and the log-likelihood in 60 digits; entries that are NaN are not measured."""
    with mpmath.workdps(60):
        A, C, Q, R, P = (mpmath.matrix(np.atleast_2d(M).tolist()) for M in (A, C, Q, R, P))
        x, likelihood = mpmath.zeros(A.rows, 1), mpmath.mpf(0)
        for row in np.atleast_2d(np.asarray(y, float).T).T:
            for i, value in enumerate(row):
                if np.isnan(value):
                    continue
                c = C[i, :]
                S = (c * P * c.T)[0] + R[i, i]
                e, K = mpmath.mpf(float(value)) - (c * x)[0], P * c.T / S
                likelihood -= (mpmath.log(2 * mpmath.pi * S) + e * e / S) / 2
                x, P = x + K * e, P - K * K.T * S
            last = x.copy()
            x, P = A * x, A * P * A.T + Q
        return np.array(last.tolist(), float).ravel(), float(likelihood)


def seasonal():
    """Level, slope and a season of 7."""
    A = np.zeros((8, 8))
    A[:2, :2], A[2, 2:], A[3:, 2:7] = [[1, 1], [0, 1]], -1, np.eye(5)
    C = np.zeros((1, 8))
    C[0, [0, 2]] = 1
    y = (
        np.arange(60) * 0.5
        + np.tile([3, 1, -1, 0, 2, -3, -2.0], 9)[:60]
        + 0.1 * np.sin(np.arange(60) ** 2)
    )
    return A, C, np.diag([1e-2, 1e-4, 1e-6, 0, 0, 0, 0, 0]), y


GAPS = np.column_stack([WALK, WALK[::-1]])
GAPS[::3, 1] = np.nan
GAPS[5] = np.nan
A_7, C_7, Q_7, Y_7 = seasonal()
LIKELIHOODS = [
    case("statsmodels-6660", LEVEL, 1469.1, [[15099.0]], 1e7, NILE, 1e-10),
    case(
        "pykalman-58",
        LinearModel(A=[[1, 1], [0, 1]], C=np.eye(2)),
        0.1 * np.eye(2),
        0.5 * np.eye(2),
        1.0,
        GAPS,
        1e-10,
    ),
    case("statsmodels-5044", LinearModel(A=A_7, C=C_7), Q_7, [[1e-8]], 1e8, Y_7, 1e-7),
    case("filterpy-62", CV, np.zeros((2, 2)), [[1e-12]], 1e12, np.arange(50) * 0.1, 1e-6),
]


@pytest.mark.parametrize(("model", "Q", "R", "P_0", "y", "within"), LIKELIHOODS)
def test_likelihood_and_state_in_sixty_digits(model, Q, R, P_0, y, within):
    """The textbook's recursion in mpmath, measurement by measurement."""
    n = np.atleast_2d(model.A).shape[0]
    estimates = estimate(EKF(model, Q=Q, R=R, P_0=P_0), y)
    x, likelihood = textbook(model.A, model.C, Q, R, P_0 * np.eye(n), y)
    assert estimates.log_likelihood == pytest.approx(likelihood, rel=within)
    assert estimates.x[-1] == pytest.approx(x, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("alpha", [1e-3, 0.5, 1.0])
def test_on_a_linear_model_all_filters_agree(alpha):
    """filterpy #172."""
    one = estimate(EKF(CV, Q=1e-3, R=1, P_0=1), WALK).x
    other = estimate(UKF(CV, Q=1e-3, R=1, P_0=1, alpha=alpha), WALK).x
    assert other == pytest.approx(one, rel=1e-7, abs=1e-7)


def test_a_steady_filter_is_the_riccati_equation():
    """python-control #1173: its covariance after a measurement, from the DARE of the dual."""
    estimates = estimate(EKF(CV, Q=1e-3, R=1, P_0=1), np.zeros(3000))
    P = solve_riccati(CV.A.T, CV.C.T, 1e-3 * np.eye(2), 1, time="discrete").P
    after = P - P @ CV.C.T @ np.linalg.inv(CV.C @ P @ CV.C.T + 1) @ CV.C @ P
    assert estimates.deviation[-1] ** 2 == pytest.approx(np.diag(after), rel=1e-8)


def test_a_covariance_stays_definite():
    """filterpy #31, #218: no noise of the process, 5000 exact measurements."""
    estimates = estimate(EKF(CV, Q=0, R=1e-8, P_0=1e12), np.arange(5000) * 0.1)
    assert np.all(estimates.deviation[-1] > 0) and estimates.x[-1] == pytest.approx(
        [499.9, 1], rel=1e-9
    )


def test_a_measurement_without_noise():
    """filterpy #214: R = 0 in the UKF; the state is what is measured."""
    estimates = estimate(UKF(CV, Q=np.diag([1e-3, 1e-3]), R=0, P_0=10), WALK)
    assert estimates.x[-1, 0] == pytest.approx(WALK[-1], abs=1e-6)


def test_a_model_with_abs():
    """filterpy #296."""
    model = NonlinearModel(lambda k, x, *_: np.abs(x - 0.01), lambda k, x, *_: x, n_x=1, l_y=1)
    estimates = estimate(UKF(model, Q=1, R=1e-4), np.abs(WALK))
    assert estimates.x[:, 0] == pytest.approx(np.abs(WALK), abs=1e-2)


MASKED = np.ma.masked_array([1.0, 2.0, 1e6, 3.0, 2.5], mask=[0, 0, 1, 0, 0])
SENTINEL = np.ma.masked_equal(np.array([1.0, 2.0, -9999.0, 3.0, 2.5]), -9999.0)


def settings():
    return ControllerSettings(structure=iir(1), target=TargetModel([0, 1]), update=UD(1.0))


def step_with_a_mask():
    """Whether a masked y is a missing one."""
    theta = []
    for y in (np.ma.masked_array([5.0], mask=[True]), np.nan):
        controller = Controller(settings())
        for k in range(5):
            controller.step(y=[1.0 + k], z=[1.0])
        controller.step(y=y, z=[1.0])
        controller.step(y=[1.0], z=[1.0])
        theta.append(np.array(controller.theta))
    assert np.array_equal(*theta)


MASKS = [
    case("pykalman-94", lambda: _never(estimate(EKF(LEVEL, Q=0.1, R=1, P_0=1), MASKED), 1e3)),
    case(
        "pykalman-94-smoother", lambda: _never(smooth(EKF(LEVEL, Q=0.1, R=1, P_0=1), MASKED), 1e3)
    ),
    case("sentinel-log", lambda: _no_sentinel(ControllerLog(np.ones(5), SENTINEL))),
    case("sentinel-step", step_with_a_mask),
]


def _never(estimates, at_most):
    assert np.abs(estimates.x).max() < at_most


def _no_sentinel(log):
    assert not np.any(np.asarray(log.y) == -9999.0)


@pytest.mark.parametrize("ask", MASKS)
def test_what_is_masked_is_missing_or_refused(ask):
    with suppress(CompensatorError):
        ask()


REFUSED = [
    case("indefinite-P", lambda: estimate(EKF(CV, Q=0, R=1, P_0=[[1, 2], [2, 1]]), WALK)),
    case("UKF-no-noise-at-all", lambda: estimate(UKF(CV, Q=0, R=0, P_0=10), WALK)),
    case("infinite-y", lambda: estimate(EKF(LEVEL, Q=0.1, R=1, P_0=1), [1, np.inf, 2])),
    case("asymmetric-Q", lambda: estimate(EKF(CV, Q=[[1, 0.5], [0, 1]], R=1), WALK)),
]


@pytest.mark.parametrize("ask", REFUSED)
def test_what_is_no_noise_is_refused(ask):
    with pytest.raises(CompensatorError):
        ask()


def test_steps_at_rest():
    """padasip #5: forgetting at rest lets a covariance grow; it is said, and u stays bounded."""
    controller = Controller(
        ControllerSettings(
            structure=iir(2), target=TargetModel([0, 1.0]), update=UD(1.0, lambda_=0.95)
        )
    )
    with pytest.warns(SupervisionWarning, match="windup"):
        for _ in range(3000):
            controller.step(y=0.0, z=0.0)
    assert all(np.abs(controller.step(y=1.0, z=1.0)).max() < 1e3 for _ in range(5))
