"""The plant of a step test, for `design`."""

from __future__ import annotations

from numpy.typing import ArrayLike

from rcac_numeric.designing._plants import DesignPlant, Uncertainty, read_plant
from rcac_numeric.identification._step_response import StepResponse

LONGEST = 3.0  # factor between time constants; a wider interval is of a record that did not settle


def plant_of_step(
    step: StepResponse, period: float, dead_time: ArrayLike | None = None
) -> DesignPlant:
    """The sampled plant, with the identified dead time or another one."""
    return read_plant(step.plant, period, step.dead_time if dead_time is None else dead_time)


def uncertainty_of_step(step: StepResponse, period: float) -> Uncertainty:
    """The uncertainty of the intervals of the step test, and at least the default."""
    usual, (low, high) = Uncertainty(), step.gain_factors
    total, shortest, longest = step.residence_time
    return Uncertainty(
        gain=(min(usual.gain[0], low), max(usual.gain[1], high)),
        delay=max(usual.delay, step.delay_error(period)),
        time=min(max(usual.time, longest / total, total / max(shortest, 1e-9 * total)), LONGEST),
    )
