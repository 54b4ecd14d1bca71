"""Long runs and small R_theta: what can be trusted, digit by digit."""

import numpy as np
import pytest
from scipy import signal

import rcac_numeric as rn
from rcac_numeric.arrays._values import replaced as replace
from tests.support.dissertation_plants import PLANT_4_1
from tests.support.examples import EXAMPLE_4_6, EXAMPLE_4_7, EXAMPLE_4_8


def split(row, inputs):
    """Leading coefficient, relative degree, zeros inside and outside the unit circle."""
    numerator = signal.ss2tf(PLANT_4_1.A, inputs, row, np.zeros((1, 1)))[0][0]
    degree = int(np.flatnonzero(np.abs(numerator) > 1e-9)[0])
    zeros = np.roots(numerator[degree:])
    return numerator[degree], degree, zeros[np.abs(zeros) < 1], zeros[np.abs(zeros) > 1]


def targets_of_4_1():
    """High authority (4.24), with d_yw in its power of q and monic reflections; FIR (2.50)."""
    H, d_zu, _, outside = split(PLANT_4_1.E_1, PLANT_4_1.B)
    _, d_yw, inside_yw, outside_yw = split(PLANT_4_1.C, PLANT_4_1.D_1)
    top = H * np.real(np.poly(outside))
    bottom = np.real(np.poly([*(1 / outside), *inside_yw, *(1 / outside_yw)]))
    power = PLANT_4_1.n - d_zu - d_yw
    padded = np.concatenate([top, np.zeros(power)])  # descending powers of q
    high = rn.TargetModel(np.concatenate([np.zeros(len(bottom) - len(padded)), padded]), bottom)
    return high, rn.TargetModel(np.concatenate([np.zeros(d_zu), top]))


def example(name, k_w):
    """(plant, settings, w) with 200 steps."""
    if name.startswith("4.1"):
        high, fir = targets_of_4_1()
        structure, target = (rn.iir(5), high) if name == "4.1, n_c = 5" else (rn.iir(20), fir)
        w = 0.1 * np.random.default_rng(0).standard_normal((200, 1))
        return PLANT_4_1, rn.ControllerSettings(
            structure=structure, target=target, update=rn.UD(R_theta=1.0), k_w=k_w
        ), w  # fmt: skip
    loop = {"4.6": EXAMPLE_4_6, "4.7": EXAMPLE_4_7, "4.8": EXAMPLE_4_8}[name]
    return loop.plant, replace(loop.settings, k_w=k_w, k_update=k_w), loop.w(200)


# What the covariance of the text loses at R_theta = 1e-10 and 1e-20; None: little or by luck.
@pytest.mark.costly
@pytest.mark.parametrize(
    ("name", "k_w", "lost_at_1e_10", "lost_at_1e_20"),
    [
        ("4.1, n_c = 5", 50, 1e-11, 1e-4),
        ("4.1, n_c = 20", 50, 1e-9, 1e-4),
        ("4.6", 5, 1e-9, 1e-3),
        ("4.6", 50, None, None),
        ("4.7", 5, 1e-9, 1e-4),
        ("4.7", 50, 1e-12, 1e-10),
        ("4.8", 5, 1e-8, 1e-3),
    ],
)
def test_ud_keeps_ten_digits_for_every_R_theta(name, k_w, lost_at_1e_10, lost_at_1e_20):
    plant, settings, w = example(name, k_w)
    for R_theta, lost in ((1.0, None), (1e-10, lost_at_1e_10), (1e-20, lost_at_1e_20)):
        chosen = replace(settings, update=rn.UD(R_theta=R_theta))
        exact = rn.simulate_reference(plant, chosen, w, digits=400)
        assert 50 < exact.digits < 450
        size = np.abs(exact.theta_final).max()
        run = rn.simulate(plant, chosen, w)
        assert np.abs(run.theta_final - exact.theta_final).max() < 1e-10 * size
        if lost is not None:
            plain = rn.simulate(plant, replace(chosen, update=rn.Covariance(R_theta=R_theta)), w)
            assert (
                plain.outcome != "completed"
                or np.abs(plain.theta_final - exact.theta_final).max() > lost * size
            )


@pytest.mark.costly
@pytest.mark.long
@pytest.mark.parametrize("lambda_", [1.0, 0.9999])
def test_a_million_steps_with_80_coefficients(in_full, lambda_):
    """P stays positive definite, and theta is the batch minimiser of (2.41) to nine digits."""
    steps, n_c = (1_000_000 if in_full else 20_000), 40
    plant = rn.standard_plant("(q - 0.5)/(q^2 - 1.2*q + 0.5)")
    target, R_theta = rn.TargetModel([0, 1.0]), 1e-3
    settings = rn.ControllerSettings(
        structure=rn.iir(n_c),
        target=target,
        update=rn.UD(R_theta=R_theta, lambda_=lambda_),
        k_w=n_c,
    )
    w = np.random.default_rng(1).standard_normal((steps, 1))
    run, state, chunk = None, None, steps // 5
    u, y, z = [], [], []
    for i in range(5):
        run = rn.simulate(
            plant, settings, w[i * chunk : (i + 1) * chunk], start=state, stride=chunk
        )
        state = run.state
        assert run.outcome == "completed" and run.guard_count == 0
        for name, remaining in (("u", u), ("y", y), ("z", z)):
            remaining.append(getattr(run, name)[:, 0])
    u, y, z = (np.concatenate(parts) for parts in (u, y, z))

    # Row i of the cost: z(i) + phi(i-1)' theta - u(i-1), from i = k_update on; G_f = 1/q.
    R, past = np.sqrt(R_theta) * np.eye(2 * n_c), np.zeros(2 * n_c)
    right = past.copy()
    for first in range(n_c, steps, 10_000):
        i = np.arange(first, min(first + 10_000, steps))
        lags = i[:, None] - 1 - np.arange(1, n_c + 1)
        rows = np.concatenate([np.where(lags < 0, 0, s[lags]) for s in (u, y)], axis=1)
        age = lambda_ ** ((len(i) - 1 - np.arange(len(i))) / 2)
        remaining = lambda_ ** (len(i) / 2)
        stacked = np.vstack([remaining * R, age[:, None] * rows])
        goal = np.concatenate([remaining * right, age * (u[i - 1] - z[i])])
        Q, R = np.linalg.qr(stacked)
        right = Q.T @ goal
    theta = np.linalg.solve(R, right)
    assert np.abs(run.theta_final - theta).max() < 1e-9 * np.abs(theta).max()

    controller = rn.Controller(settings)  # the same data once more, to look at P on the way
    for k in range(steps):
        controller.step(y[k], z[k])
        if (k + 1) % (steps // 10) == 0:
            P = controller.P
            scale = 1 / np.sqrt(np.diag(P))
            assert np.isfinite(P).all()
            assert np.linalg.eigvalsh(P * scale * scale[:, None]).min() > 0
    assert np.array_equal(controller.theta, run.theta_final)
    inverse = np.linalg.inv(R)
    assert np.abs(P - inverse @ inverse.T).max() < 1e-7 * P.max()
