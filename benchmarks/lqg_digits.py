"""LQG with little noise held against sixty digits: refusals, and errors of the costs.

Run with: python benchmarks/lqg_digits.py [DESIGNS] [FIRST_SEED]

Random plants with V_2 (and R_2) from 1 to 1e-14 of V_1 (and R_1), several signals, delays of u,
modes that are hardly moved or seen, and modes near the unit circle. Each design is refused, or its
gains and its cost are compared with those of Kleinman's iteration in sixty digits (mpmath). A
refusal is false where sixty digits find a solution.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import mpmath
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))  # tests/support makes the plants

from compensator_theory.errors import CompensatorError
from rcac_numeric import lqg_controller
from tests.support.riccati_digits import design_60_digits, hard_design


def compared(seed: int) -> tuple[str, float]:
    """What became of a design, and the relative error of its cost."""
    plant = hard_design(seed)
    try:
        design = lqg_controller(plant)
    except CompensatorError as error:
        return f"{type(error).__name__}: {str(error)[:100]}", np.nan
    with mpmath.workdps(60):
        K, P = design_60_digits(plant.A, plant.B, plant.E_1, plant.E_2, design.regulator.K)
        _, Q = design_60_digits(plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T, design.estimator.K)
        D_1, E_2, B = (mpmath.matrix(M.tolist()) for M in (plant.D_1, plant.E_2, plant.B))
        S = E_2.T * E_2 + B.T * P * B
        J = _trace(D_1.T * P * D_1) + _trace(S * K * Q * K.T)
        return "designed", float(abs(design.cost.value - J) / J)


def _trace(M: mpmath.matrix) -> mpmath.mpf:
    return sum((M[i, i] for i in range(M.rows)), mpmath.mpf(0))


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    counts: Counter[str] = Counter()
    errors, seeds = [], []
    for seed in range(first, first + count):
        outcome, error = compared(seed)
        counts[outcome] += 1
        if outcome != "designed":
            print(f"seed {seed}: {outcome}", flush=True)
        else:
            errors.append(error)
            seeds.append(seed)
    print(f"{count} designs: {counts['designed']} designed, {count - counts['designed']} refused")
    if errors:
        worst = int(np.argmax(errors))
        print(
            f"relative error of J beside sixty digits: median {np.median(errors):.1e}, "
            f"99 % {np.quantile(errors, 0.99):.1e}, worst {max(errors):.1e} (seed {seeds[worst]})"
        )


if __name__ == "__main__":
    main()
