"""Sensors that say nothing, entry by entry, and measurements that are angles."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from compensator_theory.errors import FunctionFailedError
from rcac_numeric.estimation import (
    EKF,
    UKF,
    Estimator,
    LinearModel,
    NonlinearModel,
    SymbolicModel,
    estimate,
    observability,
    smooth,
)
from tests.support.estimation_cases import every_filter, linear_case, relative_error

seeds = st.integers(0, 10_000)
# A drawn record may say nothing of a direction: that is not what is tested.
pytestmark = pytest.mark.filterwarnings("ignore::rcac_numeric.estimation.UnobservableWarning")


def with_gaps(seed):
    """A linear case with two sensors, each of which says nothing in a third of the steps."""
    model, Q, R, y, u = linear_case(seed)
    y[np.random.default_rng([seed, 1]).random(y.shape) < 1 / 3] = np.nan
    return model, Q, R, y, u


def kalman_of_what_is_there(model, Q, R, P, y, u):
    """The textbook filter whose C and R have only the rows of what was measured."""
    x, result = np.zeros(model.n), []
    for k in range(len(y)):
        there = np.flatnonzero(~np.isnan(y[k]))
        C, noise = model.C[there], R[np.ix_(there, there)]
        gain = P @ C.T @ np.linalg.inv(C @ P @ C.T + noise)
        x = x + gain @ (y[k, there] - C @ x - model.D[there] @ u[k])
        P = P - gain @ C @ P
        result.append((x, P))
        x, P = model.A @ x + model.B @ u[k], model.A @ P @ model.A.T + Q
    return map(np.array, zip(*result, strict=True))


@every_filter
@given(seed=seeds)
def test_a_sensor_that_says_nothing_is_left_out(make, seed):
    model, Q, R, y, u = with_gaps(seed)
    estimates = estimate(make(model, Q=Q, R=R), y, u, keep_covariances=True)
    x, P = kalman_of_what_is_there(model, Q, R, np.eye(model.n), y, u)
    assert relative_error(estimates.x, x) < 1e-9 and relative_error(estimates.P, P) < 1e-9
    assert np.array_equal(np.isnan(estimates.innovation), np.isnan(y))
    assert np.array_equal(np.isnan(estimates.nis), np.isnan(y).all(axis=1))


@given(seed=seeds)
def test_the_likelihood_is_that_of_what_was_measured(seed):
    model, Q, R, y, u = with_gaps(seed)
    settings = EKF(model, Q=Q, R=R)
    assert estimate(settings, y, u).log_likelihood == pytest.approx(
        smooth(settings, y, u).log_likelihood, rel=1e-9
    )


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
@every_filter
def test_steps_are_those_of_the_record(make):
    model, Q, R, y, u = with_gaps(3)
    settings = make(model, Q=Q, R=R)
    result, estimator = estimate(settings, y, u), Estimator(settings)
    masked = estimate(settings, np.where(np.isnan(y), 7.0, y), u, ~np.isnan(y))
    assert np.array_equal(result.x, masked.x)
    for k in range(len(y)):
        measured = list(y[k]) if k % 2 else y[k]
        assert np.array_equal(estimator.step(measured, u[k]), result.x[k])
        assert np.array_equal(estimator.innovation, result.innovation[k], equal_nan=True)
        assert np.array_equal(estimator.nis, result.nis[k], equal_nan=True)
        other = Estimator(settings)
        other.restore(estimator.state)
        assert np.array_equal(other.P, estimator.P)


def test_consistency_counts_what_was_measured():
    rng = np.random.default_rng(4)
    still = LinearModel(A=np.eye(2) * 0.5, C=np.eye(2))
    y = 1.1 * rng.standard_normal((4000, 2))
    y[::2, 1] = np.nan
    noises = {"Q": 1e-9, "R": 1.21, "P_0": 1e-9}
    whole = estimate(EKF(still, **noises), y).nis_consistency(0.9999)
    assert whole.degrees == 1.5 and whole.verdict == "consistent"
    assert (
        estimate(EKF(still, Q=1e-9, R=1.0, P_0=1e-9), y).nis_consistency().verdict == "optimistic"
    )


def test_what_a_dead_sensor_would_have_shown_is_unobservable():
    apart = LinearModel(A=[[0.5, 0], [0, 0.9]], C=np.eye(2))
    y = np.ones((20, 2))
    assert not estimate(EKF(apart, Q=0.1, R=1), y).observability.unseen
    y[:, 1] = np.nan
    with pytest.warns(UserWarning, match=r"x\[1\]"):
        estimate(EKF(apart, Q=0.1, R=1), y)
    assert not observability(apart, x=np.zeros((5, 2))).unseen


# ---- angles: a heading that turns several times, known by a compass that starts again at pi

TURN = sp.symbols("phi omega", real=True)
MODELS = {
    "linear": LinearModel(A=[[1, 0.3], [0, 1]], C=[[1, 0], [0, 1]], angles=[0]),
    "SymPy": SymbolicModel(
        [TURN[0] + sp.Rational(3, 10) * TURN[1], TURN[1]], TURN, TURN, angles=[0]
    ),
    "Python": NonlinearModel(
        lambda k, x, u: [x[0] + 0.3 * x[1], x[1]], lambda k, x, u: x, n_x=2, l_y=2, angles=[0]
    ),
    "a residual": NonlinearModel(
        lambda k, x, u: [x[0] + 0.3 * x[1], x[1]],
        lambda k, x, u: x,
        n_x=2,
        l_y=2,
        residual=lambda y, expected: [
            np.angle(np.exp(1j * (y[0] - expected[0]))),
            y[1] - expected[1],
        ],
    ),
}


def turning(seed, steps=60):
    """A heading beyond pi, and its measurements with a gyroscope that fails now and then."""
    rng = np.random.default_rng(seed)
    heading = 0.3 * np.cumsum(1 + 0.1 * rng.standard_normal(steps))
    y = np.column_stack([heading + 0.05 * rng.standard_normal(steps), np.full(steps, 1.0)])
    y[rng.random(steps) < 0.3, 1] = np.nan
    return y


@every_filter
@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@given(seed=seeds)
def test_a_whole_turn_changes_nothing(make, model, seed):
    y = turning(seed)
    noises = {"Q": 1e-3, "R": np.diag([0.01, 0.04]), "x_0": [0.3, 1.0], "P_0": 0.1}
    plain = estimate(make(LinearModel(A=[[1, 0.3], [0, 1]], C=np.eye(2)), **noises), y)
    wrapped = y.copy()
    wrapped[:, 0] = np.angle(np.exp(1j * y[:, 0]))  # by NumPy, in (-pi, pi]
    assert abs(wrapped[:, 0] - y[:, 0]).max() > 6
    estimates = estimate(make(model, **noises), wrapped)
    assert np.allclose(estimates.x, plain.x, rtol=0, atol=1e-8)
    assert np.allclose(estimates.innovation, plain.innovation, rtol=0, atol=1e-8, equal_nan=True)
    assert estimates.log_likelihood == pytest.approx(plain.log_likelihood, rel=1e-6)


def test_sigma_points_on_both_sides_of_pi_have_their_mean_between_them():
    """h jumps from pi to -pi among the points: their plain mean points the other way."""
    x, y = sp.symbols("x y", real=True)
    bearing = SymbolicModel([x, y], [sp.atan2(y, x)], [x, y], angles=[0])
    noises = {"Q": 0.0, "R": 1e-4, "x_0": [-1.0, 0.01], "P_0": 0.04}
    estimates = estimate(UKF(bearing, **noises), [-np.pi + 0.01])
    turned = SymbolicModel([x, y], [sp.atan2(-y, -x)], [x, y])  # the same from the other side
    same = estimate(UKF(turned, **noises), [0.01])
    assert np.allclose(estimates.x, same.x, rtol=0, atol=1e-12)
    assert abs(estimates.innovation[0, 0]) < 0.1


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: LinearModel(A=1, C=1, angles=[1]), "angles names measurement 1; there are 1"),
        (lambda: LinearModel(A=1, C=1, angles=0), "angles = 0 must be a list"),
        (lambda: LinearModel(A=1, C=1, angles=["0"]), "angles"),
        (lambda: model_with(residual=3), "residual = 3 is not a function"),
        (lambda: model_with(residual=max, angles=[0]), "give angles or a residual"),
        (lambda: smooth(EKF(MODELS["linear"], 1, 1), np.zeros((3, 2))), "unwrap"),
        (lambda: estimate(EKF(LinearModel(1, 1), 1, 1), [1, np.inf]), "y has the entry inf"),
        (lambda: Estimator(EKF(LinearModel(1, 1), 1, 1)).step(np.inf), "y has the entry inf"),
        (lambda: Estimator(EKF(LinearModel(1, 1), 1, 1)).step([np.nan, 1]), "y has 2 entries"),
        (lambda: estimate(EKF(LinearModel(1, 1), 1, 1), ["a"]), "y must be an array of real"),
        (
            lambda: estimate(EKF(LinearModel(1, 1), 1, 1), [np.nan] * 3).nis_consistency(),
            "no step has a measurement",
        ),
    ],
)
def test_what_is_refused(make, says):
    with pytest.raises(InputError, match=says):
        make()


def model_with(**options):
    return NonlinearModel(lambda k, x, u: x, lambda k, x, u: x, n_x=1, l_y=1, **options)


@pytest.mark.parametrize("answer", [None, [1.0, 2.0], [np.nan], "far"])
def test_a_residual_that_is_none_is_named(answer):
    model = model_with(residual=lambda y, expected: answer)
    with pytest.raises(FunctionFailedError, match=r"residual|string"):
        estimate(EKF(model, 1, 1), [1.0])
