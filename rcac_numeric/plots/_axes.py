"""Elements of figures of runs: control, poles and zeros, changes, legends."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from rcac_numeric.analysis._loop_analysis import LoopAnalysis, attempted
from rcac_numeric.arrays._array_types import ComplexArray
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._pole_maps import PoleGroup, draw_plane, largest_counts
from rcac_numeric.plots._style import INK, REACHED, REQUESTED, SECOND, draw_history


def draw_control(axis: Axes, run: Run) -> None:
    """Draw the control u and, if different, the applied control."""
    draw_history(axis, run.u, "control $u$", "u")
    if run.u_applied is run.u or np.array_equal(run.u_applied, run.u):
        return
    for i, column in enumerate(run.u_applied.T):
        axis.step(np.arange(len(column)), column, where="post", linewidth=1.1, color=REQUESTED,
                  label="applied" if i == 0 else None)  # fmt: skip
    if run.u.shape[1] == 1:
        axis.lines[0].set(label="requested", alpha=0.6)
    axis.legend(fontsize=8)


def mark_changes(axis: Axes, runs: Iterable[Run], first: int, last: int | None) -> None:
    """Draw a line at each step at which the plant of a run changes."""
    end = np.inf if last is None else last
    starts = {
        change.start
        for run in runs
        if isinstance(run.plant, PlantSchedule)
        for change in run.plant.changes
        if max(first, run.first_step) < change.start <= end
    }
    for number, k in enumerate(sorted(starts)):
        axis.axvline(k, color=INK, linewidth=0.9, linestyle=(0, (1, 2)), zorder=0.5,
                     label=None if number else "the plant changes")  # fmt: skip


def legend_below(figure: Figure, *, always: bool = False) -> None:
    """Draw one legend for all axes below them; none for one line."""
    handles: dict[str, Any] = {}
    for axis in figure.axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    needless = len(handles) == 1 and "the plant changes" not in handles and not always
    if not handles or needless:
        return
    longest = max(map(len, handles))
    columns = max(1, min(len(handles), int(figure.get_figwidth() / 0.072) // (longest + 7)))
    figure.set_figheight(figure.get_figheight() + 0.17 * -(-len(handles) // columns))
    figure.legend(
        handles.values(), handles, fontsize=8, loc="outside lower center", ncols=columns,
        frameon=False,
    )  # fmt: skip


def draw_pole_zero(axis: Axes, repetition: LoopAnalysis, *, legend: bool = True) -> None:
    """Draw closed-loop poles and zeros of the final controller, and the target poles of G_f."""
    comparison, _ = attempted(lambda: repetition.comparison)
    nothing = np.zeros(0, dtype=np.complex128)
    requested, zeros = nothing, nothing
    if comparison is not None:
        poles, requested = comparison.poles, comparison.requested_poles
        zeros = largest_counts(comparison.zeros.values())
    else:
        poles = repetition.loop.poles()
        if repetition.plant.l_z == 1:
            zeros = largest_counts(repetition.zeros.values())
    draw_poles(axis, poles, requested, zeros)
    if legend:
        axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3,
                    frameon=False, handletextpad=0.3, columnspacing=1.2)  # fmt: skip


def draw_poles(
    axis: Axes, poles: ComplexArray, requested: ComplexArray, zeros: ComplexArray
) -> None:
    """Draw closed-loop poles, target poles, and zeros from w to z."""
    finite = np.isfinite(poles)
    kinds = [
        PoleGroup("requested", "requested", requested, "s", REQUESTED, 10),
        PoleGroup("zeros from w to z", "zero", zeros, "o", SECOND, 6),
        PoleGroup("poles reached", "pole", poles[finite], "x", REACHED, 7),
    ]
    draw_plane(axis, [kind for kind in kinds if len(kind.values)])
    title = "closed loop with the final controller"
    axis.set_title(title if finite.all() else f"{title}: poles beyond float64", fontsize=10)
