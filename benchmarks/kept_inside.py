"""What `CertifiedBounds` cost per step, beside the update that they follow, alone and in lanes.

    python benchmarks/kept_inside.py [--steps 40000] [--rounds 7] [--lanes]

One loop of a second-order plant runs without update, with it, and with an ellipsoid: the certified
set of the loop, and three about zero that theta never reaches, reaches now and then, and leaves at
every update. Processor time, the medians of differences within a round, over the time of the update
of the same round: the machine drops out. Then the time of a step of `simulate_many`, one run after
another and in lanes, 16 runs on one thread.

With --lanes: the time of such a step alone over that in lanes, for l_theta = 20, 30, 40 and 50 and
ellipsoids that project a growing share of the steps.
"""

import argparse
import statistics
import time

import attrs
import numpy as np

from rcac_numeric import (
    UD,
    CertifiedBounds,
    CoefficientBounds,
    ControllerSettings,
    SimulationCase,
    TargetModel,
    certified_set,
    iir,
    simulate,
    simulate_many,
    standard_plant,
)

PLANT = standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
SIZES = (4, 8, 20, 40)
RUNS = 16


def bounds_of(plain):
    """What is compared, by its name."""
    l_theta = plain.l_theta
    rng = np.random.default_rng(0)
    L = np.tril(rng.standard_normal((l_theta, l_theta)), -1) * 0.2 / np.sqrt(l_theta)
    L += np.eye(l_theta)
    center = np.zeros(l_theta)
    return {
        "never outside": CertifiedBounds(center, 1e3 * L),
        "now and then": CertifiedBounds(center, 1.0 * L),
        "certified set": certified_set(PLANT, plain).bounds,
        "always outside": CertifiedBounds(center, 1e-3 * L),
        "box, clip": CoefficientBounds(-0.01, 0.01, method="clip"),
        "box, metric": CoefficientBounds(-0.01, 0.01),
    }


def seconds(settings, w):
    """Processor time per step, and the share of the steps that were projected."""
    few, times = len(w) // 4, []
    for part in (w[:few], w):  # what is spent before the first step drops out
        start = time.process_time()
        run = simulate(PLANT, settings, part, stride=len(w))
        times.append(time.process_time() - start)
    return (times[1] - times[0]) / (len(w) - few), run.bounded / len(w)


def measure(plain, bounded, steps, rounds):
    """For each bound the projected steps and the cost in updates; and the update in seconds."""
    w = np.random.default_rng(1).standard_normal((steps, 1))
    idle = attrs.evolve(plain, freeze=[(0, None)])
    updates, costs, shares = [], {name: [] for name in bounded}, {}
    for _ in range(rounds):
        without, _ = seconds(idle, w)
        adapting, _ = seconds(plain, w)
        updates.append(adapting - without)
        for name, settings in bounded.items():
            spent, shares[name] = seconds(settings, w)
            costs[name].append(spent - adapting)
    update = statistics.median(updates)
    return {
        name: (shares[name], statistics.median(costs[name]) / update) for name in bounded
    }, update


def per_step(settings, lanes, steps, rounds):
    """Processor time of a step of one of many runs."""
    w = [np.random.default_rng(i).standard_normal((steps, 1)) for i in range(RUNS)]
    cases = [SimulationCase(PLANT, settings, signal, {"stride": steps}) for signal in w]
    times = []
    for _ in range(rounds):
        start = time.process_time()
        simulate_many(cases, threads=1, lanes=lanes)
        times.append(time.process_time() - start)
    return statistics.median(times) / (RUNS * steps)


def gain_of_lanes(steps, rounds):
    """How many times faster lanes are, by l_theta and the share of the steps that are projected."""
    print(f"{'l_theta':>7} projected  ns alone  in lanes  gain")
    for l_theta in (20, 30, 40, 50):
        plain = ControllerSettings(
            structure=iir(l_theta // 2), target=TargetModel([0, 1.0]), update=UD(0.05)
        )
        factor = bounds_of(plain)["now and then"].factor
        for scale in (1e3, 2.0, 1.5, 1.2, 1.0, 0.7, 0.5, 0.1, 1e-3):
            bounds = CertifiedBounds(np.zeros(l_theta), scale * factor)
            settings = attrs.evolve(plain, bounds=bounds)
            _, share = seconds(settings, np.random.default_rng(0).standard_normal((steps, 1)))
            alone, lanes = (per_step(settings, lanes, steps, rounds) for lanes in (False, True))
            print(
                f"{l_theta:>7} {share:>9.0%} {1e9 * alone:>9.0f} {1e9 * lanes:>9.0f} "
                f"{alone / lanes:>5.2f}",
                flush=True,
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--steps", type=int, default=40_000)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--lanes", action="store_true")
    options = parser.parse_args()
    if options.lanes:
        return gain_of_lanes(options.steps // RUNS, options.rounds)
    print(f"{'l_theta':>7} {'bounds':<15} projected  updates  per projection  ns alone  in lanes")
    for l_theta in SIZES:
        plain = ControllerSettings(
            structure=iir(l_theta // 2), target=TargetModel([0, 1.0]), update=UD(0.05)
        )
        bounded = {name: attrs.evolve(plain, bounds=b) for name, b in bounds_of(plain).items()}
        rows, update = measure(plain, bounded, options.steps, options.rounds)
        for name, settings in {"none": plain, **bounded}.items():
            alone, lanes = (
                per_step(settings, lanes, options.steps // RUNS, options.rounds)
                for lanes in (False, True)
            )
            share, cost = rows.get(name, (0.0, 0.0))
            each = f"{cost / share:.1f}" if share else ""
            print(
                f"{l_theta:>7} {name:<15} {share:>9.0%} {cost:>8.2f} {each:>15} "
                f"{1e9 * alone:>9.0f} {1e9 * lanes:>9.0f}",
                flush=True,
            )
        print(f"{l_theta:>7} an update: {1e9 * update:.0f} ns", flush=True)


if __name__ == "__main__":
    main()
