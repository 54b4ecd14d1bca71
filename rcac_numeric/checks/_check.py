"""The analysis of a converged controller from any program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, TypedDict, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory import figures
from compensator_theory._few_lines import in_few_lines
from compensator_theory.errors import CompensatorError, DivergedError, InputError
from rcac_numeric.analysis._certified_tail import (
    CertifiedTail,
    certified_from_log,
    tail_of_run,
)
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
from rcac_numeric.arrays._showing import notebook_of, report_of, summary_of
from rcac_numeric.arrays._validation import instance_of, integer
from rcac_numeric.arrays._values import Result, replaced
from rcac_numeric.checks._convention_search import (
    ConventionSearch,
    search_conventions,
    search_signs,
)
from rcac_numeric.checks._conventions import OURS, OWN_U, Convention, convention_of
from rcac_numeric.checks._hypotheses import Decision
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.checks._plant_residual import PlantResidual, plant_residual
from rcac_numeric.checks._regressor import require_fit
from rcac_numeric.checks._replays import ControlReplay, Replayer, limits_of_u, replay_compensator
from rcac_numeric.checks._run_replays import replay_run
from rcac_numeric.checks._sample_shifts import SampleShift, search_sample_shifts
from rcac_numeric.controllers._compensator import Compensator, compensator_of
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.engine._compatibility import AnyController, command_position, controllers_of
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._foreign import agreed_times, linear_plant
from rcac_numeric.plants._functions import FunctionPlant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._saturation import Saturation
from rcac_numeric.plants._schedules import plant_at
from rcac_numeric.signals._log_signals import require_sample_time
from rcac_numeric.targets._model import TargetModel

# Where `simulate` calls a loop diverged; beyond it float64 cannot multiply coefficients.
LARGEST = 1e100
T = TypeVar("T")
NEED_THE_PLANT = ("poles", "costs", "margins", "match", "split")
NEED_THE_TARGET = ("target", "match", "split")


@dataclass(frozen=True, eq=False)
class ControllerCheck(Result):
    """The analysis of a log's final controller, with reasons for items that were not evaluated.

    Attributes
    ----------
    log, structure, plant, target : what was given.
    compensator : Compensator
        The last coefficients of the log, fixed.
    analysis : LoopAnalysis or None
        The plant with the fixed controller, beside the target model.
    replay : ControlReplay or None
        Whether the logged u is the output of the logged theta; of a run of ours whose u is not that
        of one theta, whether u and theta are those of its settings on the recorded y, z and r.
    drift : Drift or None
        How far theta still moved in the last tenth of the log.
    internal_models : tuple of InternalModel
        Controller poles within 0.01 of the unit circle, and what they reject.
    loop : ClosedLoop or None
        The plant with the fixed controller: poles, frequency responses.
    zeros : mapping from channel of w to array of complex
    comparison : ExactComparison or None
        The exact characteristic polynomial beside that of the target.
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
    conventions : ConventionSearch or None
        Where the logged u is not the output of the logged coefficients: the conventions of other
        programs by which it is.
    sample_shift : SampleShift or None
        Where no convention does: newer or older samples of y, or of its sum, by which it is.
    run : Run or None
        The run, where the log is that of one with its own plant.
    settings : ControllerSettings, FixedController or another controller, or None
        Those of a run, where no structure or compensator is given beside it.
    certified : CertifiedTail or str
        From which step on the loop of the logged theta and the plant is proved stable while theta
        moves (`certified_from`), or why that was not evaluated; computed on demand.
    unanswered : mapping
        The reason for each result that was not evaluated.
    """

    _REST: ClassVar[str] = "report() has all of it"

    log: ControllerLog
    structure: Structure | None
    compensator: Compensator
    target: TargetModel | None
    analysis: LoopAnalysis | None
    replay: ControlReplay | None
    drift: Drift | None
    plant_residual: PlantResidual | None
    costs: LoopCosts | None
    margins: dict[str, Margins]
    disk: DiskMargin | None
    unanswered: dict[str, str]
    is_fixed: bool = False
    decision: Decision | str | None = None
    conventions: ConventionSearch | None = None
    sample_shift: SampleShift | None = None
    run: Run | None = None
    settings: AnyController | None = None

    @property
    def plant(self) -> Plant | None:
        """The plant, if known."""
        return None if self.analysis is None else self.analysis.plant

    @property
    def loop(self) -> ClosedLoop | None:
        """The plant with the fixed controller."""
        return None if self.analysis is None else self.analysis.loop

    @property
    def zeros(self) -> dict[str, ComplexArray]:
        """Closed-loop zeros by channel of w; exact where the comparison is."""
        return self._evaluated("zeros", lambda analysis: analysis.zeros) or {}

    @property
    def comparison(self) -> ExactComparison | None:
        """The exact characteristic polynomial and its target."""
        return self._evaluated("exact poles", lambda analysis: analysis.comparison)

    @property
    def match(self) -> IntercalatedMatch | None:
        """The match of the intercalated transfer function with G_f."""
        return self._evaluated("match", lambda analysis: analysis.match)

    @cached_property
    def split(self) -> ResidualSplit | None:
        """The retrospective residual of the log, split exactly (4.14)."""
        return self._evaluated("split", lambda analysis: split_of_log(self.log, analysis))

    @cached_property
    def internal_models(self) -> tuple[InternalModel, ...]:
        """Controller poles within 0.01 of the unit circle, and the signals that they reject."""
        return internal_models(self.compensator, self.loop)

    @cached_property
    def certified(self) -> CertifiedTail | str:
        """The first step from which the loop is proved stable, or why it is not known."""
        try:
            return self._certified()
        except CompensatorError as error:
            return str(error).rstrip(".")

    def _certified(self) -> CertifiedTail | str:
        if self.run is not None:
            return tail_of_run(self.run)
        log, replay, plant = self.log, self.replay, self.plant
        if plant is None:
            return "the plant is not known"
        if self.structure is None or log.theta is None or not log.has_history:
            return "it needs the structure, and theta of every step"
        if replay is None or not replay.agrees:
            return "the logged u is not the output of the logged theta"
        if self.plant_residual is not None and self.plant_residual.is_doubtful:
            return "the plant does not make the logged y of the logged u"
        if replay.limited:
            return f"u was at a limit in {replay.limited} steps, where the loop is another one"
        # Row k - shift of the log is theta(k).
        first = max(replay.start - replay.shift, 0)
        return certified_from_log(plant, self.structure, log.theta[first:], first + replay.shift)

    def _evaluated(self, name: str, evaluate: Callable[[LoopAnalysis], T]) -> T | None:
        """Evaluate a property of the loop; None if `unanswered` has a reason."""
        is_open = name == "exact poles" and self.target is None
        if self.analysis is None or name in self.unanswered or is_open:
            return None
        with np.errstate(over="ignore", invalid="ignore"):  # an unstable loop leaves float64
            return evaluate(self.analysis)

    @property
    def is_undecided(self) -> bool:
        """Whether the problem had to be decided and the log does not decide it."""
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

    def _sheet(self) -> Any:
        from rcac_numeric.reports._check import check_sheet

        return check_sheet(self)

    def report(self) -> str:
        """The whole check in words and numbers."""
        return report_of(self._sheet())

    @in_few_lines
    def __str__(self) -> str:
        return summary_of(self._sheet())

    def __repr__(self) -> str:
        verdict = "consistent" if self.is_consistent else "u is not the controller's output"
        loop = "no plant" if self.loop is None else f"rho = {self.loop.spectral_radius:.6g}"
        if self.loop is not None and not self.is_consistent:
            loop = "the loop is not that of the log"
        return f"ControllerCheck({verdict}, {loop}, {len(self.unanswered)} unanswered)"

    def _repr_html_(self) -> str:
        """The report and its figures as HTML for a notebook."""
        return notebook_of(self._sheet(), self.plot)

    def plot(self) -> figures.Figure:
        """One sheet: signals and coefficients, poles, the match and the Nyquist curve."""
        from rcac_numeric.plots._check import plot_check

        return plot_check(self)


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
    convention: str | Convention | None = None,
    u_limits: Saturation | tuple[float, float] | None = None,
) -> ControllerCheck:
    """Analyse the final controller of a log from any program.

    If the logged u is not the output of the logged coefficients, the conventions that differ
    between programs are tried, and `conventions` has the one that replays.

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
        default that is compared with the last tenth of the log alone.
    sample_time : float, optional
        In seconds, of a log without one.
    tolerance : float, optional
        The relative difference between u and Phi theta that counts as none; by default what the
        digits of the log leave open.
    convention : str, optional
        What differs from u = Phi theta in the program that wrote the log, as for
        `ControllerLog.converted` and `replay`: "-y, y first" for instance.
    u_limits : (low, high) or Saturation, optional
        Limits of the actuator; the plant receives u within them. By default those of a Run, if its
        saturation has no rate.

    Returns
    -------
    ControllerCheck
        Of the longest part without missing rows, if the log has gaps.

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
    run = u if isinstance(u, Run) and knows_its_plant else None
    known = convention_of(convention)
    is_default = known in (OURS, OWN_U)
    # A run whose own controller is checked.
    of_its_settings = structure is None and compensator is None and is_default
    checked_run = u if isinstance(u, Run) and of_its_settings else None
    if isinstance(u, Run):
        arguments = arguments_of_run(u)
        if u_limits is None and u.saturation is not None and u.saturation.rate is None:
            u_limits = u.saturation
        u = arguments["log"]
        plant = arguments.get("plant") if plant is None else plant
        target = arguments.get("target") if target is None else target
        if structure is None and compensator is None:
            structure, compensator = arguments.get("structure"), arguments.get("compensator")
            k_w = arguments.get("k_w") if k_w is None else k_w
    log = _log_of(u, y=y, z=z, w=w, r=r, theta=theta)
    if target is not None:
        instance_of(target, "target", TargetModel)
    log = log.longest_part()
    require_sample_time(log.source, log.sample_time, sample_time)
    sample_time = log.sample_time if sample_time is None else sample_time
    agreed_times([plant, compensator], sample_time)
    if k_w is not None:
        integer(k_w, "k_w")
    has_theta = compensator is None and log.theta is not None and structure is not None
    written = log  # its roundings are those of the file; a sum of two signals has both
    if has_theta and structure is not None:
        require_fit(log, structure)
        log = log.converted(known, structure)
    fixed = fixed_compensator(log, structure, compensator)
    if not has_theta:
        log, fixed = log.reading(known), known.compensator(fixed)
    _require_bounded(log, fixed)
    if compensator is None and not has_theta:
        k_w = None  # polynomials of a log are those that it ended with
    limits = limits_of_u(log, u_limits)
    conventions, sample_shift, drift, unanswered = None, None, None, {}
    replayed: ControlReplay | None = None
    of_run: ControlReplay | str | None = None
    if has_theta and structure is not None:
        replayer = Replayer(written, structure, k_w=k_w, tolerance=tolerance)
        replayed = replayer.replay(known, limits)
        if checked_run is not None and not replayed.agrees:  # theta alone need not make u: a dither
            of_run = replay_run(checked_run, k_w=k_w, tolerance=tolerance)
            if isinstance(of_run, str):
                replayed, unanswered["replay"] = None, of_run
            elif of_run.agrees:
                replayed = of_run
        if replayed is not None and not replayed.agrees and is_default:
            conventions = search_conventions(replayer, replayed, limits)
            if not conventions.matches:
                sample_shift = search_sample_shifts(replayer, replayed, limits)
        if log.has_history:
            assert log.theta is not None
            drift = drift_of(log.theta)
        else:
            unanswered["convergence"] = "theta was logged only once"
    else:
        reason = "no theta was logged" if log.theta is None else "theta was not used"
        unanswered["convergence"] = reason
        options: dict[str, Any] = {"k_w": k_w, "tolerance": tolerance, "u_limits": u_limits}
        if checked_run is not None:
            of_run = replay_run(checked_run, k_w=k_w, tolerance=tolerance)
        if isinstance(of_run, ControlReplay):
            replayed = of_run
        elif log.steps > len(fixed.past_u):
            replayed = replay_compensator(written, fixed, convention=known, **options)
            if of_run is not None and not replayed.agrees:  # another controller may have made u
                replayed, unanswered["replay"] = None, of_run
            elif not replayed.agrees and is_default:
                conventions = search_signs(log, fixed, replayed, **options)
        else:
            short = f"the log of {log.steps} steps does not fill the controller's memory"
            unanswered["replay"] = short
    if limits is not None:
        log = replaced(log, u=np.clip(log.u, *limits))
    analysis, residual, costs, disk = None, None, None, None
    margins: dict[str, Margins] = {}
    if plant is None:
        if noise is not None:
            raise InputError("noise is for the H2 costs, and they need the plant; give both.")
        unanswered |= dict.fromkeys(NEED_THE_PLANT, "the plant is not known")
    else:
        require_widths(log, plant)
        analysis = LoopAnalysis((plant, fixed), target)
        with np.errstate(over="ignore", invalid="ignore"):  # an unstable loop leaves float64
            loop = analysis.loop
            unanswered |= _unanswered(log, analysis)
            if not knows_its_plant:  # a run's plant may have changed on the way
                residual = plant_residual(_as_read(log, conventions), plant)
        costs = loop_costs(loop, noise)
        margins, reasons = channel_margins(loop, sample_time)
        unanswered |= reasons
        disk = multivariable_disk_margin(loop) if plant.l_u > 1 and loop.is_stable else None
    return ControllerCheck(
        log, structure, fixed, target, analysis, replayed, drift, residual, costs, margins, disk,
        unanswered, is_fixed, conventions=conventions, run=run, sample_shift=sample_shift,
        settings=None if checked_run is None else checked_run.settings,
    )  # fmt: skip


