"""Predictive cost adaptive control: model, gain, limits of u, and what a run holds."""

import numpy as np
import pytest
import scipy.optimize
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
import rcac_numeric as rcac
from compensator_theory.errors import CompensatorError, ImproperError, InputError
from rcac_numeric import ControlLimits, PredictiveCost, PredictiveCostController, simulate

SIZES = st.sampled_from([(1, 1, 1), (2, 1, 1), (3, 1, 1), (2, 2, 1), (1, 1, 2), (2, 2, 3)])
SEEDS = st.integers(0, 2**32 - 1)


def drawn(seed, n, l_y, l_u):
    """theta of a model whose coefficients have a size of about 1/2."""
    return np.random.default_rng(seed).uniform(-1, 1, l_y * n * (l_u + l_y)) / 2


def exactly(value):
    return [[ct.exact_number(float(entry), binary=True) for entry in row] for row in value]


def model_plant(settings, theta):
    """y(k) of the ARX model itself, whose w is r; its states are the past y and u."""
    b, a = settings.model(theta)
    n, p, m = b.shape
    A, B = np.zeros((n * (p + m),) * 2), np.zeros((n * (p + m), m))
    A[: n * p, : n * p] = np.eye(n * p, k=-p)
    A[n * p :, n * p :] = np.eye(n * m, k=-m)
    A[:p] = np.hstack([*a, *b])
    B[n * p : n * p + m] = np.eye(m)
    # y(k) reads u(k-1) at the latest, so y is the newest row after the step
    C = A[:p]
    zero = np.zeros((p, m))
    blocks = {"r": p} if settings.l_r else {}
    return rcac.Plant(
        A=A, B=B, D_1=np.zeros((len(A), p)), C=C, D_0=zero, D_2=np.zeros((p, p)), E_1=C, E_2=zero,
        E_0=np.zeros((p, p)), **({"blocks": blocks} if blocks else {}),
    )  # fmt: skip


@given(SIZES, SEEDS, st.integers(1, 6), st.sampled_from(["moves", "u"]))
def test_the_gain_is_the_exact_one(size, seed, horizon, weighs):
    n, l_y, l_u = size
    settings = PredictiveCost(
        n, horizon, Q=2, P=5, R=0.5, weighs=weighs, l_u=l_u, l_y=l_y, problem="tracking"
    )
    theta = drawn(seed, *size)
    b, a = settings.model(theta)
    limit = ct.predictive_cost_compensator(
        ([exactly(M) for M in b], [exactly(M) for M in a]),
        horizon=horizon, Q=2, P=5, R="1/2", weighs=weighs,
    )  # fmt: skip
    K, K_u, _ = settings.gain(theta)
    target = np.array(limit.K.tolist(), dtype=float)
    # R + B'SB >= 1/2, and A and B have norms below 4: each step loses a few digits at most.
    assert abs(K - target).max() <= 1e-9 * (1 + abs(target).max())
    if limit.K_u is None:
        assert not K_u.any()
    else:
        assert np.allclose(K_u, np.array(limit.K_u.tolist(), dtype=float), rtol=1e-9, atol=1e-9)


@given(SIZES, SEEDS, st.sampled_from(["standard", "servo", "tracking"]))
def test_the_steps_of_a_constant_model_are_its_compensator(size, seed, problem):
    n, l_y, l_u = size
    theta = drawn(seed, *size)
    settings = PredictiveCost(
        n, 4, R=0.3, problem=problem, theta_0=theta, R_theta=1e200, l_u=l_u, l_y=l_y
    )
    steps, rng = PredictiveCostController(settings), np.random.default_rng(seed)
    y, r = rng.standard_normal((2, 30, l_y))
    compensator, inputs = settings.compensator_of(theta), y if problem == "standard" else None
    inputs = y if problem == "standard" else np.hstack([y, r])
    u = np.zeros((30, l_u))
    for k in range(30):
        for i in range(compensator.n_c + 1):
            if i <= k:
                u[k] += compensator.past_y[i] @ inputs[k - i]
                if i:
                    u[k] += compensator.past_u[i - 1] @ u[k - i]
        # An open loop may grow; the controller goes on from the same past.
        control = steps.step(y[k], r[k] if settings.l_r else (), u[k - 1] if k else None)
        assert np.allclose(control, u[k], rtol=1e-8, atol=1e-8 * (1 + abs(u[: k + 1]).max()))


