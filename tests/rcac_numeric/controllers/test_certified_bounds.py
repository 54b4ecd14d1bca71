"""An ellipsoid for theta: every theta inside without rounding, nothing moved that is inside."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory.errors import InputError
from rcac_numeric.compiled import _kernel
from rcac_numeric.controllers._bounds import ellipsoid_radii, inverse_factor
from tests.support.ellipsoids import ellipsoid, exact_square, rational
from tests.support.signals import noise
from tests.support.strategies import seeds

PLANT = rn.standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
UPDATES = {
    "ud": rn.UD(0.05, lambda_=0.99),
    "noise": rn.UD(0.05, process_noise=0.01),
    "reset": rn.UD(0.05, reset=rn.CovarianceReset(every=9)),
    "subspace": rn.UD(0.05, lambda_=rn.SubspaceForgetting(0.98)),
    "capped": rn.UD(0.05, lambda_=rn.CappedForgetting(0.98)),
    "covariance": rn.Covariance(0.05),
    "window": rn.SlidingWindow(0.05, window=9),
    "joint": rn.JointUD(0.05, n_d=1, rho=1.0),
    "instantaneous": rn.Instantaneous(0.05),
    "gradient": rn.Gradient(0.01),
}
updates = st.sampled_from(sorted(UPDATES))


def settings_of(n_c=2, **more):
    argument = {"structure": rn.iir(n_c), "target": rn.TargetModel([0, 1.0])}
    return rn.ControllerSettings(**{**argument, "update": rn.UD(0.05), **more})


def bounded_settings(seed, n_c, update="ud", **more):
    bounds = ellipsoid(seed, 2 * n_c, **more)
    return settings_of(n_c, update=UPDATES[update], bounds=bounds, theta_0=bounds.center)


@given(
    seeds, st.integers(1, 5), st.sampled_from([1e-3, 0.05, 1.0]), st.sampled_from([1, 1e6]), updates
)
def test_no_theta_leaves_the_ellipsoid_and_a_projection_ends_on_its_boundary(
    seed, n_c, width, spread, update
):
    settings = bounded_settings(seed, n_c, update, width=width, spread=spread)
    bounds, (limit, aim) = settings.bounds, ellipsoid_radii(settings.bounds)
    controller, w = rn.Controller(settings), noise(seed, 40, 1)
    run = rn.simulate(PLANT, settings, w)
    for k in range(run.steps):
        before = controller.bounded
        controller.step(run.y[k], run.z[k])
        assert exact_square(bounds, controller.theta) <= 1
        if controller.bounded > before:
            assert controller.radius >= aim - (1 - aim)
    assert controller.bounded == run.bounded and bounds.contains(run.theta)
    assert controller.radius <= limit + (1 - limit) / 2


@pytest.mark.parametrize("update", UPDATES)
def test_what_is_inside_stays_the_same_bits(update):
    w = noise(3, 300, 1)
    plain = rn.simulate(PLANT, settings_of(update=UPDATES[update]), w)
    radii = ellipsoid(3, 4, width=1.0).radius_of(np.vstack([plain.theta, plain.theta_final]))
    wide = ellipsoid(3, 4, width=1.01 * (radii.max() + 2), center=np.zeros(4))
    run = rn.simulate(PLANT, settings_of(update=UPDATES[update], bounds=wide), w)
    assert run.bounded == 0 and run.radius.max() < 1
    for name in ("u", "theta", "theta_final"):
        assert getattr(run, name).tobytes() == getattr(plain, name).tobytes()


@given(seeds, st.integers(1, 9), st.sampled_from([1, 1e6, 1e12]))
def test_the_inverse_of_the_factor_has_the_nearest_numbers(seed, size, spread):
    bounds = ellipsoid(seed, size, spread=spread)
    exact = rational(bounds.factor).inv().entries()
    for value, entry in zip(inverse_factor(bounds).ravel(), exact, strict=True):
        assert value == int(entry.p) / int(entry.q)


def nearest(theta, P, bounds):
    """The minimiser of (t - theta)' P^-1 (t - theta) in the ellipsoid, by its multiplier."""
    inverse = np.linalg.inv(bounds.factor)
    values, Q = np.linalg.eigh(inverse @ P @ inverse.T)
    c = Q.T @ inverse @ (theta - bounds.center)
    low, high = 0.0, 1.0
    while np.linalg.norm(c / (1 + high * values)) > 1:
        high *= 2
    for _ in range(200):
        middle = (low + high) / 2
        outside = np.linalg.norm(c / (1 + middle * values)) > 1
        low, high = (middle, high) if outside else (low, middle)
    return bounds.center + bounds.factor @ Q @ (c / (1 + high * values))


