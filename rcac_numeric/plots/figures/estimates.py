"""What estimators found over the step k, beside the truth."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.experiments.estimation.studies import StudyResult
from rcac_numeric.experiments.figure_requests import FigureRequest
from rcac_numeric.plots.figures.histories import thinned
from rcac_numeric.plots.library import Axes, Figure
from rcac_numeric.plots.style import INK, line_style


def draw_estimates(
    figure: Figure, results: Mapping[str, StudyResult], request: FigureRequest
) -> None:
    """The estimate of the first seed of each run and the truth; or the error's magnitude."""
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
    """Z of the first seed of each run, the largest component of each step."""
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
