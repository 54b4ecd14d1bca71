"""Figures of a design and of tuning: a nominal run, the rms on every plant."""

from __future__ import annotations

import numpy as np

from rcac_numeric.designing._design import Design
from rcac_numeric.designing._trials import FIXED, RCAC
from rcac_numeric.engine._runs import Run
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import INK, line_style


def plot_design(design: Design) -> Figure:
    """Plot error and control of a nominal run, and below the rms of the test runs.

    With a certified set also the share of its radius that theta uses.
    """
    radius = design.runs[RCAC].radius
    heights = [1.2, 1] if radius is None else [1.2, 1, 0.7]
    figure = Figure(figsize=(9, 7.5 if radius is None else 9), layout="constrained")
    axes = figure.subplots(len(heights) + 1, 1, height_ratios=[*heights, 1.4])
    error, control, *shares, below = axes
    for axis in axes[1:-1]:
        axis.sharex(error)
    names = list(design.runs)
    period = design.runs[FIXED].sample_time or 1.0
    for i, name in reversed(list(enumerate(names))):
        run = design.runs[name]
        e = run.z + run.w[: len(run.z), -run.z.shape[1] :]
        lines = error.plot(run.k * period, e, linewidth=1.1, **line_style(i))
        lines[0].set_label(name)  # several signals are of one controller
        control.plot(run.k * period, run.u_applied, linewidth=1.1, **line_style(i))
    fixed_run = design.runs[FIXED]
    largest = float(np.abs(fixed_run.z).max(initial=0.0)) or 1.0
    error.set_ylim(-2 * largest, 2 * largest)
    reach = float(np.abs(fixed_run.u_applied).max(initial=0.0)) or 1.0
    control.set_ylim(-2 * reach, 2 * reach)
    error.set_title(str(design.verdict), fontsize=9, loc="left", wrap=True)
    error.set_ylabel("$e_0$")
    error.legend(fontsize=8, loc="upper right")
    steps = "step $k$" if design.runs[FIXED].sample_time is None else "time $t$, s,"
    control.set(ylabel="$u$")
    for axis in shares:
        _share(axis, design.runs[RCAC], period)
    axes[-2].set_xlabel(f"{steps} of a test run with the nominal plant")
    plants = list(dict.fromkeys(trial.variation.name for trial in design.evidence))
    for i, name in enumerate(names):
        trials = [t for t in design.evidence if t.controller == name]
        for j, trial in enumerate(trials):
            finite = [value for value in trial.rms if np.isfinite(value)]
            place = j + 0.25 * (i - (len(names) - 1) / 2)
            style = line_style(i)
            below.plot([place] * len(finite), finite, "o", markersize=4, color=style["color"])
            if lost := len(trial.rms) - len(finite):
                words = f"{lost} lost"
                top = {"xycoords": ("data", "axes fraction"), "ha": "center", "va": "bottom"}
                below.annotate(words, (place, 1.0), fontsize=7, color=style["color"], **top)
    below.set_yscale("log")
    below.set_xticks(range(len(plants)), plants, fontsize=7, rotation=15)
    below.set(xlabel="plant", ylabel="rms of $e_0$")
    for axis in figure.axes:
        axis.grid(alpha=0.25)
    return figure


def _share(axis: Axes, run: Run, period: float) -> None:
    """Plot the share of the radius of the certified set over the steps."""
    radius = run.radius
    if radius is None:
        return
    axis.plot(run.k[: len(radius)] * period, radius, linewidth=1.1, **line_style(0))
    axis.axhline(1.0, color=INK, linewidth=0.7, linestyle="--")
    axis.set(ylabel="share of\nthe radius", ylim=(0, 1.08))
