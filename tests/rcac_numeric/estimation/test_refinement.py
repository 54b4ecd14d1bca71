"""RCMR against batch least squares and against its own definition in plain NumPy."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rcac_numeric.estimation import RCMR, FIRSubsystem, ModelRefinement, RepeatedParameters, refine
from tests.support.estimation_cases import relative_error

seeds = st.integers(0, 10_000)


def random_settings(seed, **changes):
    """A stable MIMO model with a FIR subsystem of two outputs and three inputs."""
    rng = np.random.default_rng(seed)
    n, l_u, l_y, l_y0, n_c = 4, 2, 2, 3, 2
    A = rng.standard_normal((n, n))
    A *= 0.6 / max(abs(np.linalg.eigvals(A)))
    arguments = {
        "A": A,
        "B": rng.standard_normal((n, l_u)),
        "D_1": rng.standard_normal((n, 1)),
        "C": rng.standard_normal((l_y, n)),
        "E_1": rng.standard_normal((l_y0, n)),
        "subsystem": FIRSubsystem(n_c, strictly_proper=bool(seed % 2)),
        "beta": 1.0,
        "theta_0": rng.standard_normal(l_u * n_c * l_y0),
        "x_0": rng.standard_normal(n),
        "delays": (2,),
    } | changes
    steps = 60
    record = [rng.standard_normal((steps, width)) for width in (1, l_y, n)]
    return RCMR(**arguments), *record


def replay(settings, w, y, states, theta):
    """x^, u^ and Phi of every step from the recorded theta, in plain NumPy."""
    steps, part = len(w), settings.subsystem
    x, past = settings.x_0, np.zeros((part.n_c + 1, settings.E_1.shape[0]))
    zs, us, Phis = [], [], []
    for k in range(steps):
        zs.append(settings.C @ x - y[k])
        x = x if states is None else states[k]
        past = np.vstack([settings.E_1 @ x, past[:-1]])
        phi = (past[1:] if part.strictly_proper else past[:-1]).ravel()
        Phi = np.kron(np.eye(settings.l_u), phi)
        u = Phi @ theta[k]
        us.append(u)
        Phis.append(Phi)
        x = settings.A @ x + settings.D_1 @ w[k] + settings.B @ u
    return np.array(zs), np.array(us), np.array(Phis)


def reconstructed(settings, k, z, u):
    """u*(k - d) by (8.56), or nearest to what was, in plain NumPy."""
    Z = np.concatenate([z[k - k_j] for k_j in settings.stack])
    U = np.concatenate([u[k - i] for i in settings.delays])
    H, R = settings.H, settings.R
    eta = settings.eta_bar * z[k] @ z[k]
    normal = H.T @ R @ H + eta * np.eye(H.shape[1])
    if settings.method == "nearest":
        best = U - np.linalg.pinv(normal, rcond=1e-10) @ (H.T @ R @ Z)
    else:
        best = -np.linalg.pinv(normal, rcond=1e-10) @ (H.T @ R @ (Z - H @ U))
    at = settings.delays.index(settings.d) * settings.l_u
    return best[at : at + settings.l_u]


def batch(settings, k, z, u, Phi):
    """The minimiser of (8.61), corrected, at step k by one solution of all equations so far."""
    steps = range(settings.k_update, k + 1)
    share = settings.lambda_ ** (len(steps) / 2)
    rows = [share * np.linalg.inv(np.linalg.cholesky(settings.beta))]
    goals = [rows[0] @ settings.theta_0]
    for i in steps:
        share = settings.lambda_ ** ((k - i) / 2)
        if settings.method == "direct":
            Z = np.concatenate([z[i - k_j] for k_j in settings.stack])
            U = np.concatenate([u[i - m] for m in settings.delays])
            root = share * np.linalg.cholesky(settings.R).T
            rows.append(root @ settings.H @ np.vstack([Phi[i - m] for m in settings.delays]))
            goals.append(root @ (settings.H @ U - Z))
        else:
            rows.append(share * Phi[i - settings.d])
            goals.append(share * reconstructed(settings, i, z, u))
    return np.linalg.lstsq(np.vstack(rows), np.concatenate(goals), rcond=None)[0]


WEIGHT = np.diag([1, 2, 3, 4])
CHOICES = {
    "one delay": {},
    "first of three": {"delays": (1, 2, 3), "d": 1},
    "pseudoinverse": {"delays": (1, 2), "method": "pseudoinverse"},
    "as printed": {"delays": (1, 2), "method": "smallest", "eta_bar": 0.3},
    "stacked": {
        "delays": (1, 2),
        "stack": (0, 1),
        "method": "smallest",
        "R": np.diag([1, 2, 3, 4]),
    },
    "regularised": {"delays": (1, 3), "eta_bar": 0.1, "lambda_": 0.95},
    "regularised and stacked": {"delays": (1, 3), "stack": (0, 1), "eta_bar": 0.1},
    "direct": {"delays": (1, 2), "method": "direct", "lambda_": 0.98},
    "direct and stacked": {"delays": (1, 2, 4), "stack": (0, 2), "method": "direct"},
}


@pytest.mark.parametrize("choice", CHOICES.values(), ids=CHOICES)
@pytest.mark.filterwarnings("ignore::rcac_numeric.estimation.UnidentifiableWarning")
@given(seed=seeds)
def test_the_recursion_is_batch_least_squares(choice, seed):
    settings, w, y, states = random_settings(seed, **choice)
    shares = np.linalg.svd(settings.H, compute_uv=False) ** 2
    shares /= shares.max()
    # Which of them count as zero is a threshold, here not that of the kernel.
    assume(not ((shares > 1e-15) & (shares < 1e-8)).any())
    run = refine(settings, w, y, states)
    z, u, Phi = replay(settings, w, y, states, run.theta)
    condition = np.linalg.cond(settings.H.T @ settings.H)
    if settings.H.shape[1] > np.linalg.matrix_rank(settings.H):
        condition = np.linalg.cond(settings.H) ** 2 if np.linalg.cond(settings.H) < 1e8 else 1e6
    assert relative_error(run.z, z) < 1e-12 * max(1, abs(run.theta).max())
    assert relative_error(run.u, u) < 1e-12
    for k in (settings.k_update, 20, 59):
        expected = batch(settings, k, run.z, run.u, Phi)
        assert relative_error(run.theta[k], expected) < 1e-13 * max(condition, 100)


@pytest.mark.filterwarnings("ignore::rcac_numeric.estimation.UnidentifiableWarning")
def test_the_recursion_is_batch_least_squares_to_1e_13():
    settings, w, y, states = random_settings(5, delays=(1,))
    run = refine(settings, w, y, states)
    _, _, Phi = replay(settings, w, y, states, run.theta)
    for k in (10, 30, 59):
        expected = batch(settings, k, run.z, run.u, Phi)
        assert relative_error(run.theta[k], expected) < 1e-13


@pytest.mark.filterwarnings("ignore::rcac_numeric.estimation.UnidentifiableWarning")
@pytest.mark.parametrize("seed", range(5))
def test_the_model_runs_freely(seed):
    settings, w, y, _ = random_settings(seed, beta=1e-6, theta_0=np.zeros(12))
    run = refine(settings, w, y)
    z, u, _ = replay(settings, w, y, None, run.theta)
    assert relative_error(run.z, z) < 1e-11 and relative_error(run.u, u) < 1e-9


def test_the_recursion_as_printed_is_no_covariance():
    """(8.63) has phi(k - d) in its bracket: P turns indefinite, as the ledger's entry says."""
    rng = np.random.default_rng(3)
    phi = rng.standard_normal((40, 3))
    P = np.eye(3)
    for k in range(1, 40):
        bracket = phi[k - 1] @ P @ phi[k] + 1.0
        P = P - np.outer(P @ phi[k - 1], phi[k - 1] @ P) / bracket
        if np.linalg.eigvalsh((P + P.T) / 2).min() < 0:
            return
    raise AssertionError("the printed recursion kept P definite")


