"""A run with the analyses that are asked of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.analysis.closed_loop import (
    ClosedLoop,
    IntercalatedMatch,
    frozen_loop,
    intercalated_match,
)
from rcac_numeric.analysis.exact_comparison import ExactComparison, compare_exactly
from rcac_numeric.analysis.residual_split import ResidualSplit, split_residual
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine.compatibility import controllers_of
from rcac_numeric.engine.runs import Run
from rcac_numeric.plants.frozen import measuring_command, plant_at
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.targets.model import TargetModel


@dataclass(frozen=True, eq=False)
class AnalysedRun:
    """A run with the analyses that claims ask of it, each made once and when it is needed."""

    run: Run
    given_target: TargetModel | None = None

    @property
    def is_scalar(self) -> bool:
        """Whether the exact comparison applies."""
        return not self.obstacle

    @cached_property
    def obstacle(self) -> str:
        """Why the exact comparison does not apply; empty where it does."""
        run, compensator = self.run, self.run.compensator
        sizes = {"l_u": compensator.l_u, "l_y": run.plant.l_y, "l_z": run.plant.l_z}
        if set(sizes.values()) != {1}:
            words = ", ".join(f"{name} = {size}" for name, size in sizes.items())
            return f"it is for scalar signals, and the plant has {words}"
        if compensator.l_y > 1:
            return "it is for a controller that reads y alone, and this one reads the command too"
        return ""

    @cached_property
    def plant(self) -> Plant:
        """The plant of the last completed step, without its delay line."""
        return plant_at(self.run.plant, self.last_step)

    @property
    def last_step(self) -> int:
        """The last completed step."""
        return self.run.first_step + max(self.run.steps - 1, 0)

    @cached_property
    def target(self) -> TargetModel:
        """The target model to compare with: the one given, or that in force at the last step."""
        if self.given_target is not None:
            return self.given_target
        targets = []
        for settings in controllers_of(self.run.settings):
            if isinstance(settings, ControllerSettings):
                changes = settings.target_changes
                later = [model for k, model in changes.items() if k <= self.last_step]
                targets.append([settings.target, *later][-1])
        if not targets:
            raise InputError("nothing adapts in this run, so it has no target model of its own")
        if any(other != targets[0] for other in targets[1:]):
            raise InputError("the controllers have different target models")
        return targets[0]

    @cached_property
    def loop(self) -> ClosedLoop:
        """The plant of the last step in a loop with the final controller."""
        return frozen_loop(self.run.plant, self.run.compensator, self.last_step)

    @cached_property
    def zeros(self) -> dict[str, np.ndarray]:
        """Closed-loop zeros from each channel of w to z with the final controller."""
        return dict(self.comparison.zeros) if self.is_scalar else dict(self.loop.zeros())

    @cached_property
    def comparison(self) -> ExactComparison:
        """The final controller beside the exact prediction."""
        if self.obstacle:
            raise InputError(f"there is no exact comparison here: {self.obstacle}.")
        return compare_exactly(self.plant, self.run.compensator, self.target)

    @cached_property
    def match(self) -> IntercalatedMatch:
        """The intercalated transfer function of the final controller beside G_f."""
        return intercalated_match(self.loop, self.target)

    @cached_property
    def split(self) -> ResidualSplit:
        """The retrospective residual of the whole run for the final controller.

        Behind a saturation it is that of the applied input, which the controller's own past holds.
        """
        run, y = self.run, self.run.y
        if isinstance(run.plant, PlantSchedule) and len(run.plant.changes) > 1:
            raise InputError("the plant changes during the run")
        plant = self.plant
        if run.compensator.l_y > plant.l_y:
            plant = measuring_command(plant)
            y = np.hstack([y, run.w @ plant.D_2[run.plant.l_y :].T])
        return split_residual(
            plant, run.compensator, self.target, u=run.u_applied, y=y, z=run.z, w=run.w
        )
