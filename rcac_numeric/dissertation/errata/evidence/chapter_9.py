"""Chapter 9 as it is printed: what its proposals need."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rcac_numeric.arrays.array_types import Array

Facts = Iterator[tuple[str, bool]]


def null_space() -> Facts:
    """The regressor of (theta, d) for y = z, N_f = q^-1 and random u, y: its null dimension."""
    rng = np.random.default_rng(0)
    u, y = rng.standard_normal((2, 400))
    for n_p in (1, 2, 4):
        columns = [_lagged(signal, i + 1) for signal in (u, y) for i in range(1, 9)]
        columns += [_lagged(y, i) for i in range(1, n_p + 1)]
        regressor = np.column_stack(columns)[20:]
        null = regressor.shape[1] - int(np.linalg.matrix_rank(regressor))
        yield f"for n_p = {n_p} it is {n_p - 1}", null == n_p - 1


def perturbation_needs_a_fixed_theta() -> Facts:
    """The map from u~ to z for u = theta z(k-1) + u~, with one theta and with a moving one."""
    rng = np.random.default_rng(1)
    z, u = np.zeros(60), rng.standard_normal(60)
    for k in range(1, 60):
        z[k] = 0.5 * z[k - 1] + u[k - 1]
    fixed = u - 0.1 * np.roll(z, 1)
    moving = u - np.where(np.arange(60) < 30, 0.1, -0.4) * np.roll(z, 1)
    yield "with one theta z follows from u~ through G_zu~", _residual(z, fixed, 0.1) < 1e-12
    yield "with the theta of each step it does not", _residual(z, moving, 0.1) > 0.1


def zero_direction() -> Facts:
    """G_f = q^-1 (I - z_0 q^-1 eta eta') and q^-1 (1 - z_0 q^-1) I at z_0 = 3/2."""
    z_0, eta = 1.5, np.array([0.6, 0.8])

    def directed(q: float) -> Array:
        value: Array = (np.eye(2) - z_0 / q * np.outer(eta, eta)) / q
        return value

    def in_both(q: float) -> Array:
        value: Array = (1 - z_0 / q) / q * np.eye(2)
        return value

    lost = eta @ directed(z_0)
    yield "the first has eta'G_f(z_0) = 0", bool(np.abs(lost).max() < 1e-15)
    yield "and loses no other direction", np.linalg.matrix_rank(directed(z_0), 1e-9) == 1
    yield "the second loses both", np.linalg.matrix_rank(in_both(z_0), 1e-9) == 0


def _lagged(signal: Array, by: int) -> Array:
    late: Array = np.roll(signal, by)
    return late


def _residual(z: Array, perturbation: Array, theta: float) -> float:
    """Of z(k) = (0.5) z(k-1) + theta z(k-2) + u~(k-1), the loop with that theta."""
    made = 0.5 * z[1:-1] + theta * z[:-2] + perturbation[1:-1]
    return float(np.abs(z[2:] - made).max())