@pytest.mark.exact_data  # bit for bit in two ways, whose intermediate results are read anew
@pytest.mark.filterwarnings("ignore::rcac_numeric.estimation.UnidentifiableWarning")
@pytest.mark.parametrize("choice", CHOICES.values(), ids=CHOICES)
def test_steps_are_those_of_the_record_also_after_a_restart(choice, tmp_path):
    settings, w, y, states = random_settings(11, **choice)
    run = refine(settings, w, y, states)
    refinement = ModelRefinement(settings)
    for k in range(60):
        if k == 25:
            refinement.state.save(tmp_path / "state.npz")
            state = refinement.state.load(tmp_path / "state.npz")
            refinement = ModelRefinement(settings)
            refinement.restore(state)
        assert np.array_equal(refinement.step(w[k], y[k], states[k]), run.theta[k])
        assert np.array_equal(refinement.z, run.z[k]) and np.array_equal(refinement.u, run.u[k])
    assert np.array_equal(refinement.P, run.P)


def test_a_frozen_refinement_keeps_theta():
    settings, w, y, _ = random_settings(12, beta=1e-6, theta_0=np.zeros(12))
    refinement = ModelRefinement(settings)
    for k in range(20):
        refinement.step(w[k], y[k])
    refinement.freeze()
    before = refinement.theta
    assert np.array_equal(refinement.step(w[20], y[20]), before)
    refinement.resume()
    assert not np.array_equal(refinement.step(w[21], y[21]), before)


