"""What a fixed controller does to a plant, beside a target model: each analysis once, on demand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from compensator_theory import figures
from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.analysis.exact_comparison import ExactComparison, compare_exactly
from rcac_numeric.analysis.match import IntercalatedMatch, intercalated_match
from rcac_numeric.analysis.residual_split import ResidualSplit, split_residual
from rcac_numeric.arrays.array_types import Array, ComplexArray
from rcac_numeric.arrays.showing import picture_of
from rcac_numeric.arrays.validation import integer
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.engine.compatibility import controllers_of
from rcac_numeric.engine.runs import Run
from rcac_numeric.plants.frozen import measuring_command, plant_at
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.targets.model import TargetModel

Result = TypeVar("Result")
SIGNALS = ("w", "u", "y", "z", "u_applied")


@dataclass(frozen=True, eq=False)
class LoopAnalysis(Value):
    """A plant with a fixed controller, held against a target model; of a run, its last controller.

    Parameters
    ----------
    of : Run, or a pair of Plant and Compensator
        Of a run it is the plant of the last completed step with the controller after it. A
        compensator reads y, or [y; r].
    target : TargetModel, optional
        By default, of a run, the one that its settings adapt to at the last step. Without any
        there is nothing to compare with: `comparison`, `match` and `split` raise.

    Examples
    --------
    >>> from rcac_numeric import Compensator, fir_target, standard_plant, target_model
    >>> from rcac_numeric.experiments.measures.loop_analysis import LoopAnalysis, attempted
    >>> from rcac_numeric.dissertation import load_example
    >>> run = load_example("4.7").main_run.execute().first.run
    >>> other = target_model("1/q")
    >>> LoopAnalysis(run).match.worst < 1e-5, LoopAnalysis(run, other).match.worst > 0.1
    (True, True)
    >>> plant = standard_plant("1/(q - 2)")
    >>> compensator = Compensator(past_u=[[[-2.0]]], past_y=[[[0.0]], [[-4.0]]])
    >>> analysis = LoopAnalysis((plant, compensator), fir_target(plant))
    >>> analysis.comparison.worst_distance, analysis.match.worst < 1e-12
    (0.0, True)
    >>> attempted(lambda: LoopAnalysis((plant, compensator)).match)
    (None, 'the target model is not known')
    """

    of: Run | tuple[Plant, Compensator]
    target: TargetModel | None = None

    @property
    def run(self) -> Run:
        """The run that this is the analysis of."""
        if isinstance(self.of, Run):
            return self.of
        raise InputError("this is the analysis of a plant and a compensator; no run is known.")

    def until(self, k: int) -> LoopAnalysis:
        """That of the run cut off before step k: of the controller theta(k), which must be kept."""
        run = self.run
        length = integer(k, "k") - run.first_step
        if length == run.steps:
            return self
        if k not in self._earlier:
            run.compensator_at(k)  # raises where theta(k) was not kept
            row = length // run.stride
            signals = {name: getattr(run, name)[:length] for name in SIGNALS}
            kept = {"theta": run.theta[:row], "theta_final": run.theta[row]}
            cut = replace(run, **signals, **kept, outcome="completed", state=None, D_f=None)
            self._earlier[k] = LoopAnalysis(cut, self.target)
        return self._earlier[k]

    @cached_property
    def _earlier(self) -> dict[int, LoopAnalysis]:
        return {}

    @property
    def last_step(self) -> int:
        """The last completed step of the run."""
        return self.run.first_step + max(self.run.steps - 1, 0)

    @cached_property
    def plant(self) -> Plant:
        """The plant, that of a run without its delay line."""
        return plant_at(self.of.plant, self.last_step) if isinstance(self.of, Run) else self.of[0]

    @cached_property
    def compensator(self) -> Compensator:
        """The fixed controller."""
        return self.of.compensator if isinstance(self.of, Run) else self.of[1]

    @cached_property
    def compared_with(self) -> TargetModel:
        """The target model that was given, or the one in force at the last step for all."""
        if self.target is not None:
            return self.target
        if not isinstance(self.of, Run):
            raise InputError("the target model is not known.")
        targets = []
        for settings in controllers_of(self.run.settings):
            if isinstance(settings, ControllerSettings):
                scheduled = settings.target_changes.items()
                later = [model for k, model in scheduled if k <= self.last_step]
                made = [
                    one.change.target
                    for one in self.run.changes
                    if one.change.target is not None and one.k <= self.last_step
                ]
                first = [settings.target] if settings.learning is None else []
                targets += [*first, *later, *made][-1:]
        if not targets:
            raise InputError("nothing adapts in this run, so it has no target model of its own")
        if any(other != targets[0] for other in targets[1:]):
            raise InputError("the controllers have different target models")
        return targets[0]

    @property
    def _target(self) -> TargetModel:
        """The target model, as large as the plant's G_zu."""
        target, plant = self.compared_with, self.plant
        if (target.l_z, target.l_u) != (plant.l_z, plant.l_u):
            raise InputError(
                f"the target model is {target.l_z} x {target.l_u}; the plant's G_zu is "
                f"{plant.l_z} x {plant.l_u}."
            )
        return target

    @property
    def reads_command(self) -> bool:
        """Whether the controller reads the command r beside y."""
        return self.compensator.l_y > self.plant.l_y

    @property
    def structure(self) -> Structure | None:
        """What the coefficients weigh; None for a controller of several parts, and for none."""
        settings = self.run.settings
        return settings.structure if isinstance(settings, ControllerSettings) else None

    @cached_property
    def obstacle(self) -> str:
        """Why the exact comparison does not apply; empty where it does."""
        plant = self.plant
        sizes = {"l_u": self.compensator.l_u, "l_y": plant.l_y, "l_z": plant.l_z}
        if set(sizes.values()) != {1}:
            words = ", ".join(f"{name} = {size}" for name, size in sizes.items())
            return f"it is for scalar signals, and the plant has {words}"
        if self.reads_command:
            return "it is for a controller that reads y alone, and this one reads the command too"
        return ""

    @cached_property
    def loop(self) -> ClosedLoop:
        """The closed loop, whose measurement is what the controller reads."""
        plant = measuring_command(self.plant) if self.reads_command else self.plant
        return ClosedLoop(plant, self.compensator)

    @cached_property
    def comparison(self) -> ExactComparison:
        """The controller beside the exact prediction."""
        if self.obstacle:
            raise InputError(f"there is no exact comparison here: {self.obstacle}.")
        return compare_exactly(self.plant, self.compensator, self._target)

    @cached_property
    def zeros(self) -> dict[str, ComplexArray]:
        """Closed-loop zeros from each channel of w to z; exact where the comparison is."""
        exact, _ = attempted(lambda: self.comparison.zeros)
        return dict(self.loop.zeros() if exact is None else exact)

    @cached_property
    def match(self) -> IntercalatedMatch:
        """The intercalated transfer function beside G_f."""
        target = self._target  # where there is none, this says why
        return intercalated_match(self.loop, target)

    @cached_property
    def split(self) -> ResidualSplit:
        """The retrospective residual of the whole run for the final controller.

        Behind a saturation it is that of the applied input, which the controller's own past holds.
        """
        run = self.run
        plant = run.plant
        if isinstance(plant, PlantSchedule) and plant.at(self.last_step) is not plant.changes[0]:
            raise InputError("the plant changes during the run")
        return self.split_of(u=run.u_applied, y=run.y, z=run.z, w=run.w)

    def split_of(
        self, *, u: Array, y: Array, z: Array, w: Array, r: Array | None = None
    ) -> ResidualSplit:
        """The retrospective residual of recorded signals, which begin at rest, split for it.

        Where the controller reads the command, r is its record; by default the one that w holds.
        """
        target, plant = self._target, self.loop.plant
        if self.reads_command:
            y = np.hstack([y, w @ plant.D_2[self.plant.l_y :].T if r is None else r])
        return split_residual(plant, self.compensator, target, u=u, y=y, z=z, w=w)

    def plot(self, title: str = "") -> figures.Figure:
        """One sheet: response, coefficients, poles and zeros, and the intercalated match."""
        return picture_of(self, title)


def attempted(analysis: Callable[[], Result]) -> tuple[Result | None, str]:
    """An analysis, or None and why there is none."""
    try:
        return analysis(), ""
    except CompensatorError as error:
        return None, str(error).rstrip(".")
