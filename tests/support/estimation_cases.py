"""Models and records for the tests of the estimators."""

import numpy as np
import pytest
import sympy

from rcac_numeric.estimation import EKF, UKF, LinearModel, NonlinearModel, SymbolicModel

FILTERS = {
    "extended": EKF,
    "joseph": lambda *a, **k: EKF(*a, form="joseph", **k),
    "unscented": UKF,
    "negative weight": lambda *a, **k: UKF(*a, alpha=1.7, **k),
}
every_filter = pytest.mark.parametrize("make", FILTERS.values(), ids=FILTERS)


def linear_case(seed, n=3, l_u=2, l_y=2, steps=40):
    """A stable observable model, its record, and the noises it was made with."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A *= 0.95 / max(abs(np.linalg.eigvals(A)))
    B, C = rng.standard_normal((n, l_u)), rng.standard_normal((l_y, n))
    D = rng.standard_normal((l_y, l_u))
    root_Q, root_R = rng.standard_normal((n, n)) / 3, np.eye(l_y) + rng.random((l_y, l_y)) / 3
    u, x, y = rng.standard_normal((steps, l_u)), rng.standard_normal(n), []
    for k in range(steps):
        y.append(C @ x + D @ u[k] + root_R @ rng.standard_normal(l_y))
        x = A @ x + B @ u[k] + root_Q @ rng.standard_normal(n)
    Q, R = root_Q @ root_Q.T, root_R @ root_R.T
    return LinearModel(A=A, B=B, C=C, D=D), symmetric(Q), symmetric(R), np.array(y), u


def relative_error(estimate, truth):
    """The largest error as a share of the largest entry."""
    return abs(estimate - truth).max() / abs(truth).max()


def symmetric(matrix):
    return (matrix + matrix.T) / 2


h = 0.05
TH, OM, DAMPING, U, STEP = sympy.symbols("theta omega c u k")
PENDULUM = SymbolicModel(
    dynamics=[TH + h * OM, OM + h * (U - DAMPING * OM - 9.81 * sympy.sin(TH))],
    output=[sympy.sin(TH), sympy.sqrt(1 + OM**2) / (2 + sympy.cos(TH))],
    states=[TH, OM],
    inputs=[U],
    parameters=[DAMPING],
    step=STEP,
)


def dynamics(k, x, u, p):
    return np.array([x[0] + h * x[1], x[1] + h * (u[0] - p[0] * x[1] - 9.81 * np.sin(x[0]))])


def output(k, x, u, p):
    return np.array([np.sin(x[0]), np.sqrt(1 + x[1] ** 2) / (2 + np.cos(x[0]))])


PYTHON_PENDULUM = NonlinearModel(dynamics, output, n_x=2, l_y=2, l_u=1, l_p=1)


def pendulum_record(seed, steps=200, c=0.4):
    """y and u of the pendulum with noise of deviation 0.01."""
    rng = np.random.default_rng(seed)
    x, y, u = np.array([0.5, 0.0]), [], 2 * rng.standard_normal((steps, 1))
    for k in range(steps):
        y.append(output(k, x, u[k], [c]) + 0.01 * rng.standard_normal(2))
        x = dynamics(k, x, u[k], [c])
    return np.array(y), u
