"""Chapter 6 as it is printed: costs of LQG, zeros and signs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import compensator_theory as exact
from rcac_numeric.analysis._lqg import lqg_controller
from rcac_numeric.plants._problems import standard_plant

Facts = Iterator[tuple[str, bool]]
G_1 = "(q - 0.8)*(q - 1.1)/((q - 0.5)*(q**2 - 1.9*q + 1))"
G_2 = "(q**2 - 1.52*q + 0.9025)/((q - 0.85)*(q**2 - 1.8*q + 1))"


def cost_of_6_1() -> Facts:
    """The LQG cost of (6.2)."""
    cost = lqg_controller(standard_plant(G_1)).cost.value
    yield "it is 1.9620", round(cost, 4) == 1.9620
    yield "RCAC's 1.4945 over LQG's 1.4798 is 1.010", round(1.4945 / 1.4798, 3) == 1.010


def cost_of_6_2() -> Facts:
    """The LQG cost of (6.3)."""
    cost = lqg_controller(standard_plant(G_2)).cost.value
    yield "it is 2.2769", round(cost, 4) == 2.2769
    yield "the printed cost of RCAC is within 5% of it, that of LQG is not", _near(cost)


def pole_of_6_2() -> Facts:
    """The poles of the LQG controller of (6.3)."""
    poles = lqg_controller(standard_plant(G_2)).compensator.poles()
    worst = poles[np.abs(poles).argmax()]
    yield "the unstable pole is at -1.13", abs(worst + 1.13) < 0.005


def zeros_of_6_7() -> Facts:
    """The entries of (6.7), reduced."""
    D = "((q - 0.995)*(q - 0.975)*(q**2 - 1.9*q + 0.9125))"
    first = exact.transfer_function(f"(q - 0.99)*(q**2 + 0.98)/{D}")
    second = exact.transfer_function(f"(q - 0.925)*(q - 0.975)*(q - 1.2)/{D}")
    shared = second.common_factor().degree()
    yield (
        "q - 0.975 cancels in the second entry",
        (shared, first.common_factor().degree()) == (1, 0),
    )
    common = first.numerator.gcd(second.reduced().numerator)
    yield "the entries have no zero in common", common.degree() == 0
    decision = exact.decide_stability(first.numerator, time="discrete")
    yield "the first entry is minimum phase", decision.is_stable is True


def signs_of_dc_gains() -> Facts:
    """Signs of G(1) for (6.6) and for the second entry of (6.7), whose H is 1."""
    G = exact.transfer_function("(q - 1.1)*(q - 1.2)/((q - 0.99)*(q**2 - 1.8*q + 1))")
    second = exact.transfer_function("(q - 0.925)*(q - 1.2)/((q - 0.995)*(q**2 - 1.9*q + 0.9125))")
    yield "two nonminimum-phase zeros: G(1) = 10 has the sign of H", _at_one(G) == 10
    yield "one: G(1) = -240 has the other", _at_one(second) == -240


def _near(cost: float) -> bool:
    return abs(2.3717 / cost - 1) < 0.05 < abs(1.7252 / cost - 1)


def _at_one(G: exact.TransferFunction) -> object:
    return G.numerator.eval(1) / G.denominator.eval(1)
