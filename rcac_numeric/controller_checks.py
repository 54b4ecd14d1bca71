"""The analysis of a converged controller, whatever program it ran in."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import CompensatorError, DivergedError, InputError
from rcac_numeric.closed_loop import ClosedLoop, Match, intercalated_match
from rcac_numeric.comparison import Comparison, compare
from rcac_numeric.compensators import Compensator
from rcac_numeric.controller_logs import ControllerLog
from rcac_numeric.disk_margins import DiskMargin, multivariable_disk_margin
from rcac_numeric.frozen_plants import measuring_command
from rcac_numeric.internal_models import Drift, InternalModel, drift_of, internal_models
from rcac_numeric.loop_costs import LoopCosts, loop_costs
from rcac_numeric.margins import Margins, stability_margins
from rcac_numeric.plants import Plant
from rcac_numeric.replays import Replay, replay, require_fit
from rcac_numeric.residual_split import ResidualSplit, split_residual
from rcac_numeric.structures import Structure
from rcac_numeric.target_models import TargetModel
from rcac_numeric.validation import instance_of, number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rcac_numeric.closed_loop import ComplexArray
    from rcac_numeric.validation import Array

# Where `simulate` calls a loop diverged; beyond it float64 cannot multiply coefficients.
LARGEST = 1e100


@dataclass(frozen=True, eq=False)
class ControllerCheck:
    """What a log says of the controller that it ended with, and what it cannot say.

    Attributes
    ----------
    log, structure, plant, target : what was given.
    compensator : Compensator
        The last coefficients of the log, fixed.
    replay : Replay or None
        Whether the logged u is the output of the logged theta.
    drift : Drift or None
        How far theta still moved in the last tenth of the log.
    internal_models : tuple of InternalModel
        Controller poles within 0.01 of the unit circle, and what they reject.
    loop : ClosedLoop or None
        The plant with the fixed controller: poles, frequency responses.
    zeros : mapping from channel of w to array of complex
    comparison : Comparison or None
        The exact characteristic polynomial beside the one that the target asks for.
    match : Match or None
        The intercalated transfer function beside G_f.
    split : ResidualSplit or None
        The retrospective residual, split exactly (4.14).
    costs : LoopCosts or None
        The H2 cost with the share of each channel of w, beside LQG's.
    margins : mapping from names of channels to Margins
        Opened at each component of u in turn.
    disk : DiskMargin or None
        For several inputs at once.
    unsaid : mapping
        From what could not be said to the reason.
    """

    log: ControllerLog
    structure: Structure | None
    compensator: Compensator
    plant: Plant | None = None
    target: TargetModel | None = None
    replay: Replay | None = None
    drift: Drift | None = None
    internal_models: tuple[InternalModel, ...] = ()
    loop: ClosedLoop | None = None
    zeros: dict[str, ComplexArray] = field(default_factory=dict)
    comparison: Comparison | None = None
    match: Match | None = None
    split: ResidualSplit | None = None
    costs: LoopCosts | None = None
    margins: dict[str, Margins] = field(default_factory=dict)
    disk: DiskMargin | None = None
    unsaid: dict[str, str] = field(default_factory=dict)

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

    def __str__(self) -> str:
        from rcac_numeric.check_reports import as_text

        return as_text(self)

    def __repr__(self) -> str:
        said = "consistent" if self.is_consistent else "u is not the output of theta"
        loop = "no plant" if self.loop is None else f"rho = {self.loop.spectral_radius:.6g}"
        return f"ControllerCheck({said}, {loop}, {len(self.unsaid)} unsaid)"

    def plot(self) -> Figure:
        """One sheet: signals and coefficients, poles, the match and the Nyquist curve."""
        from rcac_numeric.check_plots import plot_check

        return plot_check(self)


def check_controller(
    u: ArrayLike | ControllerLog,
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
    k_w: int | None = None,
    sample_time: float | None = None,
) -> ControllerCheck:
    """Analyse the controller that a log ended with: ours, or anybody's.

    Parameters
    ----------
    u, y : arrays, shape (steps, l_u), (steps, l_y)
        Or a ControllerLog in place of all the signals and theta.
    z, w, r : arrays, optional
        Performance, exogenous input, command. The split of the residual needs z and w.
    theta : array, shape (steps, l_theta) or (l_theta,)
        The coefficients, with the structure that they belong to.
    structure : Structure, optional
    compensator : Compensator, optional
        In place of theta and structure. (D_c and N_c of a log do the same.)
    plant : Plant, optional
        Without it there are no poles, margins, costs or match.
    target : TargetModel, optional
    k_w : int, optional
        First step with u = Phi theta.
    sample_time : float, optional
        In seconds.

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
    >>> from rcac_numeric import *
    >>> plant = standard_plant("(q - 0.5)/(q*(q - 0.9))")
    >>> settings = ControllerSettings(structure=iir(n_c=2), target=fir_target(plant), R_theta=1e-4)
    >>> run = simulate(plant, settings, exogenous([step()], steps=1000))
    >>> check = check_controller(run.u, run.y, z=run.z, w=run.w, theta=run.theta,
    ...     structure=iir(n_c=2), plant=plant, target=settings.target)
    >>> check.replay.agrees, check.drift.is_converged, check.loop.is_stable
    (True, True, True)
    >>> check_controller(run.u, run.y, theta=run.theta, structure=iir(n_c=2)).unsaid["poles"]
    'the plant is not known'
    """
    if isinstance(u, ControllerLog):
        if any(v is not None for v in (y, z, w, r, theta)):
            raise InputError("give a ControllerLog, or arrays, not both.")
        log = u
    else:
        log = ControllerLog(u=u, y=y, z=z, w=w, r=r, theta=theta)
    if target is not None:
        instance_of(target, "target", TargetModel)
    if sample_time is not None and not number(sample_time, "sample_time") > 0:
        raise InputError(f"sample_time = {sample_time} must be positive, in seconds.")
    unsaid: dict[str, str] = {}
    known: dict[str, Any] = {}
    fixed = _fixed(log, structure, compensator)
    if (largest := max(np.abs(fixed.P).max(initial=0), np.abs(fixed.Q).max())) > LARGEST:
        raise DivergedError(
            f"{log.source}: the controller has a coefficient of size {largest:.3g}: the loop has "
            "diverged. Cut the log before that."
        )
    if log.theta is not None and structure is not None and compensator is None:
        known["replay"] = replay(log, structure, k_w=k_w)
        if log.has_history:
            known["drift"] = drift_of(log.theta)
        else:
            unsaid["convergence"] = "theta was logged only once"
    else:
        unsaid["replay"] = unsaid["convergence"] = "no theta was logged"
    if plant is None:
        for name in ("poles", "costs", "margins", "match", "split"):
            unsaid[name] = "the plant is not known"
    else:
        with np.errstate(over="ignore", invalid="ignore"):  # an unstable loop leaves float64
            known |= _with_plant(log, fixed, instance_of(plant, "plant", Plant), target, unsaid)
        known["margins"], known["disk"] = _margins(known["loop"], sample_time, unsaid)
    return ControllerCheck(
        log=log,
        structure=structure,
        compensator=fixed,
        plant=plant,
        target=target,
        internal_models=internal_models(fixed, known.get("loop")),
        unsaid=unsaid,
        **known,
    )


def _fixed(
    log: ControllerLog, structure: Structure | None, compensator: Compensator | None
) -> Compensator:
    """The controller at the end of the log."""
    if compensator is not None:
        return compensator
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
    D_c, N_c = np.trim_zeros(log.D_c, "f"), np.trim_zeros(log.N_c, "f")
    if not len(D_c) or len(N_c) > len(D_c):
        raise InputError(
            f"{log.source}: D_c has degree {len(D_c) - 1} and N_c degree {len(N_c) - 1}; the "
            "controller would use future values, or is none."
        )
    N_c = np.concatenate([np.zeros(len(D_c) - len(N_c)), N_c]) / D_c[0]
    return Compensator((-D_c[1:] / D_c[0])[:, None, None], N_c[:, None, None])


def _with_plant(
    log: ControllerLog,
    fixed: Compensator,
    plant: Plant,
    target: TargetModel | None,
    unsaid: dict[str, str],
) -> dict[str, Any]:
    """Poles, zeros, costs, comparison, match and split, as far as the inputs allow."""
    for name in ("u", "y", "z", "w"):
        signal, width = getattr(log, name), getattr(plant, f"l_{name}")
        if signal is not None and signal.shape[1] != width:
            raise InputError(
                f"{log.source}: {name} has {signal.shape[1]} components; the plant has l_{name} = "
                f"{width}."
            )
    y = log.y
    if fixed.l_y > plant.l_y:
        plant = measuring_command(plant)
        y = log.y if log.r is None else np.hstack([log.y, log.r])
    loop = ClosedLoop(plant, fixed)
    known: dict[str, Any] = {"loop": loop, "costs": loop_costs(loop)}
    if target is None:
        for name in ("target", "match", "split"):
            unsaid[name] = "the target model is not known"
    else:
        known |= _against_target(log, loop, target, y, unsaid)
    comparison = known.get("comparison")
    if comparison is not None:
        known["zeros"] = comparison.zeros
    elif plant.l_z == 1:
        known["zeros"] = loop.zeros()
    else:
        unsaid["zeros"] = f"they are for one z, and the plant has l_z = {plant.l_z}"
    return known


def _against_target(
    log: ControllerLog, loop: ClosedLoop, target: TargetModel, y: Array, unsaid: dict[str, str]
) -> dict[str, Any]:
    plant, fixed = loop.plant, loop.compensator
    known: dict[str, Any] = {}
    try:
        known["comparison"] = compare(plant, fixed, target)
    except CompensatorError as error:
        unsaid["exact poles"] = str(error).rstrip(".")
    try:
        known["match"] = intercalated_match(loop, target)
    except (CompensatorError, ValueError) as error:
        unsaid["match"] = str(error).rstrip(".")
    if log.w is None:
        unsaid["split"] = "the exogenous input w was not logged"
    elif log.z is None:
        unsaid["split"] = "the performance z was not logged"
    else:
        try:
            known["split"] = split_residual(plant, fixed, target, u=log.u, y=y, z=log.z, w=log.w)
        except CompensatorError as error:
            unsaid["split"] = str(error).rstrip(".")
    return known


def _margins(
    loop: ClosedLoop, sample_time: float | None, unsaid: dict[str, str]
) -> tuple[dict[str, Margins], DiskMargin | None]:
    found = {}
    for i in range(loop.plant.l_u):
        name = "u" if loop.plant.l_u == 1 else f"u{i + 1}"
        try:
            found[name] = stability_margins(loop, channel=i, sample_time=sample_time)
        except CompensatorError as error:
            unsaid[f"margins at {name}"] = str(error).rstrip(".")
    if loop.plant.l_u > 1 and loop.is_stable:
        return found, multivariable_disk_margin(loop)
    return found, None
