"""Closed-loop poles and zeros of several runs, each in the plane with the unit circle."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import fill

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_numeric.arrays.array_types import ComplexArray
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.experiments.experiment import RunResult
from rcac_numeric.experiments.figure_requests import FigureRequest
from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
from rcac_numeric.plots.library import Axes, Figure
from rcac_numeric.plots.style import INK, REACHED, SECOND, WANTED

NARROWEST = 2.2  # inches of a map in which its words have room
LETTERS = 11  # of a title, for each inch
WIDEST = 1.5  # what lies further out is named instead of drawn: the unit circle stays readable


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
            axis.set_title(fill(shortened(name, 60), letters), fontsize=9, parse_math=False)
    for axis in axes[len(runs) :]:
        axis.set_visible(False)
    handles, labels = axes[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, fontsize=8, loc="outside lower center", ncols=3)


def _draw(axis: Axes, analysed: AnalysedRun) -> None:
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 400))
    axis.plot(circle.real, circle.imag, color=INK, linewidth=0.7)
    kinds: dict[str, ComplexArray] = {}
    try:
        if analysed.is_scalar:
            comparison = analysed.comparison
            kinds["asked for"] = comparison.asked_poles
            kinds["zeros"] = np.concatenate([np.zeros(0), *comparison.zeros.values()])
            kinds["poles"] = comparison.poles
        else:
            kinds["poles"] = analysed.loop.poles()
    except CompensatorError as error:
        axis.annotate(shortened(str(error), 70), (0.5, 0.5), xycoords="axes fraction",
                      ha="center", fontsize=7, wrap=True)  # fmt: skip
    finite = [values[np.isfinite(values)] for values in kinds.values()]
    farthest = max((float(np.abs(values).max(initial=0.0)) for values in finite), default=0.0)
    span = min(max(1.15, 1.1 * farthest), WIDEST)
    for name, marker, colour, size in (
        ("asked for", "s", WANTED, 10), ("zeros", "o", SECOND, 7), ("poles", "x", REACHED, 7),
    ):  # fmt: skip
        values = kinds.get(name, np.zeros(0, dtype=np.complex128))
        axis.plot(values.real, values.imag, marker, mfc="none", mec=colour, ms=size, mew=1.5,
                  label=name)  # fmt: skip
    beyond = [
        f"{name} beyond: " + ", ".join(map(_words, far[:3]))
        for name, values in kinds.items()
        if len(far := np.unique(np.round(values[np.abs(values) > span], 3)))
    ]
    axis.annotate("\n".join(beyond), (0.02, 0.02), xycoords="axes fraction", fontsize=7)
    axis.set(xlim=(-span, span), ylim=(-span, span), xlabel="real", ylabel="imaginary")
    axis.set_aspect("equal")
    axis.grid(alpha=0.25)


def _words(value: complex) -> str:
    return f"{value.real:.3g}" if value.imag == 0 else f"{value:.3g}"
