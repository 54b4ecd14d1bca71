"""(Phi theta)' R (Phi theta) beside the filtered penalty: rows of its own, and the rule of H^2."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from rcac_numeric import (
    UD,
    Controller,
    ControllerChange,
    ControllerSettings,
    JointUD,
    Plant,
    SignalWeight,
    SlidingWindow,
    TargetModel,
    fir,
    iir,
    simulate,
    simulate_reference,
    standard_plant,
)
from tests.support.signals import noise
from tests.support.strategies import seeds

EPS = np.finfo(float).eps
PLANT = standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")


def settings_of(**more):
    argument = {"structure": iir(3), "target": TargetModel([0, 1.0, -0.3]), "update": UD(0.1)}
    return ControllerSettings(**{**argument, **more})


def regressors(u, y, n):
    """phi(k) of an IIR structure, (2.30), with zeros before the beginning."""
    past = lambda s, k, i: s[k - i, 0] if k >= i else 0.0  # noqa: E731
    return np.array([[v for s in (u, y) for v in (past(s, k, i) for i in range(1, n + 1))]
                     for k in range(len(u))])  # fmt: skip


def information_and_theta(u, y, z, r, first=3, n=3, R_theta=0.1, taps=(0, 1.0, -0.3)):
    """Batch least squares of both rows of every step from `first` on, and what rounding may do.

    Whoever sums the normal equations, (R_theta I + A'A) theta = A'b, row by row is off by rows x
    eps x |A| (|A| |theta| + |b|) on their right, and by that over the least eigenvalue in theta.
    """
    phi, steps = regressors(u, y, n), len(u)
    delayed = lambda s, i: np.vstack([np.zeros((i, s.shape[1])), s[: steps - i]])  # noqa: E731
    phi_f = sum(c * delayed(phi, i) for i, c in enumerate(taps))
    u_f = sum(c * delayed(u, i) for i, c in enumerate(taps))
    A = np.vstack([phi_f[first:], np.sqrt(r) * phi[first:]])
    b = np.concatenate([(u_f - z)[first:, 0], np.zeros(steps - first)])
    information = R_theta * np.eye(2 * n) + A.T @ A
    theta = np.linalg.solve(information, A.T @ b)
    size = np.linalg.norm(A, 2)
    least = np.linalg.eigvalsh(information)[0]
    resolution = len(A) * EPS * size * (size * np.linalg.norm(theta) + np.linalg.norm(b)) / least
    return information, theta, resolution


@given(seeds, st.floats(1e-3, 10))
def test_it_is_a_row_of_its_own_in_every_step(seed, r):
    run = simulate(PLANT, settings_of(R_u_unfiltered=r), noise(seed, 60, 1))
    _, theta, resolution = information_and_theta(run.u, run.y, run.z, r)
    assert np.linalg.norm(run.theta_final - theta) <= resolution


@given(seeds, st.floats(0.1, 10), st.floats(0.01, 10), st.floats(0.1, 5))
def test_the_two_penalties_are_one_up_to_H_squared(seed, H, r, R_theta):
    """With G_f = H q^-1 the filtered row of step k + 1 is H times the unfiltered one of step k.

    The data are those of an open loop, so that both see the same, and Phi is zero at the last step.
    """
    w = noise(seed, 40, 1)
    w[-3:] = 0.0
    plant = standard_plant("1/q")
    common = {
        "structure": fir(1), "target": TargetModel([0, H]), "update": UD(R_theta), "k_w": 10**6,
        "k_update": 1,
    }  # fmt: skip
    unfiltered = simulate(plant, ControllerSettings(**common, R_u_unfiltered=r), w)
    filtered = simulate(plant, ControllerSettings(**common, R_u=r / H**2), w)
    assert unfiltered.y[-2, 0] == 0 and unfiltered.theta_final[0] != 0
    assert np.allclose(unfiltered.theta_final, filtered.theta_final, rtol=1e-10)
    other = simulate(plant, ControllerSettings(**common, R_u=2 * r / H**2), w)
    assert not np.allclose(unfiltered.theta_final, other.theta_final, rtol=1e-10)


def test_a_penalty_set_live_is_that_of_the_settings():
    built, bare = settings_of(R_u_unfiltered=0.5), settings_of()
    run = simulate(PLANT, built, noise(1, 50, 1))
    controller = Controller(bare)
    controller.set_weights(R_u_unfiltered=0.5)
    u = [controller.step(y, z) for y, z in zip(run.y, run.z, strict=True)]
    assert np.array_equal(u, run.u)
    # And back to none: what comes after is a controller that never had one in those steps.
    changes = {20: ControllerChange(R_u_unfiltered=0.5), 21: ControllerChange(R_u_unfiltered=0)}
    hook = {"on_step": lambda run: changes.get(run.first_step + run.steps)}
    w = noise(1, 50, 1)
    whole = simulate(PLANT, bare, w, **hook)
    first = simulate(PLANT, bare, w[:21], **hook)
    rest = simulate(PLANT, bare, w[21:], start=first.state, **hook)
    assert np.array_equal(whole.u, np.vstack([first.u, rest.u]))
    assert rest.state.values.tobytes() == whole.state.values.tobytes()
    plain = simulate(PLANT, bare, w)
    assert np.array_equal(plain.u[:21], whole.u[:21])
    assert not np.array_equal(plain.u[21:], whole.u[21:])


def test_a_replay_has_the_rows_of_control_too():
    settings, steps = settings_of(R_u_unfiltered=0.4), 50
    run = simulate(PLANT, settings, noise(2, steps, 1))
    controller = Controller(settings)
    for y, z in zip(run.y, run.z, strict=True):
        controller.step(y, z)
    taps = (0, 0.7, 0.2)
    controller.set_target(TargetModel(taps), covariance="replay")
    information, _, _ = information_and_theta(run.u, run.y, run.z, 0.4, taps=taps)
    size = np.linalg.norm(information)
    rounding = steps * EPS * np.linalg.cond(information) * size
    assert np.linalg.norm(np.linalg.inv(controller.P) - information) <= rounding < 1e-6 * size


def test_a_window_is_the_batch_of_its_rows():
    settings = settings_of(update=SlidingWindow(0.1, window=1000), R_u_unfiltered=0.4)
    run = simulate(PLANT, settings, noise(3, 40, 1))
    _, theta, resolution = information_and_theta(run.u, run.y, run.z, 0.4)
    assert np.linalg.norm(run.theta_final - theta) <= resolution


def test_a_semidefinite_weight_of_two_inputs_penalises_its_direction_alone():
    """R = s s' leaves the inputs free across s."""
    one = [[1.0]]
    plant = Plant(A=[[0.9]], B=[[1.0, 0.5]], C=one, D_1=one, E_1=one)
    settings = ControllerSettings(
        structure=iir(1, l_u=2), target=TargetModel([[[0, 0]], [[1.0, 0.5]]]), update=UD(1e-3),
        R_u_unfiltered=1e4 * np.array([[1.0, -1.0], [-1.0, 1.0]]),
    )  # fmt: skip
    run = simulate(plant, settings, noise(4, 300, 1))
    late = run.u[100:]
    assert np.abs(late[:, 0] - late[:, 1]).max() < 1e-2 * np.abs(late).max()
    with pytest.raises(InputError, match="positive definite"):
        simulate_reference(plant, settings, noise(4, 5, 1))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: settings_of(R_u_unfiltered=-1.0), "R_u_unfiltered"),
        (lambda: settings_of(R_u_unfiltered=np.eye(2)), "R_u_unfiltered"),
        (lambda: settings_of(R_u_unfiltered=[[np.nan]]), "R_u_unfiltered"),
        (
            lambda: settings_of(update=JointUD(1.0, n_d=1, rho=1.0), R_u_unfiltered=1.0),
            "JointUD penalises D_f",
        ),
        (
            lambda: Controller(settings_of(update=SlidingWindow(1.0, window=3))).set_weights(
                R_u_unfiltered=1.0
            ),
            "holds no rows for R_u_unfiltered",
        ),
        (lambda: Controller(settings_of()).set_weights(R_u_unfiltered=np.eye(2)), "unfiltered"),
        (
            lambda: Controller(settings_of()).set_weights(R_u_unfiltered=SignalWeight(1.0)),
            "must be constant",
        ),
    ],
)
def test_what_is_no_such_weight_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
