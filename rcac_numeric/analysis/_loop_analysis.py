"""Analyses of a loop with a fixed controller and a target model, computed on demand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar, cast

import numpy as np

import compensator_theory as exact
from compensator_theory import figures
from compensator_theory.errors import Advice, CompensatorError, InputError
from rcac_numeric.analysis._certified_tail import CertifiedTail, tail_of_run
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._exact_comparison import ExactComparison, comparison_of
from rcac_numeric.analysis._match import (
    IntercalatedMatch,
    ResidualSplit,
    intercalated_match,
    split_residual,
)
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._showing import notebook_of, report_of
from rcac_numeric.arrays._validation import instance_of, integer
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator, compensator_of
from rcac_numeric.controllers._predictive_cost import PredictiveCost
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.engine._compatibility import controllers_of
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule, measuring_command, plant_at
from rcac_numeric.targets._filters import target_model
from rcac_numeric.targets._model import TargetModel

Result = TypeVar("Result")
SIGNALS = ("w", "u", "y", "z", "u_applied")


@dataclass(frozen=True, eq=False)
class LoopAnalysis(Value):
    """Analysis of a loop with a fixed controller, or with the final controller of a run.

    Parameters
    ----------
    of : Run, or a pair of a plant and a compensator
        Of a run it is the plant of the last completed step with the controller after it. Plant and
        compensator may each be a transfer function in q, as a text too; a compensator reads y, or
        [y; r].
    target : TargetModel or transfer function in q, optional
        By default, of a run, the one that its settings adapt to at the last step. Without any
        there is nothing to compare with: `comparison`, `match` and `split` raise.

    Raises
    ------
    InputError
        Where it is neither a run nor such a pair, or the target model cannot be read.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, Compensator, ControllerSettings, LoopAnalysis, Step, exogenous, fir_target, iir,
    ...     simulate, standard_plant, target_model)
    >>> from rcac_numeric.analysis._loop_analysis import attempted
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = ControllerSettings(structure=iir(2), target=fir_target(plant), update=UD(1e-10))
    >>> run = simulate(plant, settings, exogenous([Step()], steps=300))
    >>> other = target_model("1/(2*q)")
    >>> LoopAnalysis(run).match.worst < 1e-5, LoopAnalysis(run, other).match.worst > 0.1
    (True, True)
    >>> plant = standard_plant("1/(q - 2)")
    >>> compensator = Compensator(past_u=[[[-2.0]]], past_y=[[[0.0]], [[-4.0]]])
    >>> analysis = LoopAnalysis((plant, compensator), fir_target(plant))
    >>> analysis.comparison.worst_distance, analysis.match.worst < 1e-12
    (0.0, True)
    >>> attempted(lambda: LoopAnalysis((plant, compensator)).match)
    (None, 'the target model is missing; give it as target=')
    """

    of: Run | tuple[AnyPlant | str, Compensator | str]
    target: TargetModel | None = None

    def __post_init__(self) -> None:
        of, target = cast("tuple[object, object]", (self.of, self.target))  # unconverted arguments
        if not isinstance(of, Run):
            if not isinstance(of, tuple) or len(of) != 2:
                raise InputError(
                    f"a {type(of).__name__} is not a loop; give a Run, or a pair of a plant and a "
                    "compensator."
                )
            object.__setattr__(self, "of", (linear_plant(of[0]), compensator_of(of[1])))
        if isinstance(target, str | exact.TransferFunction):
            object.__setattr__(self, "target", target_model(target))
        elif target is not None:
            instance_of(target, "target", TargetModel)

    @property
    def run(self) -> Run:
        """The analysed run."""
        if isinstance(self.of, Run):
            return self.of
        raise InputError("the analysis has a plant and a compensator, but no run; give a Run.")

    def until(self, k: int) -> LoopAnalysis:
        """Return the analysis of the run up to step k, with the controller theta(k)."""
        run = self.run
        length = integer(k, "k") - run.first_step
        if length == run.steps:
            return self
        if k not in self._earlier:
            run.compensator_at(k)  # raises if theta(k) was not stored
            row = length // run.stride
            signals = {name: getattr(run, name)[:length] for name in SIGNALS}
            rows = {"theta": run.theta[:row], "theta_final": run.theta[row]}
            cut = replace(run, **signals, **rows, outcome="completed", state=None, D_f=None)
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
        if isinstance(self.of, Run):
            return plant_at(self.of.plant, self.last_step)
        return linear_plant(self.of[0])

    @cached_property
    def compensator(self) -> Compensator:
        """The fixed controller."""
        return self.of.compensator if isinstance(self.of, Run) else compensator_of(self.of[1])

    @cached_property
    def compared_with(self) -> TargetModel:
        """The target model: the given one, or that of all controllers at the last step."""
        if self.target is not None:
            return self.target
        if not isinstance(self.of, Run):
            raise InputError("the target model is missing; give it as target=.")
        if isinstance(self.run.settings, StepwiseController):
            raise InputError(
                f"a {type(self.run.settings).__name__} adapts to no target model; give one as "
                "target=."
            )
        targets = []
        for settings in controllers_of(self.run.settings):
            if isinstance(settings, ControllerSettings):
                scheduled = settings.target_changes.items()
                later = [model for k, model in scheduled if k <= self.last_step]
                comparisons = [
                    one.change.target
                    for one in self.run.changes
                    if one.change.target is not None and one.k <= self.last_step
                ]
                first = [settings.target] if settings.learning is None else []
                targets += [*first, *later, *comparisons][-1:]
        if not targets:
            raise InputError("the controller of this run is fixed, so it has no target model")
        if any(other != targets[0] for other in targets[1:]):
            raise InputError("the controllers have different target models")
        return targets[0]

    @property
    def _target(self) -> TargetModel:
        """Return the target model, checked for the size of G_zu."""
        target, plant = self.compared_with, self.plant
        if (target.l_z, target.l_u) != (plant.l_z, plant.l_u):
            raise InputError(
                f"the target model is {target.l_z} x {target.l_u}; the plant's G_zu is "
                f"{plant.l_z} x {plant.l_u}."
            )
        return target

    @property
    def reads_command(self) -> bool:
        """Whether the controller reads the command r."""
        return self.compensator.l_y > self.plant.l_y

    @property
    def structure(self) -> Structure | None:
        """The structure of the controller; None for several controllers, and for a fixed one."""
        settings = self.run.settings
        return settings.structure if isinstance(settings, ControllerSettings) else None

    @cached_property
    def obstacle(self) -> str:
        """The reason why the exact comparison does not apply; empty if it does."""
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
        """The closed loop; its measurement is the input of the controller."""
        plant = measuring_command(self.plant) if self.reads_command else self.plant
        return ClosedLoop(plant, self.compensator)

    @cached_property
    def comparison(self) -> ExactComparison:
        """The comparison of the controller with the exact prediction."""
        if self.obstacle:
            raise InputError(f"the exact comparison does not apply: {self.obstacle}.")
        return comparison_of(self.plant, self.compensator, self._target)

    @cached_property
    def zeros(self) -> dict[str, ComplexArray]:
        """Closed-loop zeros from each channel of w to z; exact if the comparison applies."""
        zeros, _ = attempted(lambda: self.comparison.zeros)
        return dict(self.loop.zeros() if zeros is None else zeros)

    @cached_property
    def match(self) -> IntercalatedMatch:
        """The intercalated transfer function compared with G_f."""
        target = self._target  # raises the reason if there is none
        return intercalated_match(self.loop, target)

    @cached_property
    def certified(self) -> CertifiedTail:
        """The first step from which the run is proved stable, as by `certified_from`."""
        return tail_of_run(self.run)

    @cached_property
    def split(self) -> ResidualSplit:
        """The split of the retrospective residual of the run for the final controller.

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
        """Split the retrospective residual of recorded signals that begin at rest.

        Where the controller reads the command, r is its record; by default the one that w holds.
        """
        target, plant = self._target, self.loop.plant
        if self.reads_command:
            y = np.hstack([y, w @ plant.D_2[self.plant.l_y :].T if r is None else r])
        return split_residual(plant, self.compensator, target, u=u, y=y, z=z, w=w)

    def _sheet(self) -> Any:
        from rcac_numeric.reports._loop import analysis_sheet

        return analysis_sheet(self)

    def report(self) -> str:
        """Return the report: poles and zeros, the intercalated match, the residual split."""
        return report_of(self._sheet())

    def __str__(self) -> str:
        """Return the state of the analysis in a few lines; `report` has the whole analysis."""
        stable = "stable" if self.loop.is_stable else "unstable"
        lines = [f"the closed loop is {stable}, spectral radius {self.loop.spectral_radius:.6g}"]
        comparison, reason = attempted(lambda: self.comparison)
        lines.append(reason if comparison is None else comparison.verdict)
        lines.append("report() has poles, zeros, the intercalated match and the residual split")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"LoopAnalysis({self.of!r})"

    def _repr_html_(self) -> str:
        """Return the notebook view: the report and the plots."""
        return notebook_of(self._sheet(), self.plot)

    def plot(self, title: str = "") -> figures.Figure:
        """Plot response, coefficients, poles and zeros, and the intercalated match."""
        from rcac_numeric.plots._run import plot_sheet

        return plot_sheet(self, title)


