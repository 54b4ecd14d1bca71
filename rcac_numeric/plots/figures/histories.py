"""Several runs over the step k: signals and estimates in one pair of axes, coefficients apart."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.engine.runs import Run
from rcac_numeric.experiments.estimation.studies import StudyResult
from rcac_numeric.experiments.figure_requests import FigureRequest
from rcac_numeric.plots.style import INK, line_style

WORDS = {
    "z": "performance $z$",
    "u": "control $u$",
    "y": "measurement $y$",
    "u_applied": "applied control $u$",
}
MANY = 2000  # points of a line; of longer signals each point is the largest of its neighbours


def draw_responses(figure: Figure, runs: Mapping[str, Run], request: FigureRequest) -> None:
    """A signal of each run, one pair of axes for each component."""
    width = max(getattr(run, request.signal).shape[1] for run in runs.values())
    for i, axis in enumerate(np.ravel(figure.subplots(width, 1, sharex=True, squeeze=False))):
        for index, (name, run) in enumerate(runs.items()):
            values = getattr(run, request.signal)
            if i < values.shape[1]:
                _draw(axis, values[:, i], run, request, index, name)
        symbol = WORDS[request.signal] + (f", component {i + 1}" if width > 1 else "")
        axis.set_ylabel(f"magnitude of {symbol}" if request.magnitude else symbol)
        if request.magnitude:
            axis.set_yscale("log")
        axis.grid(alpha=0.25)
    axis.locator_params(axis="x", nbins=6)  # steps have five digits
    axis.set_xlabel("step $k$")
    if len(runs) > 1:
        figure.axes[0].legend(fontsize=8, loc="best")


def draw_coefficients(figure: Figure, runs: Mapping[str, Run], request: FigureRequest) -> None:
    """Theta of each run that adapts, each in axes of its own with a common step."""
    adapting = {name: run for name, run in runs.items() if run.theta.shape[1]}
    axes = np.ravel(figure.subplots(max(len(adapting), 1), 1, sharex=True, squeeze=False))
    if not adapting:
        axes[0].set_title("no run of this figure adapts", fontsize=10)
    figure.set_figheight(max(figure.get_figheight(), 1.6 * len(axes)))
    for axis, (name, run) in zip(axes, adapting.items(), strict=False):
        k = run.first_step + np.arange(len(run.theta)) * run.stride
        shown = (k >= request.first) & (k <= (np.inf if request.last is None else request.last))
        axis.plot(k[shown], run.theta[shown], linewidth=1.0)
        axis.set_ylabel(r"coefficients $\theta$")
        if len(adapting) > 1:
            axis.set_title(shortened(name, 60), fontsize=10, parse_math=False)
        axis.grid(alpha=0.25)
    axes[-1].locator_params(axis="x", nbins=6)
    axes[-1].set_xlabel("step $k$")


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


def _thinned(k: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Blocks of a long signal by their largest and smallest value: peaks stay."""
    size = len(values) // (MANY // 2)
    if size < 2:
        return k, values
    count = len(values) // size
    blocks = values[: count * size].reshape(count, size)
    steps = k[: count * size].reshape(count, size)
    rows = np.arange(count)[:, None]
    places = np.sort(np.stack([blocks.argmin(1), blocks.argmax(1)], 1), axis=1)
    rest = slice(count * size, None)
    return (
        np.concatenate([steps[rows, places].ravel(), k[rest]]),
        np.concatenate([blocks[rows, places].ravel(), values[rest]]),
    )


def _draw(
    axis: Axes, values: np.ndarray, run: Run, request: FigureRequest, index: int, name: str
) -> None:
    last = len(values) if request.last is None else min(request.last + 1, len(values))
    k, shown = _thinned(np.arange(request.first, last), values[request.first : last])
    label = name if run.outcome == "completed" else f"{name}: {run.outcome}, step {run.steps - 1}"
    with np.errstate(all="ignore"):
        drawn = np.where(shown == 0, np.nan, np.abs(shown)) if request.magnitude else shown
    axis.step(k + run.first_step, drawn, where="post", linewidth=1.2,
                        label=shortened(label, 60), **line_style(index))  # fmt: skip
    if run.outcome != "completed" and len(k):
        axis.plot(k[-1] + run.first_step, drawn[-1], "x", color=INK, ms=7)


def _line(axis: Axes, values: Array, request: FigureRequest, name: str, **style: object) -> None:
    last = len(values) if request.last is None else min(request.last + 1, len(values))
    k, shown = _thinned(np.arange(request.first, last), values[request.first : last])
    drawn = np.where(shown == 0, np.nan, shown) if request.magnitude else shown
    axis.plot(k, drawn, label=shortened(name, 40), **{"linewidth": 1.1, **style})  # type: ignore[arg-type]


def _finish(axis: Axes, request: FigureRequest, label: str) -> None:
    if request.magnitude:
        axis.set_yscale("log")
    axis.set(xlabel="step $k$", ylabel=label)
    axis.locator_params(axis="x", nbins=6)
    axis.grid(alpha=0.25)
    axis.legend(fontsize=8, loc="best")
