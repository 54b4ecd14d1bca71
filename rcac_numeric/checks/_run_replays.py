"""Replay of the controller of a run on its recorded signals, from its settings."""

from __future__ import annotations

from math import gcd
from typing import Any, cast

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import number
from rcac_numeric.checks._replays import ROUNDING, STILL, ControlReplay
from rcac_numeric.controllers._gain_schedule import GainSchedule, ScheduledSteps
from rcac_numeric.controllers._predictive_cost import PredictiveCost
from rcac_numeric.controllers._stepwise import StepwiseController, stepper_of
from rcac_numeric.controllers._supervision import ACTIONS
from rcac_numeric.engine._compatibility import command_position, controllers_of
from rcac_numeric.engine._runs import Run
from rcac_numeric.engine._simulation import simulate
from rcac_numeric.identification._predictive_cost import PredictiveCostController
from rcac_numeric.plants._linear import Plant

NO_START = (
    "the run continues another one, and the memory with which its controller began is not in it; "
    "check the whole run"
)
ACTED = "the supervision acted on the controller, and its policy is not in the run"
OTHER_CHANGES = "the changes of the controller during the run do not follow from its settings"


def replay_run(
    run: Run, *, k_w: int | None = None, tolerance: float | None = None
) -> ControlReplay | str:
    """Compare u and theta of a run with those of its settings on the recorded y, z and r.

    Every kind of controller is replayed by the code that ran it, so that nothing differs where the
    run is unchanged: to the bit for the compiled ones, up to the rounding of LAPACK for those with
    Python steps, which receive the recorded u(k-1). A text says why there is no replay.
    """
    if run.first_step:
        return NO_START
    if run.supervision is not None and any(name in ACTIONS for name in run.supervision.troubles):
        return ACTED
    start = min(k_w or 0, run.steps - 1)
    exact = ROUNDING if tolerance is None else number(tolerance, "tolerance")
    if not exact > 0:
        raise InputError(f"tolerance = {tolerance} must be positive.")
    allowed = exact
    if tolerance is None and isinstance(run.settings, PredictiveCost):
        # Other kernels of OpenBLAS move u by up to 2e-10 at R_theta = 1e-8; theta stays the same.
        allowed = STILL
    try:
        with np.errstate(all="ignore"):
            computed = _stepped(run) if isinstance(run.settings, StepwiseController) else _run(run)
    except CompensatorError as error:
        return f"the controller does not run on the recorded signals: {str(error).rstrip('.')}"
    if isinstance(computed, str):
        return computed
    signals, theta = computed
    recorded = np.hstack([run.u, run.u_applied])
    gaps = _relative(recorded, signals)
    gaps[:start] = 0.0
    of, step, worst = "the controller with its settings", *_worst(gaps)
    if worst <= allowed and run.theta.size:
        moved = _relative(run.theta, theta)
        row, worst_theta = _worst(moved)
        if worst_theta > exact:
            allowed = exact
            of, step, worst = "the logged theta", row * run.stride, worst_theta
    return ControlReplay(
        u=signals[:, run.plant.l_u :], start=start, shift=0, worst=worst, worst_step=step, of=of,
        tolerance=allowed, limited=int((run.u != run.u_applied).any(axis=1).sum()),
    )  # fmt: skip


def _run(run: Run) -> tuple[Array, Array] | str:
    """[u, u_applied] and theta of the compiled controllers, with a plant that plays y and z back.

    They receive their own u, which is the recorded one to the bit where nothing was changed.
    """
    signals = {"y": run.y, "z": run.z, "r": _command(run)}
    widths = {name: one.shape[1] for name, one in signals.items() if one.shape[1]}
    w, l_u = np.hstack([*signals.values()]), run.plant.l_u
    rows = np.eye(w.shape[1])
    of_y, of_z = rows[: widths["y"]], rows[widths["y"] : widths["y"] + widths["z"]]
    playback = Plant(
        A=np.zeros((0, 0)), B=np.zeros((0, l_u)), D_1=np.zeros((0, w.shape[1])),
        C=np.zeros((len(of_y), 0)), D_2=of_y, E_1=np.zeros((len(of_z), 0)),
        E_2=np.zeros((len(of_z), l_u)), E_0=of_z, blocks=widths, sample_time=run.sample_time,
    )  # fmt: skip
    changes = {one.k: one.change for one in run.changes}
    learns = any(getattr(one, "learning", None) is not None for one in controllers_of(run.settings))
    requests: dict[str, Any] = {}
    if changes and not learns:
        requests = {
            "on_step": lambda so_far: changes.get(so_far.first_step + so_far.steps),
            "every": gcd(*changes),
        }
    other = simulate(
        playback, run.settings, w, stride=run.stride, saturation=run.saturation,
        divergence_limit=run.divergence_limit, **requests,
    )  # fmt: skip
    if [one.k for one in other.changes] != [*changes]:
        return OTHER_CHANGES
    if other.steps < run.steps:
        return f"the controller does not run on the recorded signals: {other.outcome}"
    return np.hstack([other.u, other.u_applied]), other.theta


def _stepped(run: Run) -> tuple[Array, Array] | str:
    """[u, u_applied] and theta of a controller with Python steps on the recorded y, r and u."""
    if not isinstance(run.settings, PredictiveCost | GainSchedule):
        return f"a {type(run.settings).__name__} has more in its memory than y, r and u"
    controller = cast(PredictiveCostController | ScheduledSteps, stepper_of(run.settings))
    r = _command(run)
    u, theta = np.empty_like(run.u), np.empty_like(run.theta)
    for k in range(run.steps):
        u[k] = controller.step(run.y[k], r[k], run.u[k - 1] if k else None)
        if k % run.stride == 0:
            theta[k // run.stride] = controller.theta
    return np.hstack([u, u]), theta


def _command(run: Run) -> Array:
    """The command that the controller reads, shape (steps, l_r)."""
    settings = run.settings
    parts = [settings] if isinstance(settings, StepwiseController) else controllers_of(settings)
    l_r = max(one.l_r for one in parts)
    start = command_position(run.plant, l_r)
    return run.w[:, start : start + l_r]


def _relative(recorded: Array, computed: Array) -> Array:
    """Differences over the largest recorded entry; infinite where one is not a number."""
    size = float(np.abs(recorded).max(initial=0.0)) or 1.0
    gaps = np.abs(recorded - computed) / size
    return np.where(np.isnan(gaps), np.inf, gaps)


def _worst(gaps: Array) -> tuple[int, float]:
    """The row with the largest difference, and that difference."""
    rows = gaps.max(axis=1)
    row = int(rows.argmax())
    return row, float(rows[row])