def _as_read(log: ControllerLog, conventions: ConventionSearch | None) -> ControllerLog:
    """The log with the signal that the controller reads as y, where a convention replays."""
    if conventions is None or not conventions.matches:
        return log
    return log.reading(conventions.matches[0].convention)


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


def _unanswered(log: ControllerLog, analysis: LoopAnalysis) -> dict[str, str]:
    """The reasons of the results that the loop does not have."""
    if analysis.target is None:
        reasons = dict.fromkeys(NEED_THE_TARGET, "the target model is not known")
    else:
        reasons = {
            "exact poles": attempted(lambda: analysis.comparison)[1],
            "match": attempted(lambda: analysis.match)[1],
            "split": attempted(lambda: split_of_log(log, analysis))[1],
        }
    several = f"they are for one z, and the plant has l_z = {analysis.plant.l_z}"
    is_one = analysis.plant.l_z == 1
    reasons["zeros"] = attempted(lambda: analysis.zeros)[1] if is_one else several
    return {name: reason for name, reason in reasons.items() if reason}


def split_of_log(log: ControllerLog, analysis: LoopAnalysis) -> ResidualSplit:
    """The split of the logged residual."""
    if log.w is None:
        raise InputError("the exogenous input w was not logged")
    if log.z is None:
        raise InputError("the performance z was not logged")
    return analysis.split_of(u=log.u, y=log.y, z=log.z, w=log.w, r=log.r)


