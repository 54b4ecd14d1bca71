"""Figures of a run: response, controller, poles and zeros, and the match with G_f."""

from __future__ import annotations

from rcac_numeric.analysis._exact_comparison import ExactComparison
from rcac_numeric.analysis._loop_analysis import LoopAnalysis, attempted
from rcac_numeric.analysis._match import IntercalatedMatch
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.engine._runs import Run
from rcac_numeric.plots._axes import draw_control, draw_pole_zero, draw_poles
from rcac_numeric.plots._coefficients import draw_theta
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._pole_maps import largest_counts
from rcac_numeric.plots._style import (
    REQUESTED,
    checked_width,
    draw_history,
    draw_magnitude,
    draw_phase,
    draw_title,
    label_words,
)

WIDE = 10.5  # inches


def plot_sheet(repetition: LoopAnalysis, title: str = "") -> Figure:
    """Plot one run on one sheet.

    Left, over the step k: performance z, control u and controller coefficients theta. Right:
    closed-loop poles and zeros beside the poles of the target, and the frequency
    responses of G_f and of the intercalated transfer function of the final controller. A run
    that diverged is drawn up to where it did.

    Parameters
    ----------
    repetition : LoopAnalysis
        ``LoopAnalysis(run)``, for example.
    title : str

    Returns
    -------
    matplotlib.figure.Figure
        Not attached to a window; ``figure.savefig("sheet.png")`` writes it.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, LoopAnalysis, Step, exogenous, fir_target, iir, simulate,
    ...     standard_plant)
    >>> from rcac_numeric.plots import plot_sheet
    >>> plant = standard_plant("(q - 0.5)/((q - 0.9)*(q - 0.8))")
    >>> settings = ControllerSettings(structure=iir(2), target=fir_target(plant), update=UD(1e-3))
    >>> run = simulate(plant, settings, exogenous([Step()], steps=100))
    >>> figure = plot_sheet(LoopAnalysis(run), "A step disturbance")
    >>> len(figure.axes)
    6
    """
    if not isinstance(repetition.of, Run):
        return _sheet_of_loop(repetition, title)
    figure = Figure(figsize=(WIDE, 8.5), layout="constrained")
    axes = figure.subplots(3, 2, width_ratios=[1.25, 1], height_ratios=[1.25, 1, 1])
    if title:
        draw_title(figure, title)
    run = repetition.run
    draw_history(axes[0, 0], run.z, "performance $z$", "z")
    draw_control(axes[1, 0], run)
    draw_theta(axes[2, 0], run, above=WIDE / 2)
    axes[2, 0].set_xlabel("step $k$")
    for axis in axes[:2, 0]:
        axis.sharex(axes[2, 0])
    if run.outcome != "completed":
        for axis in axes[:, 0]:
            if axis.get_yscale() == "linear":
                axis.set_yscale("symlog")
        axes[0, 0].set_title(f"diverged after step {run.steps - 1}", color=REQUESTED, fontsize=10)
    draw_pole_zero(axes[0, 1], repetition)
    _draw_match(axes[1, 1], axes[2, 1], repetition)
    for axis in axes.ravel():
        axis.grid(alpha=0.25)
    return figure


def _sheet_of_loop(loop: LoopAnalysis, title: str) -> Figure:
    """Plot the right half of the sheet, for a loop without a run."""
    figure = Figure(figsize=(6, 8.5), layout="constrained")
    axes = figure.subplots(3, 1, height_ratios=[1.25, 1, 1])
    if title:
        draw_title(figure, title)
    draw_pole_zero(axes[0], loop)
    _draw_match(axes[1], axes[2], loop)
    for axis in axes:
        axis.grid(alpha=0.25)
    return figure


def _draw_match(above: Axes, below: Axes, analysis: LoopAnalysis) -> None:
    match, obstacle = attempted(lambda: analysis.match)
    if match is None:
        words = label_words(shortened(obstacle, 60))
        above.set_title(f"no intercalated match: {words}", fontsize=10)
        return
    above.sharex(below)
    draw_magnitude(above, match)
    draw_phase(below, match)


def plot_comparison(comparison: ExactComparison, *, width: float = 5.0) -> Figure:
    """Plot closed-loop poles and their exact prediction."""
    inches = checked_width(width)
    figure = Figure(figsize=(inches, 1.08 * inches), layout="constrained")
    axis = figure.subplots()
    zeros = largest_counts(comparison.zeros.values())
    draw_poles(axis, comparison.poles, comparison.requested_poles, zeros)
    axis.set_title("")
    figure.legend(fontsize=8, loc="outside lower center", ncols=3, frameon=False)
    return figure


def plot_match(match: IntercalatedMatch) -> Figure:
    """Plot gain and phase of G_f and of the intercalated transfer function."""
    figure = Figure(figsize=(7, 5), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    draw_magnitude(above, match)
    draw_phase(below, match)
    for axis in (above, below):
        axis.grid(alpha=0.25)
    return figure
