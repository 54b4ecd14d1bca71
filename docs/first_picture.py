"""The pictures of the README and of the first page; `python -m docs.first_picture` draws them anew.

The block diagram of the loop, with its signs. Then the run of their ten lines, which is the first
scene of the explorer: the performance with RCAC and without, and the closed-loop poles beside those
that theory predicts.
"""

from pathlib import Path

import attrs
import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

import rcac_experiments.explorer
from rcac_experiments import load_experiment
from rcac_numeric import simulate
from rcac_numeric.analysis._loop_analysis import LoopAnalysis

FOLDER = Path(__file__).resolve().parent / "_static"
CASE = Path(rcac_experiments.explorer.__file__).parent / "scenes" / "tame.toml"
INKS = {
    "light": {"ink": "#1f2328", "reached": "#0969da", "predicted": "#cf222e", "faint": "#6e7781"},
    "dark": {"ink": "#e6edf3", "reached": "#58a6ff", "predicted": "#ff7b72", "faint": "#8b949e"},
}


def first_picture(
    analysis: LoopAnalysis, *, ink: str, reached: str, predicted: str, faint: str
) -> Figure:
    """The performance over the step, and the poles in the plane."""
    figure = Figure(figsize=(7.6, 3.3), layout="constrained")
    history, plane = figure.subplots(1, 2, width_ratios=[1.6, 1])
    run, start = analysis.run, analysis.run.settings.k_w
    idle = simulate(run.plant, attrs.evolve(run.settings, k_w=run.steps), run.w)
    limit = 7.5
    leaves = int(np.argmax(np.abs(idle.z[:, 0]) > limit)) + 1  # what comes after is a picket fence
    history.plot(idle.z[:leaves, 0], color=faint, linestyle=(0, (4, 2)), linewidth=1.4)
    history.plot(run.z[:, 0], color=reached, linewidth=2)
    history.axvline(start, color=faint, linewidth=1)
    history.text(start - 2, -0.93 * limit, "RCAC starts", color=ink, ha="right", size=11)
    history.text(leaves + 2, 0.85 * limit, "without control", color=faint, size=11)
    history.text(leaves + 2, 0.08 * limit, "with RCAC", color=reached, size=11)
    history.set(xlim=(0, run.steps - 1), ylim=(-limit, limit))
    history.set_xlabel("step $k$", color=ink)
    history.set_title("performance $z$", color=ink)
    plane.add_patch(Circle((0, 0), 1, fill=False, edgecolor=faint, linewidth=1.2))
    open_loop = np.linalg.eigvals(run.plant.A)
    for values, marker, colour, size, label in (
        (open_loop, "x", faint, 8, "of the plant"),
        (analysis.comparison.requested_poles, "s", predicted, 12, "predicted, exactly"),
        (analysis.comparison.poles, "x", reached, 7, "reached by RCAC"),
    ):
        plane.plot(
            values.real, values.imag, marker, color=colour, markersize=size, label=label,
            markerfacecolor="none", markeredgewidth=1.8,
        )  # fmt: skip
    plane.set(
        aspect="equal", xlim=(-1.2, 1.2), ylim=(-1.1, 1.1), xticks=(-1, 0, 1), yticks=(-1, 0, 1)
    )
    plane.set_title("poles", color=ink)
    figure.legend(
        *plane.get_legend_handles_labels(), loc="outside lower right", ncols=3, frameon=False,
        labelcolor=ink, handletextpad=0.2, columnspacing=1.4,
    )  # fmt: skip
    for axes in (history, plane):
        axes.set_facecolor("none")
        axes.tick_params(colors=ink)
        for side, spine in axes.spines.items():
            spine.set_color(faint)
            spine.set_visible(side in ("left", "bottom"))
    return figure


def block_diagram(*, ink: str, reached: str, faint: str, **_: str) -> Figure:
    """The standard problem: plant and controller, with positive feedback u = Phi theta."""
    figure = Figure(figsize=(7.6, 2.1))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(-6, 84), ylim=(0, 23))
    axes.axis("off")
    for left, low, width, text, colour in (
        (29, 12, 18, "plant $G$", ink),
        (29, 1, 18, "controller $\\theta$\n(RCAC)", reached),
    ):
        axes.add_patch(
            Rectangle((left, low), width, 9, fill=False, edgecolor=colour, linewidth=1.6)
        )
        axes.text(
            left + width / 2, low + 4.5, text, ha="center", va="center", color=colour, size=12
        )
    for path in (
        [(12, 19), (29, 19)],  # w
        [(47, 19), (64, 19)],  # z
        [(47, 14), (56, 14), (56, 4), (47, 4)],  # y
        [(29, 5.5), (20, 5.5), (20, 14), (29, 14)],  # u
        [(52, 19), (52, 8), (47, 8)],  # z to the adaptation
    ):
        axes.plot(*zip(*path, strict=True), color=ink, linewidth=1.3)
        axes.annotate(
            "", xy=path[-1], xytext=path[-2],
            arrowprops={"arrowstyle": "-|>", "color": ink, "linewidth": 1.3},
        )  # fmt: skip
    for x, y, text, where in (
        (11, 19, "$w$: command,\ndisturbance, noise", "right"),
        (65, 19, "$z$: performance,\nnot the z-transform", "left"),
        (57, 10, "$y$: measurement", "left"),
        (19, 10, "$u$: control,\npositive feedback", "right"),
    ):
        axes.text(x, y, text, ha=where, va="center", color=ink, size=10)
    return figure


def main() -> None:
    """Draw it for both pages."""
    analysis = load_experiment(CASE).main_run.execute().first
    with matplotlib.rc_context({"svg.hashsalt": "first", "svg.fonttype": "path"}):
        for page, inks in INKS.items():
            for name, figure in (
                ("first", first_picture(analysis, **inks)),
                ("loop", block_diagram(**inks)),
            ):
                figure.savefig(
                    FOLDER / f"{name}-{page}.svg", transparent=True, metadata={"Date": None}
                )


if __name__ == "__main__":
    main()
