"""Data-driven RCAC on random plants: how many loops stay bounded, and at what cost over LQG's.

SISO plants of order 2 to 6, y = z, w matched with u; poles of modulus up to 0.95, one or two NMP
zeros of modulus 1.1 to 1.8, the others within 0.95, relative degree 1 or 2. Each plant is run with
its zeros told, with `DataDriven`, and without its zeros.

    .venv/bin/python benchmarks/data_driven_plants.py [plants] [steps] [first seed]
"""

import sys

import numpy as np

from compensator_theory.errors import IllConditionedError
from rcac_numeric import (
    UD,
    ControllerSettings,
    DataDriven,
    ModellingInformation,
    WhiteNoise,
    exogenous,
    fir_target,
    h2_cost,
    iir,
    lqg_controller,
    simulate,
    standard_plant,
)
from rcac_numeric.targets import modelling_information

WAYS = ("told", "data driven", "data driven, replay", "without the zeros")


def roots(rng, count, low, high):
    """Real roots and conjugate pairs with moduli in [low, high]."""
    values = []
    while len(values) < count:
        size = rng.uniform(low, high)
        if count - len(values) > 1 and rng.random() < 0.5:
            angle = rng.uniform(0.2, 2.9)
            values += [size * np.exp(1j * angle), size * np.exp(-1j * angle)]
        else:
            values.append(size * rng.choice([1, 1, 1, -1]))
    return values


def random_plant(seed):
    """A plant as a quotient of decimals, and its NMP zeros."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 7))
    outside = roots(rng, int(rng.integers(1, min(3, n))), 1.1, 1.8)
    inside = roots(rng, max(n - int(rng.integers(1, 3)) - len(outside), 0), 0.0, 0.95)
    quotient = [
        " + ".join(f"({c:.12f})*q**{len(p) - 1 - i}" for i, c in enumerate(p))
        for p in (np.poly(outside + inside).real, np.poly(roots(rng, n, 0.1, 0.95)).real)
    ]
    return standard_plant(f"({quotient[0]})/({quotient[1]})"), outside


def target(way, known, seed):
    """What RCAC is given for a plant."""
    if way == "told":
        return fir_target(known)
    if way == "without the zeros":
        return fir_target(ModellingInformation(known.d_zu, known.H))
    return DataDriven(order=20, seed=seed, covariance="replay" if "replay" in way else "reset")


def cost(plant, compensator):
    """J, and infinity where the loop is not stable beyond rounding."""
    try:
        return float(h2_cost(plant, compensator).value)
    except IllConditionedError:
        return np.inf


def main(plants=100, steps=20000, first=0):
    """Prints the share that is bounded, and the quartiles of J over LQG's."""
    costs = {way: [] for way in WAYS}
    for seed in range(first, first + plants):
        plant, outside = random_plant(seed)
        known, best = modelling_information(plant), lqg_controller(plant).cost.value
        row = []
        for way in WAYS:
            settings = ControllerSettings(
                structure=iir(12), target=target(way, known, seed), update=UD(R_theta=0.1)
            )
            w = exogenous([WhiteNoise(0.01)], steps, seed)
            run = simulate(plant, settings, w, stride=steps)
            bounded = run.outcome == "completed"
            costs[way].append(cost(plant, run.compensator) / best if bounded else np.nan)
            row.append(
                f"{costs[way][-1]:.4g} ({np.abs(run.z).max(initial=0):.1g}, {len(run.changes)})"
            )
        zeros = ", ".join(f"{z:.3g}" if np.imag(z) else f"{np.real(z):.3g}" for z in outside)
        print(seed, f"n = {plant.n}, d = {known.d_zu}, zeros {zeros}:", "; ".join(row), flush=True)
    for way in WAYS:
        J = np.array(costs[way])
        stable = J[np.isfinite(J)]
        quartiles = np.quantile(stable, [0.5, 0.9, 1.0]) if stable.size else []
        print(
            f"{way}: {np.count_nonzero(~np.isnan(J))} of {plants} bounded, {stable.size} with a "
            f"stable last loop, J median, 90 %, worst: {np.round(quartiles, 4)}"
        )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
