"""Plants that jump: the interacting multiple model filter beside a textbook in 50 digits."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory.errors import (
    FunctionFailedError,
    IllConditionedError,
    InputError,
)
from rcac_numeric.estimation import (
    EKF,
    IMM,
    UKF,
    Estimator,
    LinearModel,
    NonlinearModel,
    estimate,
)
from tests.support.estimation_cases import relative_error
from tests.support.textbook_imm import interacting

pytestmark = pytest.mark.filterwarnings("ignore::rcac_numeric.estimation.UnobservableWarning")
seeds = st.integers(0, 10_000)
KINDS = {"extended": EKF, "unscented": UKF}

# The federal funds rate in percent, each quarter from 1954-III to 2010-IV (FRED; usmacro of Stata).
FEDERAL_FUNDS = [
    1.03, 0.99, 1.34, 1.5, 1.94, 2.36, 2.48, 2.69, 2.81, 2.93, 2.93, 3, 3.23, 3.25, 1.86, 0.94,
    1.32, 2.16, 2.57, 3.08, 3.58, 3.99, 3.93, 3.7, 2.94, 2.3, 2, 1.73, 1.68, 2.4, 2.46, 2.61,
    2.85, 2.92, 2.97, 2.96, 3.33, 3.45, 3.46, 3.49, 3.46, 3.58, 3.97, 4.08, 4.07, 4.17, 4.56,
    4.91, 5.41, 5.56, 4.82, 3.99, 3.89, 4.17, 4.79, 5.98, 5.94, 5.92, 6.57, 8.33, 8.98, 8.94,
    8.57, 7.88, 6.7, 5.57, 3.86, 4.56, 5.47, 4.75, 3.54, 4.3, 4.74, 5.14, 6.54, 7.82, 10.56, 10,
    9.32, 11.25, 12.09, 9.35, 6.3, 5.42, 6.16, 5.41, 4.83, 5.2, 5.28, 4.87, 4.66, 5.16, 5.82,
    6.51, 6.76, 7.28, 8.1, 9.58, 10.07, 10.18, 10.95, 13.58, 15.05, 12.69, 9.84, 15.85, 16.57,
    17.78, 17.58, 13.59, 14.23, 14.51, 11.01, 9.29, 8.65, 8.8, 9.46, 9.43, 9.69, 10.56, 11.39,
    9.27, 8.48, 7.92, 7.9, 8.1, 7.83, 6.92, 6.21, 6.27, 6.22, 6.65, 6.84, 6.92, 6.66, 7.16,
    7.98, 8.47, 9.44, 9.73, 9.08, 8.61, 8.25, 8.24, 8.16, 7.74, 6.43, 5.86, 5.64, 4.82, 4.02,
    3.77, 3.26, 3.04, 3.04, 3, 3.06, 2.99, 3.21, 3.94, 4.49, 5.17, 5.81, 6.02, 5.8, 5.72, 5.36,
    5.24, 5.31, 5.28, 5.28, 5.52, 5.53, 5.51, 5.52, 5.5, 5.53, 4.86, 4.73, 4.75, 5.09, 5.31,
    5.68, 6.27, 6.52, 6.47, 5.59, 4.33, 3.5, 2.13, 1.73, 1.75, 1.74, 1.44, 1.25, 1.25, 1.02, 1,
    1, 1.01, 1.43, 1.95, 2.47, 2.94, 3.46, 3.98, 4.46, 4.91, 5.25, 5.25, 5.26, 5.25, 5.07, 4.5,
    3.18, 2.09, 1.94, 0.51, 0.18, 0.18, 0.16, 0.12, 0.13, 0.19, 0.19, 0.19,
]  # fmt: skip


def jumping(seed, modes=3, steps=25, gaps=0.2):
    """Modes of a random plant, their Markov chain, and a record that one path of it made."""
    rng = np.random.default_rng(seed)
    n, l_u, l_y = 2, 1, 2
    B, D = rng.standard_normal((n, l_u)), rng.standard_normal((l_y, l_u))
    parts = []
    for _ in range(modes):
        A = rng.standard_normal((n, n))
        A *= 0.9 / max(abs(np.linalg.eigvals(A)))
        q, r = rng.standard_normal((n, n)) / 2, np.eye(l_y) + rng.random((l_y, l_y)) / 3
        C, x_0 = rng.standard_normal((l_y, n)), rng.standard_normal(n)
        parts.append((A, B, C, D, q @ q.T, r @ r.T, x_0, np.diag(0.5 + rng.random(n))))
    transitions = rng.dirichlet(np.ones(modes), size=modes)
    mode, x = 0, rng.standard_normal(n)
    y, u = np.zeros((steps, l_y)), rng.standard_normal((steps, l_u))
    for k in range(steps):
        A, _, C, _, Q, R, _, _ = parts[mode]
        y[k] = C @ x + D @ u[k] + np.linalg.cholesky(R) @ rng.standard_normal(l_y)
        x = A @ x + B @ u[k] + np.linalg.cholesky(Q) @ rng.standard_normal(n)
        mode = rng.choice(modes, p=transitions[mode])
    y[rng.random(y.shape) < gaps] = np.nan
    return parts, transitions, rng.dirichlet(np.ones(modes)), y, u


def settings_of(parts, transitions, mu, kind=EKF):
    filters = [
        kind(LinearModel(A=A, B=B, C=C, D=D), Q=(Q + Q.T) / 2, R=(R + R.T) / 2, x_0=x_0, P_0=P_0)
        for A, B, C, D, Q, R, x_0, P_0 in parts
    ]
    return IMM(filters, transitions, mu)


@pytest.mark.costly
@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
@given(seed=seeds)
def test_it_is_the_textbook_in_50_digits(kind, seed):
    parts, transitions, mu, y, u = jumping(seed, steps=12)
    estimates = estimate(settings_of(parts, transitions, mu, kind), y, u, keep_covariances=True)
    x, P, probabilities, likelihood = interacting(parts, transitions, mu, y, u)
    # Innovations of 10 deviations would multiply a rounding of S by 100: 1e-10 leaves room.
    assert relative_error(estimates.x, x) < 1e-10 and relative_error(estimates.P, P) < 1e-10
    assert np.abs(estimates.probabilities - probabilities).max() < 1e-10
    assert estimates.log_likelihood == pytest.approx(likelihood, rel=1e-11, abs=1e-10)
    assert np.allclose(estimates.deviation**2, np.diagonal(P, axis1=1, axis2=2), rtol=1e-9)
    assert np.array_equal(np.isnan(estimates.innovation), np.isnan(y))
    assert np.array_equal(np.isnan(estimates.nis), np.isnan(y).all(axis=1))


@given(seed=seeds)
def test_filterpys_estimator_says_the_same(seed):
    pytest.importorskip("filterpy", reason="filterpy is an optional oracle: pip install filterpy")
    from filterpy.kalman import IMMEstimator, KalmanFilter

    parts, transitions, mu, y, u = jumping(seed, gaps=0.0)
    others = []
    for A, B, C, _, Q, R, x_0, P_0 in parts:
        other = KalmanFilter(dim_x=2, dim_z=2, dim_u=1)
        other.F, other.B, other.H, other.Q, other.R, other.x, other.P = A, B, C, Q, R, x_0, P_0
        others.append(other)
    oracle = IMMEstimator(others, mu, transitions)
    parts = [(*one[:3], 0 * one[3], *one[4:]) for one in parts]  # filterpy has no D
    # filterpy moves the probabilities before the first measurement as well.
    estimates = estimate(
        settings_of(parts, transitions, mu @ transitions), y, u, keep_covariances=True
    )
    for k in range(len(y)):
        oracle.update(y[k])
        # Where a likelihood underflows, filterpy puts the smallest float64 in its place.
        assume(min(one.likelihood for one in oracle.filters) > 1e-290)
        assert oracle.x == pytest.approx(estimates.x[k], rel=1e-9, abs=1e-10)
        assert pytest.approx(estimates.P[k], rel=1e-8, abs=1e-10) == oracle.P
        assert oracle.mu == pytest.approx(estimates.probabilities[k], rel=1e-7, abs=1e-12)
        oracle.predict(u[k])


def test_the_federal_funds_rate():
    """A mean that switches: Stata 14, [TS] mswitch, example 1, prints log likelihood -508.63592.

    With p_11 = .9820939, p_21 = .0503587, means 3.70877 and 9.556793 and sigma = 2.107562. Nothing
    is unknown but the mode, so that the filter is Hamilton's and approximates nothing.
    """
    filters = [
        EKF(LinearModel(A=1, C=mean), Q=0, R=2.107562**2, x_0=[1], P_0=0)
        for mean in (3.70877, 9.556793)
    ]
    stay, back = 0.9820939, 0.0503587
    stationary = np.array([back, 1 - stay]) / (1 - stay + back)
    jumps = IMM(filters, [[stay, 1 - stay], [back, 1 - back]], stationary)
    estimates = estimate(jumps, FEDERAL_FUNDS)
    assert estimates.log_likelihood == pytest.approx(-508.63592, abs=1e-5)
    quarters = 1954.5 + np.arange(len(FEDERAL_FUNDS)) / 4
    high = quarters[estimates.most_probable == 1]
    assert 1979 < np.median(high) < 1985  # Volcker's disinflation


@given(seed=seeds)
def test_modes_that_never_change_are_a_mixture_of_filters(seed):
    """With Pi = I the answer is exact: each filter alone, weighed by its likelihood."""
    parts, _, mu, y, u = jumping(seed)
    estimates = estimate(settings_of(parts, np.eye(3), mu), y, u)
    alone = [estimate(one, y, u) for one in estimates.settings.filters]
    joint = np.log(mu) + [one.log_likelihood for one in alone]
    assert estimates.log_likelihood == pytest.approx(np.logaddexp.reduce(joint), rel=1e-11)
    weights = np.exp(joint - np.logaddexp.reduce(joint))
    assert estimates.probabilities[-1] == pytest.approx(weights, abs=1e-9)
    x = np.tensordot(weights, [one.x[-1] for one in alone], axes=1)
    assert estimates.x[-1] == pytest.approx(x, rel=1e-8, abs=1e-9)


def test_a_mode_that_was_ruled_out_by_thousands_of_nats_comes_back():
    """Without logarithms the probability of the right mode is 0 after five steps, for ever."""
    level = LinearModel(A=1, C=1)
    low, high = (EKF(level, Q=0, R=1e-4, x_0=[x], P_0=0) for x in (0.0, 1.0))
    y = np.repeat([0.0, 1.0], [40, 60])
    estimates = estimate(IMM([low, high], np.eye(2)), y)
    assert estimates.probabilities[39, 1] == 0.0 and estimates.probabilities[-1, 1] == 1.0
    # 40 steps for 0, then 60 for 1, at 1/(2 R) = 5000 nats each
    assert estimates.log_likelihood == pytest.approx(
        np.log(0.5) - 50 * np.log(2 * np.pi * 1e-4) - 40 * 5000
    )


def test_a_single_mode_is_its_filter():
    parts, _, _, y, u = jumping(3)
    one = settings_of(parts[:1], [[1.0]], [1.0])
    result, alone = estimate(one, y, u), estimate(one.filters[0], y, u)
    assert result.x == pytest.approx(alone.x, rel=1e-12)
    assert result.nis == pytest.approx(alone.nis, rel=1e-11, nan_ok=True)
    assert result.innovation == pytest.approx(alone.innovation, rel=1e-11, nan_ok=True)
    assert result.log_likelihood == pytest.approx(alone.log_likelihood, rel=1e-12)


def test_the_normalised_innovation_has_the_mean_of_a_chi_square(in_full):
    """Its mean is l_y for the covariance of the mixture, whatever its distribution.

    One step from a known mixture, where the IMM is exact, drawn N times: the mean of the squares s
    scatters by std(s)/sqrt(N), and five of these are exceeded in 6 of 10^7 draws.
    """
    draws = 200_000 if in_full else 2000
    rng = np.random.default_rng(8)
    mu, R = np.array([0.7, 0.3]), np.array([0.5, 4.0])
    x, P = np.array([-1.0, 2.0]), np.array([1.0, 0.3])
    filters = [EKF(LinearModel(A=1, C=1), Q=0, R=R[j], x_0=[x[j]], P_0=P[j]) for j in range(2)]
    jumps = IMM(filters, np.eye(2), mu)
    modes = rng.choice(2, p=mu, size=draws)
    y = x[modes] + np.sqrt(P[modes] + R[modes]) * rng.standard_normal(draws)
    squares = np.array([estimate(jumps, [value]).nis[0] for value in y])
    assert abs(squares.mean() - 1) < 5 * squares.std() / np.sqrt(draws)


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
@given(seed=seeds)
def test_steps_are_those_of_the_record_and_go_on_from_a_saved_state(seed):
    parts, transitions, mu, y, u = jumping(seed)
    settings = settings_of(parts, transitions, mu)
    result, estimator = estimate(settings, y, u), Estimator(settings)
    for k in range(len(y)):
        estimator.correct(y[k], u[k])
        assert np.array_equal(estimator.probabilities, result.probabilities[k])
        assert np.array_equal(estimator.x, result.x[k])
        assert np.array_equal(estimator.innovation, result.innovation[k], equal_nan=True)
        assert np.array_equal(estimator.nis, result.nis[k], equal_nan=True)
        other = Estimator(settings)
        other.restore(estimator.state)
        estimator = other
        estimator.predict(u[k])
    again = Estimator(settings)
    for k in range(len(y)):
        assert np.array_equal(again.step(y[k], u[k]), result.x[k])


def test_probabilities_are_those_of_the_step_of_x():
    parts, transitions, mu, y, u = jumping(5)
    estimator = Estimator(settings_of(parts, transitions, mu))
    assert estimator.probabilities == pytest.approx(mu)
    estimator.correct(y[0], u[0])
    place = estimator.probabilities
    estimator.predict(u[0])
    assert estimator.probabilities == pytest.approx(place @ transitions)
    assert Estimator(settings_of(parts, transitions, mu).filters[0]).probabilities.shape == (0,)


def moved(fails):
    def dynamics(k, x, u):
        return x if k < fails else x * np.nan

    return NonlinearModel(dynamics, lambda k, x, u: x, n_x=1, l_y=1)


def test_a_mode_that_fails_is_named_and_nothing_has_moved():
    filters = [EKF(LinearModel(A=1, C=1), Q=1, R=1), EKF(moved(fails=5), Q=1, R=1)]
    jumps = IMM(filters, [[0.9, 0.1], [0.1, 0.9]])
    estimator = Estimator(jumps)
    y = np.random.default_rng(1).standard_normal(10)
    for k in range(5):
        estimator.step(y[k])
    before = estimator.state
    with pytest.raises(FunctionFailedError, match=r"step 5: in mode 1, f\(k, x, u\) .* nan"):
        estimator.step(y[5])
    assert np.array_equal(estimator.state.values, before.values) and estimator.k == 5
    with pytest.raises(FunctionFailedError) as caught:
        estimate(jumps, y)
    assert np.array_equal(caught.value.run.x, estimate(jumps, y[:5]).x)

    twice = LinearModel(A=1, C=[[1], [1]])
    jumps = IMM([EKF(twice, Q=1, R=1), EKF(twice, Q=1, R=0)], np.eye(2))
    estimator = Estimator(jumps)
    before = estimator.state
    with pytest.raises(IllConditionedError, match="in mode 1, the covariance of the innovation"):
        estimator.step([1, 1])
    assert np.array_equal(estimator.state.values, before.values)


def test_its_picture_shows_every_state_and_every_probability():
    parts, transitions, mu, y, u = jumping(1)
    estimates = estimate(settings_of(parts, transitions, mu), y, u)
    *states, modes = estimates.plot().axes
    assert [axis.get_ylabel() for axis in states] == ["x[0]", "x[1]"]
    for i, axis in enumerate(states):
        assert np.array_equal(axis.get_lines()[0].get_ydata(), estimates.x[:, i])
        band = axis.collections[0].get_paths()[0].vertices[:, 1]
        assert band.max() == pytest.approx((estimates.x + 2 * estimates.deviation)[:, i].max())
    shown = [line.get_ydata() for line in modes.get_lines()]
    assert np.array_equal(np.transpose(shown), estimates.probabilities)


ONE, TWO = EKF(LinearModel(A=1, C=1), 1, 1), EKF(LinearModel(A=np.eye(2), C=[[1, 0]]), 1, 1)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: IMM([], np.eye(0)), "filters is empty"),
        (lambda: IMM(ONE, 1), "must be a list"),
        (lambda: IMM([ONE, "EKF"], np.eye(2)), "an entry of filters = 'EKF' is not a EKF or UKF"),
        (lambda: IMM([ONE, TWO], np.eye(2)), r"filter 1 has \(n, l_u, l_y\) = \(2, 0, 1\)"),
        (lambda: IMM([EKF(ONE.model, 1, 1, form="joseph")], 1), "filter 0 has the form 'joseph'"),
        (lambda: IMM([ONE, ONE], np.eye(3)), "transitions has shape"),
        (lambda: IMM([ONE, ONE], [[0.9, 0.1], [0.9, 0.9]]), "row 1 of transitions = .* add up to"),
        (lambda: IMM([ONE, ONE], [[1.1, -0.1], [0, 1]]), "row 0 of transitions"),
        (lambda: IMM([ONE, ONE], np.eye(2), [0.5, 0.6]), "probabilities = .* no distribution"),
        (lambda: IMM([ONE, ONE], np.eye(2), [1]), "probabilities has 1 entries"),
        (lambda: IMM([ONE, ONE], [[np.nan, 1], [0, 1]]), "transitions has the entry nan"),
        (lambda: estimate(IMM([ONE], 1), [1, 2], Q=[1, 1]), "a IMM has its own"),
        (lambda: Estimator(IMM([ONE], 1)).step(1, R=2), "a IMM has its own"),
        (lambda: Estimator(IMM([ONE], 1)).step(np.inf), "y has the entry inf"),
        (lambda: Estimator(IMM([ONE], 1)).Q, "each mode of an IMM"),
        (lambda: estimate(IMM([ONE], 1), [[1, 2]]), "y has shape"),
    ],
)
def test_what_is_wrong_is_named(make, says):
    with pytest.raises(InputError, match=says):
        make()


def test_a_target_that_turns_is_followed_better_than_by_either_filter_alone():
    """Drawn from the chain itself: 32 of 40 independent runs are 9 in 10^5 for a fair coin."""
    model, runs, steps = LinearModel(A=[[1, 1], [0, 1]], C=[[1, 0]]), 40, 200
    shape = np.array([[1 / 4, 1 / 2], [1 / 2, 1]])
    chain = np.array([[0.98, 0.02], [0.1, 0.9]])
    single = [EKF(model, Q=q * shape, R=100.0, P_0=100.0) for q in (1e-4, 25.0)]
    jumps, rng = IMM(single, chain), np.random.default_rng(2)
    better = np.zeros((2, runs), dtype=bool)
    for run in range(runs):
        mode, x = rng.integers(2), 10 * rng.standard_normal(2)
        states, y = np.zeros((steps, 2)), np.zeros(steps)
        for k in range(steps):
            states[k], y[k] = x, x[0] + 10 * rng.standard_normal()
            mode = rng.choice(2, p=chain[mode])
            push = np.sqrt((1e-4, 25.0)[mode]) * rng.standard_normal()
            x = model.A @ x + np.array([0.5, 1.0]) * push
        errors = [((estimate(one, y).x - states) ** 2)[:, 1].mean() for one in (jumps, *single)]
        better[:, run] = errors[0] < np.array(errors[1:])
    assert (better.sum(axis=1) >= 32).all()
