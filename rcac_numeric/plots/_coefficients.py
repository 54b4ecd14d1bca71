"""Figures of theta over the step, each line labelled by its tap of the regressor."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.engine._compatibility import controllers_of
from rcac_numeric.engine._runs import Run
from rcac_numeric.plots._library import Axes
from rcac_numeric.plots._style import line_style

NAMED = 12  # lines that a legend can name; more are coloured by their signal
SHORT, COLUMN = 16, 1.1  # characters of a label that stands in a column of so many inches
LONG = 200_000  # rows of theta that are drawn
FEW = 3
GAINS = ("P", "I", "D", "PI", "PD", "ID", "PID")


def coefficient_names(run: Run) -> list[str]:
    """The tap of each entry of theta, such as u(k-1)."""
    if isinstance(run.settings, StepwiseController):
        return [rf"\theta_{{{i + 1}}}" for i in range(run.theta.shape[1])]
    return [
        name
        for one in controllers_of(run.settings)
        if isinstance(one, ControllerSettings)
        for name in structure_names(one.structure)
    ]


def structure_names(structure: Structure) -> list[str]:
    """The taps of one structure, in the order of its coefficients."""
    if structure.name in GAINS and structure.l_theta == len(structure.name):
        return [f"K_{letter}" for letter in structure.name]
    widths = {"u": structure.l_u, "y": structure.l_y, "r": structure.l_r}
    widths["derived"] = len(structure.derived)
    names = []
    for tap in structure.taps:
        letter = "s" if tap.signal == "derived" else tap.signal
        index = f"_{tap.component + 1}" if widths[tap.signal] > 1 else ""
        lag = f"k-{tap.delay}" if tap.delay else "k"
        for row in range(structure.l_u):
            to = rf"\to u_{row + 1}" if structure.l_u > 1 else ""
            names.append(f"{letter}{index}({lag}){to}")
    return names


def draw_theta(
    axis: Axes, run: Run, title: str = "", shown: np.ndarray | None = None, *,
    legend: bool = True, above: float = 0.0, period: float = 1.0,
) -> None:  # fmt: skip
    """Draw theta over the step times a period.

    Its lines are named by `coefficient_names`.
    The legend stands beside the axes or, in a picture that is `above` inches wide, above them.
    """
    k = run.first_step + np.arange(len(run.theta)) * run.stride
    every = max(len(run.theta) // LONG, 1)
    rows = slice(None, None, every) if shown is None else shown
    k, theta = k[rows], run.theta[rows]
    if shown is None and run.stride > 1:  # what became of it after the last row that was kept
        k = np.append(k, run.first_step + run.steps)
        theta = np.vstack([theta, run.theta_final])
    draw_coefficients(axis, k * period, theta, coefficient_names(run), legend=legend and not above)
    if above:
        legend_above(axis, above, title)
    elif title:
        axis.set_title(title, fontsize=10)


def legend_above(axis: Axes, width: float, title: str = "") -> None:
    """Draw the legend in rows above the axes, under their title.

    `width` is that of the picture in inches.
    """
    handles, labels = axis.get_legend_handles_labels()
    if not handles:
        axis.set_title(title, fontsize=8)
        return
    columns = min(len(handles), max(int(width / COLUMN), 1) if max(map(len, labels)) < SHORT else 1)
    axis.legend(fontsize=7, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=columns,
                frameon=False, handlelength=1.8, columnspacing=1.2,
                title=title or None, title_fontsize=8)  # fmt: skip


def draw_coefficients(
    axis: Axes, k: np.ndarray, theta: Array, names: list[str], *, legend: bool = True
) -> None:
    """Draw a line for each coefficient, with a legend.

    Where they are many, one of the signals that they weigh.
    """
    groups = [name.split("(")[0].split("_")[0] for name in names]
    kinds = list(dict.fromkeys(groups))
    many = len(names) > NAMED
    for i, (name, group) in enumerate(zip(names, groups, strict=True)):
        style = line_style(kinds.index(group) if many else i)
        if many:
            style["linestyle"] = "-"  # dashes of fifty lines are a carpet
        if len(k) < FEW:
            style |= {"linestyle": "none", "marker": "."}  # no line tells what lies between
        first = groups.index(group) == i
        label = (f"of ${group}$" if first else None) if many else f"${name}$"
        axis.plot(k, theta[:, i], linewidth=0.9 if many else 1.2, label=label, **style)
    if names and legend:
        axis.legend(fontsize=7.5, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False,
                    title=None if many or names[0].startswith("K_") else "weighs",
                    title_fontsize=7.5)  # fmt: skip
    axis.set_ylabel("gains" if names and names[0].startswith("K_") else r"coefficients $\theta$")
