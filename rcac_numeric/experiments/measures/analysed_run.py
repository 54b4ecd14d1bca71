"""A run with the analyses that are asked of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from compensator_theory.errors import InputError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.analysis.exact_comparison import ExactComparison
from rcac_numeric.analysis.loop_analysis import LoopAnalysis, attempted
from rcac_numeric.analysis.match import IntercalatedMatch
from rcac_numeric.analysis.residual_split import ResidualSplit
from rcac_numeric.arrays import figures
from rcac_numeric.arrays.array_types import ComplexArray
from rcac_numeric.arrays.showing import picture_of
from rcac_numeric.arrays.validation import integer
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine.compatibility import controllers_of
from rcac_numeric.engine.runs import Run
from rcac_numeric.plants.frozen import plant_at
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.targets.model import TargetModel

SIGNALS = ("w", "u", "y", "z", "u_applied")


@dataclass(frozen=True, eq=False)
class AnalysedRun(Value):
    """A run with the analyses that claims ask of it, each made once and when it is needed.

    Parameters
    ----------
    run : Run
    target : TargetModel, optional
        What its last controller is compared with; by default the target model that its settings
        adapt to at the last step.

    Examples
    --------
    >>> from rcac_numeric import target_model
    >>> from rcac_numeric.dissertation import load_example
    >>> from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
    >>> run = load_example("4.7").main_run.execute().first.run
    >>> AnalysedRun(run).match.worst < 1e-5, AnalysedRun(run, target_model("1/q")).match.worst > 0.1
    (True, True)
    """

    run: Run
    target: TargetModel | None = None

    def until(self, k: int) -> AnalysedRun:
        """The same run cut off before step k: the controller theta(k), which must be kept."""
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
            self._earlier[k] = AnalysedRun(cut, self.target)
        return self._earlier[k]

    @cached_property
    def _earlier(self) -> dict[int, AnalysedRun]:
        return {}

    @property
    def is_scalar(self) -> bool:
        """Whether the exact comparison applies."""
        return not self.obstacle

    @property
    def obstacle(self) -> str:
        """Why the exact comparison does not apply; empty where it does."""
        return self._analysis.obstacle

    @cached_property
    def plant(self) -> Plant:
        """The plant of the last completed step, without its delay line."""
        return plant_at(self.run.plant, self.last_step)

    @property
    def last_step(self) -> int:
        """The last completed step."""
        return self.run.first_step + max(self.run.steps - 1, 0)

    @cached_property
    def compared_with(self) -> TargetModel:
        """The target model that was given, or the one in force at the last step for all."""
        if self.target is not None:
            return self.target
        targets = []
        for settings in controllers_of(self.run.settings):
            if isinstance(settings, ControllerSettings):
                changes = settings.target_changes
                later = [model for k, model in changes.items() if k <= self.last_step]
                told = [
                    one.change.target
                    for one in self.run.changes
                    if one.change.target is not None and one.k <= self.last_step
                ]
                first = [settings.target] if settings.learning is None else []
                targets += [*first, *later, *told][-1:]
        if not targets:
            raise InputError("nothing adapts in this run, so it has no target model of its own")
        if any(other != targets[0] for other in targets[1:]):
            raise InputError("the controllers have different target models")
        return targets[0]

    @property
    def loop(self) -> ClosedLoop:
        """The plant of the last step in a loop with the final controller."""
        return self._analysis.loop

    @property
    def zeros(self) -> dict[str, ComplexArray]:
        """Closed-loop zeros from each channel of w to z with the final controller."""
        return self._analysis.zeros

    @property
    def comparison(self) -> ExactComparison:
        """The final controller beside the exact prediction."""
        analysis = self._against_target if self.is_scalar else self._analysis
        return analysis.comparison

    @property
    def match(self) -> IntercalatedMatch:
        """The intercalated transfer function of the final controller beside G_f."""
        return self._against_target.match

    @cached_property
    def split(self) -> ResidualSplit:
        """The retrospective residual of the whole run for the final controller.

        Behind a saturation it is that of the applied input, which the controller's own past holds.
        """
        run = self.run
        plant = run.plant
        if isinstance(plant, PlantSchedule) and plant.at(self.last_step) is not plant.changes[0]:
            raise InputError("the plant changes during the run")
        return self._against_target.split(u=run.u_applied, y=run.y, z=run.z, w=run.w)

    @cached_property
    def _analysis(self) -> LoopAnalysis:
        """What there is a target model for, and what needs none."""
        target, _ = attempted(lambda: self.compared_with)
        return LoopAnalysis(self.plant, self.run.compensator, target)

    @property
    def _against_target(self) -> LoopAnalysis:
        _ = self.compared_with  # where there is none, this says why
        return self._analysis

    def plot(self, title: str = "") -> figures.Figure:
        """One sheet: response, coefficients, poles and zeros, and the intercalated match."""
        return picture_of(self, title)
