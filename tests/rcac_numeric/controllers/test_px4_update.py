"""The update of the PX4 fork, written out from its equations, against the engine with its settings.

Source: the class RCAC of the fork of PX4 by Goel and others, as in "Adaptive digital PID control of
a quadcopter with unknown dynamics" (arXiv:2006.00416): with phi(k) = [z(k), sum z, z(k) - z(k-1)],
    phi_f(k) = N phi(k-2), u_f(k) = N u(k-2), Phi = [phi_f; phi], R = diag(1, R_u),
    P(k+1) = P - P Phi' (R^-1 + Phi P Phi')^-1 Phi P,
    theta(k+1) = theta - P(k+1) (phi_f' (f(z) - u_f + phi_f theta) + R_u phi' phi theta),
    u(k) = phi(k) theta(k+1), from step 4 on, and the error through f before it enters.
"""

import math

import numpy as np
import pytest

import rcac_numeric as rn
from tests.support.signals import noise

# The five functions with mu and nu, as published; the second with mu = nu alone.
FUNCTIONS = {
    "rational": lambda z, mu, nu: mu * nu * z / (mu + nu * abs(z)),
    "arctan": lambda z, mu, nu: 2 * nu / math.pi * math.atan(math.pi * nu * z / (2 * mu)),
    "root": lambda z, mu, nu: mu * nu * z / math.sqrt(mu * mu + nu * nu * z * z),
    "tanh": lambda z, mu, nu: mu * math.tanh(nu * z / mu),
    "erf": lambda z, mu, nu: mu * math.erf(math.sqrt(math.pi) * nu * z / (2 * mu)),
}


def as_published(errors, answer, *, P_0, N, R_u, f, limit, first=4):
    """u and theta of every step; `errors` gives z(k), and `answer` takes u(k)."""
    theta, P = np.zeros(3), P_0 * np.eye(3)
    phis, us, integral, last = [np.zeros(3)] * 3, [0.0, 0.0], 0.0, 0.0
    message = []
    for k, z in enumerate(errors):
        phi = np.array([z, integral, z - last])
        phis, z_f = [phi, *phis[:2]], f(z)
        phi_f, u_f = N * phis[2], N * us[1]
        if k >= first:
            if R_u:
                Phi, R = np.vstack([phi_f, phi]), np.diag([1.0, R_u])
            else:
                Phi, R = phi_f[None], np.eye(1)
            P = P - P @ Phi.T @ np.linalg.solve(np.linalg.inv(R) + Phi @ P @ Phi.T, Phi @ P)
            slope = phi_f * (z_f - u_f + phi_f @ theta) + R_u * phi * (phi @ theta)
            theta = theta - P @ slope
        u = float(phi @ theta)
        us, last = [u, us[0]], z
        integral = min(max(integral + z, -limit), limit)
        message.append((u, *theta))
        answer(u)
    return np.array(message)


class Loop:
    """x(k+1) = A x + b u + d: the errors that the published update asks for, one by one."""

    def __init__(self, w):
        self.x, self.w, self.k = np.zeros(2), w, 0

    def __iter__(self):
        while self.k < len(self.w):
            yield self.x[0]

    def take(self, u):
        x = self.x
        self.x = np.array([1.4 * x[0] + x[1] + 0.8 * u, -0.45 * x[0] - 0.24 * u])
        self.x += np.array([1.0, -0.3]) * self.w[self.k]
        self.k += 1


@pytest.mark.costly
@pytest.mark.parametrize("update", [rn.UD, rn.Covariance])
@pytest.mark.parametrize("R_u", [0.0, 0.01, 1.0])
@pytest.mark.parametrize("name", [None, *FUNCTIONS])
def test_the_engine_runs_the_published_update(name, R_u, update):
    mu = nu = 1.0 if name == "arctan" else 0.7
    nu = nu if name == "arctan" else 1.3
    w = noise(7, 300, 1)[:, 0] / 10 + 0.2
    loop = Loop(w)
    f = (lambda z: z) if name is None else (lambda z: FUNCTIONS[name](z, mu, nu))
    N, limit = 0.8, 0.8
    message = as_published(loop, loop.take, P_0=0.1, N=N, R_u=R_u, f=f, limit=limit)
    settings = rn.ControllerSettings(
        structure=rn.pid(k_c=0, integral_limit=limit),
        target=rn.TargetModel([0, 0, N]),
        update=update(10.0),
        form="filter",
        k_w=4,
        R_u_unfiltered=R_u,
        z_normalization=None if name is None else rn.Normalization(mu, nu, name),
    )
    controller, again, u = rn.Controller(settings), Loop(w), []
    for z in again:
        u.append(float(controller.step(z, z)[0]))
        again.take(u[-1])
    assert 0.05 < np.abs(message[:, 0]).max() < 10
    assert np.abs(np.array(u) - message[:, 0]).max() <= 1e-12 * np.abs(message[:, 0]).max()
    assert np.abs(controller.theta - message[-1, 1:]).max() <= 1e-12 * np.abs(message[:, 1:]).max()
