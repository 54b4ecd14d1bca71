"""Target models with zero directions on random plants: J over LQG's, seed of plants by seed.

Square plants G = diag(1/d_i) (q I - X) H, two poles in (-0.5, 0.85) for each output, NMP zeros of
modulus 1.1 to 1.8 at eigenvalues of X, H and the eigenvectors Gaussian; w matched with u.

    .venv/bin/python benchmarks/directed_plants.py [plants] [size] [kind] [seed ...]

with the kinds "one real", "complex pair" and "two real".
"""

import sys

import numpy as np
import scipy.linalg

from rcac_numeric import (
    UD,
    ControllerSettings,
    Plant,
    WhiteNoise,
    h2_cost,
    iir,
    lqg,
    simulate,
    zero_direction_target,
)


def random_plant(rng, size, kind):
    """A plant, its poles and X."""
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
    A, B, C = np.zeros((2 * size, 2 * size)), np.zeros((2 * size, size)), np.zeros((size, 2 * size))
    for i, (a, b) in enumerate(poles):
        A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[a + b, 1.0], [-a * b, 0.0]]
        B[2 * i], B[2 * i + 1], C[i, 2 * i] = H[i], -(X @ H)[i], 1.0
    return Plant(A=A, B=B, D_1=B, C=C), poles, X, V


def cost_ratio(plant, steps=30000, R_theta=1e-3):
    """J of the last controller over LQG's: inf where its loop is unstable, nan if unbounded."""
    settings = ControllerSettings(
        structure=iir(n_c=8, l_u=plant.l_u, l_y=plant.l_y),
        target=zero_direction_target(plant),
        update=UD(R_theta),
    )
    draws = np.random.default_rng(0).spawn(plant.l_w)
    w = np.column_stack([WhiteNoise(0.01).values(steps, rng) for rng in draws])
    run = simulate(plant, settings, w, stride=steps)
    if run.outcome != "completed":
        return np.nan
    return float(h2_cost(plant, run.compensator).value / lqg(plant).cost.value)


def main(plants="100", size="2", kind="one real", *seeds):
    """Prints, for each seed, how many are bounded, how many at most 1.01, and what is lost."""
    for seed in map(int, seeds or ("911",)):
        rng, costs = np.random.default_rng(seed), []
        for number in range(int(plants)):
            plant, poles, X, V = random_plant(rng, int(size), kind)
            costs.append(cost_ratio(plant))
            if not costs[-1] <= 1.01:
                zeros = np.array([z for z in np.linalg.eigvals(X) if abs(z) > 1])
                again = [cost_ratio(plant, 300000), cost_ratio(plant, R_theta=1e-5)]
                print(
                    f"  seed {seed}, plant {number}: {costs[-1]:.4g}; with ten times the steps "
                    f"{again[0]:.4g}, with R_theta = 1e-5 {again[1]:.4g}; zeros {zeros.round(3)}, "
                    f"cond V = {np.linalg.cond(V):.3g}, largest pole {np.abs(poles).max():.3g}",
                    flush=True,
                )
        J = np.array(costs)
        good, bounded = int(np.sum(J <= 1.01)), int(np.sum(~np.isnan(J)))
        print(
            f"seed {seed}, {size} x {size}, {kind}: {bounded} of {plants} bounded, {good} at most "
            f"1.01, median {np.nanmedian(J):.5g}, worst {np.nanmax(J):.4g}",
            flush=True,
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
