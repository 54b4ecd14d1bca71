"""A run in several small pictures, each readable on a phone."""

from __future__ import annotations

from compensator_theory.errors import CompensatorError
from rcac_experiments.experiments._experiment import Verification
from rcac_experiments.plots._requested import plot_verification
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.plots._axes import draw_control, draw_pole_zero, legend_below
from rcac_numeric.plots._coefficients import draw_theta
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._style import draw_history, draw_magnitude, draw_phase

WIDTH = 4.6  # inches; at 9 points the words are still words on a screen of 360 pixels


def single_figures(repetition: LoopAnalysis) -> dict[str, Figure]:
    """The response, the coefficients, the poles and zeros, and the intercalated match."""
    figures = {
        "Performance z and control u": _response(repetition),
        "Controller coefficients": _coefficients(repetition),
        "Closed-loop poles and zeros": _pole_zero(repetition),
    }
    try:
        repetition.match  # noqa: B018 asked for before anything is drawn
    except CompensatorError:
        return figures
    return {**figures, "Target model and what was reached": _match(repetition)}


def page_figures(verification: Verification) -> dict[str, Figure]:
    """The requested pictures, or those of the main run, by their subject."""
    requests = [r for r in verification.experiment.figures if r.kind != "sheet"]
    if not requests and verification.estimates:
        return {"What is estimated.": plot_verification(verification, width=WIDTH)}
    if not requests:
        return single_figures(verification.main.first)
    return {r.caption: plot_verification(verification, r, width=WIDTH) for r in requests}


def _response(repetition: LoopAnalysis) -> Figure:
    figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
    first, second = figure.subplots(2, 1, sharex=True)
    draw_history(first, repetition.run.z, "performance $z$", "z")
    draw_control(second, repetition.run)
    second.set_xlabel("step $k$")
    if repetition.run.outcome != "completed":
        for axis in (first, second):
            if axis.get_yscale() == "linear":
                axis.set_yscale("symlog")
    return _with_grid(figure)


def _coefficients(repetition: LoopAnalysis) -> Figure:
    figure = Figure(figsize=(WIDTH, 2.6), layout="constrained")
    axis = figure.subplots()
    draw_theta(axis, repetition.run, legend=False)
    axis.set_xlabel("step $k$")
    legend_below(figure, always=True)
    return _with_grid(figure)


def _pole_zero(repetition: LoopAnalysis) -> Figure:
    figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
    axis = figure.subplots()
    draw_pole_zero(axis, repetition, legend=False)  # beside the map there is no room for it
    legend_below(figure, always=True)
    return _with_grid(figure)


def _match(repetition: LoopAnalysis) -> Figure:
    figure = Figure(figsize=(WIDTH, 4.2), layout="constrained")
    first, second = figure.subplots(2, 1, sharex=True)
    draw_magnitude(first, repetition.match)
    draw_phase(second, repetition.match)
    return _with_grid(figure)


def _with_grid(figure: Figure) -> Figure:
    for axis in figure.axes:
        axis.grid(alpha=0.25)
        axis.locator_params(axis="x", nbins=5)
        for side in ("top", "right"):
            axis.spines[side].set_visible(False)
    return figure
