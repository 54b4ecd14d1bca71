"""Random plants with several inputs and outputs whose NMP zeros and directions are prescribed."""

import numpy as np
import scipy.linalg

from rcac_numeric import (
    UD,
    ControllerSettings,
    Plant,
    WhiteNoise,
    h2_cost,
    iir,
    lqg_controller,
    simulate,
)


def plant_of_fractions(poles, H, X):
    """G = diag(1/d_i) (q I - X) H with d_i = (q - p_i1)(q - p_i2): zeros at the eigenvalues of X.

    The left eigenvectors of X are the directions of the left numerator; those of G are
    eta_i d_i(z0). Noise enters where the control does.
    """
    p, first = len(poles), -X @ H
    A, B, C = np.zeros((2 * p, 2 * p)), np.zeros((2 * p, p)), np.zeros((p, 2 * p))
    for i, (a, b) in enumerate(poles):
        A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[a + b, 1.0], [-a * b, 0.0]]
        B[2 * i], B[2 * i + 1], C[i, 2 * i] = H[i], first[i], 1.0
    return Plant(A=A, B=B, D_1=B, C=C)


def random_plant(rng, size, kind):
    """Poles in (-0.5, 0.85), NMP zeros of modulus 1.1 to 1.8, H and the eigenvectors Gaussian."""
    poles = rng.uniform(-0.5, 0.85, (size, 2))
    H = rng.standard_normal((size, size))
    radii = rng.uniform(1.1, 1.8, 2)
    if kind == "complex pair":
        angle = rng.uniform(0.2, 2.9)
        c, s = radii[0] * np.cos(angle), radii[0] * np.sin(angle)
        outside = np.array([[c, -s], [s, c]])
    else:
        count = {"one real": 1, "two real": 2}[kind]
        outside = np.diag(radii[:count] * rng.choice([-1, 1], count))
    inside = np.diag(rng.uniform(-0.8, 0.8, size - len(outside)))
    V = rng.standard_normal((size, size))
    X = V @ scipy.linalg.block_diag(outside, inside) @ np.linalg.inv(V)
    return plant_of_fractions(poles, H, X), (poles, H, X, V)


def cost_ratio(plant, target, seed=0, steps=30000, R_theta=1e-3, n_c=8):
    """J of the last controller over LQG's: inf where its loop is unstable, nan if unbounded."""
    settings = ControllerSettings(
        structure=iir(n_c=n_c, l_u=plant.l_u, l_y=plant.l_y), target=target, update=UD(R_theta)
    )
    draws = np.random.default_rng(seed).spawn(plant.l_w)
    w = np.column_stack([WhiteNoise(0.01).values(steps, rng) for rng in draws])
    run = simulate(plant, settings, w, stride=steps)
    if run.outcome != "completed":
        return np.nan
    return float(h2_cost(plant, run.compensator).value / lqg_controller(plant).cost.value)
