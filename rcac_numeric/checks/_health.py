"""The health of a loop as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from compensator_theory._few_lines import in_few_lines
from rcac_numeric.analysis._classical import Margins
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._showing import notebook_of
from rcac_numeric.arrays._values import Result
from rcac_numeric.checks._trials import NextDisturbance
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._forgetting import Forgetting
from rcac_numeric.controllers._recursive import UD
from rcac_numeric.controllers._regressor import (
    filtered_regressor,
    has_common_filter,
    regressor_of,
)
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._supervision import SupervisionRecord
from rcac_numeric.engine._compatibility import command_position
from rcac_numeric.engine._runs import Run
from rcac_numeric.engine._simulation import simulate
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule


@dataclass(frozen=True)
class SignalSize:
    """The peak and the root mean square of a signal over some steps."""

    peak: float
    rms: float

    @classmethod
    def of(cls, values: Array) -> SignalSize | None:
        """Return the size of these rows; None if there are none."""
        if not len(values):
            return None
        with np.errstate(over="ignore"):
            power = np.sqrt(np.mean(np.sum(values**2, axis=1)))
        return cls(float(np.abs(values).max(initial=0.0)), float(power))


NEGLIGIBLE = 1e-6  # of the peak: a smaller rms at the end is not printed, but is in the data


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
        sentences = []
        if self.before is not None and self.before.peak:
            sentences.append(
                f"peak {self.before.peak:.3g}, rms {self.before.rms:.3g} before control"
            )
        if self.after is not None:
            sentences.append(f"peak {self.after.peak:.3g}, rms {self.after.rms:.3g} under control")
        if self.late is not None:
            sentences.append(f"at the end rms {self._late_rms()}")
        return "; ".join(sentences) or "no step"

    def _late_rms(self) -> str:
        """The rms at the end; below 1e-6 of the peak it is rounding, which differs by machine."""
        assert self.late is not None
        peak = max(size.peak for size in (self.before, self.after, self.late) if size is not None)
        is_small = 0 < self.late.rms < NEGLIGIBLE * peak
        return "below 1e-6 of the peak" if is_small else f"{self.late.rms:.3g}"


def signal_health(values: Array, start: int) -> SignalHealth:
    """The sizes of a signal whose control begins at row `start`."""
    start = min(max(start, 0), len(values))
    last = values[start:][-max(len(values) // 10, 1) :]
    return SignalHealth(
        SignalSize.of(values[:start]), SignalSize.of(values[start:]), SignalSize.of(last)
    )


def without_control(run: Run) -> Array | None:
    """Return z of the same run with u = 0; None if it is unbounded or needs a user's function."""
    if type(run.plant) not in (Plant, PlantSchedule) or run.first_step or not run.steps:
        return None

    plant = run.plant
    idle = Compensator(np.zeros((0, plant.l_u, plant.l_u)), np.zeros((1, plant.l_u, plant.l_y)))
    free = simulate(plant, FixedController(idle), run.w, x_0=run.x_0)
    return free.z if free.outcome == "completed" else None


DRIFT = 1e-6  # share of norm(theta) from which a drift by rounding is reported
ROWS = 20_000  # steps that are evaluated: the first ones from k_w on


@dataclass(frozen=True)
class Excitation:
    """The excitation of theta by the data of a run.

    Attributes
    ----------
    l_theta : int
        Number of coefficients.
    outweighed : int
        Number of directions of theta in which sum Phi_f' R_z Phi_f exceeds R_theta: there the data
        move theta, in the others theta stays near theta(0).
    excited : int
        Number of directions that the data excite by more than rounding.
    drift : float
        Distance, relative to norm(theta), by which theta(final) is off theta(0) along directions
        that no Phi_f of the run excites by more than rounding. Exact arithmetic does not move
        theta there: all of it is rounding, some eps/R_theta a step. Zero where that is not so
        (bounds, resets, R_u, process noise) or not looked for.
    """

    l_theta: int
    outweighed: int
    excited: int
    drift: float = 0.0

    def __str__(self) -> str:
        l_theta, remainder = self.l_theta, self.l_theta - self.outweighed
        if not remainder:
            words = f"sufficient in all {l_theta} parameter directions"
        else:
            words = (
                f"sufficient in {self.outweighed} of {l_theta} parameter directions; in the other "
                f"{remainder} R_theta outweighs the data"
            )
        if self.excited < l_theta:
            words += f"; {self.excited} directions are excited above rounding"
        if self.drift > DRIFT:
            words += f"; rounding moved theta by {self.drift:.1g} of its size in the others"
        return words


