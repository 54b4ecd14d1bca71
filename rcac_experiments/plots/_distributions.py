"""A measure over the repetitions of several runs: every value, and the median."""

from __future__ import annotations

import inspect
from collections.abc import Mapping

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_experiments.experiments._estimation_studies import StudyResult
from rcac_experiments.experiments._experiment import RunResult
from rcac_experiments.experiments._figure_requests import FigureRequest
from rcac_experiments.judging._measures import MEASURES
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._style import INK, line_style

DECADES = 30.0  # a ratio from which the axis is logarithmic


def draw_distribution(
    figure: Figure, results: Mapping[str, RunResult], request: FigureRequest
) -> None:
    """Draw a row for each run; the missing values are counted at its end."""
    values = {name: _values(result, request) for name, result in results.items()}
    draw_values(figure, values, request.measure)


def draw_study_distribution(
    figure: Figure, results: Mapping[str, StudyResult], request: FigureRequest
) -> None:
    """Draw a row for each study of an estimation example, measured from the step `first` on."""
    arguments = {"start": request.first} if request.first else {}
    values = {name: np.array(r.values(request.measure, arguments)) for name, r in results.items()}
    draw_values(figure, values, request.measure)


def draw_values(figure: Figure, values_by_name: Mapping[str, Array], measure: str) -> None:
    """The values of a measure, a row for each run."""
    axis = figure.subplots()
    figure.set_figheight(max(2.2, 0.45 * len(values_by_name) + 1.2))
    finite = np.concatenate([v[np.isfinite(v)] for v in values_by_name.values()] or [np.zeros(0)])
    if len(finite) and finite.min() > 0 and finite.max() > DECADES * finite.min():
        axis.set_xscale("log")
    else:
        axis.locator_params(axis="x", nbins=5)
    rng = np.random.default_rng(0)  # spreads points that would lie on each other
    labels = []
    for row, (name, values) in enumerate(values_by_name.items()):
        known = values[np.isfinite(values)]
        height = row + (0.25 * rng.uniform(-1, 1, len(known)) if len(known) > 1 else 0.0)
        colour = line_style(row)["color"]
        axis.plot(known, np.broadcast_to(height, known.shape), "o", ms=5, alpha=0.6, color=colour)
        if len(known):
            axis.plot([np.median(known)] * 2, [row - 0.35, row + 0.35], color=INK, linewidth=2)
        lost = len(values) - len(known)
        labels.append(shortened(name, 40) + (f"\n{lost} of {len(values)} lost" if lost else ""))
    axis.set_yticks(range(len(labels)), labels, fontsize=8)
    axis.invert_yaxis()
    axis.set_xlabel(measure.replace("_", " ") + " (bar: median)")
    axis.grid(alpha=0.25, axis="x")


def _values(result: RunResult, request: FigureRequest) -> Array:
    measure = MEASURES[request.measure]
    known = inspect.signature(measure).parameters
    options = {"noise": request.noise or None, "direct": request.direct}
    arguments = {name: value for name, value in options.items() if name in known}
    values = []
    for repetition in result.repetitions:
        try:
            values.append(float(measure(repetition, **arguments)))
        except CompensatorError:
            values.append(np.nan)
    return np.array(values)
