"""Frequency responses of several runs: from w to z beside LQG's, and beside the target model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from compensator_theory.errors import CompensatorError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.analysis.match import IntercalatedMatch
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.wording import shortened
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.experiments.figure_requests import FigureRequest
from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
from rcac_numeric.h2.lqg import lqg
from rcac_numeric.h2.noise import NoiseIntensities, noise_inputs
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plots.style import INK, WANTED, line_style

POINTS = 1000


def draw_disturbance_response(
    figure: Figure, runs: Mapping[str, AnalysedRun], request: FigureRequest
) -> None:
    """Gain from w to z (norm over what is several): without control, with LQG, with each run."""
    axis = figure.subplots()
    omega = (np.arange(POINTS) + 0.5) * np.pi / POINTS
    plant = next(iter(runs.values())).plant
    intensities = request.noise or None
    shown = {request.channel: 1.0} if request.channel else intensities
    missing = []

    def curve(name: str, loop: Callable[[], ClosedLoop], **style: object) -> None:
        try:
            gain = _gain(loop(), omega, shown)
        except CompensatorError as error:
            missing.append(f"{name}: {shortened(str(error), 60)}")
        else:
            axis.semilogy(omega, gain, label=shortened(name, 60), **style)

    curve("without control", lambda: ClosedLoop(plant, _nothing(plant)), color=INK, linewidth=0.8)
    curve("LQG", lambda: lqg(plant, noise=intensities).loop, color=WANTED, linewidth=4, alpha=0.4)
    for index, (name, analysed) in enumerate(runs.items()):
        curve(name, partial(getattr, analysed, "loop"), linewidth=1.3, **line_style(index))
    axis.set(
        xlabel=r"frequency $\omega$, rad/sample",
        ylabel=f"gain from {request.channel or 'w'} to z",
        xlim=(0, np.pi),
    )
    if missing:
        axis.set_title("; ".join(missing), fontsize=8)
    axis.grid(alpha=0.25)
    axis.legend(fontsize=8)


def draw_matches(figure: Figure, runs: Mapping[str, AnalysedRun], request: FigureRequest) -> None:
    """G_f, and the intercalated transfer function that each run has made of it."""
    del request
    above, below = figure.subplots(2, 1, sharex=True)
    first: IntercalatedMatch | None = None
    words = []
    for index, (name, analysed) in enumerate(runs.items()):
        try:
            match = analysed.match
        except CompensatorError as error:
            words.append(f"{name}: {shortened(str(error), 60)}")
            continue
        if first is None:
            first = match
            above.semilogy(match.omega, _norm(match.wanted), color=WANTED, linewidth=4, alpha=0.4,
                           label="$G_f$")  # fmt: skip
        above.semilogy(match.omega, _norm(match.reached), linewidth=1.2,
                       label=shortened(name, 60), **line_style(index))  # fmt: skip
        below.semilogy(match.omega, np.maximum(match.error, 1e-17), linewidth=1.2,
                       **line_style(index))  # fmt: skip
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
        axis.grid(alpha=0.25)
    above.legend(fontsize=8)


def _nothing(plant: Plant) -> Compensator:
    return Compensator(np.zeros((0, plant.l_u, plant.l_u)), np.zeros((1, plant.l_u, plant.l_y)))


def _norm(response: np.ndarray) -> Array:
    return np.asarray(np.linalg.norm(response, axis=(1, 2)))


def _gain(loop: ClosedLoop, omega: Array, noise: NoiseIntensities | None) -> Array:
    return _norm(loop.frequency_response(omega) @ noise_inputs(loop.plant, noise).factor)
