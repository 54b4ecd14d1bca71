"""How large the signals of a run are: before control, under it, at the end, and without it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.fixed import FixedController
from rcac_numeric.engine.runs import Run
from rcac_numeric.engine.simulation import simulate
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule


@dataclass(frozen=True)
class SignalSize:
    """The largest entry and the root mean square of a signal over some steps."""

    peak: float
    rms: float

    @classmethod
    def of(cls, values: Array) -> SignalSize | None:
        """The size of these rows; None where there are none."""
        if not len(values):
            return None
        with np.errstate(over="ignore"):
            power = np.sqrt(np.mean(np.sum(values**2, axis=1)))
        return cls(float(np.abs(values).max(initial=0.0)), float(power))


@dataclass(frozen=True)
class SignalHealth:
    """A signal before and after step k_w, at which the control begins.

    Attributes
    ----------
    before, after : SignalSize or None
        None where there is no such step.
    late : SignalSize or None
        Over the last tenth of the run.
    """

    before: SignalSize | None
    after: SignalSize | None
    late: SignalSize | None

    def __str__(self) -> str:
        said = []
        if self.before is not None and self.before.peak:
            said.append(f"peak {self.before.peak:.3g}, rms {self.before.rms:.3g} before control")
        if self.after is not None:
            said.append(f"peak {self.after.peak:.3g}, rms {self.after.rms:.3g} under control")
        if self.late is not None:
            said.append(f"rms {self.late.rms:.3g} at the end")
        return "; ".join(said) or "no step"


def signal_health(values: Array, start: int) -> SignalHealth:
    """The sizes of a signal whose control begins at row `start`."""
    start = min(max(start, 0), len(values))
    last = values[start:][-max(len(values) // 10, 1) :]
    return SignalHealth(
        SignalSize.of(values[:start]), SignalSize.of(values[start:]), SignalSize.of(last)
    )


def without_control(run: Run) -> Array | None:
    """The z of the same run with u = 0; None where it is unbounded, or takes a user's code."""
    if type(run.plant) not in (Plant, PlantSchedule) or run.first_step or not run.steps:
        return None

    plant = run.plant
    idle = Compensator(np.zeros((0, plant.l_u, plant.l_u)), np.zeros((1, plant.l_u, plant.l_y)))
    free = simulate(plant, FixedController(idle), run.w, x_0=run.x_0)
    return free.z if free.outcome == "completed" else None
