"""Figures of studies: the share of failed runs, and the measures of the others."""

from __future__ import annotations

from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_experiments.sweeps._statistics import SweepSummary
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import REACHED, REQUESTED

FEW = 4  # values of an axis of a map that a legend can name


def plot_summary(summary: SweepSummary) -> Figure:
    """Plot the share of runs that did not complete, and the median of the measure, over the axes.

    Over one axis lines with their 95 % interval and quantiles, over two a map each.
    """
    if len(summary.axes) not in (1, 2):
        raise InputError(
            f"a picture is over one axis or two; these groups differ in "
            f"{', '.join(summary.axes) or 'nothing'}. Choose with by=, or --by."
        )
    wide = 2 if summary.measure else 1
    figure = Figure(figsize=(5.2 * wide, 4.2), layout="constrained")
    axes = [figure.add_subplot(1, wide, i + 1) for i in range(wide)]
    names = ["share", "median"][:wide]
    for axis, name in zip(axes, names, strict=True):
        if len(summary.axes) == 1:
            _draw_line(axis, summary, name)
        else:
            _draw_map(figure, axis, summary, name)
        title = "share of runs that did not complete" if name == "share" else (
            f"median {summary.measure} of completed runs"
        )  # fmt: skip
        axis.set_title(title, fontsize=10, parse_math=False)
    return figure


def _draw_line(axis: Axes, summary: SweepSummary, name: str) -> None:
    (over,) = summary.axes
    x, ticks = _places(summary.columns[over])
    order = np.argsort(x)
    columns = {key: values[order] for key, values in summary.columns.items()}
    if name == "share":
        low, high = columns["share_low"], columns["share_high"]
        colour = REQUESTED
        axis.set_ylim(-0.03, 1.03)
    else:
        ends = [columns[f"q{q:g}"] for q in (min(summary.quantiles), max(summary.quantiles))]
        low, high = ends
        colour = REACHED
        if _spans_decades(columns["median"]):
            axis.set_yscale("log")
    axis.plot(x[order], columns[name], "o-", color=colour, markersize=4, linewidth=1.2)
    axis.fill_between(x[order], low, high, color=colour, alpha=0.18, linewidth=0)
    _label(axis, "x", over, x, ticks)


def _draw_map(figure: Figure, axis: Axes, summary: SweepSummary, name: str) -> None:
    over, up = summary.axes
    places = {
        which: _places(summary.columns[axis_name], FEW)
        for which, axis_name in (("x", over), ("y", up))
    }
    xs, column = np.unique(places["x"][0], return_inverse=True)
    ys, row = np.unique(places["y"][0], return_inverse=True)
    values = np.full((len(ys), len(xs)), np.nan)
    values[row, column] = summary.columns[name]
    options: dict[str, Any] = {"vmin": 0, "vmax": 1, "cmap": "magma_r"}
    if name == "median":
        options = {"cmap": "viridis"}
        if _spans_decades(values):
            options["norm"] = "log"
    logarithmic = {key: places[key][1] is None and _spans_decades(v)
                   for key, v in (("x", xs), ("y", ys))}  # fmt: skip
    drawn = axis.pcolormesh(
        _edges(xs, logarithmic["x"]), _edges(ys, logarithmic["y"]), values, **options
    )
    figure.colorbar(drawn, ax=axis)
    _label(axis, "x", over, *places["x"])
    _label(axis, "y", up, *places["y"])


def _places(values: Any, few: int = 0) -> tuple[Array, list[str] | None]:
    """Place numbers at their values; words and a few numbers at equal distances."""
    distinct_numbers = np.unique(values) if values.dtype.kind in "if" else None
    if distinct_numbers is not None:
        if len(distinct_numbers) > few:
            return values.astype(np.float64), None
        places = np.searchsorted(distinct_numbers, values)
        return places.astype(np.float64), [f"{number:g}" for number in distinct_numbers]
    words = [str(value) for value in values]
    distinct = list(dict.fromkeys(words))
    return np.array([float(distinct.index(word)) for word in words]), distinct


def _label(axis: Axes, which: str, name: str, places: Array, ticks: list[str] | None) -> None:
    getattr(axis, f"set_{which}label")(name, parse_math=False)
    if ticks is not None:
        getattr(axis, f"set_{which}ticks")(range(len(ticks)), ticks)
    elif _spans_decades(places):
        getattr(axis, f"set_{which}scale")("log")


def _spans_decades(values: Array) -> bool:
    """Whether positive numbers need a logarithmic axis."""
    known = values[np.isfinite(values)]
    return bool(known.size and known.min() > 0 and known.max() > 50 * known.min())


def _edges(values: Array, logarithmic: bool) -> Array:
    """The boundaries between the cells of a map."""
    places = np.log(values) if logarithmic else values
    if len(places) == 1:
        edges = np.array([places[0] - 0.5, places[0] + 0.5])
    else:
        middles = (places[1:] + places[:-1]) / 2
        edges = np.concatenate([[2 * places[0] - middles[0]], middles,
                                [2 * places[-1] - middles[-1]]])  # fmt: skip
    return np.exp(edges) if logarithmic else edges