def closed_loop(of: ClosedLoop | LoopAnalysis | Run | tuple[AnyPlant, Compensator]) -> ClosedLoop:
    """Return the closed loop of a run with its final controller, or of plant and compensator."""
    if isinstance(of, ClosedLoop):
        return of
    if isinstance(of, LoopAnalysis):
        return of.loop
    return LoopAnalysis(of).loop


def attempted(analysis: Callable[[], Result]) -> tuple[Result | None, str]:
    """Return (analysis, "") or (None, reason)."""
    try:
        return analysis(), ""
    except CompensatorError as error:
        return None, str(error).rstrip(".")


def compare_exactly(
    of: Run | AnyPlant, compensator: Compensator | None = None, target: TargetModel | None = None
) -> ExactComparison:
    """Compare the final controller of a run, or any compensator, with the exact prediction.

    The closed-loop polynomial D D_c - N_yu N_c of the float64 coefficients, which are dyadic
    rationals, is exact. It is compared with the polynomial at which the intercalated
    transfer function (4.18) equals the target model G_f, and with every compensator of this order
    that places it.

    Parameters
    ----------
    of : Run, Plant, or a system that `plant_of` reads
        Of a run it is the plant of its last step with the controller after it. u, y and z are
        scalar.
    compensator : Compensator, or a transfer function in q
        With a plant; of a run its last controller.
    target : TargetModel or transfer function in q, optional
        With exact data: built by `fir_target`, `pole_placement_target` or `target_model`. Of a run
        by default the one that it adapted to.

    Raises
    ------
    InputError
        Where a signal is not scalar, or there is no compensator or no target model.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, Compensator, ControllerSettings, Step, compare_exactly, exogenous, iir,
    ...     pole_placement_target, simulate, standard_plant)
    >>> plant = standard_plant("1/(q - 2)")
    >>> target = pole_placement_target(plant, ["1/2", "1/4"])
    >>> converged = Compensator(past_u=[[[-1.25]]], past_y=[[[0.0]], [[-2.625 + 1e-6]]])
    >>> comparison = compare_exactly(plant, converged, target)
    >>> comparison.requested
    Poly(q**2 - 3/4*q + 1/8, q, domain='QQ')
    >>> round(comparison.worst_distance, 8), round(comparison.controller_distance, 8)
    (4e-06, 1e-06)

    Of a run nothing else is needed:

    >>> plant = standard_plant("(q**2 - 1.44*q + 0.81)/((q - 0.9)*(q**2 - 1.71*q + 0.903))")
    >>> target = pole_placement_target(plant, ["1/2", "-1/2", "4j/5", "-4j/5"])
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=4), target=target, update=UD(R_theta=1e-10), k_w=50)
    >>> run = simulate(plant, settings, exogenous([Step()], steps=100))
    >>> compare_exactly(run)  # doctest: +ELLIPSIS
    ExactComparison(worst_distance=...e-06, backward_error=...e-06)
    >>> compare_exactly(run).report().splitlines()[2].strip()
    'Characteristic polynomial D D_c - N_yu N_c:'
    """
    if isinstance(of, Run):
        if compensator is not None:
            raise InputError("a run contains its controller; leave compensator out.")
        if target is None and isinstance(of.settings, PredictiveCost):
            raise InputError(
                "a PredictiveCost adapts to no target model. ",
                Advice(
                    "predictive_cost_limit", (), "Compare with its exact limit by {function}(run)"
                ),
                ".",
            )
        return LoopAnalysis(of, target).comparison
    if compensator is None:
        raise InputError("a loop needs a controller; give a Run, or a plant and its Compensator.")
    return LoopAnalysis((of, compensator), target).comparison
