"""The analysis of a converged controller, whatever program it ran in."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory import figures
from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.analysis._classical import Margins, channel_margins
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._disk import DiskMargin, multivariable_disk_margin
from rcac_numeric.analysis._exact_comparison import ExactComparison
from rcac_numeric.analysis._internal_models import Drift, InternalModel, drift_of, internal_models
from rcac_numeric.analysis._loop_analysis import LoopAnalysis, attempted
from rcac_numeric.analysis._loop_costs import LoopCosts, loop_costs
from rcac_numeric.analysis._match import IntercalatedMatch, ResidualSplit
from rcac_numeric.analysis._noise import NoiseIntensities
from rcac_numeric.arrays._array_types import ComplexArray
from rcac_numeric.arrays._showing import notebook_of, picture_of, report_of
from rcac_numeric.arrays._validation import instance_of, integer
from rcac_numeric.arrays._values import Result
from rcac_numeric.checks._hypotheses import Decision
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.checks._plant_residual import PlantResidual, plant_residual
from rcac_numeric.checks._regressor import require_fit
from rcac_numeric.checks._replays import ControlReplay, replay, replay_compensator
from rcac_numeric.controllers._compensator import Compensator, compensator_of
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.engine._compatibility import command_position, controllers_of
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._foreign import agreed_times, linear_plant
from rcac_numeric.plants._functions import FunctionPlant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import plant_at
from rcac_numeric.targets._model import TargetModel

# Where `simulate` calls a loop diverged; beyond it float64 cannot multiply coefficients.
LARGEST = 1e100
NEED_THE_PLANT = ("poles", "costs", "margins", "match", "split")
NEED_THE_TARGET = ("target", "match", "split")


@dataclass(frozen=True, eq=False)
class ControllerCheck(Result):
    """What a log says of the controller that it ended with, and what it cannot say.

    Attributes
    ----------
    log, structure, plant, target : what was given.
    compensator : Compensator
        The last coefficients of the log, fixed.
    replay : ControlReplay or None
        Whether the logged u is the output of the logged theta.
    drift : Drift or None
        How far theta still moved in the last tenth of the log.
    internal_models : tuple of InternalModel
        Controller poles within 0.01 of the unit circle, and what they reject.
    loop : ClosedLoop or None
        The plant with the fixed controller: poles, frequency responses.
    zeros : mapping from channel of w to array of complex
    comparison : ExactComparison or None
        The exact characteristic polynomial beside the one that the target asks for.
    match : IntercalatedMatch or None
        The intercalated transfer function beside G_f.
    split : ResidualSplit or None
        The retrospective residual, split exactly (4.14).
    costs : LoopCosts or None
        The H2 cost with the share of each channel of w, beside LQG's.
    margins : mapping from names of channels to Margins
        Opened at each component of u in turn.
    disk : DiskMargin or None
        For several inputs at once.
    plant_residual : PlantResidual or None
        How far the log's y is from what the plant makes of the logged u; None for a run of ours
        with its own plant.
    decision : Decision or str or None
        Which problem the log is of, where that was to be decided; a text says why it could not be.
    is_fixed : bool
        Whether the controller is one that does not adapt: given as a compensator, or a run's.
    unanswered : mapping
        From what could not be answered to the reason.
    """

    log: ControllerLog
    structure: Structure | None
    compensator: Compensator
    plant: Plant | None = None
    target: TargetModel | None = None
    replay: ControlReplay | None = None
    drift: Drift | None = None
    internal_models: tuple[InternalModel, ...] = ()
    loop: ClosedLoop | None = None
    zeros: dict[str, ComplexArray] = field(default_factory=dict)
    comparison: ExactComparison | None = None
    match: IntercalatedMatch | None = None
    split: ResidualSplit | None = None
    costs: LoopCosts | None = None
    margins: dict[str, Margins] = field(default_factory=dict)
    disk: DiskMargin | None = None
    unanswered: dict[str, str] = field(default_factory=dict)
    plant_residual: PlantResidual | None = None
    decision: Decision | str | None = None
    is_fixed: bool = False

    @property
    def is_undecided(self) -> bool:
        """Whether the problem was to be decided and the log leaves it open."""
        return self.decision is not None and (
            isinstance(self.decision, str) or self.decision.is_undecided
        )

    @property
    def poles(self) -> ComplexArray | None:
        """The closed-loop poles; certified roots of the exact polynomial for scalar loops."""
        if self.comparison is not None:
            return self.comparison.poles
        return None if self.loop is None else self.loop.poles()

    @property
    def is_consistent(self) -> bool:
        """False where the logged u is not the output of the logged coefficients."""
        return self.replay is None or self.replay.agrees

    def report(self) -> str:
        """The whole check in words and numbers."""
        return report_of(self)

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        verdict = "consistent" if self.is_consistent else "u is not the controller's output"
        loop = "no plant" if self.loop is None else f"rho = {self.loop.spectral_radius:.6g}"
        return f"ControllerCheck({verdict}, {loop}, {len(self.unanswered)} unanswered)"

    def _repr_html_(self) -> str:
        """What a notebook shows: the report and its sheet of pictures."""
        return notebook_of(self, self.plot)

    def plot(self) -> figures.Figure:
        """One sheet: signals and coefficients, poles, the match and the Nyquist curve."""
        return picture_of(self)


def check_controller(
    u: ArrayLike | ControllerLog | Run,
    y: ArrayLike | None = None,
    *,
    z: ArrayLike | None = None,
    w: ArrayLike | None = None,
    r: ArrayLike | None = None,
    theta: ArrayLike | None = None,
    structure: Structure | None = None,
    compensator: Compensator | None = None,
    plant: Plant | None = None,
    target: TargetModel | None = None,
    noise: NoiseIntensities | None = None,
    k_w: int | None = None,
    sample_time: float | None = None,
    tolerance: float | None = None,
) -> ControllerCheck:
    """Analyse the controller that a log ended with: ours, or anybody's.

    Parameters
    ----------
    u, y : arrays, shape (steps, l_u), (steps, l_y)
        Or a ControllerLog in place of all the signals and theta; or a Run, which knows its
        structure, plant, target model and k_w too. What is given beside it goes before.
    z, w, r : arrays, optional
        Performance, exogenous input, command. The split of the residual needs z and w.
    theta : array, shape (steps, l_theta) or (l_theta,)
        The coefficients, with the structure that they belong to.
    structure : Structure, optional
    compensator : Compensator, or a transfer function in q, optional
        In place of theta and structure. (D_c and N_c of a log do the same.)
    plant : Plant, optional
        Or a discrete system of python-control, SciPy or SymPy, read by `plant_of`. Without it
        there are no poles, margins, costs or match.
    target : TargetModel, optional
    noise : mapping, optional
        Intensities of blocks or channels of w for the H2 costs, as for `h2_cost`.
    k_w : int, optional
        First step with u = Phi theta; beside a compensator the one since which it made u. By
        default that is held against the last tenth of the log alone.
    sample_time : float, optional
        In seconds.
    tolerance : float, optional
        The relative difference between u and Phi theta that counts as none; by default what the
        digits of the log leave open.

    Returns
    -------
    ControllerCheck

    Raises
    ------
    InputError
        Where sizes do not fit, or neither coefficients nor compensator are given.
    DivergedError
        Where the log ended with coefficients beyond 1e100.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, Step, check_controller, exogenous, fir_target, iir, simulate,
    ...     standard_plant)
    >>> plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=fir_target(plant), update=UD(R_theta=1e-4))
    >>> run = simulate(plant, settings, exogenous([Step()], steps=1000))
    >>> check = check_controller(run.u, run.y, z=run.z, w=run.w, theta=run.theta,
    ...     structure=iir(n_c=2), plant=plant, target=settings.target)
    >>> check.replay.agrees, check.drift.is_converged, check.loop.is_stable
    (True, True, True)
    >>> check_controller(run.u, run.y, theta=run.theta, structure=iir(n_c=2)).unanswered["poles"]
    'the plant is not known'
    """
    plant = None if plant is None else linear_plant(plant)
    knows_its_plant = isinstance(u, Run) and plant is None
    is_fixed = isinstance(u.settings, FixedController) if isinstance(u, Run) else False
    is_fixed |= compensator is not None
    if isinstance(u, Run):
        own = arguments_of_run(u)
        u = own["log"]
        plant = own.get("plant") if plant is None else plant
        target = own.get("target") if target is None else target
        if structure is None and compensator is None:
            structure, compensator = own.get("structure"), own.get("compensator")
            k_w = own.get("k_w") if k_w is None else k_w
    log = _log_of(u, y=y, z=z, w=w, r=r, theta=theta)
    if target is not None:
        instance_of(target, "target", TargetModel)
    agreed_times([plant, compensator], sample_time)
    if k_w is not None:
        integer(k_w, "k_w")
    fixed = fixed_compensator(log, structure, compensator)
    _require_bounded(log, fixed)
    check = ControllerCheck(log, structure, fixed, plant, target, is_fixed=is_fixed)
    used = None if compensator is not None else structure
    if compensator is None and (log.theta is None or structure is None):
        k_w = None  # polynomials of a log are those that it ended with
    check = _with_log(check, used, k_w, tolerance)
    if plant is None:
        if noise is not None:
            raise InputError("noise is for the H2 costs, and they need the plant; give both.")
        nothing = dict.fromkeys(NEED_THE_PLANT, "the plant is not known")
        check = replace(check, unanswered=check.unanswered | nothing)
    else:
        with np.errstate(over="ignore", invalid="ignore"):  # an unstable loop leaves float64
            check = _with_loop(check, plant)
            if not knows_its_plant:  # a run's plant may have changed on the way
                check = replace(check, plant_residual=plant_residual(log, plant))
        check = _with_costs_and_margins(check, noise, sample_time)
    return replace(check, internal_models=internal_models(fixed, check.loop))


def _log_of(signals: ArrayLike | ControllerLog, **arrays: Any) -> ControllerLog:
    if not isinstance(signals, ControllerLog):
        return ControllerLog(u=signals, **arrays)
    if any(values is not None for values in arrays.values()):
        raise InputError("give a ControllerLog, or arrays, not both.")
    return signals


def _require_bounded(log: ControllerLog, fixed: Compensator) -> None:
    largest = max(np.abs(fixed.past_u).max(initial=0), np.abs(fixed.past_y).max())
    if largest > LARGEST:
        raise DivergedError(
            f"{log.source}: the controller has a coefficient of size {largest:.3g}: the loop has "
            "diverged. Cut the log before that."
        )


def _with_log(
    check: ControllerCheck, structure: Structure | None, k_w: int | None, tolerance: float | None
) -> ControllerCheck:
    """What the log says by itself; with a structure its theta made u, else a compensator did."""
    log, fixed = check.log, check.compensator
    if log.theta is not None and structure is not None:
        replayed = replay(log, structure, k_w=k_w, tolerance=tolerance)
        if log.theta.ndim == 2:
            return replace(check, replay=replayed, drift=drift_of(log.theta))
        reason = "theta was logged only once"
        return replace(check, replay=replayed, unanswered={"convergence": reason})
    reason = "no theta was logged" if log.theta is None else "theta was not used"
    if log.steps > len(fixed.past_u):
        replayed = replay_compensator(log, fixed, k_w=k_w, tolerance=tolerance)
        return replace(check, replay=replayed, unanswered={"convergence": reason})
    short = f"the log of {log.steps} steps does not fill the controller's memory"
    return replace(check, unanswered={"convergence": reason, "replay": short})


def _with_loop(check: ControllerCheck, plant: Plant) -> ControllerCheck:
    """The loop with that plant: poles and zeros, and what it is beside the target model."""
    require_widths(check.log, plant)
    analysis = LoopAnalysis((plant, check.compensator), check.target)
    check = replace(check, loop=analysis.loop)
    if check.target is None:
        nothing = dict.fromkeys(NEED_THE_TARGET, "the target model is not known")
        check = replace(check, unanswered=check.unanswered | nothing)
    else:
        check = _against_target(check, analysis)
    if check.comparison is not None or plant.l_z == 1:
        return replace(check, zeros=analysis.zeros)
    reason = f"they are for one z, and the plant has l_z = {plant.l_z}"
    return replace(check, unanswered=check.unanswered | {"zeros": reason})


def _against_target(check: ControllerCheck, analysis: LoopAnalysis) -> ControllerCheck:
    comparison, no_comparison = attempted(lambda: analysis.comparison)
    match, no_match = attempted(lambda: analysis.match)
    split, no_split = _split(check.log, analysis)
    reasons = {"exact poles": no_comparison, "match": no_match, "split": no_split}
    reasons = {name: reason for name, reason in reasons.items() if reason}
    return replace(
        check,
        comparison=comparison,
        match=match,
        split=split,
        unanswered=check.unanswered | reasons,
    )


def _split(log: ControllerLog, analysis: LoopAnalysis) -> tuple[ResidualSplit | None, str]:
    """The split of the logged residual, or why there is none."""
    if log.w is None:
        return None, "the exogenous input w was not logged"
    if log.z is None:
        return None, "the performance z was not logged"
    u, y, z, w, r = log.u, log.y, log.z, log.w, log.r
    return attempted(lambda: analysis.split_of(u=u, y=y, z=z, w=w, r=r))


def _with_costs_and_margins(
    check: ControllerCheck, noise: NoiseIntensities | None, sample_time: float | None
) -> ControllerCheck:
    loop = check.loop
    assert loop is not None
    costs = loop_costs(loop, noise)
    margins, reasons = channel_margins(loop, sample_time)
    several = loop.plant.l_u > 1 and loop.is_stable
    disk = multivariable_disk_margin(loop) if several else None
    return replace(
        check, costs=costs, margins=margins, disk=disk, unanswered=check.unanswered | reasons
    )


# A run of our own as what a check needs: its log, its controller, its plant.


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


def fixed_compensator(
    log: ControllerLog, structure: Structure | None, compensator: Compensator | None
) -> Compensator:
    """The controller at the end of the log."""
    if compensator is not None:
        return compensator_of(compensator)
    if log.theta_final is not None and structure is not None:
        require_fit(log, structure)
        return structure.compensator(log.theta_final)
    if log.D_c is not None and log.N_c is not None:
        return _from_polynomials(log)
    what = "theta needs the structure it belongs to" if log.theta is not None else "no theta"
    raise InputError(
        f"{log.source}: {what}; give theta with a structure such as iir(n_c=4), D_c and N_c, or a "
        "Compensator."
    )


def _from_polynomials(log: ControllerLog) -> Compensator:
    assert log.D_c is not None and log.N_c is not None
    D_c, N_c = np.trim_zeros(log.D_c, "f"), np.trim_zeros(log.N_c, "f")
    if not len(D_c) or len(N_c) > len(D_c):
        raise InputError(
            f"{log.source}: D_c has degree {len(D_c) - 1} and N_c degree {len(N_c) - 1}; the "
            "controller would use future values, or is none."
        )
    with np.errstate(over="ignore"):
        N_c = np.concatenate([np.zeros(len(D_c) - len(N_c)), N_c]) / D_c[0]
        D_c = D_c / D_c[0]
    if not (np.isfinite(D_c).all() and np.isfinite(N_c).all()):
        raise InputError(
            f"{log.source}: the leading coefficient of D_c is so small that D_c and N_c divided by "
            "it leave float64; scale both."
        )
    return Compensator((-D_c[1:])[:, None, None], N_c[:, None, None])


def require_widths(log: ControllerLog, plant: Plant) -> None:
    """Refuse a log whose signals are not as wide as those of the plant."""
    for name in ("u", "y", "z", "w"):
        signal, width = getattr(log, name), getattr(plant, f"l_{name}")
        if signal is not None and signal.shape[1] != width:
            raise InputError(
                f"{log.source}: {name} has {signal.shape[1]} components; the plant has l_{name} = "
                f"{width}."
            )
