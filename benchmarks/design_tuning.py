"""What `tune` brings over the rule of `design`, on plants and draws that chose nothing.

The random plants of benchmarks/design_road.py, the size of the disturbance known and its kind not
in every second one. For each: the settings of the rule, 40 points beside them, then both on the
nominal plant and 8 plants drawn from the uncertainty, with 3 draws each.

    .venv/bin/python benchmarks/design_tuning.py [plants] [first seed] [budget]
"""

import sys
import time

import numpy as np
from design_road import random_plant, surroundings

from compensator_theory.errors import CompensatorError
from rcac_experiments import tune
from rcac_numeric import design
from rcac_numeric.designing._plants import read_plant


def main(count=30, first=70_000, budget=40):
    start = time.perf_counter()
    gains, stable, rows = [], np.zeros(2, dtype=int), 0
    for seed in range(first, first + count):
        kind, G, late = random_plant(seed)
        model = read_plant(G, 1.0, late)
        signals, disturbance, command, noise = surroundings(model, seed)
        size = disturbance if seed % 2 else 1.0
        try:
            designed = design(G, sample_time=1.0, dead_time=late, disturbance=size, command=command,
                           noise=noise, seeds=1)  # fmt: skip
        except CompensatorError as error:
            print(f"{seed} {kind}: {error}")
            continue
        began = time.process_time()
        tuned = tune(designed, budget)
        beside = tuned.beside_rule
        gains.append(beside.ratio)
        stable += beside.stable[0], beside.fixed_stable[0]
        rows += beside.stable[1]
        print(f"{seed} {kind}, {signals}{'' if seed % 2 else ', size known'}: chosen "
              f"{tuned.chosen.name}, rms over the rule's {beside.ratio:.3g}, stable "
              f"{beside.stable[0]} and {beside.fixed_stable[0]} of {beside.stable[1]}, verdict "
              f"{tuned.verdict.use}, before {designed.verdict.use}; "
              f"{time.process_time() - began:.1f} s", flush=True)  # fmt: skip
    quartiles = np.nanquantile(gains, [0, 0.25, 0.5, 0.75, 1])
    print(f"\nheld-out rms over the rule's, quartiles: {np.round(quartiles, 3)}")
    print(f"stable: tuned {stable[0]}, rule {stable[1]} of {rows}")
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