@given(seeds, st.sampled_from([0.03, 0.1, 0.3]))
def test_the_cuts_bring_theta_nearer_to_the_nearest_point_in_the_metric_of_P(seed, width):
    """From nearby they reach it; the nearest point itself by its multiplier is the oracle."""
    bounds = ellipsoid(seed, 4, width=width, center=np.zeros(4))
    settings = settings_of(bounds=bounds)
    run, controller = rn.simulate(PLANT, settings, noise(seed, 40, 1)), rn.Controller(settings)
    u, y, z = run.u[:, 0], run.y[:, 0], run.z[:, 0]
    for k in range(40):
        theta, P, moved = controller.theta, controller.P, controller.bounded
        controller.step(y[k], z[k])
        past = lambda s, i, k=k: s[k - i] if k >= i else 0.0  # noqa: E731
        phi = np.array([past(s, i) for s in (u, y) for i in (2, 3)])
        gain = P @ phi / (1 + phi @ P @ phi)
        free = theta - gain * (phi @ theta + z[k] - past(u, 1))
        if controller.bounded == moved:
            continue
        P = controller.P
        point = nearest(free, P, bounds)
        distance = lambda a, b, P=P: np.sqrt((a - b) @ np.linalg.solve(P, a - b))  # noqa: E731
        best, there = distance(free, point), distance(free, controller.theta)
        radius = float(bounds.radius_of(free))
        assert there >= best * (1 - 1e-9)
        if radius < 1.05:  # so near that the last cut leaves nothing to the radius
            assert distance(controller.theta, point) <= best * (1 + 1e-4), (k, radius)
            assert there <= best * (1 + 0.2)


@pytest.mark.parametrize("update", ["ud", "covariance", "instantaneous", "gradient"])
@pytest.mark.parametrize("n_c", [1, 2, 3, 5])
def test_every_instruction_set_projects_as_ball_arithmetic_does(update, n_c, monkeypatch):
    for seed in range(3):
        settings = bounded_settings(seed, n_c, update)
        w = noise(seed, 20, 1)
        exact = rn.simulate_reference(PLANT, settings, w)
        size = max(1.0, np.abs(exact.u).max())
        for name in _kernel.instruction_sets():
            monkeypatch.setenv("RCAC_INSTRUCTION_SET", name)
            run = rn.simulate(PLANT, settings, w)
            assert run.bounded > 0
            assert np.abs(run.theta - exact.theta).max() <= 1e-10 * size
            assert np.abs(run.u - exact.u).max() <= 1e-10 * size


def test_a_theta_beyond_float64_comes_back_along_its_direction():
    bounds = ellipsoid(1, 4)
    settings = settings_of(bounds=bounds, theta_0=bounds.center, update=rn.Gradient(1.0), k_w=3)
    controller = rn.Controller(settings, rn.Supervision("off"))
    signals = np.random.default_rng(2).standard_normal(6)
    u = [controller.step(y, 0.0)[0] for y in signals]
    before = controller.theta
    controller.step(0.0, 1e250)
    phi = np.array([u[-2], u[-3], signals[-2], signals[-3]])
    assert exact_square(bounds, controller.theta) <= 1 and controller.radius > 1 - 1e-9
    direction = (controller.theta - bounds.center) / -phi
    assert np.allclose(direction, direction[0], rtol=1e-9) and direction[0] > 0
    assert not np.array_equal(before, controller.theta)


@pytest.mark.parametrize("policy", ["warn", "freeze", "bound", "reset"])
def test_the_supervision_records_the_largest_radius_of_its_looks(policy):
    settings = bounded_settings(4, 2, width=0.3)
    w = noise(4, 200, 1)
    run, supervision = rn.simulate(PLANT, settings, w), rn.Supervision(policy)
    controller = rn.Controller(settings, supervision)
    radii = []
    for k, (y, z) in enumerate(zip(run.y, run.z, strict=True), start=1):
        controller.step(y, z)
        if k % 16 == 0:
            radii.append(controller.radius)
        if k == 100:  # bit for bit through a saved state
            twin = rn.Controller(settings, supervision)
            twin.restore(controller.state)
            controller = twin
        assert controller.record.radius == pytest.approx(max(radii, default=0.0), rel=1e-12)
    assert f"{100 * max(radii):.3g} % of the radius" in rn.loop_health(controller).report()


def test_the_share_of_the_radius_is_in_the_run_its_tables_and_its_health():
    settings = bounded_settings(5, 2)
    run = rn.simulate(PLANT, settings, noise(5, 100, 1), stride=7)
    expected = [float(exact_square(settings.bounds, theta)) ** 0.5 for theta in run.theta]
    assert np.allclose(run.radius, expected, rtol=1e-12, atol=1e-15)
    health = rn.loop_health(run)
    assert health.radius == max(*run.radius, settings.bounds.radius_of(run.theta_final))
    assert "% of the radius of CertifiedBounds" in health.report()
    assert "not apply u" not in health.report()
    limited = rn.simulate(
        PLANT, settings, noise(5, 100, 1), saturation=rn.Saturation(low=-0.01, high=0.01)
    )
    assert "the actuator did not apply u" in rn.loop_health(limited).report()
    plain = rn.simulate(PLANT, settings_of(), noise(5, 10, 1))
    assert plain.radius is None and rn.loop_health(plain).radius is None
    assert rn.Controller(settings_of()).radius is None


