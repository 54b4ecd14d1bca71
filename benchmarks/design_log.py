"""`design` from logs of random plants at four signal-to-noise ratios, held against the true plant.

The random plants of benchmarks/design_road.py but the unstable ones; u white, 2000 steps, noise of
y with a pole at 0.8. The loops are those of the true plant: a step of d, and sensor noise as in the
log; stable: the fixed controller, and the last one of RCAC; Ms of the fixed one, median and 90 %.
"held": the fixed controller holds all three parts of the log with Ms < 4.

    .venv/bin/python benchmarks/design_log.py [plants] [first seed]
"""

import sys
import time

import numpy as np
from design_road import quantiles, random_plant
from scipy.signal import lfilter

from compensator_theory.errors import CompensatorError
from rcac_numeric import (
    ControllerLog,
    SimulationCase,
    Step,
    WhiteNoise,
    design,
    exogenous,
    simulate_many,
)
from rcac_numeric.synthesis.logs import PARTS
from rcac_numeric.synthesis.plants import read_plant
from rcac_numeric.synthesis.trials import measured

STEPS = 2000


def log_of(model, ratio, seed):
    """U and y of the plant in an open loop."""
    rng = np.random.default_rng([seed, 9])
    u = rng.standard_normal(STEPS)
    x, y = np.zeros((len(model.A), 1)), np.zeros(STEPS)
    late = np.r_[np.zeros(model.delay), u]
    for k in range(STEPS):
        y[k] = (model.C @ x).item()
        x = model.A @ x + model.B * late[k]
    e = lfilter([1.0], [1.0, -0.8], rng.standard_normal(STEPS))
    return ControllerLog(u, y + e * y.std() / e.std() / ratio)


def main(count=30, first=80_000):
    start = time.perf_counter()
    plants = []
    for seed in range(first, first + 2 * count):
        kind, G, late = random_plant(seed)
        if kind != "unstable" and len(plants) < count:
            plants.append((seed, read_plant(G, 1.0, late)))
    for ratio in (3, 10, 30, 100):
        rows, peaks, refused = [], [], 0
        for seed, model in plants:
            try:
                found = design(log_of(model, ratio, seed), sample_time=1.0, seeds=1, steps=500)
            except CompensatorError as error:
                refused += 1
                print(f"{seed}, {ratio}: {error}")
                continue
            v = WhiteNoise(found.logged.noise)
            w = exogenous([Step(0.0), Step(1.0), v], STEPS, seed)
            servo = model.servo()
            runs = simulate_many([SimulationCase(servo, one, w, {"stride": STEPS})
                                  for one in (found.fixed, found.settings)])  # fmt: skip
            fixed, rcac = (measured(run, STEPS) for run in runs)
            held = found.logged.held(found.fixed.compensator) == PARTS
            near = abs(found.model.delay - model.delay) <= 1
            close = 0.9 < found.model.low_gain / model.low_gain < 1.1
            same = found.model.sign == model.sign
            rows.append((near, close, same, fixed[0], rcac[0], held, fixed[0] and held))
            peaks.append(fixed[3])
        near, close, same, fixed, rcac, held, both = 100 * np.mean(rows, axis=0)
        print(f"ratio {ratio}, {len(rows)} logs, {refused} refused: delay within 1 {near:.0f} %, "
              f"gain within 10 % {close:.0f} %, sign {same:.0f} %; stable: fixed {fixed:.0f} %, "
              f"RCAC {rcac:.0f} %; Ms {quantiles(peaks)}; held {held:.0f} %, of those stable "
              f"{100 * both / held if held else 0:.0f} %", flush=True)  # fmt: skip
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
