"""Forgetting that does not wind up: against its formula on dense matrices, and over 10^6 steps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rcac_numeric as rn
from compensator_theory import InputError
from rcac_numeric.compiled import _kernel
from tests.support.engine_cases import positive
from tests.support.strategies import seeds, sizes

L, NOISE, BEFORE, AFTER = 20, 0.01, 1000, 3000


def replayed(update, rows, target, lambda_, P_0, theta_0=None):
    l_z = rows.shape[1]
    return _kernel.replay_updates(
        update, rows, target, R_z=np.eye(l_z), R_u=np.zeros((l_z, l_z)), forgetting=lambda_,
        P_0=P_0, theta_0=np.zeros(rows.shape[2]) if theta_0 is None else theta_0,
    )  # fmt: skip


def dense(rows, target, lambda_, P_0):
    """The docstring of `SubspaceForgetting`, on full matrices with inverses."""
    _, l_z, size = rows.shape
    theta, P, R_theta = np.zeros(size), P_0, np.linalg.inv(P_0)
    lambda_d = max(0.5, 1 - size / l_z * (1 - lambda_))
    for step, goal in zip(rows, target, strict=True):
        for phi, value in zip(step, goal, strict=True):
            q, f = phi @ np.linalg.solve(P, phi), phi @ R_theta @ phi
            if f > 0:
                P = P + np.outer(phi, phi) * min(
                    (1 - lambda_d) / (lambda_d * q), max(0.0, 1 / f - 1 / q)
                )
            gain = P @ phi / (1 + phi @ P @ phi)
            theta = theta - gain * (value + phi @ theta)
            P = P - np.outer(gain, phi @ P)
    return theta, P


@given(st.integers(1, 11), sizes, st.sampled_from([1.0, 0.999, 0.99, 0.9]), st.booleans(), seeds)
def test_the_factors_do_what_the_formula_says(size, l_z, lambda_, diagonal, seed):
    rng = np.random.default_rng(seed)
    rows, target = rng.standard_normal((40, l_z, size)), rng.standard_normal((40, l_z))
    rows[20:, :, : size // 2] = 0  # directions without excitation
    rows[30] = 0
    P_0 = np.eye(size) if diagonal else np.eye(size) + positive(rng, size)
    theta, P, *_ = replayed("ud, subspace", rows, target, lambda_, P_0)
    theta_2, P_2 = dense(rows, target, lambda_, P_0)
    assert np.allclose(theta, theta_2, rtol=1e-9, atol=1e-10)
    assert np.allclose(P, P_2, rtol=1e-9, atol=1e-10 * np.abs(P_2).max())


@given(st.integers(2, 9), st.floats(-150, 150), seeds)
def test_no_direction_becomes_less_certain_than_at_first(size, exponent, seed):
    """Whatever the scale: phi' P^-1 phi >= phi' R_theta phi after each forgetting."""
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((3000, 1, size)) * 10.0**exponent
    _, P, _, _, finite = replayed("ud, subspace", rows, np.zeros((3000, 1)), 0.9, np.eye(size))
    assert finite and np.linalg.eigvalsh(P).max() <= 3.0


def poor_rows(kind, count, rng):
    if kind == "zero":
        return np.zeros((count, 1, L))
    if kind == "sine":
        k = np.arange(count)[:, None] - np.arange(L)
        return np.sin(0.1 * k)[:, None, :]
    return 1e-8 * rng.standard_normal((count, 1, L))


def identification(update, lambda_, kind, count, seed):
    """(drift, peak, n90) of the notes' experiment: white, `count` poor steps, a jump, white."""
    rng = np.random.default_rng(seed)
    first, second = (v / np.linalg.norm(v) for v in rng.standard_normal((2, L)))
    rows = np.concatenate([rng.standard_normal((BEFORE, 1, L)), poor_rows(kind, count, rng)])
    target = -(rows @ first) + NOISE * rng.standard_normal((len(rows), 1))
    P_0 = 100 * np.eye(L)
    with np.errstate(all="ignore"):
        theta, *_ = replayed(update, rows, target, lambda_, P_0)
        drift = np.linalg.norm(theta - first)
        jump = np.linalg.norm(second - first)
        white = rng.standard_normal((AFTER, 1, L))
        after = -(white @ second) + NOISE * rng.standard_normal((AFTER, 1))
        errors = []
        for more in (1, 3, 10, 20, 40, 80, 300):
            whole, goal = (
                np.concatenate([rows, white[:more]]),
                np.concatenate([target, after[:more]]),
            )
            result, *_ = replayed(update, whole, goal, lambda_, P_0)
            errors.append(np.linalg.norm(result - second) / jump)
    return drift, max(errors), errors[-1]


