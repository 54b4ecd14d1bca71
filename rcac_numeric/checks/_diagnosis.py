"""The health of a run, of a verification's main run, or of a logged controller."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol, runtime_checkable

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.analysis._classical import channel_margins
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.checks._check import ControllerCheck
from rcac_numeric.checks._health import (
    LoopHealth,
    SignalSize,
    excitation_of,
    signal_health,
    without_control,
)
from rcac_numeric.checks._rules import warnings_of_check, warnings_of_controller, warnings_of_run
from rcac_numeric.checks._trials import cost_over_lqg, missed_poles, next_disturbance
from rcac_numeric.controllers._bounds import CertifiedBounds
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.engine._compatibility import controllers_of
from rcac_numeric.engine._controller import Controller
from rcac_numeric.engine._runs import Run

NO_LOOP = "the logged u is not the output of the logged controller"


@runtime_checkable
class HasMainLoop(Protocol):
    """An object with a main analysed loop, such as a verification."""

    @property
    def main_loop(self) -> LoopAnalysis:
        """The analysis of the main loop."""


def loop_health(
    of: Run | LoopAnalysis | HasMainLoop | ControllerCheck | Controller,
) -> LoopHealth:
    """The health of a loop: stability, sizes of signals, margins, arithmetic, excitation.

    Parameters
    ----------
    of : Run, Verification, ControllerCheck or Controller
        Of a verification, its main run; of a controller that is driven step by step, what its
        supervision noted so far.

    Raises
    ------
    InputError
        Where it is none of these, or an exact example, which runs nothing.

    Examples
    --------
    >>> from rcac_numeric import FixedController, Step, exogenous, lqg_controller, simulate
    >>> from rcac_numeric import loop_health, standard_plant
    >>> plant = standard_plant("1/(q - 1.2)")
    >>> controller = FixedController(lqg_controller(plant).compensator)
    >>> loop_health(simulate(plant, controller, exogenous([Step()], steps=100))).is_stable
    True
    """
    match of:
        case ControllerCheck():
            return _of_check(of)
        case LoopAnalysis():
            return _of_run(of)
        case Run():
            return _of_run(LoopAnalysis(of))
        case Controller():
            return _of_controller(of)
        case HasMainLoop():
            return _of_run(of.main_loop)
    raise InputError(
        f"loop_health of {type(of).__name__}: give a Run, a Verification, a ControllerCheck or "
        "a Controller."
    )


def _of_run(analysis: LoopAnalysis) -> LoopHealth:
    run = analysis.run
    k_w = 0
    if not isinstance(run.settings, StepwiseController):
        k_w = min(one.k_w for one in controllers_of(run.settings))
    start = max(k_w - run.first_step, 0)
    free = without_control(run)
    signals = {"z": signal_health(run.z, start), "u": signal_health(run.u, start)}
    if not np.array_equal(run.u, run.u_applied, equal_nan=True):
        signals["u_applied"] = signal_health(run.u_applied, start)
    health = LoopHealth(
        outcome=run.outcome,
        steps=run.steps,
        k_w=k_w,
        signals=signals,
        free=None if free is None else SignalSize.of(free[-max(len(free) // 10, 1) :]),
        guard_count=run.guard_count,
        guard_first_step=run.guard_first_step,
        bounded=run.bounded,
        excitation=excitation_of(run),
        supervision=run.supervision,
        next_disturbance=next_disturbance(run),
        missed_by=missed_poles(analysis),
        cost_ratio=cost_over_lqg(analysis),
        radius=largest_radius(run),
        **_of_loop(lambda: analysis.loop),
    )
    return replace(health, warnings=warnings_of_run(health, analysis))


def largest_radius(run: Run) -> float | None:
    """Return the largest share of the radius of CertifiedBounds, that of theta_final included."""
    bounds = run.settings.bounds if isinstance(run.settings, ControllerSettings) else None
    if not isinstance(bounds, CertifiedBounds):
        return None
    return float(bounds.radius_of(np.vstack([run.theta, run.theta_final])).max())


def _of_controller(controller: Controller) -> LoopHealth:
    record = controller.record
    health = LoopHealth(
        is_stable=None,
        spectral_radius=None,
        outcome="",
        steps=controller.k,
        k_w=controller.settings.k_w,
        signals={},
        guard_count=controller.guard_count,
        bounded=controller.bounded,
        supervision=record,
        radius=None if controller.radius is None else max(controller.radius, record.radius),
        obstacle="the plant is not known",
    )
    return replace(health, warnings=warnings_of_controller(health, record))


def _of_check(check: ControllerCheck) -> LoopHealth:
    log = check.log
    moving = np.flatnonzero(log.u.any(axis=1))
    start = int(moving[0]) if len(moving) else 0
    signals = {"u": signal_health(log.u, start)}
    if log.z is not None:
        signals = {"z": signal_health(log.z, start), **signals}
    elif log.y is not None:
        signals = {"y": signal_health(log.y, start), **signals}
    loop, obstacle = check.loop, "the plant is not known"
    if loop is not None and not check.is_consistent:
        loop, obstacle = None, NO_LOOP
    health = LoopHealth(
        is_stable=None if loop is None else loop.is_stable,
        spectral_radius=None if loop is None else loop.spectral_radius,
        outcome="",
        steps=log.steps,
        k_w=start,
        signals=signals,
        margins={} if loop is None else check.margins,
        obstacle=obstacle if loop is None else "",
    )
    return replace(health, warnings=warnings_of_check(health, check))


def _of_loop(evaluate: Callable[[], ClosedLoop]) -> dict[str, Any]:
    """Stability and margins of a frozen loop, or the obstacle."""
    nothing: dict[str, Any] = {"is_stable": None, "spectral_radius": None}
    try:
        with np.errstate(all="ignore"):
            loop = evaluate()
            radius = loop.spectral_radius
            if not np.isfinite(radius):
                return {**nothing, "obstacle": "the controller left the range of float64"}
            known = {"is_stable": loop.is_stable, "spectral_radius": radius}
            return {**known, "margins": channel_margins(loop, disk=False)[0]}
    except (CompensatorError, np.linalg.LinAlgError) as error:
        return {**nothing, "obstacle": str(error).rstrip(".")}
