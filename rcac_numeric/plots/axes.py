"""What the pictures of a run are made of: control, coefficients, poles and zeros, legends."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from rcac_numeric.engine.runs import Run
from rcac_numeric.experiments.figure_requests import FigureRequest
from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.plots.library import Axes, Figure
from rcac_numeric.plots.style import INK, REACHED, SECOND, WANTED, draw_history


def draw_control(axis: Axes, run: Run) -> None:
    """What the controller asked for and, where that differs, what the actuator applied."""
    draw_history(axis, run.u, "control $u$", "u")
    if run.u_applied is run.u or np.array_equal(run.u_applied, run.u):
        return
    for i, column in enumerate(run.u_applied.T):
        axis.step(np.arange(len(column)), column, where="post", linewidth=1.1, color=WANTED,
                  label="applied" if i == 0 else None)  # fmt: skip
    if run.u.shape[1] == 1:
        axis.lines[0].set(label="asked for", alpha=0.6)
    axis.legend(fontsize=8)


def draw_coefficients(axis: Axes, run: Run) -> None:
    """The coefficients over all steps, with their legend."""
    k = run.first_step + np.arange(len(run.theta)) * run.stride
    draw_theta(axis, run, k, np.ones(len(k), dtype=bool))
    axis.set_xlabel("step $k$")
    if axis.get_legend_handles_labels()[1]:
        axis.legend(fontsize=8)


def draw_theta(axis: Axes, run: Run, k: np.ndarray, shown: np.ndarray) -> None:
    """The coefficients at some steps; gains by name for P, I and D terms of one signal."""
    name = getattr(getattr(run.settings, "structure", None), "name", "")
    gains = name if set(name) <= set("PID") and len(name) == run.theta.shape[1] else ""
    lines = axis.plot(k[shown], run.theta[shown], linewidth=1.0)
    for line, gain in zip(lines, gains, strict=False):
        line.set_label(f"$K_{gain}$")
    axis.set_ylabel("gains" if gains else r"coefficients $\theta$")


def mark_changes(axis: Axes, runs: Iterable[Run], request: FigureRequest) -> None:
    """A line at each step that is shown at which the plant of one of the runs changes."""
    last = np.inf if request.last is None else request.last
    starts = {
        change.start
        for run in runs
        if isinstance(run.plant, PlantSchedule)
        for change in run.plant.changes
        if max(request.first, run.first_step) < change.start <= last
    }
    for number, k in enumerate(sorted(starts)):
        axis.axvline(k, color=INK, linewidth=0.9, linestyle=(0, (1, 2)), zorder=0.5,
                     label=None if number else "the plant changes")  # fmt: skip


def legend_below(figure: Figure) -> None:
    """One legend for all axes, below them, where it hides nothing; none for one line."""
    found: dict[str, Any] = {}
    for axis in figure.axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    if not found or (len(found) == 1 and "the plant changes" not in found and not _is_gain(found)):
        return
    longest = max(map(len, found))
    columns = max(1, min(len(found), int(figure.get_figwidth() / 0.072) // (longest + 7)))
    figure.set_figheight(figure.get_figheight() + 0.17 * -(-len(found) // columns))
    figure.legend(
        found.values(), found, fontsize=8, loc="outside lower center", ncols=columns,
        frameon=False,
    )  # fmt: skip


def _is_gain(found: Iterable[str]) -> bool:
    return all(label.startswith("$K_") for label in found)


def draw_pole_zero(axis: Axes, repetition: AnalysedRun) -> None:
    """Closed-loop poles and zeros of the final controller, and the poles that G_f asks for."""
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 400))
    axis.plot(circle.real, circle.imag, color=INK, linewidth=0.7)
    if repetition.is_scalar:
        comparison = repetition.comparison
        poles, wanted = comparison.poles, comparison.asked_poles
        zeros = np.concatenate([np.zeros(0), *comparison.zeros.values()])
        axis.plot(wanted.real, wanted.imag, "s", mfc="none", mec=WANTED, ms=10, label="asked for")
        axis.plot(zeros.real, zeros.imag, "o", mfc="none", mec=SECOND, ms=6, label="zeros")
    else:
        poles, zeros = repetition.loop.poles(), np.zeros(0)
        wanted = np.zeros(0, dtype=np.complex128)
        if repetition.run.plant.l_z == 1:
            zeros = np.concatenate([zeros, *repetition.zeros.values()])
            axis.plot(zeros.real, zeros.imag, "o", mfc="none", mec=SECOND, ms=6, label="zeros")
    axis.plot(poles.real, poles.imag, "x", color=REACHED, ms=7, mew=1.6, label="poles reached")
    span = max(1.15, 1.1 * np.abs(poles).max(initial=0.0)) if np.isfinite(poles).all() else 1.15
    span = min(span, 3.0)
    axis.set(xlim=(-span, span), ylim=(-span, span), xlabel="real", ylabel="imaginary")
    axis.set_aspect("equal")
    axis.set_title("closed loop with the final controller", fontsize=10)
    axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
    hidden = [
        f"{name} beyond: {count}"
        for name, values in (
            ("asked for", wanted),
            ("poles", poles),
            ("zeros", np.unique(np.round(zeros, 9))),
        )
        if (count := int((np.abs(values) > span).sum()))
    ]
    axis.annotate(", ".join(hidden), (0.02, 0.02), xycoords="axes fraction", fontsize=8)