@pytest.mark.costly
@pytest.mark.parametrize("kind", ["zero", "sine", "tiny"])
def test_nothing_winds_up_while_the_data_are_poor(kind, in_full):
    """Peak <= 1.1, error <= 10 % within 300 steps of the jump, drift <= 0.02."""
    count = 1_000_000 if in_full else 80_000
    drift, peak, error_300 = identification("ud, subspace", 0.99, kind, count, 0)
    assert drift <= 0.02 and peak <= 1.1 and error_300 <= 0.1
    bad = identification("ud", 0.99, kind, count, 0)
    assert not (bad[0] <= 0.02 and bad[1] <= 1.1 and bad[2] <= 0.1)


def closed_loop(lambda_, steps, seed, noise):
    """A lag under a constant disturbance, whose sign and size then change."""
    plant = rn.standard_plant("(1/10*q + 1/20)/((q - 0.9)*(q - 0.7))")
    settings = rn.ControllerSettings(
        structure=rn.iir(n_c=5), target=rn.TargetModel([0, 0.1]),
        update=rn.UD(R_theta=0.01, lambda_=lambda_),
    )  # fmt: skip
    w = np.where(np.arange(steps + 3000) < steps, 0.1, -0.2)[:, None]
    w = w + noise * rn.exogenous([rn.WhiteNoise()], steps + 3000, seed)
    return rn.simulate(plant, settings, w, stride=1000)


@pytest.mark.parametrize("noise", [0, 1e-3])
def test_a_loop_at_rest_still_adapts(noise, in_full):
    """The change costs what it costs without forgetting; exponential forgetting is lost there."""
    steps = 1_000_000 if in_full else 30_000
    run = closed_loop(rn.SubspaceForgetting(0.99), steps, 0, noise)
    assert run.outcome == "completed" and np.abs(run.z[steps:]).max() <= 1
    assert np.abs(run.z[-500:]).max() <= 1e-9 + 10 * noise
    bad = closed_loop(0.99, steps, 0, noise)
    assert bad.outcome != "completed" or np.abs(bad.z[steps:]).max() > 100


def test_only_ud_forgets_so_and_the_reference_says_that_it_does_not():
    with pytest.raises(InputError, match="process_noise"):
        rn.UD(1.0, lambda_=rn.SubspaceForgetting(0.9), process_noise=0.1)
    with pytest.raises(InputError, match="use UD"):
        rn.Covariance(1.0, lambda_=rn.SubspaceForgetting(0.9))
    for lambda_ in (0.0, 1.5, "a"):
        with pytest.raises(InputError):
            rn.SubspaceForgetting(lambda_)
    plant = rn.standard_plant("1/(q - 0.5)")
    settings = rn.ControllerSettings(
        structure=rn.iir(1),
        target=rn.TargetModel([0, 1]),
        update=rn.UD(1.0, lambda_=rn.SubspaceForgetting(0.9)),
    )
    with pytest.raises(InputError, match="does not know the forgetting SubspaceForgetting"):
        rn.simulate_reference(plant, settings, np.zeros((3, 1)))
    controller = rn.Controller(settings)
    controller.set_lambda(0.99)
    twin = rn.Controller(
        rn.ControllerSettings(
            structure=rn.iir(1), target=rn.TargetModel([0, 1]),
            update=rn.UD(1.0, lambda_=rn.SubspaceForgetting(0.99)),
        )
    )  # fmt: skip
    for k in range(20):
        assert controller.step(k % 3, k % 2) == twin.step(k % 3, k % 2)
