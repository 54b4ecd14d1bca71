"""The measures that hold a controller against the least H2 cost there is."""

from __future__ import annotations

import numpy as np

from rcac_numeric import h2_costs
from rcac_numeric.closed_loop import ClosedLoop
from rcac_numeric.repetitions import Repetition
from rcac_numeric.validation import number


def h2_cost(r: Repetition) -> float:
    """Variance of z for white w of unit variance with the final controller."""
    return h2_costs.h2_cost(r.loop)


def high_authority_cost(r: Repetition) -> float:
    """The same with the high-authority LQG controller: the least cost there is."""
    return h2_costs.h2_cost(_high_authority_loop(r))


def cost_over_high_authority(r: Repetition) -> float:
    """The H2 cost of the final controller over that of high-authority LQG; at least 1."""
    return h2_cost(r) / high_authority_cost(r)


def high_authority_pole_distance(r: Repetition, value: float) -> float:
    """Distance from a real number to the nearest pole of the high-authority LQG controller."""
    poles = _high_authority_loop(r).compensator.poles()
    return float(np.abs(poles - number(value, "value")).min())


def high_authority_response_distance(r: Repetition) -> float:
    """Median over frequency of the relative distance of abs(G_zw) to that of high-authority LQG."""
    omega = (np.arange(1000) + 0.5) * np.pi / 1000
    reached, best = (
        np.linalg.norm(loop.frequency_response(omega), axis=(1, 2))
        for loop in (r.loop, _high_authority_loop(r))
    )
    return float(np.median(np.abs(reached - best) / best))


def _high_authority_loop(r: Repetition) -> ClosedLoop:
    return ClosedLoop(r.plant, h2_costs.high_authority_compensator(r.plant))


COST_MEASURES = (
    h2_cost,
    high_authority_cost,
    cost_over_high_authority,
    high_authority_pole_distance,
    high_authority_response_distance,
)
