"""Several runs over the step k: signals and estimates in common axes, theta in separate axes."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from rcac_experiments.experiments._estimation_studies import StudyResult
from rcac_experiments.experiments._experiment import RunResult
from rcac_experiments.experiments._figure_requests import FigureRequest
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.plots._axes import legend_below, mark_changes
from rcac_numeric.plots._coefficients import coefficient_names, draw_theta
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import INK, line_style
from rcac_numeric.plots._thinning import thinned

WORDS = {
    "z": "performance $z$",
    "u": "control $u$",
    "y": "measurement $y$",
    "u_applied": "applied control $u$",
}
SMALLEST = 1e-2  # a coefficient below which a logarithmic axis is straight
BLOCKS = 300  # points of a band: what lies between them counts by its largest value
ROOM = 0.25  # above and below what the runs that did not diverge need
DECADES_DOWN, DECADES_UP = 1e12, 1e3  # below and above their largest magnitude

Results = Mapping[str, RunResult]


def draw_responses(figure: Figure, results: Results, request: FigureRequest) -> None:
    """Plot a signal of each run, one pair of axes for each component.

    Magnitudes of a run with seeds or repetitions are drawn as their median and range.
    """
    runs = {name: result.first.run for name, result in results.items()}
    width = max(getattr(run, request.signal).shape[1] for run in runs.values())
    for i, axis in enumerate(np.ravel(figure.subplots(width, 1, sharex=True, squeeze=False))):
        ends = []
        for index, (name, result) in enumerate(results.items()):
            if i >= getattr(runs[name], request.signal).shape[1]:
                continue
            if request.magnitude and len(result.repetitions) > 1:
                _draw_band(axis, result, request, i, index, name)
            elif end := _draw(axis, result, request, i, index, name):
                ends.append(end)
        symbol = WORDS[request.signal] + (f", component {i + 1}" if width > 1 else "")
        axis.set_ylabel(f"magnitude of {symbol}" if request.magnitude else symbol)
        if request.magnitude:
            axis.set_yscale("log")
        _leave_out_divergence(axis, results, request, i)
        low, high = axis.get_ylim()
        for k, value in ends:
            axis.plot(k, np.clip(value, low, high), "x", color=INK, ms=7, clip_on=False)
        mark_changes(axis, runs.values(), request.first, request.last)
        axis.grid(alpha=0.25)
    axis.locator_params(axis="x", nbins=6)  # steps have five digits
    axis.set_xlabel("step $k$")
    legend_below(figure)


def draw_coefficients(figure: Figure, results: Results, request: FigureRequest) -> None:
    """Plot theta of each adaptive run in separate axes over a common step."""
    runs = {name: result.first.run for name, result in results.items()}
    adapting = {name: run for name, run in runs.items() if run.theta.shape[1]}
    axes = np.ravel(figure.subplots(max(len(adapting), 1), 1, sharex=True, squeeze=False))
    if not adapting:
        axes[0].set_title("no run of this figure adapts", fontsize=10)
    figure.set_figheight(max(figure.get_figheight(), 1.6 * len(axes)))
    alike = len({tuple(coefficient_names(run)) for run in adapting.values()}) < 2
    for axis, (name, run) in zip(axes, adapting.items(), strict=False):
        k = run.first_step + np.arange(len(run.theta)) * run.stride
        shown = (k >= request.first) & (k <= (np.inf if request.last is None else request.last))
        draw_theta(axis, run, shown=shown, legend=not alike)
        if request.magnitude:  # gains of several sizes, with their signs
            axis.set_yscale("symlog", linthresh=SMALLEST)
        mark_changes(axis, [run], request.first, request.last)
        if len(adapting) > 1:
            axis.set_title(shortened(name, 60), fontsize=10)
        axis.grid(alpha=0.25)
    axes[-1].locator_params(axis="x", nbins=6)
    axes[-1].set_xlabel("step $k$")
    if alike:
        legend_below(figure, always=True)


def _draw(
    axis: Axes, result: RunResult, request: FigureRequest, i: int, index: int, name: str
) -> tuple[int, float] | None:
    """Draw the line of the first run, with a mark at its end if it diverged early."""
    run = result.first.run
    seeds = result.specification.seeds
    name = f"{name}, one of {seeds} seeds" if seeds > 1 else name
    values = getattr(run, request.signal)[:, i]
    last = len(values) if request.last is None else min(request.last + 1, len(values))
    k, shown = thinned(np.arange(request.first, last), values[request.first : last])
    label = name if run.outcome == "completed" else f"{name}: {run.outcome}, step {run.steps - 1}"
    with np.errstate(all="ignore"):
        drawn = np.where(shown == 0, np.nan, np.abs(shown)) if request.magnitude else shown
    axis.step(k + run.first_step, drawn, where="post", linewidth=1.2,
                        label=shortened(label, 60), **line_style(index))  # fmt: skip
    if run.outcome == "completed" or last < len(values) or not len(k):
        return None
    return k[-1] + run.first_step, float(drawn[-1])


def _draw_band(
    axis: Axes, result: RunResult, request: FigureRequest, i: int, index: int, name: str
) -> None:
    """Draw the median and the range of the largest magnitudes of neighbouring steps."""
    run = result.first.run
    specification = result.specification
    last = specification.steps if request.last is None else request.last + 1
    edges = np.unique(np.linspace(request.first, last, BLOCKS + 1).astype(int))
    rows = [_largest(getattr(r.run, request.signal)[:, i], edges) for r in result.repetitions]
    band = np.where(np.array(rows) == 0, np.nan, rows)
    count = np.isfinite(band).sum(axis=0)
    known = band[:, count > 0]  # beyond the last step that any of them has reached is nothing
    k = run.first_step + edges[:-1][count > 0]
    kind = "seeds" if specification.seeds > 1 else "repetitions"
    words = f"{shortened(name, 40)}: median and range of {len(rows)} {kind}"
    style: dict[str, Any] = line_style(index)
    axis.plot(k, np.nanmedian(known, axis=0), linewidth=1.2, label=words, **style)
    axis.fill_between(
        k, np.nanmin(known, axis=0), np.nanmax(known, axis=0), alpha=0.2, linewidth=0,
        color=style["color"],
    )  # fmt: skip


def _largest(values: Array, edges: np.ndarray) -> Array:
    """Return the largest magnitude between edges; NaN after the last step."""
    parts = (np.abs(values[a:b]) for a, b in pairwise(edges))
    return np.array([part.max() if len(part) else np.nan for part in parts])


def _leave_out_divergence(axis: Axes, results: Results, request: FigureRequest, i: int) -> None:
    """Return limits for the runs that did not diverge; a few decades at most for magnitudes."""
    last = None if request.last is None else request.last + 1
    every = [r.run for result in results.values() for r in result.repetitions]
    parts = [
        getattr(run, request.signal)[request.first : last, i]
        for run in every
        if run.outcome == "completed" and i < getattr(run, request.signal).shape[1]
    ]
    whole = [part for part in parts if len(part)]
    if not whole:
        return
    low, high = min(v.min() for v in whole), max(v.max() for v in whole)
    if request.magnitude:
        largest = max(abs(low), abs(high))
        bottom, top = axis.get_ylim()
        if largest:
            axis.set_ylim(max(bottom, largest / DECADES_DOWN), min(top, largest * DECADES_UP))
    elif len(whole) < len(every) and high > low:
        axis.set_ylim(low - ROOM * (high - low), high + ROOM * (high - low))


def draw_estimates(
    figure: Figure, results: Mapping[str, StudyResult], request: FigureRequest
) -> None:
    """Plot the estimate of each run's first seed and the true value, or the error's magnitude."""
    axis = figure.subplots()
    for index, (name, result) in enumerate(results.items()):
        run = result.repetitions[0]
        values = np.abs(run.estimate - run.truth) if request.magnitude else run.estimate
        _line(axis, values, request, name, **line_style(index))
    if not request.magnitude:
        longest = max((r.repetitions[0].truth for r in results.values()), key=len)
        _line(axis, longest, request, "truth", color=INK, linestyle=":", linewidth=1.6)
    _finish(axis, request, "error of the estimate" if request.magnitude else "estimate")


def draw_outputs(
    figure: Figure, results: Mapping[str, StudyResult], request: FigureRequest
) -> None:
    """Return z of the first seed of each run, the largest component at each step."""
    axis = figure.subplots()
    for index, (name, result) in enumerate(results.items()):
        z = result.repetitions[0].z
        values = np.abs(z).max(axis=1) if request.magnitude else z[:, 0]
        _line(axis, values, request, name, **line_style(index))
    _finish(axis, request, "magnitude of $z$" if request.magnitude else "$z$")


def _line(axis: Axes, values: Array, request: FigureRequest, name: str, **style: object) -> None:
    last = len(values) if request.last is None else min(request.last + 1, len(values))
    k, shown = thinned(np.arange(request.first, last), values[request.first : last])
    drawn = np.where(shown == 0, np.nan, shown) if request.magnitude else shown
    axis.plot(k, drawn, label=shortened(name, 40), **{"linewidth": 1.1, **style})  # type: ignore[arg-type]


def _finish(axis: Axes, request: FigureRequest, label: str) -> None:
    if request.magnitude:
        axis.set_yscale("log")
    axis.set(xlabel="step $k$", ylabel=label)
    axis.locator_params(axis="x", nbins=6)
    axis.grid(alpha=0.25)
    axis.legend(fontsize=8, loc="best")
