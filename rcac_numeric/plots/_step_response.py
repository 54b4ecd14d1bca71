"""The figure of a step test: record, model, dead time."""

from __future__ import annotations

import numpy as np

from rcac_numeric.identification._step_response import StepResponse
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._style import QUIET, REACHED, REQUESTED


def plot_step_response(step: StepResponse) -> Figure:
    """Plot y with the response of the model, the dead time marked, and u below."""
    figure = Figure(figsize=(8, 5.5), layout="constrained")
    upper, lower = figure.subplots(2, 1, height_ratios=[2.5, 1], sharex=True)
    h = step.sample_time or 1.0
    t = h * np.arange(len(step.y))
    upper.plot(t, step.y, ".", color=QUIET, markersize=3, label="y")
    upper.plot(t, step.response, color=REACHED, linewidth=1.5, label="model")
    at = step.first_move
    low, high = step.dead_time_interval
    upper.axvspan(at, at + step.dead_time, color=REQUESTED, alpha=0.12, label="dead time")
    for edge in (low, high):
        upper.axvline(at + edge, color=REQUESTED, linewidth=0.8, linestyle=":")
    for i, (time, _) in enumerate(step.jumps):
        label = None if i else "level jump"
        upper.axvline(time, color=QUIET, linewidth=0.8, linestyle="--", label=label)
    upper.set_title(str(step), fontsize=9, loc="left", wrap=True)
    upper.set_ylabel("$y$")
    upper.legend(fontsize=8)
    lower.step(t, step.u, where="post", color=REACHED, linewidth=1.1)
    lower.set(ylabel="$u$", xlabel="time $t$, s" if step.sample_time else "step $k$")
    for axis in (upper, lower):
        axis.grid(alpha=0.25)
    return figure