@given(seed=seeds)
def test_a_repeated_parameter_is_found_where_the_truth_is_linear_in_it(seed):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((3, 3))
    A *= 0.5 / max(abs(np.linalg.eigvals(A)))
    D = rng.standard_normal((3, 1))
    A_j, D_j = 0.2 * rng.standard_normal((2, 3, 3)), 0.2 * rng.standard_normal((2, 3, 1))
    theta = 0.2 * rng.standard_normal(2)
    w, x, states = rng.standard_normal((400, 1)), np.zeros(3), []
    for k in range(400):
        states.append(x)
        x = (A + np.tensordot(theta, A_j, 1)) @ x + (D + np.tensordot(theta, D_j, 1)) @ w[k]
    settings = RCMR(
        A=A, D_1=D, C=np.eye(3), subsystem=RepeatedParameters(A_j, D_j), beta=1e6,
        delays=(1,), method="direct",
    )  # fmt: skip
    run = refine(settings, w, states, x=states)  # a one-step predictor: least squares, exactly
    assert np.allclose(run.theta[-1], theta, atol=1e-5)


@given(seed=seeds)
def test_a_mimo_fir_subsystem_is_found(seed):
    """Second-order, strictly proper, two inputs and two outputs, the states measured."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((3, 3))
    A *= 0.4 / max(abs(np.linalg.eigvals(A)))
    B, E_1, D = (
        rng.standard_normal((3, 2)),
        rng.standard_normal((2, 3)),
        rng.standard_normal((3, 2)),
    )
    N = 0.02 * rng.standard_normal((2, 2, 2))
    w, x, states = rng.standard_normal((500, 2)), np.zeros(3), []
    past = np.zeros((2, 2))
    for k in range(500):
        states.append(x)
        u = N[0] @ past[0] + N[1] @ past[1]
        past = np.vstack([E_1 @ x, past[:1]])
        x = A @ x + B @ u + D @ w[k]
    settings = RCMR(
        A=A, B=B, D_1=D, C=np.eye(3), E_1=E_1, beta=1e8, delays=(1,),
        subsystem=FIRSubsystem(2, strictly_proper=True),
    )  # fmt: skip
    run = refine(settings, w, states, x=states)
    assert np.allclose(run.theta[-1], np.hstack([N[0], N[1]]).ravel(), atol=1e-5)
