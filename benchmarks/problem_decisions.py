"""Logs with the problem and its sign withheld: how often prediction decides, and how often wrongly.

Run with: python benchmarks/problem_decisions.py [LOGS] [FIRST_SEED]

Random plants under RCAC, as the standard problem with white or coloured disturbances and as the
servo problem with steps and with noises, in short and long logs, with and without the command in
the log. What made the log is withheld; `decide_problem` compares standard and servo for the same G.
"""

from __future__ import annotations

import sys
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from loop_health import _polynomial, _words

from compensator_theory.errors import CompensatorError
from rcac_numeric import UD, ControllerLog, ControllerSettings, fir_target, iir, simulate
from rcac_numeric.checks._hypotheses import decide_problem
from rcac_numeric.plants._problems import servo_plant, standard_plant


def answered(seed: int) -> str:
    """Right, undecided, WRONG, or why there is no log."""
    rng = np.random.default_rng([300, seed])
    n = int(rng.integers(1, 5))
    relative = int(rng.integers(1, min(3, n) + 1))
    poles, zeros = _polynomial(rng, n, 1.02), _polynomial(rng, n - relative, 0.85)
    gain = rng.choice([-1, 1]) * rng.uniform(0.1, 3)
    G = f"({gain:.6f})*({_words(zeros)})/({_words(poles)})"
    servo = bool(rng.random() < 0.5)
    plant = servo_plant(G) if servo else standard_plant(G)
    steps = int(rng.choice([150, 400, 2000]))
    w = rng.standard_normal((steps, plant.l_w))
    if servo:
        w[:, 0] = rng.choice([-1, 1]) * (1 + (np.arange(steps) > steps // 2) * rng.choice([0, 1]))
        w[:, 1] *= rng.choice([0.0, 0.02, 0.3])
        w[:, 2] *= rng.choice([0.0, 0.02])
    elif rng.random() < 0.5:  # a coloured disturbance
        for k in range(1, steps):
            w[k] += 0.9 * w[k - 1]
    settings = ControllerSettings(
        structure=iir(n_c=n + int(rng.integers(1, 3))), target=fir_target(plant),
        update=UD(10 ** rng.uniform(-6, 2)), k_w=[None, 30][rng.integers(0, 2)],
    )  # fmt: skip
    with np.errstate(all="ignore"):
        run = simulate(plant, settings, w)
    if run.outcome != "completed" or np.abs(run.y).max() > 1e6:
        return "blew up"
    r = w[:, :1] if servo and rng.random() < 0.3 else None
    log = ControllerLog(run.u, run.y, r=r)
    plants = {"standard": standard_plant(G), "servo": servo_plant(G)}
    try:
        decision = decide_problem(log, plants)
    except CompensatorError as error:
        return f"refused: {str(error)[:60]}"
    if decision.decided is None:
        return "undecided"
    right = decision.decided.problem == ("servo" if servo else "standard")
    late = "" if decision.decided.delay == 0 else f", delay {decision.decided.delay}"
    if not right or late:
        print(f"seed {seed}: {'servo' if servo else 'standard'}: {decision}", flush=True)
    return ("right" if right else "WRONG") + late


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    warnings.simplefilter("ignore")
    print(Counter(answered(seed) for seed in range(first, first + count)))


if __name__ == "__main__":
    main()