@given(SIZES, SEEDS)
def test_the_model_is_the_least_squares_solution(size, seed):
    """Of all equations at once, with the prior R_theta |theta - theta_0|^2."""
    n, l_y, l_u = size
    rng = np.random.default_rng(seed)
    theta_0 = drawn(seed, *size)
    settings = PredictiveCost(n, 2, theta_0=theta_0, R_theta=0.7, l_u=l_u, l_y=l_y)
    steps = PredictiveCostController(settings)
    y, u = rng.standard_normal((25, l_y)), rng.standard_normal((25, l_u))
    for k in range(25):
        steps.step(y[k], u_applied=u[k - 1] if k else None)
    phi = np.array(
        [np.concatenate([*u[k - n : k][::-1], *y[k - n : k][::-1]]) for k in range(n, 24)]
    )
    information = phi.T @ phi + 0.7 * np.eye(phi.shape[1])
    prior = 0.7 * theta_0.reshape(l_y, -1).T
    theta = np.linalg.solve(information, phi.T @ y[n:24] + prior).T
    assert np.allclose(steps.theta, theta.ravel(), rtol=1e-8, atol=1e-8)
    assert np.allclose(steps.covariance, np.linalg.inv(information), rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize("weighs", ["moves", "u"])
@pytest.mark.parametrize("seed", range(4))
def test_bounded_least_squares_has_the_least_cost(weighs, seed):
    """Of the controls that SciPy's L-BFGS-B finds for the cost of the difference equation."""
    rng = np.random.default_rng(seed)
    size, horizon = [(2, 1, 1), (2, 2, 2)][seed % 2], 5
    n, l_y, l_u = size
    theta = drawn(seed, *size)
    limits = ControlLimits(low=-0.2, high=0.3, rise=0.1)
    settings = PredictiveCost(
        n, horizon, Q=2, P=5, R=0.05, weighs=weighs, problem="tracking", theta_0=theta,
        R_theta=1e200, l_u=l_u, l_y=l_y, limits=limits, limited_by="least squares",
    )  # fmt: skip
    b, a = settings.model(theta)
    steps, active = PredictiveCostController(settings), 0
    past_y, past_u = np.zeros((n, l_y)), np.zeros((n, l_u))
    for _ in range(6):
        r, y = 2 * rng.standard_normal((2, l_y))

        def cost(flat, r=r, past_y=past_y, past_u=past_u):
            ys, us, total = list(past_y), list(past_u), 0.0
            for j in range(horizon + 1):
                now = sum(a[i] @ ys[i] + b[i] @ us[i] for i in range(n))
                total += (5 if j == horizon else 2) * np.sum((now - r) ** 2)
                if j < horizon:
                    u = flat.reshape(horizon, l_u)[j]
                    total += 0.05 * np.sum((u - us[0] if weighs == "moves" else u) ** 2)
                    ys, us = [now, *ys[:-1]], [u, *us[:-1]]
            return total

        bounds = np.array([[-0.2, 0.3]] * horizon * l_u)
        bounds[:l_u, 1] = np.minimum(past_u[0] + 0.1, 0.3)
        best = scipy.optimize.minimize(
            cost, np.clip(np.zeros(len(bounds)), *bounds.T), bounds=bounds, method="L-BFGS-B",
            options={"ftol": 1e-15, "gtol": 1e-10},
        )  # fmt: skip
        u = steps.step(y, r)
        assert np.allclose(u, best.x[:l_u], atol=1e-5)
        active += bool((best.x < bounds[:, 0] + 1e-9).any() or (best.x > bounds[:, 1] - 1e-9).any())
        past_y, past_u = np.vstack([y, past_y[:-1]]), np.vstack([u, past_u[:-1]])
    assert active >= 3


@pytest.mark.parametrize("limited_by", ["saturation", "least squares"])
def test_limits_hold_and_enter_the_model(limited_by):
    plant = rcac.servo_plant("4*(q - 6/5)/(q**2 - q + 4/5)")
    limits = ControlLimits(low=-1, high=1, rise=0.3, fall=0.3)
    settings = PredictiveCost(
        2, 20, Q=50, P=50, R=10, problem="servo", R_theta=1e-6, limits=limits, limited_by=limited_by
    )
    w = rcac.exogenous([rcac.Levels([0.5, -0.5, 0.8], hold=120), rcac.Step(0), rcac.Step(0)], 360)
    run = simulate(plant, settings, w)
    moves = np.diff(run.u[:, 0], prepend=0)
    assert run.outcome == "completed" and abs(run.u).max() <= 1 and abs(moves).max() <= 0.3 + 1e-12
    assert np.allclose(run.theta_final, [4, -4.8, 1, -0.8], atol=1e-3)
    assert abs(run.z[-1, 0]) < 0.05


SCHEDULE = rcac.PlantSchedule(
    [
        rcac.PlantChange(start=0, plant=rcac.servo_plant("1/(q - 6/5)")),
        rcac.PlantChange(start=80, plant=rcac.servo_plant("3/(q - 3/5)")),
    ]
)


def test_a_run_goes_on_bit_for_bit_and_is_loaded(tmp_path):
    settings = PredictiveCost(1, 10, problem="servo", lambda_=0.8, R_theta=1e-4)
    rng = np.random.default_rng(1)
    w = np.hstack([np.sign(rng.standard_normal((200, 1))), 1e-3 * rng.standard_normal((200, 2))])
    run = simulate(SCHEDULE, settings, w)
    half = simulate(SCHEDULE, settings, w[:70])
    rest = simulate(SCHEDULE, settings, w[70:], start=half.state)
    assert np.array_equal(np.vstack([half.u, rest.u]), run.u)
    assert np.array_equal(rest.theta_final, run.theta_final)
    # After the change the model forgets what it excites.
    assert np.allclose(run.theta_final, [3, 0.6], atol=0.1)
    run.save(tmp_path / "run.npz")
    assert rcac.load_run(tmp_path / "run.npz") == run


def test_forgetting_is_of_the_excited_direction_alone():
    """P of the formulas of `SubspaceForgetting`, in information form; at rest nothing winds up."""
    n, lambda_, R_theta = 2, 0.9, 0.5
    steps = PredictiveCostController(PredictiveCost(n, 5, lambda_=lambda_, R_theta=R_theta))
    rng = np.random.default_rng(3)
    y = np.where(np.arange(400) < 40, rng.standard_normal(400), 0.0)
    u = np.where(np.arange(400) < 30, rng.standard_normal(400), 0.0)
    P, lambda_d = np.eye(2 * n) / R_theta, max(0.5, 1 - 2 * n * (1 - lambda_))
    for k in range(400):
        steps.step(y[k], u_applied=u[k - 1 : k] if k else None)
        if n < k + 1 <= 399:
            phi = np.concatenate([u[k - n : k][::-1], y[k - n : k][::-1]])
            if phi.any():
                q, f = phi @ np.linalg.solve(P, phi), R_theta * phi @ phi
                c = min((1 - lambda_d) / (lambda_d * q), max(0, 1 / f - 1 / q))
                P = P + c * np.outer(phi, phi)
                P = P - np.outer(P @ phi, P @ phi) / (1 + phi @ P @ phi)
    assert np.allclose(steps.covariance, P, rtol=1e-7)


def test_a_nonlinear_plant_of_two_signals():
    def advance(k, x, u, w):
        return np.array([0.9 * np.sin(x[0]) + u[0] + 0.2 * u[1], 0.5 * x[1] + u[1]])

    plant = rcac.FunctionPlant(
        advance=advance, output=lambda k, x, w: (x, x - w),
        n=2, l_u=2, l_w=2, l_y=2, l_z=2, blocks={"r": 2},
    )  # fmt: skip
    settings = PredictiveCost(2, 8, problem="tracking", l_u=2, l_y=2, R_theta=1e-3)
    run = simulate(plant, settings, np.tile([0.5, -0.3], (150, 1)))
    assert run.outcome == "completed" and abs(run.z[-1]).max() < 0.02


def test_the_health_and_the_loop_of_a_run_are_those_of_its_compensator():
    plant = rcac.servo_plant("(q - 13/10)/(q**2 - 7/5*q + 3/10)")
    settings = PredictiveCost(2, 20, Q=2, P=5, problem="servo", R_theta=1e-6)
    run = simulate(plant, settings, rcac.exogenous([rcac.Step(), rcac.Step(0), rcac.Step(0)], 100))
    analysis = rcac.LoopAnalysis(run)
    assert analysis.loop.is_stable and rcac.loop_health(run).is_stable
    assert str(analysis) and run.compensator.l_y == 2
    with pytest.raises(InputError, match="adapts to no target model"):
        analysis.compared_with  # noqa: B018
    with pytest.raises(InputError, match="predictive_cost_limit"):
        rcac.compare_exactly(run)
    assert rcac.check_controller(run).compensator == run.compensator


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PredictiveCost(0, 5), "order = 0"),
        (lambda: PredictiveCost(2, 0), "horizon = 0"),
        (lambda: PredictiveCost(2, 5, R=0), "R"),
        (lambda: PredictiveCost(2, 5, Q=-1), "Q has the eigenvalue -1"),
        (lambda: PredictiveCost(2, 5, Q=np.eye(2)), r"Q has shape \(2, 2\)"),
        (lambda: PredictiveCost(2, 5, weighs="y"), "weighs = 'y' is not known"),
        (lambda: PredictiveCost(2, 5, problem="y"), "problem = 'y' is not known"),
        (lambda: PredictiveCost(2, 5, R_theta=0), "R_theta = 0 must be positive"),
        (lambda: PredictiveCost(2, 5, lambda_=0), "lambda_ = 0"),
        (lambda: PredictiveCost(2, 5, theta_0=[1, 2, 3]), r"theta_0 has shape \(3,\)"),
        (lambda: PredictiveCost(2, 5, theta_0=0), "b = 0"),
        (lambda: PredictiveCost(2, 5, theta_0=[0, 0, 1, 1]), "b = 0"),
        (lambda: PredictiveCost(2, 5, theta_0=np.nan), "theta_0"),
        (lambda: PredictiveCost(2, 5, limits=ControlLimits(low=[-1, 0])), "low has 2 entries"),
        (lambda: PredictiveCost(2, 5, limited_by="least squares"), "needs limits"),
        (lambda: PredictiveCost(2, 5, limited_by="a QP"), "is not known"),
        (lambda: PredictiveCost(2, 5).gain([1, 2, 3]), "theta has 3 entries"),
        (lambda: PredictiveCostController(PredictiveCost(2, 5)).step([1, 2]), "y has 2 entries"),
        (lambda: PredictiveCostController(PredictiveCost(2, 5)).step(np.nan), "y"),
        (lambda: simulate("1/(q - 2)", PredictiveCost(2, 5, l_u=2), [[1.0]] * 9), "l_u = 1"),
        (lambda: simulate("1/(q - 2)", PredictiveCost(2, 5, problem="servo"), [[1.0]] * 9),
         "reads a command"),
        (lambda: simulate("q/(q - 2)", PredictiveCost(2, 5), [[1.0]] * 9), "D_0 is not zero"),
        (lambda: rcac.simulate_many(
            [rcac.SimulationCase("1/(q - 2)", PredictiveCost(1, 5), [[1.0]] * 9)]
        ), "`simulate` runs it"),
    ],
)  # fmt: skip
def test_bad_input(make, words):
    with pytest.raises((InputError, ImproperError), match=words):
        make()


def test_a_run_that_leaves_float64_says_so():
    """A horizon too long for an unstable model, and a plant that the identification overflows."""
    settings = PredictiveCost(1, 1000, theta_0=[1e-3, 1e200], R_theta=1e200)
    with pytest.raises(CompensatorError, match="Riccati recursion left"):
        settings.gain(settings.theta_0.ravel())
    run = simulate("1/(q - 2)", settings, [[1.0]] * 9)
    assert run.outcome == "overflow" and "shorter horizon" in run.failure
