"""Pictures of a run: response, controller, poles and zeros, and the intercalated match."""

from __future__ import annotations

from compensator_theory.errors import CompensatorError
from rcac_numeric.analysis.match import IntercalatedMatch
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.experiments.measures.loop_analysis import LoopAnalysis
from rcac_numeric.plots.axes import draw_control, draw_pole_zero
from rcac_numeric.plots.coefficients import draw_theta
from rcac_numeric.plots.library import Figure
from rcac_numeric.plots.style import (
    WANTED,
    draw_history,
    draw_magnitude,
    draw_phase,
    draw_title,
    label_words,
)

WIDE = 10.5  # inches


def plot_sheet(repetition: LoopAnalysis, title: str = "") -> Figure:
    """One sheet on one run.

    Left, over the step k: performance z, control u and controller coefficients theta. Right:
    closed-loop poles and zeros beside the poles that the target asks for, and the frequency
    responses of G_f and of the intercalated transfer function of the final controller. A run
    that diverged is drawn up to where it did.

    Parameters
    ----------
    repetition : LoopAnalysis
        ``verify(experiment).main.first``, for example.
    title : str

    Returns
    -------
    matplotlib.figure.Figure
        Not attached to a window; ``figure.savefig("sheet.png")`` writes it.

    Examples
    --------
    >>> from rcac_numeric import plot_sheet, verify
    >>> from rcac_numeric.dissertation import load_example
    >>> figure = plot_sheet(verify(load_example("4.7")).main.first, "Example 4.7")
    >>> len(figure.axes)
    6
    """
    figure = Figure(figsize=(WIDE, 8.5), layout="constrained")
    axes = figure.subplots(3, 2, width_ratios=[1.25, 1], height_ratios=[1.25, 1, 1])
    if title:
        draw_title(figure, title)
    run = repetition.run
    draw_history(axes[0, 0], run.z, "performance $z$", "z")
    draw_control(axes[1, 0], run)
    draw_theta(axes[2, 0], run, above=WIDE / 2)
    axes[2, 0].set_xlabel("step $k$")
    if run.outcome != "completed":
        for axis in axes[:, 0]:
            if axis.get_yscale() == "linear":
                axis.set_yscale("symlog")
        axes[0, 0].set_title(f"diverged after step {run.steps - 1}", color=WANTED, fontsize=10)
    draw_pole_zero(axes[0, 1], repetition)
    try:
        match = repetition.match
    except CompensatorError as error:
        axes[1, 1].set_title(
            f"no intercalated match: {label_words(shortened(str(error), 60))}", fontsize=10
        )
    else:
        draw_magnitude(axes[1, 1], match)
        draw_phase(axes[2, 1], match)
    for axis in axes.ravel():
        axis.grid(alpha=0.25)
    return figure


def plot_match(match: IntercalatedMatch) -> Figure:
    """Gain and phase of G_f and of the intercalated transfer function, one above the other.

    Examples
    --------
    >>> from rcac_numeric.dissertation import load_example
    >>> match = load_example("4.7").main_run.execute().first.match
    >>> [axis.get_ylabel() for axis in match.plot().axes]
    ['magnitude', 'phase, rad']
    """
    figure = Figure(figsize=(7, 5), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    draw_magnitude(above, match)
    draw_phase(below, match)
    for axis in (above, below):
        axis.grid(alpha=0.25)
    return figure
