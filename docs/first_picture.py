"""The picture of the README and of the first page; `python -m docs.first_picture` draws it anew.

The run of their ten lines, which is the first scene of the explorer, in the ink of a light and of a
dark page: the performance with RCAC and without, and the closed-loop poles on the places that
theory predicts.
"""

from pathlib import Path

import attrs
import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

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
    found: LoopAnalysis, *, ink: str, reached: str, predicted: str, faint: str
) -> Figure:
    """The performance over the step, and the poles in the plane."""
    figure = Figure(figsize=(7.6, 3.3), layout="constrained")
    history, plane = figure.subplots(1, 2, width_ratios=[1.6, 1])
    run, start = found.run, found.run.settings.k_w
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
        (found.comparison.asked_poles, "s", predicted, 12, "predicted, exactly"),
        (found.comparison.poles, "x", reached, 7, "reached by RCAC"),
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


def main() -> None:
    """Draw it for both pages."""
    found = load_experiment(CASE).main_run.execute().first
    with matplotlib.rc_context({"svg.hashsalt": "first", "svg.fonttype": "path"}):
        for page, inks in INKS.items():
            first_picture(found, **inks).savefig(
                FOLDER / f"first-{page}.svg", transparent=True, metadata={"Date": None}
            )


if __name__ == "__main__":
    main()
