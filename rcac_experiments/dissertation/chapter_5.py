"""Chapter 5 as it is printed: zeros and margins."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import compensator_theory as exact
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._lqg import lqg_controller
from rcac_numeric.plants._problems import standard_plant

Facts = Iterator[tuple[str, bool]]
PERIOD = 0.1  # seconds, Example 5.6


def zeros_of_5_1() -> Facts:
    """The moduli of the zeros of (5.1)."""
    zeros = exact.polynomial("(q**2 - 1.7*q + 0.785)*(q**2 - 1.4*q + 0.85)")
    yield "(5.1) is minimum phase", exact.decide_stability(zeros, time="discrete").is_stable is True
    moduli = sorted({round(float(c) ** 0.5, 3) for c in (0.785, 0.85)})
    yield "the moduli are 0.886 and 0.922", moduli == [0.886, 0.922]


def frozen_lqg_of_5_4() -> Facts:
    """High-authority LQG of (5.4), fixed, in a loop with the plant of the moved zeros."""
    denominator = "((q - 0.35)*(q - 0.6)*(q**2 - 0.8*q + 0.32))"
    nominal = standard_plant(f"(q - 0.5)*(q**2 - 1.92*q + 1.44)/{denominator}")
    moved = standard_plant(f"(q - 0.5)*(q**2 - 1.98*q + {0.99**2 + 1.38**2:.10g})/{denominator}")
    radius = ClosedLoop(moved, lqg_controller(nominal).compensator).spectral_radius
    yield "the loop stays stable, with spectral radius 0.9976", round(radius, 4) == 0.9976


def zeros_of_5_5() -> Facts:
    """C adj(sI - A) B of (5.5) with C = [1 1] and with C = [1 0]."""
    A, B = [[1, 1], [0, 1]], [[0], [1]]
    both = exact.transfer_function(exact.Realisation(A, B, [[1, 1]]))
    first = exact.transfer_function(exact.Realisation(A, B, [[1, 0]]))
    yield "with C = [1 1] there is a zero at s = 0", both.numerator.eval(0) == 0
    yield "with C = [1 0] there is none", first.numerator.degree() == 0


def delay_margins() -> Facts:
    """Phase margin over crossover frequency, in seconds and in steps of 0.1 s."""
    other, rcac = np.deg2rad([129.12, 38.83]) / [0.3708, 2.1834]
    yield "of [2]: 6.08 seconds", abs(other - 6.08) < 0.01
    yield "of RCAC: 0.31 seconds", abs(rcac - 0.31) < 0.005
    yield "a delay of 7 steps is less than the margin of [2]", other > 7 * PERIOD
