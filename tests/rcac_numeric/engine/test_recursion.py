"""The recursion against the batch minimiser of (2.41), and its signal alignment."""

import numpy as np
import pytest
from flint import arb, arb_mat, ctx
from hypothesis import given
from hypothesis import strategies as st

from rcac_numeric import UD, Controller, ControllerSettings, Covariance, TargetModel, fir, iir
from rcac_numeric.arrays._values import replaced as replace
from tests.support.strategies import controllers, seeds, sizes


def regressors(settings, u, y):
    """Phi(k) of (2.30) for every step, written from the text and not from the taps."""
    structure = settings.structure
    has_u = structure.name == "IIR"
    k_c = structure.n_c + 1 - (structure.l_theta // structure.l_u - has_u * structure.l_u
                               * structure.n_c) // structure.l_y  # fmt: skip
    for k in range(len(u)):
        past_u = [u[k - i] if k >= i else 0 * u[0] for i in range(1, structure.n_c + 1)]
        past_y = [y[k - i] if k >= i else 0 * y[0] for i in range(k_c, structure.n_c + 1)]
        phi = np.concatenate((past_u if has_u else []) + past_y)
        yield np.kron(phi, np.eye(structure.l_u))


def filtered(settings, inputs):
    """G_f of a sequence of matrices, zero before k_filter."""
    N, D = settings.target.numerator, settings.target.denominator
    observed = [v if k >= settings.k_filter else 0 * v for k, v in enumerate(inputs)]
    out = []
    for k in range(len(observed)):
        value = sum(N[i] @ observed[k - i] for i in range(min(k, len(N) - 1) + 1))
        value = value - sum(D[i] @ out[k - i] for i in range(1, min(k, len(D) - 1) + 1))
        out.append(value)
    return out


def batch_minimiser(settings, u, y, z):
    """argmin of (2.41) by its normal equations in 300-bit ball arithmetic."""
    Phi_f = filtered(settings, list(regressors(settings, u, y)))
    u_f = filtered(settings, list(u[:, :, None]))
    R_z, R_theta = settings.R_z, settings.update.R_theta
    start, steps = settings.k_update, len(u)
    precision, ctx.prec = ctx.prec, 300
    try:
        balls = lambda a: arb_mat(*np.shape(a), [arb(float(v)) for v in np.ravel(a)])  # noqa: E731
        lam = arb(settings.update.lambda_)
        H = balls(R_theta) * lam ** max(steps - start, 0)
        g = H * balls(settings.theta_0[:, None])
        for i in range(start, steps):
            F, weight = balls(Phi_f[i]), lam ** (steps - 1 - i)
            R_u = settings.R_u(i, y[i], z[i], u[i]) if callable(settings.R_u) else settings.R_u
            H += F.transpose() * balls(R_z + R_u) * F * weight
            g -= F.transpose() * balls(R_z) * (balls(z[i][:, None]) - balls(u_f[i])) * weight
        return np.array([float(v.mid()) for v in H.solve(g).entries()])
    finally:
        ctx.prec = precision


@given(st.data(), sizes, sizes, sizes, seeds)
def test_recursion_is_the_batch_minimiser(data, l_u, l_y, l_z, seed):
    settings = data.draw(controllers(l_u, l_y, l_z))
    rng = np.random.default_rng(seed)
    y, z = 0.3 * rng.standard_normal((12, l_y)), rng.standard_normal((12, l_z))
    for kind in (UD, Covariance):
        chosen = replace(
            settings, update=kind(settings.update.R_theta, lambda_=settings.update.lambda_)
        )
        controller = Controller(chosen)
        u = np.array([controller.step(*signals) for signals in zip(y, z, strict=True)])
        exact = batch_minimiser(chosen, u, y, z)
        # The data grow with u; so does what a rounding error of the data does to theta.
        scale = np.abs(exact).max() * max(1.0, np.abs(u).max() ** 2)
        assert np.abs(controller.theta - exact).max() <= 1e-12 * scale


def test_each_z_is_paired_with_the_u_that_caused_it():
    """With G_f = h/q^2 the residual at step k is z(k) + h (phi(k-2) theta - u(k-2))."""
    h, weight = -1.7, 0.3
    settings = ControllerSettings(
        structure=fir(1), target=TargetModel([0, 0, h]), update=UD(R_theta=weight), k_w=2
    )
    y = np.array([1.0, -2.0, 3.0, 0.5, -1.5, 2.5])
    z = np.array([0.3, 0.7, -1.1, 1.3, 0.9, -0.4])
    controller, theta, u = Controller(settings), 0.0, []
    for k in range(len(y)):
        # The control of step k comes from y(k-1) and the data of steps 2, ..., k-1.
        u.append(y[k - 1] * theta if k >= 2 else 0.0)
        assert controller.step(y[k], z[k]) == pytest.approx([u[k]], abs=1e-15)
        rows = [(h * (y[i - 3] if i >= 3 else 0.0), z[i] - h * u[i - 2]) for i in range(2, k + 1)]
        theta = -sum(f * t for f, t in rows) / (weight + sum(f * f for f, _ in rows))
        assert controller.theta == pytest.approx([theta], rel=1e-13, abs=1e-15)
    assert abs(theta) > 0.05


@given(st.data(), sizes, sizes, seeds)
def test_a_weight_may_depend_on_the_performance(data, l_u, l_z, seed):
    settings = data.draw(controllers(l_u, 1, l_z))
    rng = np.random.default_rng(seed)
    y, z = 0.3 * rng.standard_normal((10, 1)), rng.standard_normal((10, l_z))
    varying = replace(settings, R_u=lambda k, y, z, u: 0.5 * (z @ z) * np.eye(len(z)))
    controller = Controller(varying)
    u = np.array([controller.step(*signals) for signals in zip(y, z, strict=True)])
    exact = batch_minimiser(varying, u, y, z)
    scale = np.abs(exact).max() * max(1.0, np.abs(u).max() ** 2)
    assert np.abs(controller.theta - exact).max() <= 1e-12 * scale


@given(seeds)
def test_the_covariance_is_the_inverse_information(seed):
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((4, 4))
    R_theta = root @ root.T + np.eye(4)
    for kind in (UD, Covariance):
        settings = ControllerSettings(
            structure=iir(2),
            target=TargetModel([0.0, 1.0]),
            update=kind(R_theta=(R_theta + R_theta.T) / 2),
        )
        inverse = np.linalg.inv(R_theta)
        assert pytest.approx(inverse, rel=1e-10, abs=1e-12) == Controller(settings).P
