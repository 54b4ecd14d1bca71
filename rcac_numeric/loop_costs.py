"""The H2 cost of a loop by channel of w, beside the least that LQG reaches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_numeric.closed_loop import ClosedLoop
from rcac_numeric.h2_costs import h2_cost, high_authority_compensator
from rcac_numeric.plants import MATRICES, Plant


@dataclass(frozen=True)
class LoopCosts:
    """The variance of z for white w of unit variance.

    Attributes
    ----------
    cost : float
        Infinite for an unstable loop.
    by_channel : mapping from channel of w to float
        What each channel alone contributes; they add up to the cost.
    lqg : float or None
        The cost of high-authority LQG, the least of any controller that uses past y.
    obstacle : str
        Why there is no LQG cost; empty where there is one.
    """

    cost: float
    by_channel: dict[str, float]
    lqg: float | None
    obstacle: str

    @property
    def ratio(self) -> float | None:
        """The cost over LQG's, at least 1."""
        return None if not self.lqg else self.cost / self.lqg


def loop_costs(loop: ClosedLoop) -> LoopCosts:
    """The costs of a loop.

    Examples
    --------
    >>> from rcac_numeric import ClosedLoop, Compensator, standard_plant
    >>> from rcac_numeric.loop_costs import loop_costs
    >>> plant = standard_plant("1/(q - 2)")
    >>> costs = loop_costs(ClosedLoop(plant, Compensator(P=[[[-1.0]]], Q=[[[0.0]], [[-2.5]]])))
    >>> round(costs.cost, 6), round(costs.lqg, 6)
    (8.0, 5.0)
    """
    plant = loop.plant
    shares = {
        name: h2_cost(ClosedLoop(_with_one_channel(plant, i), loop.compensator))
        for i, name in enumerate(plant.channels)
    }
    try:
        least, obstacle = least_cost(plant), ""
    except CompensatorError as error:
        least, obstacle = None, str(error).rstrip(".")
    return LoopCosts(h2_cost(loop), shares, least, obstacle)


def least_cost(plant: Plant) -> float:
    """LQG's cost with R_2 = 0 and V_2 = 0, the one place that says which LQG that is."""
    return h2_cost(ClosedLoop(plant, high_authority_compensator(plant)))


def _with_one_channel(plant: Plant, index: int) -> Plant:
    matrices = {name: getattr(plant, name) for name in MATRICES}
    for name in ("D_1", "D_2", "E_0"):
        matrices[name] = np.asarray(matrices[name])[:, [index]]
    return Plant(**matrices)