def excitation_of(run: Run) -> Excitation | None:
    """The excitation of a run with recursive least squares and constant weights; else None.

    None too with a fixed compensator in parallel, whose part of u the run does not tell apart.
    """
    settings = run.settings
    if not isinstance(settings, ControllerSettings) or not run.steps:
        return None
    R_theta, R_z = getattr(settings.update, "R_theta", None), settings.R_z
    structure, target = settings.structure, settings.target
    if settings.learning is not None:
        targets = [one.change.target for one in run.changes if one.change.target is not None]
        if not targets:
            return None
        target = targets[-1]
    if R_theta is None or not isinstance(R_z, np.ndarray) or not has_common_filter(target):
        return None
    if settings.fixed is not None:
        return None
    start = max(settings.k_update - run.first_step, 0)
    rows = slice(0, start + ROWS)
    r = None
    if structure.l_r:
        at = command_position(run.plant, structure.l_r)
        r = run.w[rows, at : at + structure.l_r]
    phi = regressor_of(structure, {"u": run.u_applied[rows], "y": run.y[rows], "r": r}, np.asarray)
    size = structure.l_theta
    information = np.zeros((size, size))
    with np.errstate(all="ignore"):
        root = np.linalg.cholesky(R_z)
        Phi_f = np.einsum("zs,ksj->kzj", root.T, filtered_regressor(phi, target)[start:])
        for block in np.array_split(Phi_f.reshape(-1, size), max(len(Phi_f) // 1000, 1)):
            information += block.T @ block
        if not np.isfinite(information).all():
            return None
        scale = np.eye(size) * R_theta if np.ndim(R_theta) == 0 else np.asarray(R_theta)
        inverse = np.linalg.inv(np.linalg.cholesky(scale))
        outweighed = np.linalg.eigvalsh(inverse @ information @ inverse.T) > 1
        spread = np.sqrt(np.diag(information))
        spread[spread == 0] = 1.0
        values = np.linalg.eigvalsh(information / np.outer(spread, spread))
        rows_of_theta = Phi_f.reshape(-1, size)
        drift = 0.0
        if is_still_where_unexcited(run) and len(Phi_f) == run.steps - start:
            drift = drift_of(rows_of_theta, scale, run.theta_final - settings.theta_0)
            drift /= float(np.linalg.norm(run.theta_final)) or 1.0
    excited = int((values > 1e-13 * size).sum())
    return Excitation(size, int(outweighed.sum()), excited, drift)


def is_still_where_unexcited(run: Run) -> bool:
    """Whether exact arithmetic keeps theta(0) in every direction without excitation."""
    settings = run.settings
    if not isinstance(settings, ControllerSettings) or type(settings.update) is not UD:
        return False
    update = settings.update
    return (
        not isinstance(update.lambda_, Forgetting)
        and update.process_noise is None
        and update.reset is None
        and settings.bounds is None
        and not settings.reflect_poles
        and isinstance(settings.R_u, np.ndarray)
        and not (settings.R_u.any() or settings.R_u_unfiltered.any())
        and not run.first_step
        and not run.changes
        and bool(np.isfinite(run.theta_final).all())
    )


def drift_of(rows: Array, R_theta: Array, moved: Array) -> float:
    """The part of theta - theta(0) along directions without excitation, in the metric of R_theta.

    R_theta (theta - theta(0)) is a combination of the rows, so that it is orthogonal to a v that
    all of them are orthogonal to.
    """
    spread = np.linalg.norm(rows, axis=0)
    spread[spread == 0] = 1.0
    triangle = np.linalg.qr(rows / spread, mode="r")
    _, singular, V = np.linalg.svd(triangle)
    sizes = np.zeros(rows.shape[1])
    sizes[: len(singular)] = singular
    rounding = 100 * np.finfo(float).eps * np.sqrt(len(sizes)) * sizes.max(initial=0.0)
    still = (V[sizes <= rounding] / spread).T
    if not still.size or not np.isfinite(rows).all():
        return 0.0
    by = np.linalg.lstsq(still.T @ R_theta @ still, still.T @ R_theta @ moved, rcond=None)[0]
    return float(np.linalg.norm(still @ by))


BOUNDED_SHARE = 0.1  # share of the steps in which bounds moved theta


@dataclass(frozen=True)
class HealthWarning:
    """A warning of a report with its next step.

    Attributes
    ----------
    code : str
        Its name, for programs: "diverged", "unstable", "slow", "small margins", "large transient",
        "large control", "worse than without control", "rounding", "no excitation", "unsettled",
        "saturated", "windup", "missed poles", "costly", "wrong sign", "wrong d_zu",
        "unmodelled zero"; of several inputs and outputs "zero in every channel",
        "zero in one channel", "zero on the input side", "zero in another direction"; of
        `DataDriven` "nothing learnt", "low order", "poor excitation", "unstable start"; of a log
        "inconsistent log"; of a controller that is driven step by step "overflow",
        "missed samples", "stopped".
    sentence, next_step : str
        What was found, and what to try.
    is_grave : bool
        Whether the loop cannot be used as it is.

    Examples
    --------
    >>> from rcac_numeric import HealthWarning
    >>> print(HealthWarning("slow", "A pole is at 0.9999.", "run more steps"))
    A pole is at 0.9999. Try next: run more steps.
    """

    code: str
    sentence: str
    next_step: str
    is_grave: bool = False

    def __str__(self) -> str:
        return f"{self.sentence} Try next: {self.next_step}."


@dataclass(frozen=True, eq=False)
class LoopHealth(Result):
    """Whether a loop is healthy, and the evidence.

    Attributes
    ----------
    is_stable : bool or None
        Of the final controller, frozen, with the plant of the last step; None where no linear
        plant is known.
    spectral_radius : float or None
    outcome : str
        How the run ended; empty for a log.
    steps, k_w : int
        Number of steps, and the first one with control.
    signals : mapping from "z", "u" and, behind a saturation, "u_applied" to SignalHealth
    free : SignalSize or None
        z of the same run with u = 0, where that is bounded.
    margins : mapping from components of u to Margins
    guard_count, guard_first_step : int
        Number of updates in which rounding exceeded the data, and the first step (-1: none).
    bounded : int
        Updates after which theta was moved to its bounds.
    radius : float or None
        With `CertifiedBounds` the largest share of the radius that theta used: in the stored steps
        of a run, or at the looks of a controller's supervision.
    excitation : Excitation or None
    warnings : tuple of HealthWarning
        The grave ones first.
    obstacle : str
        Why there is no verdict on stability.
    supervision : SupervisionRecord or None
        What was noted while it ran.
    next_disturbance : NextDisturbance or None
        How far z goes where w moves again, beside the same with theta held.
    missed_by : float or None
        The largest distance of a target pole from its closed-loop pole.
    cost_ratio : float or None
        The cost of the final controller over that of LQG, for the noise of the run.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, Step, exogenous, iir, loop_health, pole_placement_target,
    ...     simulate, standard_plant)
    >>> plant = standard_plant("(q**2 - 1.44*q + 0.81)/((q - 0.9)*(q**2 - 1.71*q + 0.903))")
    >>> target = pole_placement_target(plant, ["0.5", "-0.5", "0.8j", "-0.8j"])
    >>> settings = ControllerSettings(structure=iir(4), target=target, update=UD(1e-10), k_w=50)
    >>> health = loop_health(simulate(plant, settings, exogenous([Step()], steps=100)))
    >>> health.is_stable, round(health.margins["u"].gain_up.value, 3)
    (True, 1.041)
    >>> [warning.code for warning in health.warnings]
    ['small margins']
    """

    _ANSWER = "is_healthy"
    _REST: ClassVar[str] = "report() has all of it"

    is_stable: bool | None
    spectral_radius: float | None
    outcome: str
    steps: int
    k_w: int
    signals: Mapping[str, SignalHealth]
    free: SignalSize | None = None
    margins: Mapping[str, Margins] = field(default_factory=dict)
    guard_count: int = 0
    guard_first_step: int = -1
    bounded: int = 0
    excitation: Excitation | None = None
    warnings: tuple[HealthWarning, ...] = ()
    obstacle: str = ""
    supervision: SupervisionRecord | None = None
    next_disturbance: NextDisturbance | None = None
    missed_by: float | None = None
    cost_ratio: float | None = None
    radius: float | None = None

    @property
    def is_held(self) -> bool:
        """Whether the bounds limited theta in a tenth of the steps, and so decide the poles."""
        return self.bounded > BOUNDED_SHARE * self.steps

    @property
    def is_healthy(self) -> bool:
        """Whether there is no warning."""
        return not self.warnings

    def _sheet(self) -> Any:
        from rcac_numeric.reports._loop import health_sheet

        return health_sheet(self)

    def report(self) -> str:
        """The health in lines of text."""
        return "\n".join(line.words for line in self._sheet().health)

    def _repr_html_(self) -> str:
        """The report as HTML for a notebook, the warnings in colour."""
        return notebook_of(self._sheet())

    @in_few_lines
    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        codes = ", ".join(warning.code for warning in self.warnings) or "no warning"
        return f"LoopHealth(is_stable={self.is_stable}, steps={self.steps}, {codes})"
