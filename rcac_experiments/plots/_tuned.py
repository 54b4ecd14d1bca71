"""The figure of tuning."""

from __future__ import annotations

import numpy as np

from rcac_experiments.tuning._tuning import ROUNDS, RULE, Tuned
from rcac_numeric.designing._trials import FIXED
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._style import line_style


def plot_tuned(tuned: Tuned) -> Figure:
    """Plot the cost of every candidate over its robustness; those of the last round are filled."""
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
