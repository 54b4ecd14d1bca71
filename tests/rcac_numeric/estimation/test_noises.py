"""Covariances learned from measurements: likelihoods in 50 digits, information, true values."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import IllConditionedError, InputError
from rcac_numeric.compiled._estimators import learn_noises
from rcac_numeric.estimation import (
    EKF,
    IMM,
    UKF,
    AdaptiveNoises,
    Estimator,
    LinearModel,
    UnidentifiableWarning,
    estimate,
    fit_noises,
    noise_information,
)
from rcac_numeric.estimation._compiled import compiled_model
from rcac_numeric.estimation._settings import square_root
from tests.support.estimation_cases import (
    PENDULUM,
    linear_case,
    pendulum_record,
    relative_error,
    symmetric,
)
from tests.support.nile import NILE

pytestmark = pytest.mark.filterwarnings("ignore::rcac_numeric.estimation.UnobservableWarning")
seeds = st.integers(0, 10_000)


def gappy(seed, steps, n=2):
    model, Q, R, y, u = linear_case(seed, n=n, steps=steps)
    y[np.random.default_rng([seed, 1]).random(y.shape) < 0.25] = np.nan
    y[0] = 1.0  # something is measured
    return EKF(model, Q=Q, R=R, P_0=2.0), y, u


def learned(settings, Q_root, R_root, y, u, learn=(True, True), diagonal=False):
    """One iteration on roots."""
    begins = compiled_model(settings.model), settings.x_0, square_root(settings.P_0)
    return learn_noises(*begins, Q_root, R_root, u, y, *learn, diagonal)


def log_likelihood(settings, Q, R, y, u):
    """The textbook filter on covariances, in the digits of mpmath."""
    model = settings.model
    A, B, C, D = (mp.matrix(part.tolist()) for part in (model.A, model.B, model.C, model.D))
    x, P = mp.matrix(settings.x_0.tolist()), mp.matrix(settings.P_0.tolist())
    total = mp.mpf(0)
    for k in range(len(y)):
        v, there = mp.matrix(u[k].tolist()), [int(i) for i in np.flatnonzero(~np.isnan(y[k]))]
        if there:
            rows = mp.matrix([[C[i, j] for j in range(C.cols)] for i in there])
            noise = mp.matrix([[R[i, j] for j in there] for i in there])
            e = mp.matrix([y[k][i] - (D * v)[i] for i in there]) - rows * x
            S = rows * P * rows.T + noise
            gain = P * rows.T * S**-1
            total -= ((e.T * S**-1 * e)[0] + mp.log(mp.det(2 * mp.pi * S))) / 2
            x, P = x + gain * e, P - gain * S * gain.T
        x, P = A * x + B * v, A * P * A.T + Q
    return total


def gradient(function, covariance):
    """Of a function of a symmetric matrix, by differences in 50 digits."""
    step, n = mp.mpf(10) ** -20, covariance.rows
    zeros_of_plant = np.zeros((n, n))
    for i in range(n):
        for j in range(i + 1):
            ends = []
            for sign in (1, -1):
                moved = covariance.copy()
                moved[i, j] += sign * step / (1 if i == j else 2)
                if i != j:
                    moved[j, i] += sign * step / 2
                ends.append(function(moved))
            zeros_of_plant[i, j] = zeros_of_plant[j, i] = float((ends[0] - ends[1]) / (2 * step))
    return zeros_of_plant


@pytest.mark.costly
@given(seed=seeds)
def test_an_iteration_follows_the_gradient_of_the_likelihood(seed):
    """Q + 2/(N - 1) Q (dL/dQ) Q and R + 2/M R (dL/dR) R for M steps with a measurement: Fisher's
    identity for the complete data, whose transitions are N - 1.
    """
    settings, y, u = gappy(seed, steps=7)
    roots = square_root(settings.Q), square_root(settings.R)
    Q_new, R_new, likelihood = learned(settings, *roots, y, u)
    with mp.workdps(50):
        # Of the roots that the kernel was given: those of settings are rounded once more.
        Q, R = (mp.matrix(root.tolist()) * mp.matrix(root.tolist()).T for root in roots)
        assert likelihood == pytest.approx(float(log_likelihood(settings, Q, R, y, u)), rel=1e-12)
        d_Q = gradient(lambda other: log_likelihood(settings, other, R, y, u), Q)
        d_R = gradient(lambda other: log_likelihood(settings, Q, other, y, u), R)
    measured = int((~np.isnan(y)).any(axis=1).sum())
    expected = settings.Q + 2 / (len(y) - 1) * settings.Q @ d_Q @ settings.Q
    assert relative_error(Q_new @ Q_new.T, expected) < 1e-9
    expected = settings.R + 2 / measured * settings.R @ d_R @ settings.R
    assert relative_error(R_new @ R_new.T, expected) < 1e-9


@given(seed=seeds, diagonal=st.booleans(), which=st.sampled_from([(1, 1), (1, 0), (0, 1)]))
def test_no_iteration_makes_the_record_less_likely(seed, diagonal, which):
    settings, y, u = gappy(seed, steps=30, n=3)
    G = np.random.default_rng(seed).standard_normal((3, 2))  # two channels of noise
    Q = symmetric(np.diag([1.0, 0, 2.0]) if diagonal else G @ G.T)
    settings = EKF(settings.model, Q=Q, R=np.eye(2) if diagonal else settings.R)
    roots, before = (square_root(settings.Q), square_root(settings.R)), -np.inf
    begun = [root.copy() for root in roots]
    for _ in range(10):
        *roots, likelihood = learned(settings, *roots, y, u, tuple(map(bool, which)), diagonal)
        assert likelihood >= before - 1e-9 * abs(likelihood)
        before = likelihood
    Q_new, R_new = (root @ root.T for root in roots)
    for new, root, learns in zip((Q_new, R_new), begun, which, strict=True):
        assert np.linalg.eigvalsh(new).min() > -1e-14 * np.trace(new)
        assert learns or np.array_equal(new, root @ root.T)
        assert not diagonal or np.array_equal(new, np.diag(np.diag(new)))
    # What Q did not reach at first it does not reach now.
    null = np.linalg.svd(settings.Q)[0][:, 2]
    assert np.abs(null @ Q_new).max() < 1e-12 * np.trace(Q_new)


@pytest.mark.parametrize("A", [[[0.0, 1], [0, 0]], [[1.0, 1], [0, 1]], [[2.0, 0], [0, 0.5]]])
def test_states_known_exactly_and_noises_of_lower_rank(A):
    """P_0 = 0 and one channel: [A S, Q^1/2] has no full rank in the first steps."""
    model = LinearModel(A=A, C=[[1, 0.5]], B=[[0], [0]])
    settings = EKF(model, Q=[[0, 0], [0, 1.0]], R=0.5, P_0=0)
    rng = np.random.default_rng(4)
    y, u = rng.standard_normal((6, 1)), np.zeros((6, 1))
    roots = square_root(settings.Q), square_root(settings.R)
    Q_new, R_new, _ = learned(settings, *roots, y, u)
    with mp.workdps(50):
        Q, R = mp.matrix(settings.Q.tolist()), mp.matrix(settings.R.tolist())
        d_Q = gradient(lambda other: log_likelihood(settings, other, R, y, u), Q)
        d_R = gradient(lambda other: log_likelihood(settings, Q, other, y, u), R)
    assert Q_new @ Q_new.T == pytest.approx(
        settings.Q + 2 / 5 * settings.Q @ d_Q @ settings.Q, rel=1e-9, abs=1e-12
    )
    assert R_new @ R_new.T == pytest.approx(settings.R + 2 / 6 * settings.R @ d_R @ settings.R)


def test_the_variances_of_the_nile():
    """Durbin and Koopman 2012, 2.10.3: 15099 and 1469.1; KFAS: 15098.53 and 1469.18 at -641.5856.

    Their initial state is diffuse, ours has P_0 = 1e7, and the likelihood is flat: the deviations
    of the two are 3100 and 1300.
    """
    level = EKF(LinearModel(A=1, C=1), Q=100.0, R=1000.0, P_0=1e7)
    noises = fit_noises(level, NILE)
    assert noises.converged and noises.log_likelihood == pytest.approx(-641.5856, abs=5e-5)
    assert noises.R[0, 0] == pytest.approx(15099, abs=2)
    assert noises.Q[0, 0] == pytest.approx(1469.1, abs=2)
    printed = EKF(level.model, Q=1469.18, R=15098.53, P_0=1e7)
    assert noises.log_likelihood >= estimate(printed, NILE).log_likelihood
    assert noises.log_likelihood - noises.improvement == pytest.approx(
        estimate(level, NILE).log_likelihood, rel=1e-12
    )
    with mp.workdps(40):  # at the maximum the gradient vanishes, on the scale of the variances
        y, u = np.array(NILE, dtype=float)[:, None], np.zeros((100, 1))
        settings = EKF(LinearModel(A=1, C=1, B=0), Q=1, R=1, P_0=1e7)
        Q, R = mp.matrix(noises.Q.tolist()), mp.matrix(noises.R.tolist())
        d_Q = gradient(lambda other: log_likelihood(settings, other, R, y, u), Q)
        d_R = gradient(lambda other: log_likelihood(settings, Q, other, y, u), R)
    assert abs(d_Q * noises.Q).max() < 1e-5 and abs(d_R * noises.R).max() < 1e-5


def exact_information(settings, changes, steps):
    """tr(S^-1 S_i S^-1 S_j) / 2 of the covariance S of all of a record."""
    A, C = settings.model.A, settings.model.C
    n, p = settings.model.n, settings.model.l_y

    def joint(P_0, Q, R):
        S, blocks = P_0, np.zeros((steps, p, steps, p))
        for i in range(steps):
            forward = S
            for j in range(i, steps):
                blocks[j, :, i] = C @ forward @ C.T + (R if i == j else 0)
                blocks[i, :, j] = blocks[j, :, i].T
                forward = A @ forward
            S = A @ S @ A.T + Q
        return blocks.reshape(steps * p, steps * p)

    inverse = np.linalg.inv(joint(settings.P_0, settings.Q, settings.R))
    moved = [inverse @ joint(np.zeros((n, n)), dQ, dR) for dQ, dR in changes]
    return np.array([[np.trace(a @ b) / 2 for b in moved] for a in moved])


@pytest.mark.costly
@pytest.mark.parametrize("A", [[[0.7, 0.3], [0, -0.4]], [[1.0, 0.5], [0, 0.9]]])
def test_the_information_is_that_of_a_step_of_a_long_record(A):
    """Exact information of 81 steps less that of 80: what is left of the start decays as A does."""
    settings = EKF(LinearModel(A=A, C=np.eye(2)), Q=[[1, 0.2], [0.2, 0.5]], R=np.diag([0.5, 2]))
    unit = np.eye(2)
    pairs = [(0, 0), (0, 1), (1, 1)]
    basis = [np.outer(unit[i], unit[j]) + (i != j) * np.outer(unit[j], unit[i]) for i, j in pairs]
    zero = np.zeros((2, 2))
    changes = [(b, zero) for b in basis] + [(zero, b) for b in basis]
    one = exact_information(settings, changes, 81) - exact_information(settings, changes, 80)
    deviations = np.sqrt(np.diag(np.linalg.inv(one)))
    information = noise_information(settings, 400)
    assert not information.unidentified
    result = [information.Q_deviation[i, j] for i, j in pairs] + [
        information.R_deviation[i, j] for i, j in pairs
    ]
    assert np.array(result) * 20 == pytest.approx(deviations, rel=1e-5)
    known = noise_information(settings, 400, learn=["R"])
    assert not known.Q_deviation.any() and (known.R_deviation < information.R_deviation).all()


@given(seed=seeds)
def test_what_cannot_be_told_leaves_the_spectrum_as_it_is(seed):
    """Of Q with one measurement n of n (n + 1)/2 combinations can be told (Mehra 1970)."""
    rng, n = np.random.default_rng(seed), 3
    A = rng.standard_normal((n, n))
    model = LinearModel(A=0.9 * A / max(abs(np.linalg.eigvals(A))), C=rng.standard_normal((1, n)))
    q = rng.standard_normal((n, n))
    information = noise_information(EKF(model, Q=symmetric(q @ q.T) + np.eye(n), R=1.0), 100)
    assert len(information.unidentified) == n * (n + 1) // 2 - n
    for dQ, dR in information.unidentified:
        assert max(abs(dQ).max(), abs(dR).max()) == pytest.approx(1)
        for z in np.exp(1j * rng.uniform(0, np.pi, 5)):
            G = np.linalg.solve((z * np.eye(n) - model.A).T, model.C.T).T
            size = np.abs(G).max() ** 2
            assert abs(G @ dQ @ G.conj().T + dR).max() < 1e-6 * size
    assert "no record identifies a change of Q[0,0]" in str(information)


def test_a_track_tells_one_combination_less_and_its_diagonal_whole():
    """G dQ G* = 0 for dQ = [[1, 1/T], ...]: position noise is told but for its part along that."""
    track = EKF(LinearModel(A=[[1, 1], [0, 1]], C=[[1, 0]]), Q=0.1, R=1.0)
    with pytest.warns(UnidentifiableWarning, match="Learn a diagonal"):
        noises = fit_noises(track, np.random.default_rng(1).standard_normal(200))
    message = noises.information
    ((dQ, dR),) = message.unidentified
    assert dQ == pytest.approx(dQ[0, 1] * np.array([[1, 1], [1, 0]]), abs=1e-9)
    assert dR == pytest.approx(0, abs=1e-9)
    assert np.isinf(message.Q_deviation).tolist() == [[True, True], [True, False]]
    assert np.isfinite(message.R_deviation).all()
    alone = noise_information(track, 200, diagonal=True)
    assert not alone.unidentified and np.isfinite(np.diag(alone.Q_deviation)).all()
    with pytest.warns(UnidentifiableWarning):
        estimate(AdaptiveNoises(track, window=50), np.ones(120))


def record_of(settings, steps, rng, R=None):
    """Of the model and the noises of the settings, or of R(k)."""
    model, q = settings.model, square_root(settings.Q)
    x, y = rng.standard_normal(model.n), np.zeros((steps, model.l_y))
    for k in range(steps):
        r = square_root(settings.R if R is None else R[k])
        y[k] = model.C @ x + r @ rng.standard_normal(model.l_y)
        x = model.A @ x + q @ rng.standard_normal(model.n)
    return y


TRUTH = EKF(
    LinearModel(A=[[0.9, 0.4], [-0.2, 0.7]], C=np.eye(2)),
    Q=[[1.0, 0.3], [0.3, 0.5]], R=np.diag([2.0, 0.5]),
)  # fmt: skip


@pytest.mark.costly
def test_the_true_covariances_are_found(in_full):
    """Maximum likelihood is asymptotically normal with the inverse of the information.

    Each entry lies within 5 deviations, which one of 1.7 million does not; the mean square over
    runs and the six entries is 1 with a deviation of at most sqrt(2/runs), were all six the same.
    """
    runs, steps = (100, 5000) if in_full else (8, 2000)
    scores = []
    for run in range(runs):
        rng = np.random.default_rng([7, run])
        begun = EKF(TRUTH.model, Q=0.1, R=5.0)
        noises = fit_noises(begun, record_of(TRUTH, steps, rng))
        information = noise_information(TRUTH, steps)
        assert noises.converged
        upper = np.triu_indices(2)
        scores.append(
            np.r_[
                ((noises.Q - TRUTH.Q) / information.Q_deviation)[upper],
                ((noises.R - TRUTH.R) / information.R_deviation)[upper],
            ]
        )
    assert np.abs(scores).max() < 5
    assert abs(np.mean(np.square(scores)) - 1) < 4 * np.sqrt(2 / runs)


def test_a_diagonal_is_found_where_the_whole_cannot_be(in_full):
    track = LinearModel(A=[[1, 1], [0, 1]], C=[[1, 0]])
    truth = EKF(track, Q=np.diag([0.5, 0.1]), R=4.0)
    steps = 40_000 if in_full else 4000
    y = record_of(truth, steps, np.random.default_rng(3))
    noises = fit_noises(EKF(track, Q=1.0, R=1.0), y, diagonal=True)
    information = noise_information(truth, steps, diagonal=True)
    assert (np.abs(noises.Q - truth.Q) < 5 * information.Q_deviation + 1e-300).all()
    assert abs(noises.R - truth.R) < 5 * information.R_deviation


def test_a_variance_that_is_not_there_goes_to_zero_and_it_ends():
    y = 2 * np.random.default_rng(5).standard_normal(400)
    still = EKF(LinearModel(A=1, C=1), Q=1.0, R=1.0, P_0=1e-6)
    noises = fit_noises(still, y - y.mean())
    assert noises.converged and noises.Q[0, 0] < 1e-4
    assert noises.R[0, 0] == pytest.approx(np.var(y), rel=1e-3)


def test_few_passes_are_said_not_to_be_enough():
    noises = fit_noises(EKF(LinearModel(A=1, C=1), 1.0, 1.0), NILE, most_iterations=2)
    assert not noises.converged and noises.iterations == 2 and noises.improvement > 0


def adapting(seed, **options):
    settings, y, u = gappy(seed, steps=47)
    return AdaptiveNoises(settings, window=10, iterations=3, **options), y, u


@given(seed=seeds)
def test_a_window_is_so_many_iterations_on_its_steps(seed):
    settings, y, u = adapting(seed)
    estimates = estimate(settings, y, u)
    Q, R = square_root(settings.filter.Q), square_root(settings.filter.R)
    for _ in range(3):
        Q, R, _ = learned(settings.filter, Q, R, y[:10], u[:10])
    assert estimates.Q.shape == (5, 2, 2) and estimates.R.shape == (5, 2, 2)
    assert estimates.Q[0] == pytest.approx(settings.filter.Q, rel=1e-12)
    assert estimates.Q[1] == pytest.approx(Q @ Q.T, rel=1e-12)
    assert estimates.R[1] == pytest.approx(R @ R.T, rel=1e-12)


@given(seed=seeds)
def test_what_was_learned_is_used_from_there_on(seed):
    """The filter with Q(k) and R(k) given: Q of a new window moves the last step of the old one."""
    settings, y, u = adapting(seed)
    estimates = estimate(settings, y, u, keep_covariances=True)
    k = np.arange(47)
    other = estimate(
        settings.filter,
        y,
        u,
        Q=estimates.Q[(k + 1) // 10],
        R=estimates.R[k // 10],
        keep_covariances=True,
    )
    assert (
        relative_error(estimates.x, other.x) < 1e-9 and relative_error(estimates.P, other.P) < 1e-9
    )
    assert estimates.log_likelihood == pytest.approx(other.log_likelihood, rel=1e-10)
    assert estimates.observability.steps == other.observability.steps


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
@given(seed=seeds)
def test_steps_are_those_of_the_record_and_go_on_from_a_saved_state(seed):
    settings, y, u = adapting(seed)
    result, estimator = estimate(settings, y, u), Estimator(settings)
    for k in range(47):
        assert np.array_equal(estimator.Q, result.Q[k // 10])
        assert np.array_equal(estimator.R, result.R[k // 10])
        assert np.array_equal(estimator.step(y[k], u[k]), result.x[k])
        other = Estimator(settings)
        other.restore(estimator.state)
        estimator = other


def test_a_step_without_a_measurement_is_a_row_of_nan():
    settings, y, u = adapting(2)
    y[3] = y[12] = np.nan
    result, estimator = estimate(settings, y, u), Estimator(settings)
    for k in range(47):
        missing = np.isnan(y[k]).all()
        assert np.array_equal(estimator.step(None if missing else y[k], u[k]), result.x[k])


def test_noises_that_change_are_followed():
    """R doubles and doubles again: three windows later it lies within 5 deviations of a window."""
    level = EKF(LinearModel(A=0.8, C=1), Q=0.5, R=1.0)
    R = np.repeat([1.0, 4.0, 16.0], 3000)[:, None, None]
    y = record_of(level, 9000, np.random.default_rng(6), R)
    estimates = estimate(AdaptiveNoises(level, window=500, iterations=50, learn=["R"]), y)
    assert estimates.Q[-1] == pytest.approx(level.Q, rel=1e-15)
    for end, value in ((6, 1.0), (12, 4.0), (18, 16.0)):
        there = EKF(level.model, Q=0.5, R=value)
        deviation = noise_information(there, 500, learn=["R"]).R_deviation[0, 0]
        assert (np.abs(estimates.R[end - 2 : end + 1, 0, 0] - value) < 5 * deviation).all()
    # The innovations of what was learned are as large as it says, those of what was given are not.
    assert estimates.nis[-1000:].mean() < 1.3
    assert estimate(level, y).nis[-1000:].mean() > 5


def test_a_nonlinear_model_learns_its_sensors():
    """R of 1e-4: the deviation of a variance of N samples is sqrt(2/N) of it."""
    y, u = pendulum_record(3, steps=1000)
    begun = EKF(PENDULUM, Q=np.diag([1e-9, 1e-9, 1e-10]), R=1e-2, x_0=[0.5, 0, 0.4], P_0=0.01)
    noises = fit_noises(begun, y, u, learn=["R"], diagonal=True)
    assert np.diag(noises.R) == pytest.approx(1e-4, rel=5 * np.sqrt(2 / 1000))
    assert noises.information is None
    adapted = estimate(AdaptiveNoises(begun, learn=["R"], diagonal=True), y, u)
    assert np.diag(adapted.R[-1]) == pytest.approx(1e-4, rel=5 * np.sqrt(2 / 200))
    assert adapted.information is None


LEVEL = EKF(LinearModel(A=1, C=1), 1.0, 1.0)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: AdaptiveNoises(UKF(LEVEL.model, 1, 1)), "is not a EKF"),
        (lambda: AdaptiveNoises(LEVEL, window=1), "window = 1 must be at least 2"),
        (lambda: AdaptiveNoises(LEVEL, iterations=0), "iterations = 0 must be at least 1"),
        (lambda: AdaptiveNoises(LEVEL, learn=[]), "learn is empty"),
        (lambda: AdaptiveNoises(LEVEL, learn="P"), "an entry of learn = 'P' is not known"),
        (lambda: AdaptiveNoises(LEVEL, diagonal=1), "diagonal = 1 is not a bool"),
        (lambda: AdaptiveNoises(EKF(LEVEL.model, 0, 1)), "Q is zero, and learning keeps its range"),
        (lambda: estimate(AdaptiveNoises(LEVEL), [1, 2], R=[1, 1]), "AdaptiveNoises has its own"),
        (lambda: fit_noises(IMM([LEVEL], 1), [1, 2]), "is not a EKF"),
        (lambda: fit_noises(LEVEL, [1]), "y has 1 steps; noises need at least two"),
        (lambda: fit_noises(LEVEL, [1, np.nan, np.nan]), "NaN in all steps but one"),
        (lambda: fit_noises(LEVEL, [1, np.inf]), "y has the entry inf"),
        (lambda: fit_noises(EKF(LEVEL.model, 1, 0), [1, 2]), "R is zero"),
        (lambda: fit_noises(EKF(LinearModel(1, 1, B=1), 1, 1), [1, 2]), "1 known inputs"),
        (lambda: fit_noises(LEVEL, [1, 2], most_iterations=0), "most_iterations = 0 must be"),
        (lambda: noise_information(LEVEL, 0), "steps = 0 must be at least 1"),
        (lambda: noise_information(EKF(PENDULUM, 1, 1), 10), "is that of a LinearModel"),
    ],
)
def test_what_is_wrong_is_named(make, says):
    with pytest.raises(InputError, match=says):
        make()


def test_measurements_without_any_noise_have_no_information():
    twice = LinearModel(A=0.5, C=[[1], [1]])
    with pytest.raises(IllConditionedError, match="the spectrum of y is singular"):
        noise_information(EKF(twice, Q=1, R=0), 10, learn=["Q"])
    with pytest.raises(IllConditionedError, match="the covariance of the innovation is singular"):
        fit_noises(EKF(twice, Q=1, R=0), [[1, 1], [2, 2]], learn=["Q"])
