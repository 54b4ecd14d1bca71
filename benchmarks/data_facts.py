"""How often what `target_from_data` calls sure is so: relative degree, sign, NMP zeros.

Drawn plants, every second one of benchmarks/design_road.py (time constants of 2 to 50 steps, an
unstable one left out), the others of one to four poles between 0.1 and 0.9 with zeros on both sides
of the circle; a dead time of 0 to 5; 2000 steps of white u, noise of y with a pole at 0.8, its size
3 to 100 times below what u makes of y. The order is given as it is.

    .venv/bin/python benchmarks/data_facts.py [logs] [first seed]
"""

import sys
from collections import Counter

import numpy as np
from design_road import random_plant
from scipy.signal import lfilter, ss2tf

from compensator_theory.errors import CompensatorError
from rcac_numeric import target_from_data
from rcac_numeric.designing._plants import read_plant

STEPS = 2000
ROUNDING = 1e-9  # of the largest coefficient: a numerator's leading coefficients that are none


def plant_of(seed):
    """B and A in powers of q^-1, dead time included."""
    rng = np.random.default_rng([seed, 21])
    late = int(rng.integers(0, 6))
    if seed % 2:
        kind, G, _ = random_plant(seed)
        if kind == "unstable":
            return None
        model = read_plant(G, 1.0, 0.0)
        B, A = ss2tf(model.A, model.B, model.C, np.zeros((1, 1)))
        B = np.where(np.abs(B[0]) > ROUNDING * np.abs(B).max(), B[0], 0.0)
    else:
        n = int(rng.integers(1, 5))
        zeros = [
            rng.uniform(1.1, 3) if rng.random() < 0.4 else rng.uniform(-0.9, 0.9)
            for _ in range(rng.integers(0, n))
        ]
        A = np.poly(rng.uniform(0.1, 0.9, n))
        B = np.r_[np.zeros(n - len(zeros)), rng.choice([-1.0, 1.0]) * np.poly(zeros)]
    return np.r_[np.zeros(late), B], A, len(A) - 1 + late


def main(count=200, first=700_000):
    answered_count, refused, right, sure, right_unsure = 0, 0, Counter(), Counter(), Counter()
    seed = first - 1
    while answered_count < count:
        seed += 1
        plant = plant_of(seed)
        if plant is None:
            continue
        answered_count += 1
        B, A, order = plant
        rng = np.random.default_rng([seed, 22])
        u = rng.standard_normal(STEPS)
        y = lfilter(B, A, u)
        e = lfilter([1.0], [1.0, -0.8], rng.standard_normal(STEPS))
        y = y + e * y.std() / e.std() / np.exp(rng.uniform(*np.log([3, 100])))
        try:
            target = target_from_data(u, y, mu=3 * order + 5, n_mod=order, order=order)
        except CompensatorError:
            refused += 1
            continue
        d = int(np.flatnonzero(B)[0])
        truth = (str(d), "+" if B[d] > 0 else "-", str(int((np.abs(np.roots(B[d:])) > 1).sum())))
        for fact, true in zip(target.facts, truth, strict=True):
            sure[fact.name] += fact.is_sure
            (right if fact.is_sure else right_unsure)[fact.name] += fact.value == true
    share = answered_count - refused
    print(f"{answered_count} logs, {refused} refused")
    for name, number in sure.items():
        rest = share - number
        print(f"{name}: sure of {number}, of these {right[name]} right "
              f"({100 * right[name] / max(number, 1):.1f} %); of the other {rest} "
              f"{right_unsure[name]} right")  # fmt: skip


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