def test_the_share_of_the_radius_in_a_data_frame():
    pytest.importorskip("pandas")
    run = rn.simulate(PLANT, bounded_settings(5, 2), noise(5, 30, 1), stride=4)
    column = run.to_pandas()["radius"]
    assert np.array_equal(column[::4], run.radius) and column.isna().sum() == 30 - len(run.radius)


def test_batches_with_other_numbers_are_the_single_runs():
    bounds = ellipsoid(6, 4)
    cases = [
        rn.SimulationCase(
            PLANT,
            settings_of(bounds=bounds, theta_0=theta_0, update=rn.UD(R_theta), R_u=R_u),
            noise(seed, 80, 1),
        )
        for seed in range(3)
        for theta_0 in (bounds.center, bounds.center + bounds.factor @ np.full(4, 0.4))
        for R_theta, R_u in ((0.05, 0.0), (1.0, 0.3))
    ]
    single = [rn.simulate(case.plant, case.settings, case.w) for case in cases]
    assert all(run.bounded for run in single)
    in_lanes = rn.simulate_many(cases, lanes=True)
    assert rn.simulate_many(cases) == single
    for runs, lanes in ((single, False), (in_lanes, True)):
        stream = rn.simulate_stream(cases, reduce=lambda _, run: run.theta.tobytes(), lanes=lanes)
        for result in stream:  # as they end
            assert result.value == runs[result.number].theta.tobytes()
    assert all(run.bounded and bounds.contains(run.theta) for run in in_lanes)


@pytest.mark.parametrize("past", ["keep", "reset", "blend", "replay"])
def test_a_target_model_that_is_set_while_it_runs(past):
    settings = bounded_settings(7, 2)
    run, controller = rn.simulate(PLANT, settings, noise(7, 120, 1)), rn.Controller(settings)
    for k in range(120):
        controller.step(run.y[k], run.z[k])
        if k == 60:
            controller.set_target(rn.TargetModel([0, 0.5, 0.2], [1, -0.3, 0]), past)
        assert exact_square(settings.bounds, controller.theta) <= 1


def test_several_controllers_keep_each_its_own():
    parts = [bounded_settings(seed, 1) for seed in (8, 9)]
    run = rn.simulate(PLANT, rn.Decentralized(parts, shared_u=True), noise(8, 60, 1))
    assert run.bounded > 0 and run.radius is None
    for i, part in enumerate(parts):
        assert part.bounds.contains(run.theta[:, 2 * i : 2 * i + 2])


EYE = np.eye(4)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rn.CertifiedBounds(0.0, 1.0), "a vector of l_theta entries"),
        (lambda: rn.CertifiedBounds([], np.zeros((0, 0))), "a vector of l_theta entries"),
        (lambda: rn.CertifiedBounds(np.zeros(4), np.eye(3)), r"factor has the shape \(3, 3\)"),
        (lambda: rn.CertifiedBounds(np.zeros(2), [[1, 0.5], [0.5, 1]]), "linalg.cholesky"),
        (lambda: rn.CertifiedBounds(np.zeros(4), -EYE), "positive entries are needed"),
        (lambda: rn.CertifiedBounds(np.zeros(4), np.diag([1, 1, 1, 0])), "has 0 on its diagonal"),
        (lambda: rn.CertifiedBounds(np.zeros(4), np.full((4, 4), np.inf)), "must be finite"),
        (lambda: rn.CertifiedBounds(["a"] * 4, EYE), "array of real numbers"),
        (lambda: rn.CertifiedBounds(np.full(4, 1e9), 1e-8 * EYE), "too short for the size of"),
        (
            lambda: rn.CertifiedBounds(np.zeros(2), [[1e-8, 0], [1e8, 1e-8]]),
            "cap the largest axes",
        ),
        (
            lambda: rn.CertifiedBounds(np.zeros(4), EYE).radius_of(np.zeros(3)),
            r"theta has the shape",
        ),
        (lambda: rn.CertifiedBounds(np.zeros(4), EYE).contains(0.0), r"theta has the shape \(\)"),
        (
            lambda: settings_of(bounds=rn.CertifiedBounds(np.zeros(3), np.eye(3))),
            "a center of 3 entries; l_theta = 4",
        ),
        (
            lambda: settings_of(bounds=rn.CertifiedBounds(np.full(4, 3.0), EYE)),
            "at 6 of their radius",
        ),
        (
            lambda: settings_of(bounds=rn.CertifiedBounds(np.zeros(4), EYE), reflect_poles=True),
            "one of the two",
        ),
    ],
)
def test_what_is_no_ellipsoid_for_these_settings_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_case_without_a_digit_is_projected_still():
    """With R_theta = 1e-40 the covariance loses its metric; the radius is kept."""
    bounds = ellipsoid(2, 4)
    for update in (rn.UD(1e-40), rn.Covariance(1e-40)):
        settings = settings_of(bounds=bounds, theta_0=bounds.center, update=update)
        run = rn.simulate(PLANT, settings, noise(2, 100, 1))
        assert run.bounded > 0
        assert all(exact_square(bounds, theta) <= 1 for theta in run.theta)
