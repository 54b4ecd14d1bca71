"""`design` from logs of random plants at four signal-to-noise ratios, held against the true plant.

The random plants of benchmarks/design_road.py, 2000 steps, noise of y with a pole at 0.8 and a
ratio of the standard deviations of what u makes of y and of that noise. In an open loop u is white;
an unstable plant is held by a robust LQG controller, which `design` is not told, while the command
is one of two values for 10 steps at a time.

The loops are those of the true plant: a step of d, and sensor noise as in the log. stable: with
the fixed controller, and with the last one of RCAC. good: stable too, the rms of e_0 over the last
quarter below twice and its peak below ten times that of the fixed controller that is designed for
the true plant and those signals. "cannot tell": refused, or a half of the log has another sign or
is not held by the fixed controller with Ms < 4.

    .venv/bin/python benchmarks/design_log.py [plants] [first seed] [ratios]
"""

import sys
import time

import numpy as np
from design_road import random_plant
from scipy.signal import lfilter

from compensator_theory.errors import CompensatorError
from rcac_numeric import (
    ControllerLog,
    FixedController,
    SimulationCase,
    Step,
    Uncertainty,
    WhiteNoise,
    design,
    exogenous,
    simulate,
    simulate_many,
)
from rcac_numeric.designing._expected import read_expected
from rcac_numeric.designing._logs import PARTS
from rcac_numeric.designing._plants import read_plant, variations
from rcac_numeric.designing._reference import reference_loop
from rcac_numeric.designing._trials import measured

STEPS = 2000
RATIOS = (3, 10, 30, 100)
GROUPS = ("stable", "lightly damped", "nonminimum phase", "integrating", "unstable")
COLUMNS = ("delay", "gain", "sign", "fixed stable", "good", "RCAC stable", "good")


def coloured(seed):
    """Noise of unit variance with a pole at 0.8."""
    e = lfilter([1.0], [1.0, -0.8], np.random.default_rng([seed, 8]).standard_normal(STEPS))
    return e / e.std()


def log_of(model, ratio, seed):
    """U and y of the plant in an open loop."""
    u = np.random.default_rng([seed, 9]).standard_normal(STEPS)
    x, y = np.zeros((len(model.A), 1)), np.zeros(STEPS)
    late = np.r_[np.zeros(model.delay), u]
    for k in range(STEPS):
        y[k] = (model.C @ x).item()
        x = model.A @ x + model.B * late[k]
    return ControllerLog(u, y + coloured(seed) * y.std() / ratio)


def log_of_loop(model, ratio, seed):
    """U and y of the plant while a controller holds it and the command moves."""
    expected, _ = read_expected(1.0, None, None, np.inf, model.low_gain)
    loop = reference_loop(model, expected, np.inf, variations(model, Uncertainty()))
    r = np.repeat(np.random.default_rng([seed, 9]).choice([-1.0, 1.0], STEPS // 10), 10)
    w, controller = np.zeros((STEPS, 3)), FixedController(loop.compensator)
    w[:, 0] = r
    y = r - simulate(model.servo(), controller, w).y[:, 0]
    w[:, 2] = coloured(seed) * y.std() / ratio
    run = simulate(model.servo(), controller, w)
    return ControllerLog(run.u, r - run.y[:, 0])


def judged(model, kind, ratio, seed):
    """What became of one log: (refused, cannot tell, COLUMNS)."""
    log = (log_of_loop if kind == "unstable" else log_of)(model, ratio, seed)
    try:
        designed = design(log, sample_time=1.0, seeds=1, steps=500)
    except CompensatorError as error:
        print(f"{seed} {kind}, {ratio}: {str(error)[:150]}", flush=True)
        return True, True, (False,) * len(COLUMNS)
    v = designed.logged.noise
    known, _ = read_expected(Step(1.0), v, None, np.inf, model.low_gain)
    best = reference_loop(model, known, np.inf, variations(model, Uncertainty()))
    w = exogenous([Step(0.0), Step(1.0), WhiteNoise(v)], STEPS, seed)
    ways = FixedController(best.compensator), designed.fixed, designed.settings
    runs = simulate_many([SimulationCase(model.servo(), one, w, {"stride": STEPS}) for one in ways])
    (_, tail, peak, _), *results = (measured(run) for run in runs)
    of_ways = [
        word for stable, rms, highest, _ in results
        for word in (stable, stable and rms < 2 * tail and highest < 10 * peak)
    ]  # fmt: skip
    gains = designed.logged.gains
    sure = designed.logged.stable_parts(designed.fixed.compensator) == PARTS
    sure = sure and sum(gain > 0 for gain in gains) == PARTS
    near = abs(designed.model.delay - model.delay) <= 1
    close = 0.9 < designed.model.low_gain / model.low_gain < 1.1
    return False, not sure, (near, close, designed.model.sign == model.sign, *of_ways)


def print_shares(rows, name):
    columns = np.array([columns for refused, _, columns in rows if not refused])
    refused, unsure = (sum(row[i] for row in rows) for i in (0, 1))
    sure = [columns for _, cannot, columns in rows if not cannot]
    shares = "; ".join(
        f"{column} {100 * share:.0f}"
        for column, share in zip(
            COLUMNS, columns.mean(axis=0) if len(columns) else (), strict=False
        )
    )
    share = f"{100 * np.mean([row[3] for row in sure]):.0f}" if sure else "none"
    print(f"{name}: {len(rows)} logs, {refused} refused, {unsure} cannot tell; in % of those "
          f"answered: {shares}; fixed stable where it can tell: {share}", flush=True)  # fmt: skip


def main(count=30, first=80_000, ratios=RATIOS):
    start = time.perf_counter()
    plants = [(seed, *random_plant(seed)) for seed in range(first, first + count)]
    for ratio in ratios:
        rows = [
            (kind, judged(read_plant(G, 1.0, late), kind, ratio, seed))
            for seed, kind, G, late in plants
        ]
        print_shares([row for _, row in rows], f"ratio {ratio}")
        for group in GROUPS:
            if rows_of_group := [row for kind, row in rows if kind == group]:
                print_shares(rows_of_group, f"  {group}")
        print(f"{time.perf_counter() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]), *[tuple(map(int, a.split(","))) for a in sys.argv[3:4]])
