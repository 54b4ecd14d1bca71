"""Frequency responses of several runs, compared with LQG and with the target model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_experiments.experiments._experiment import RunResult
from rcac_experiments.experiments._figure_requests import FigureRequest
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.analysis._lqg import lqg_controller
from rcac_numeric.analysis._match import IntercalatedMatch
from rcac_numeric.analysis._noise import NoiseIntensities, noise_inputs
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plots._axes import legend_below
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import DASHES, INK, REQUESTED, label_words, line_style

POINTS = 1000

Results = Mapping[str, RunResult]


def draw_disturbance_response(figure: Figure, results: Results, request: FigureRequest) -> None:
    """Plot the gain from w to z (a norm for several signals): open loop, LQG, and each run."""
    axis = figure.subplots()
    omega = (np.arange(POINTS) + 0.5) * np.pi / POINTS
    plant = next(iter(results.values())).first.plant
    intensities = request.noise or None
    shown = {request.channel: 1.0} if request.channel else intensities
    missing = []

    def curve(name: str, loops: Callable[[], Sequence[ClosedLoop]], **style: Any) -> None:
        try:
            gains = [_gain(loop, omega, shown) for loop in loops()]
        except CompensatorError as error:
            missing.append(f"{name}: {label_words(shortened(str(error), 60))}")
        else:
            _draw_band(axis, omega, gains, name, style)

    nothing = ClosedLoop(plant, _nothing(plant))
    curve("without control", lambda: [nothing], color=INK, linewidth=0.8)
    designs = request.designs or (intensities,)
    for index, noise in enumerate(designs):
        name = "LQG" if len(designs) == 1 else f"LQG, {_words(noise)}"
        curve(name, partial(_best, plant, noise), color=REQUESTED, linewidth=4 - index,
              alpha=0.6, linestyle=DASHES[index % len(DASHES)])  # fmt: skip
    for index, (name, result) in enumerate(results.items()):
        loops = partial(_loops, result)
        curve(name, loops, linewidth=1.3, **line_style(index))
    axis.set(
        xlabel=r"frequency $\omega$, rad/sample",
        ylabel=f"gain from {request.channel or 'w'} to z",
        xlim=(0, np.pi),
    )
    if missing:
        axis.set_title("; ".join(missing), fontsize=8)
    axis.grid(alpha=0.25)
    legend_below(figure)


def draw_matches(figure: Figure, results: Results, request: FigureRequest) -> None:
    """Plot G_f and the intercalated transfer function of each run."""
    del request
    figure.set_figheight(max(figure.get_figheight(), 0.8 * figure.get_figwidth()))
    above, below = figure.subplots(2, 1, sharex=True)
    requested: list[IntercalatedMatch] = []
    words = []
    for index, (name, result) in enumerate(results.items()):
        try:
            matches = [repetition.match for repetition in _repetitions(result)]
        except CompensatorError as error:
            words.append(f"{name}: {label_words(shortened(str(error), 60))}")
            continue
        match = matches[0]
        if not any(np.array_equal(match.target, other.target) for other in requested):
            label = "$G_f$" if not requested else f"$G_f$ of {shortened(name, 40)}"
            above.semilogy(match.omega, _norm(match.target), color=REQUESTED, linewidth=4,
                           alpha=0.4, label=label,
                           linestyle=DASHES[len(requested) % len(DASHES)])  # fmt: skip
            requested.append(match)
        style = {"linewidth": 1.2, **line_style(index)}
        _draw_band(above, match.omega, [_norm(m.reached) for m in matches], name, style)
        errors = [np.maximum(m.error, 1e-17) for m in matches]
        _draw_band(below, match.omega, errors, name, style)
    low, high = above.get_ylim()
    if 0 < low < high < 2 * low:
        above.set_ylim((low * high) ** 0.5 / 2**0.5, (low * high) ** 0.5 * 2**0.5)
    above.set(ylabel="gain")
    below.set(
        xlabel=r"frequency $\omega$, rad/sample", ylabel="distance to $G_f$, relative",
        xlim=(0, np.pi),
    )  # fmt: skip
    if words:
        above.set_title("; ".join(words), fontsize=8)
    for axis in (above, below):
        axis.tick_params(which="both", labelsize=8)
        axis.grid(alpha=0.25)
    legend_below(figure)


def _repetitions(result: RunResult) -> Sequence[LoopAnalysis]:
    """Return all seeds of a run; the first of repetitions, which differ by rounding."""
    return result.repetitions if result.specification.seeds > 1 else result.repetitions[:1]


def _loops(result: RunResult) -> list[ClosedLoop]:
    return [repetition.loop for repetition in _repetitions(result)]


def _best(plant: Plant, noise: NoiseIntensities | None) -> list[ClosedLoop]:
    return [lqg_controller(plant, noise=noise).loop]


def _draw_band(
    axis: Axes, omega: Array, curves: Sequence[Array], name: str, style: Mapping[str, Any]
) -> None:
    """Draw a curve, or the median and the range over several seeds."""
    label = shortened(name, 50)
    if len(curves) > 1:
        label += f": median and range of {len(curves)} seeds"
        low, high = np.min(curves, axis=0), np.max(curves, axis=0)
        axis.fill_between(omega, low, high, alpha=0.25, linewidth=0, color=style["color"])
    axis.semilogy(omega, np.median(curves, axis=0), label=label, **style)


def _words(noise: Mapping[str, Any] | None) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in (noise or {}).items())


def _nothing(plant: Plant) -> Compensator:
    return Compensator(np.zeros((0, plant.l_u, plant.l_u)), np.zeros((1, plant.l_u, plant.l_y)))


def _norm(response: np.ndarray) -> Array:
    return np.asarray(np.linalg.norm(response, axis=(1, 2)))


def _gain(loop: ClosedLoop, omega: Array, noise: NoiseIntensities | None) -> Array:
    return _norm(loop.frequency_response(omega) @ noise_inputs(loop.plant, noise).factor)
