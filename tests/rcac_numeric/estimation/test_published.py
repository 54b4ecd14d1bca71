"""Nonlinear estimation problems with the numbers that were printed for them elsewhere.

- Gustafsson and Hendeby, Some Relations Between Extended and Unscented Kalman Filters, IEEE
  Transactions on Signal Processing 60(2), 2012, pp. 545-555: a Gaussian in polar coordinates
  becomes Cartesian. The rows TT1 (EKF), UT1 and UT2, as the tests of OpenKalman carry them.
- NAG Library, example g13ejc: a robot locates itself from its distance and angle to a wall;
  the program's data and results are printed to three decimals.
"""

import numpy as np
import pytest
import sympy as sp

from rcac_numeric.estimation import (
    EKF,
    UKF,
    NonlinearModel,
    SymbolicModel,
    UnobservableWarning,
    estimate,
)

RANGE, BEARING = sp.symbols("r phi", real=True)
POLAR = SymbolicModel([RANGE * sp.cos(BEARING), RANGE * sp.sin(BEARING)], [RANGE], [RANGE, BEARING])
# alpha, beta and kappa of the papers: alpha**2 (n + kappa) is ours, 3 - alpha**2 our beta
KINDS = {
    "TT1": lambda **k: EKF(POLAR, **k),
    "UT1": lambda **k: UKF(POLAR, alpha=3, **k),  # alpha = 1, beta = 0, kappa = 3 - n
    "UT2": lambda **k: UKF(POLAR, alpha=2e-6, beta=3 - 1e-6, **k),  # 1e-3, 2, 0
}
NEAR, FAR = np.eye(2), np.diag([1.0, 0.1])
PRINTED = [  # r, phi, P, mean, (P_11, P_12, P_22)
    ("TT1", 3, 0, NEAR, (3.0, 0.0), (1.0, 0.0, 9.0)),
    ("TT1", 3, np.pi / 6, NEAR, (2.6, 1.5), (3.0, -3.5, 7.0)),
    ("TT1", 3, np.pi / 4, NEAR, (2.1, 2.1), (5.0, -4.0, 5.0)),
    ("UT1", 3, 0, NEAR, (1.8, 0.0), (3.7, 0.0, 2.9)),
    ("UT1", 3, np.pi / 6, NEAR, (1.6, 0.9), (3.5, 0.3, 3.1)),
    ("UT1", 3, np.pi / 4, NEAR, (1.3, 1.3), (3.3, 0.4, 3.3)),
    ("UT2", 3, 0, NEAR, (1.5, 0.0), (5.5, 0.0, 9.0)),
    ("UT2", 3, np.pi / 6, NEAR, (1.3, 0.8), (6.4, -1.5, 8.1)),
    ("UT2", 3, np.pi / 4, NEAR, (1.1, 1.1), (7.2, -1.7, 7.2)),
    ("TT1", 20, np.pi / 6, FAR, (17.3, 10.0), (10.7, -16.9, 30.3)),
    ("TT1", 20, np.pi / 4, FAR, (14.1, 14.1), (20.5, -19.5, 20.5)),
    ("UT1", 20, np.pi / 6, FAR, (16.5, 9.5), (11.2, -14.4, 27.8)),
    ("UT1", 20, np.pi / 4, FAR, (13.5, 13.5), (19.5, -16.6, 19.5)),
    ("UT2", 20, np.pi / 6, FAR, (16.5, 9.5), (12.3, -16.0, 30.7)),
    ("UT2", 20, np.pi / 4, FAR, (13.4, 13.4), (21.5, -18.5, 21.5)),
]


@pytest.mark.parametrize(("kind", "r", "phi", "P", "mean", "spread"), PRINTED)
def test_a_gaussian_in_polar_coordinates(kind, r, phi, P, mean, spread):
    settings = KINDS[kind](x_0=[r, phi], P_0=P, Q=0, R=1)
    # Nothing is measured at k = 0 and 1: what is believed at k = 1 is the transformed Gaussian.
    with pytest.warns(UnobservableWarning):
        estimates = estimate(settings, [0.0, 0.0], measured=[False, False], keep_covariances=True)
    (a, b), (_, c) = estimates.P[1]
    assert np.allclose(estimates.x[1], mean, rtol=0, atol=0.1)  # printed to one decimal
    assert np.allclose((a, b, c), spread, rtol=0, atol=0.1)


WHEEL, AXLE, WALL, ANGLE = 3.0, 4.0, 5.814, 0.464
TURNED = (0.4, 0.1)  # of the right and left wheel in each step
MEASURED = """
    5.262 5.923  4.347 5.783  3.818 6.181  2.706 0.085  1.878 0.442  0.684 0.836  0.752 1.300
    0.464 1.700  0.597 1.781  0.842 2.040  1.412 2.286  1.527 2.820  2.399 3.147  2.661 3.569
    3.327 3.659"""
RESULTS = """0.664 -0.092 0.104  1.598 0.081 0.314  2.128 0.213 0.378  3.134 0.674 0.660
    3.809 1.181 0.906  4.730 2.000 1.298  4.429 2.474 1.762  4.357 3.246 2.162  3.907 3.852 2.246
    3.360 4.398 2.504  2.552 4.741 2.750  2.191 5.193 3.281  1.309 5.018 3.610  1.071 4.894 4.031
    0.618 4.322 4.124"""
ROOT = [[1.92e-01, 0, 0], [-3.82e-01, 2.22e-02, 0], [1.58e-06, 2.23e-07, 9.95e-03]]


def numbers(text, columns):
    return np.array(text.split(), dtype=float).reshape(-1, columns)


def moved(k, x, u):
    right, left = TURNED
    way = WHEEL / 2 * (right + left)
    turn = WHEEL / AXLE * (right - left)
    return [x[0] + way * np.cos(x[2]), x[1] + way * np.sin(x[2]), x[2] + turn]


def range_and_bearing(k, x, u):
    # As in the published program, the angle of each point is taken modulo 2 pi.
    distance = WALL - x[0] * np.cos(ANGLE) - x[1] * np.sin(ANGLE)
    return [distance, (x[2] - ANGLE) % (2 * np.pi)]


def test_a_robot_locates_itself():
    robot = NonlinearModel(moved, range_and_bearing, n_x=3, l_y=2)
    noises = {"Q": 0.01 * np.eye(3), "R": 1e-4 * np.eye(2)}
    settings = UKF(robot, **noises, x_0=np.zeros(3), P_0=0.01 * np.eye(3), alpha=3, beta=2)
    # The program moves first: nothing is measured at k = 0.
    y = np.vstack([np.zeros(2), numbers(MEASURED, 2)])
    measured = np.ones(len(y), dtype=bool)
    measured[0] = False
    with pytest.warns(UnobservableWarning):  # where along the wall, nothing says
        estimates = estimate(settings, y, measured=measured, keep_covariances=True)
    assert np.abs(estimates.x[1:] - numbers(RESULTS, 3)).max() < 6e-4  # printed to three decimals
    root = np.linalg.cholesky(estimates.P[-1])
    assert np.allclose(root[:, 0], np.array(ROOT)[:, 0], rtol=0.01, atol=1e-6)
    assert np.allclose(np.diag(root), np.diag(ROOT), rtol=0.01)
