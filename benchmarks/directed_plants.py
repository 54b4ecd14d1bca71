"""Target models with zero directions on random plants: J over LQG's, seed of plants by seed.

Square plants G = diag(1/d_i) (q I - X) H, two poles in (-0.5, 0.85) for each output, NMP zeros of
modulus 1.1 to 1.8 at eigenvalues of X, H and the eigenvectors Gaussian; w matched with u.

    .venv/bin/python benchmarks/directed_plants.py [plants] [size] [kind] [seed ...]

with the kinds "one real", "complex pair" and "two real".
"""

import sys

import numpy as np
from yardsticks.directed_plants import cost_ratio, random_plant

from rcac_numeric.targets import zero_direction_target


def ratio(plant, **settings):
    """J of the last controller over LQG's: inf where its loop is unstable, nan if unbounded."""
    return cost_ratio(plant, zero_direction_target(plant), **settings)


def main(plants="100", size="2", kind="one real", *seeds):
    """Prints, for each seed, how many are bounded, how many at most 1.01, and what is lost."""
    for seed in map(int, seeds or ("911",)):
        rng, costs = np.random.default_rng(seed), []
        for number in range(int(plants)):
            plant, (poles, _, X, V) = random_plant(rng, int(size), kind)
            costs.append(ratio(plant))
            if not costs[-1] <= 1.01:
                zeros = np.array([z for z in np.linalg.eigvals(X) if abs(z) > 1])
                again = [ratio(plant, steps=300000), ratio(plant, R_theta=1e-5)]
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
