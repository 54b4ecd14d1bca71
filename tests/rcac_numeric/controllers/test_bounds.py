"""Bounds on theta: the minimiser in the metric of P by enumeration, and clipping."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from tests.support.signals import noise
from tests.support.strategies import seeds

PLANT = rn.standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")


def settings_of(**more):
    argument = {"structure": rn.iir(2), "target": rn.TargetModel([0, 1.0]), "update": rn.UD(0.05)}
    return rn.ControllerSettings(**{**argument, **more})


def nearest(theta, P, low, high):
    """The minimiser of (t - theta)' P^-1 (t - theta) in the box, by trying all active sets."""
    M, best, cost = np.linalg.inv(P), None, np.inf
    for sides in product((None, 0, 1), repeat=len(theta)):
        values = np.array([side is not None for side in sides])
        t = theta.astype(float).copy()
        t[values] = [(low, high)[side][i] for i, side in enumerate(sides) if side is not None]
        if not np.isfinite(t).all():
            continue
        free = ~values
        if free.any() and values.any():
            t[free] -= np.linalg.solve(
                M[np.ix_(free, free)], M[np.ix_(free, values)] @ (t - theta)[values]
            )
        value = (t - theta) @ M @ (t - theta)
        if (t >= low - 1e-12).all() and (t <= high + 1e-12).all() and value < cost:
            best, cost = t, value
    return best


def recursion(theta, P, phi_f, target):
    """(2.42)-(2.45) for one row."""
    gain = P @ phi_f / (1 + phi_f @ P @ phi_f)
    return theta - gain * (phi_f @ theta + target), P - np.outer(gain, phi_f @ P)


R_THETA = np.array([[0.1, 0.03, 0, 0], [0.03, 0.1, 0, 0.02], [0, 0, 0.2, 0], [0, 0.02, 0, 0.05]])


@pytest.mark.parametrize(
    "update",
    [rn.UD(0.05), rn.Covariance(0.05), rn.Covariance(R_THETA), rn.Instantaneous(R_THETA)], ids=repr,
)  # fmt: skip
@pytest.mark.parametrize("method", ["metric", "clip"])
def test_every_update_ends_in_the_nearest_point(method, update):
    low, high = np.array([-0.1, -0.05, -np.inf, 0.0]), np.array([0.2, 0.3, 0.02, np.inf])
    bounds = rn.CoefficientBounds(low, high, method=method, sweeps=10_000)
    settings = settings_of(bounds=bounds, update=update)
    run = rn.simulate(PLANT, settings, noise(1, 60, 1))
    controller, moved, together = rn.Controller(settings), 0, 0
    u, y, z = run.u[:, 0], run.y[:, 0], run.z[:, 0]
    for k in range(60):
        theta, P = controller.theta, controller.P
        controller.step(y[k], z[k])
        if k < settings.k_update:
            continue
        past = lambda s, i, k=k: s[k - i] if k >= i else 0.0  # noqa: E731
        phi_f = np.array([past(s, i) for s in (u, y) for i in (2, 3)])
        free, P = recursion(theta, P, phi_f, z[k] - past(u, 1))
        if isinstance(update, rn.Instantaneous):
            P = np.linalg.inv(R_THETA)
        expected = np.clip(free, low, high) if method == "clip" else nearest(free, P, low, high)
        assert np.allclose(controller.theta, expected, rtol=1e-7, atol=1e-9), k
        outside = (free < low) | (free > high)
        moved += outside.any()
        together += method == "metric" and not np.allclose(expected, np.clip(free, low, high))
    assert run.bounded == moved > 10
    assert method == "clip" or together > 3  # the other coefficients did move


@given(seeds, st.floats(0.001, 0.2), st.integers(1, 3), st.sampled_from(["metric", "clip"]))
def test_theta_never_leaves_its_box(seed, size, sweeps, method):
    bounds = rn.CoefficientBounds(-size, 2 * size, method=method, sweeps=sweeps)
    run = rn.simulate(PLANT, settings_of(structure=rn.iir(4), bounds=bounds), noise(seed, 50, 1))
    for theta in (*run.theta, run.theta_final):
        assert (theta >= -size).all() and (theta <= 2 * size).all()


@pytest.mark.parametrize("method", ["metric", "clip"])
def test_bounds_that_are_never_met_change_nothing(method):
    plain, w = rn.simulate(PLANT, settings_of(), noise(2, 200, 1)), noise(2, 200, 1)
    wide = rn.CoefficientBounds(-1e3, 1e3, method=method)
    run = rn.simulate(PLANT, settings_of(bounds=wide), w)
    assert np.array_equal(run.u, plain.u) and run.bounded == 0
    assert "bounds" not in rn.loop_health(run).report()
    tight = rn.simulate(PLANT, settings_of(bounds=rn.CoefficientBounds(-0.01, 0.01)), w)
    words = f"theta was limited in {tight.bounded} of 200 steps"
    assert words in rn.loop_health(tight).report()


