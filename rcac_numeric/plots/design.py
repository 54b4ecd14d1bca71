"""Pictures of a design: a nominal run of each controller, the rms on every plant; and of tuning."""

from __future__ import annotations

import numpy as np

from rcac_experiments.sweeps.tuning import ROUNDS, RULE, Tuned
from rcac_numeric.plots.library import Figure
from rcac_numeric.plots.style import line_style
from rcac_numeric.synthesis.design import Design
from rcac_numeric.synthesis.trials import FIXED


def plot_design(design: Design) -> Figure:
    """Above the error and the control of a nominal run, below the rms on held-out runs."""
    figure = Figure(figsize=(9, 7.5), layout="constrained")
    error, control, below = figure.subplots(3, 1, height_ratios=[1.2, 1, 1.4])
    error.sharex(control)
    names = list(design.runs)
    for i, name in reversed(list(enumerate(names))):
        run = design.runs[name]
        e = run.z + run.w[: len(run.z), -run.z.shape[1] :]
        lines = error.plot(run.k, e, linewidth=1.1, **line_style(i))
        lines[0].set_label(name)  # several signals are of one controller
        control.plot(run.k, run.u_applied, linewidth=1.1, **line_style(i))
    seen = design.runs[FIXED]
    largest = float(np.abs(seen.z).max(initial=0.0)) or 1.0
    error.set_ylim(-2 * largest, 2 * largest)
    reach = float(np.abs(seen.u_applied).max(initial=0.0)) or 1.0
    control.set_ylim(-2 * reach, 2 * reach)
    error.set_title(str(design.verdict), fontsize=9, loc="left", wrap=True)
    error.set_ylabel("$e_0$")
    error.legend(fontsize=8, loc="upper right")
    control.set(ylabel="$u$", xlabel="step $k$ of a held-out run with the nominal plant")
    plants = list(dict.fromkeys(trial.variation.name for trial in design.evidence))
    for i, name in enumerate(names):
        trials = [t for t in design.evidence if t.controller == name]
        for j, trial in enumerate(trials):
            kept = [value for value in trial.rms if np.isfinite(value)]
            place = j + 0.25 * (i - (len(names) - 1) / 2)
            style = line_style(i)
            below.plot([place] * len(kept), kept, "o", markersize=4, color=style["color"])
            if lost := len(trial.rms) - len(kept):
                words = f"{lost} lost"
                top = {"xycoords": ("data", "axes fraction"), "ha": "center", "va": "bottom"}
                below.annotate(words, (place, 1.0), fontsize=7, color=style["color"], **top)
    below.set_yscale("log")
    below.set_xticks(range(len(plants)), plants, fontsize=7, rotation=15)
    below.set(xlabel="plant", ylabel="rms of $e_0$")
    for axis in figure.axes:
        axis.grid(alpha=0.25)
    return figure


def plot_tuned(tuned: Tuned) -> Figure:
    """The cost of every candidate against its robustness, those of the last round filled."""
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axis = figure.subplots()
    lost = [one for one in tuned.candidates if not np.isfinite(one.Ms + one.beside.ratio)]
    for one in tuned.candidates:
        if one in lost:
            continue
        is_last, is_named = one.rounds == ROUNDS, one.name in (FIXED, RULE)
        colour = line_style(1 if is_named else 0)["color"]
        face = colour if is_last else "none"
        axis.plot(one.Ms, one.beside.ratio, "o", color=colour, markerfacecolor=face, markersize=5)
        if is_named or one == tuned.chosen:
            words = "chosen" if one == tuned.chosen else one.name
            axis.annotate(words, (one.Ms, one.beside.ratio), (5, 4), textcoords="offset points")
    axis.set(
        xscale="log", yscale="log", xlabel="largest peak of the sensitivity, of all plants",
        ylabel="rms of $e_0$ over that of the fixed controller",
    )  # fmt: skip
    title = f"{len(tuned.candidates)} candidates"
    axis.set_title(f"{title}, {len(lost)} of them lost" if lost else title, fontsize=9, loc="left")
    axis.grid(alpha=0.25)
    return figure
