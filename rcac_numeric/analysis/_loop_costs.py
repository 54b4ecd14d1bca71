"""The H2 cost of a loop compared with the LQG minimum."""

from __future__ import annotations

from dataclasses import dataclass

from compensator_theory.errors import CompensatorError, IllConditionedError
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._costs import H2Cost, h2_cost
from rcac_numeric.analysis._lqg import lqg_controller
from rcac_numeric.analysis._noise import NoiseIntensities
from rcac_numeric.arrays._values import Value


@dataclass(frozen=True, eq=False)
class LoopCosts(Value):
    """The H2 cost of a loop and the LQG minimum.

    Attributes
    ----------
    reached : H2Cost or None
        Of the loop, with the share of each noise; infinite for an unstable loop, None where
        rounding decides it.
    least : H2Cost or None
        Of LQG in the form that the compensator has: predictor for a strictly proper one, filter
        for an exactly proper one. No other stabilising compensator of that form costs less.
    obstacle : str
        Why `reached` is undecided, else why there is no LQG controller; empty where neither is so.
    """

    reached: H2Cost | None
    least: H2Cost | None
    obstacle: str

    @property
    def ratio(self) -> float | None:
        """The cost over the LQG minimum, at least 1."""
        if self.reached is None or self.least is None or self.least.value == 0:
            return None
        return self.reached.value / self.least.value


def loop_costs(loop: ClosedLoop, noise: NoiseIntensities | None = None) -> LoopCosts:
    """Compute the costs of a loop; `noise` as for `h2_cost`."""
    plant, compensator = loop.plant, loop.compensator
    form = "filter" if compensator.past_y[0].any() else "predictor"
    try:
        least, obstacle = lqg_controller(plant, noise=noise, form=form).cost, ""
    except CompensatorError as error:
        least, obstacle = None, str(error).rstrip(".")
    try:
        return LoopCosts(h2_cost(plant, compensator, noise=noise), least, obstacle)
    except IllConditionedError as error:
        return LoopCosts(None, least, str(error).rstrip("."))