# The log, the controller and the plant of a run.


class RunArguments(TypedDict, total=False):
    """The log of a run and keyword arguments of `check_controller`."""

    log: ControllerLog
    plant: Plant
    target: TargetModel
    structure: Structure
    compensator: Compensator
    k_w: int


def arguments_of_run(run: Run, source: str = "run") -> RunArguments:
    """The arguments of `check_controller` from a run.

    Behind a saturation, and for several controllers or a fixed one, in parallel too, it is handed
    over as a compensator: no single theta makes the logged u.
    """
    if not run.steps:
        raise InputError("the run has no step that could be checked.")
    is_stepwise = isinstance(run.settings, StepwiseController)
    known: RunArguments = {}
    last = run.first_step + run.steps - 1
    if not isinstance(run.plant, FunctionPlant):
        known["plant"] = plant_at(run.plant, last)
    settings = run.settings
    signals: dict[str, Any] = {"u": run.u_applied, "y": run.y, "z": run.z, "w": run.w}
    parts = [settings] if is_stepwise else controllers_of(settings)
    if l_r := max(one.l_r for one in parts):
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
    subject = "theta needs the structure it belongs to" if log.theta is not None else "no theta"
    raise InputError(
        f"{log.source}: {subject}; give theta with a structure such as iir(n_c=4), D_c and N_c, "
        "or a "
        "Compensator."
    )


def _from_polynomials(log: ControllerLog) -> Compensator:
    assert log.D_c is not None and log.N_c is not None
    D_c, N_c = np.trim_zeros(log.D_c, "f"), np.trim_zeros(log.N_c, "f")
    if not len(D_c) or len(N_c) > len(D_c):
        raise InputError(
            f"{log.source}: D_c has degree {len(D_c) - 1} and N_c degree {len(N_c) - 1}; D_c "
            "must not be zero, and its degree not below that of N_c (future values of y)."
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
    """Raise an error if the signals of a log do not have the widths of the plant's."""
    for name in ("u", "y", "z", "w"):
        signal, width = getattr(log, name), getattr(plant, f"l_{name}")
        if signal is not None and signal.shape[1] != width:
            raise InputError(
                f"{log.source}: {name} has {signal.shape[1]} components; the plant has l_{name} = "
                f"{width}."
            )
