"""What `CertifiedBounds` cost per step, beside the update that they follow.

    python benchmarks/kept_inside.py [--steps 40000] [--rounds 7]

One loop of a second-order plant runs without update, with it, and with an ellipsoid about zero that
theta never reaches, reaches now and then, and leaves at every update. Processor time, the medians
of differences within a round, over the time of the update of the same round: the machine drops out.
"""

import argparse
import statistics
import time

import numpy as np

from rcac_numeric import (
    UD,
    CertifiedBounds,
    CoefficientBounds,
    ControllerSettings,
    TargetModel,
    iir,
    simulate,
    standard_plant,
)

PLANT = standard_plant("(q - 0.3)/((q - 0.9)*(q - 0.5))")
SIZES = (4, 8, 20, 40)


def bounds_of(l_theta):
    """What is compared, by its name."""
    rng = np.random.default_rng(0)
    L = np.tril(rng.standard_normal((l_theta, l_theta)), -1) * 0.2 / np.sqrt(l_theta)
    L += np.eye(l_theta)
    center = np.zeros(l_theta)
    return {
        "never outside": CertifiedBounds(center, 1e3 * L),
        "now and then": CertifiedBounds(center, 1.0 * L),
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


def measure(l_theta, steps, rounds):
    """A row for each bound: projected steps, cost in updates, and the update in seconds."""
    w = np.random.default_rng(1).standard_normal((steps, 1))
    common = {"structure": iir(l_theta // 2), "target": TargetModel([0, 1.0]), "update": UD(0.05)}
    idle = ControllerSettings(**common, freeze=[(0, None)])
    plain = ControllerSettings(**common)
    kept = {name: ControllerSettings(**common, bounds=b) for name, b in bounds_of(l_theta).items()}
    updates, costs, shares = [], {name: [] for name in kept}, {}
    for _ in range(rounds):
        without, _ = seconds(idle, w)
        adapting, _ = seconds(plain, w)
        updates.append(adapting - without)
        for name, settings in kept.items():
            spent, shares[name] = seconds(settings, w)
            costs[name].append(spent - adapting)
    update = statistics.median(updates)
    return {name: (shares[name], statistics.median(costs[name]) / update) for name in kept}, update


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--steps", type=int, default=40_000)
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    print(f"{'l_theta':>7} {'update, ns':>10}  bounds: projected steps, cost per step in updates")
    for l_theta in SIZES:
        rows, update = measure(l_theta, options.steps, options.rounds)
        words = "; ".join(f"{name} {share:.0%} {cost:.2f}" for name, (share, cost) in rows.items())
        print(f"{l_theta:>7} {1e9 * update:>10.0f}  {words}")


if __name__ == "__main__":
    main()
