"""A run of our own as what a check needs: its log, its controller, its plant."""

from __future__ import annotations

from typing import Any, TypedDict

from compensator_theory.errors import InputError
from rcac_numeric.checks.logs import ControllerLog
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.controllers.stepwise import StepwiseController
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.engine.compatibility import command_position, controllers_of
from rcac_numeric.engine.runs import Run
from rcac_numeric.plants.frozen import plant_at
from rcac_numeric.plants.functions import FunctionPlant
from rcac_numeric.plants.linear import Plant
from rcac_numeric.targets.model import TargetModel


class RunArguments(TypedDict, total=False):
    """What a run knows: keyword arguments of `check_controller`, and its log."""

    log: ControllerLog
    plant: Plant
    target: TargetModel
    structure: Structure
    compensator: Compensator
    k_w: int


def arguments_of_run(run: Run, source: str = "run") -> RunArguments:
    """The arguments of `check_controller` that a run knows by itself.

    Behind a saturation, and for several controllers or a fixed one, in parallel too, it is handed
    over as a compensator: no single theta makes the logged u.

    Examples
    --------
    >>> from rcac_numeric import load_example
    >>> from rcac_numeric.checks.runs import arguments_of_run
    >>> arguments = arguments_of_run(load_example("4.7").main_run.execute().first.run)
    >>> sorted(arguments)
    ['k_w', 'log', 'plant', 'structure', 'target']
    """
    if not run.steps:
        raise InputError("the run has no step that could be checked.")
    if isinstance(run.settings, StepwiseController):
        run.settings.compensator_of(())  # says why there is none
    known: RunArguments = {}
    last = run.first_step + run.steps - 1
    if not isinstance(run.plant, FunctionPlant):
        known["plant"] = plant_at(run.plant, last)
    settings = run.settings
    signals: dict[str, Any] = {"u": run.u_applied, "y": run.y, "z": run.z, "w": run.w}
    if l_r := max(one.l_r for one in controllers_of(settings)):
        start = command_position(run.plant, l_r)
        signals["r"] = run.w[:, start : start + l_r]
    if isinstance(settings, ControllerSettings):
        changes = [model for k, model in sorted(settings.target_changes.items()) if k <= last]
        known["target"] = [settings.target, *changes][-1]
        if run.saturation is None and settings.fixed is None and not run.first_step:
            known["structure"], known["k_w"] = settings.structure, settings.k_w
            signals["theta"] = run.theta if run.stride == 1 else run.theta_final
    if "structure" not in known:
        known["compensator"] = run.compensator
    known["log"] = ControllerLog(**signals, source=source)
    return known