def test_where_bounds_hold_theta_they_and_no_failure_say_where_the_poles_are():
    target = rn.TargetModel([0.0, 1.0], [1.0, -1.2, 0.4])
    stored, free = (
        rn.loop_health(
            rn.simulate(
                PLANT, settings_of(target=target, update=rn.UD(5.0), **bounds), noise(2, 200, 1)
            )
        )
        for bounds in ({"bounds": rn.CoefficientBounds(-0.01, 0.01)}, {})
    )
    assert stored.is_held and not free.is_held and min(stored.missed_by, free.missed_by) > 0.01
    codes = [{one.code for one in health.warnings} for health in (stored, free)]
    assert "missed poles" not in codes[0] and "missed poles" in codes[1]
    assert "the bounds decide the poles" in stored.report()
    assert "they decide" not in free.report()


def test_bounds_by_name():
    names = rn.coefficient_names(rn.pid(l_u=2, l_y=2))
    assert names == ("K_P",) * 4 + ("K_I",) * 4 + ("K_D",) * 4
    bounds = rn.CoefficientBounds(gains={"K_I": (0, 3.5)})
    low, high = bounds.box(rn.pid(l_u=2, l_y=2))
    assert low.tolist() == [-np.inf] * 4 + [0.0] * 4 + [-np.inf] * 4
    assert high.tolist() == [np.inf] * 4 + [3.5] * 4 + [np.inf] * 4
    low, _ = rn.CoefficientBounds(-1.0, gains={"Q": (0, None), "Q_2": (-2, None)}).box(rn.iir(2))
    assert low.tolist() == [-1.0, -1.0, 0.0, -2.0]
    low, high = rn.CoefficientBounds(gains={"K_1": (None, 1)}).box(rn.fir_integrator(2))
    assert high.tolist() == [np.inf, np.inf, 1.0]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (rn.CoefficientBounds, "nothing is bounded"),
        (
            lambda: rn.CoefficientBounds([[1.0]]),
            "low = .* of the bounds must be a number or a list",
        ),
        (lambda: rn.CoefficientBounds("x"), "must be an array of numbers"),
        (lambda: rn.CoefficientBounds(np.nan), "low"),
        (lambda: rn.CoefficientBounds(low=np.inf), "-inf stands for none"),
        (lambda: rn.CoefficientBounds(0, method="hard"), "method"),
        (lambda: rn.CoefficientBounds(0, sweeps=0), "sweeps"),
        (lambda: rn.CoefficientBounds(gains={"K_P": 3}), r"\(low, high\) are needed"),
        (lambda: rn.CoefficientBounds(gains={"K_P": (None, None)}), "neither a low nor a high"),
        (lambda: settings_of(bounds=3), "bounds"),
        (lambda: settings_of(bounds=rn.CoefficientBounds([0, 1])), "low has 2 bounds; l_theta = 4"),
        (lambda: rn.CoefficientBounds(1, 0), "coefficient 0 are 1 and 0: low exceeds high"),
        (lambda: rn.CoefficientBounds([0, 2], 1), "coefficient 1 are 2 and 1"),
        (lambda: rn.CoefficientBounds([0, 2], [1, 3, 4]), "low has 2 entries and high 3"),
        (lambda: rn.CoefficientBounds(gains={"P": (2, 1)}), "bounds of P are 2 and 1: low exceeds"),
        (
            lambda: settings_of(bounds=rn.CoefficientBounds(1, 0, gains={"P_2": (-1, 1)})),
            "bounds of P_1 .* low exceeds high",
        ),
        (
            lambda: settings_of(bounds=rn.CoefficientBounds(gains={"K_P": (0, 1)})),
            "no coefficient is called 'K_P'; those of this IIR structure are P_1, P_2, Q_1, Q_2",
        ),
        (lambda: settings_of(bounds=rn.CoefficientBounds(low=1)), r"theta_0\[0\] = 0 is outside"),
        (
            lambda: settings_of(bounds=rn.CoefficientBounds(-1, 1), reflect_poles=True),
            "one of the two",
        ),
        (
            lambda: settings_of(
                bounds=rn.CoefficientBounds(-1, 1), update=rn.JointUD(1.0, n_d=1, rho=1.0)
            ),
            'method = "clip"',
        ),
        (
            lambda: rn.simulate_reference(
                PLANT, settings_of(bounds=rn.CoefficientBounds(-1, 1)), noise(1, 5, 1)
            ),
            'does not know bounds with method = "metric"',
        ),
    ],
)
def test_bounds_that_are_none_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
