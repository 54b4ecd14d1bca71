"""Closed-loop poles and zeros of several runs, each in the plane with the unit circle."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import fill

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_numeric.analysis.loop_analysis import LoopAnalysis
from rcac_numeric.arrays.array_types import ComplexArray
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.experiments.experiment import RunResult
from rcac_numeric.experiments.figure_requests import FigureRequest
from rcac_numeric.plots.library import Axes, Figure
from rcac_numeric.plots.pole_maps import Kind, draw_plane, largest_counts
from rcac_numeric.plots.style import REACHED, SECOND, WANTED

NARROWEST = 2.2  # inches of a map in which its words have room
LETTERS = 11  # of a title, for each inch


def draw_pole_maps(
    figure: Figure, results: Mapping[str, RunResult], request: FigureRequest
) -> None:
    """A map for each run; what was asked for is drawn where the loop is scalar."""
    del request
    runs = {name: result.first for name, result in results.items()}
    width = figure.get_figwidth()
    columns = min(int(width // NARROWEST), len(runs))
    rows = -(-len(runs) // columns)
    figure.set_figheight(min(width / columns, 4.4) * rows + 0.5)
    axes = np.ravel(figure.subplots(rows, columns, squeeze=False))
    for axis, (name, analysed) in zip(axes, runs.items(), strict=False):
        _draw(axis, analysed)
        if len(runs) > 1:
            letters = int(LETTERS * min(width / columns, 4.4))
            axis.set_title(fill(shortened(name, 60), letters), fontsize=9)
    for axis in axes[len(runs) :]:
        axis.set_visible(False)
    handles, labels = axes[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, fontsize=8, loc="outside lower center", ncols=3)


def _draw(axis: Axes, analysed: LoopAnalysis) -> None:
    kinds: dict[str, ComplexArray] = {}
    try:
        if not analysed.obstacle:
            comparison = analysed.comparison
            kinds["asked for"] = comparison.asked_poles
            kinds["zeros"] = largest_counts(comparison.zeros.values())
            kinds["poles"] = comparison.poles
        else:
            kinds["poles"] = analysed.loop.poles()
    except CompensatorError as error:
        axis.annotate(shortened(str(error), 70), (0.5, 0.5), xycoords="axes fraction",
                      ha="center", fontsize=7, wrap=True)  # fmt: skip
    nothing = np.zeros(0, dtype=np.complex128)
    drawn = [
        Kind(name, word, values[np.isfinite(values)], marker, colour, size)
        for name, word, marker, colour, size in (
            ("asked for", "asked for", "s", WANTED, 10.0),
            ("zeros", "zero", "o", SECOND, 7.0),
            ("poles", "pole", "x", REACHED, 7.0),
        )
        for values in [kinds.get(name, nothing)]
    ]
    draw_plane(axis, drawn)
