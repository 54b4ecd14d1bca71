"""The picture of the README and of the first page; `python -m docs.first_picture` draws it anew.

Example 4.7, in the ink of a light and of a dark page: the performance while RCAC learns, and the
closed-loop poles that it reached on the places that theory predicts.
"""

from pathlib import Path

import matplotlib
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from rcac_numeric.dissertation import load_example
from rcac_numeric.experiments.measures.loop_analysis import LoopAnalysis

FOLDER = Path(__file__).resolve().parent / "_static"
INKS = {
    "light": {"ink": "#1f2328", "reached": "#0969da", "predicted": "#cf222e", "faint": "#afb8c1"},
    "dark": {"ink": "#e6edf3", "reached": "#58a6ff", "predicted": "#ff7b72", "faint": "#57606a"},
}


def first_picture(
    found: LoopAnalysis, *, ink: str, reached: str, predicted: str, faint: str
) -> Figure:
    """The performance over the step, and the poles in the plane."""
    figure = Figure(figsize=(9, 3.5), layout="constrained")
    history, plane = figure.subplots(1, 2, width_ratios=[1.9, 1])
    z, start = found.run.z[:, 0], found.run.settings.k_w
    history.step(range(len(z)), z, where="post", color=reached, linewidth=1.6)
    history.axvline(start, color=faint, linestyle="--")
    history.text(start - 1.5, z.min(), "RCAC begins to learn", color=ink, ha="right")
    history.set_xlabel("step $k$", color=ink)
    history.set_title("performance $z$", color=ink)
    plane.add_patch(Circle((0, 0), 1, fill=False, edgecolor=faint, linewidth=1.2))
    for values, marker, colour, size, label in (
        (found.comparison.asked_poles, "s", predicted, 12, "exact prediction"),
        (found.comparison.poles, "x", reached, 7, "reached by RCAC"),
    ):
        plane.plot(
            values.real, values.imag, marker, color=colour, markersize=size, label=label,
            markerfacecolor="none", markeredgewidth=1.8,
        )  # fmt: skip
    plane.set(aspect="equal", xlim=(-1.15, 1.15), ylim=(-1.15, 1.15))
    plane.set_title("closed-loop poles", color=ink)
    figure.legend(loc="outside lower right", ncols=2, frameon=False, labelcolor=ink)
    for axes in (history, plane):
        axes.set_facecolor("none")
        axes.tick_params(colors=ink)
        for spine in axes.spines.values():
            spine.set_color(faint)
    return figure


def main() -> None:
    """Draw it for both pages."""
    found = load_example("4.7").runs["UD"].execute().first
    with matplotlib.rc_context({"svg.hashsalt": "4.7", "svg.fonttype": "path"}):
        for page, inks in INKS.items():
            first_picture(found, **inks).savefig(
                FOLDER / f"first-{page}.svg", transparent=True, metadata={"Date": None}
            )


if __name__ == "__main__":
    main()
