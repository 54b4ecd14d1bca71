"""Zeros of the plants of runs: frozen at steps, and identified from data."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rcac_experiments.experiments._figure_requests import FigureRequest
from rcac_experiments.judging._measures import windows_of
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._schedules import PlantSchedule, plant_at
from rcac_numeric.plants.gallery._zeros import plant_zeros
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._plants import FARTHEST, draw_moduli, draw_zeros
from rcac_numeric.plots._style import REQUESTED, draw_circle

FROZEN = 81  # steps at which the zeros of a plant that changes are found


def draw_plant_zeros(figure: Figure, runs: Mapping[str, Run], request: FigureRequest) -> None:
    """Plot the zeros of each run's plant, frozen at steps: in the plane, and their moduli."""
    if not any(isinstance(run.plant, PlantSchedule) for run in runs.values()):
        _draw_fixed(figure, runs)
        return
    rows = figure.subplots(len(runs), 2, squeeze=False)
    figure.set_figheight(max(figure.get_figheight(), 2.8 * len(runs)))
    for (plane, moduli), (name, run) in zip(rows, runs.items(), strict=True):
        last = run.steps - 1 if request.last is None else request.last
        steps = np.unique(np.linspace(request.first, last, FROZEN).round().astype(int))
        zeros = [plant_zeros(plant_at(run.plant, int(k))) for k in steps]
        draw_zeros(plane, zeros)
        draw_moduli(moduli, steps, zeros, "step $k$")
        if len(runs) > 1:
            moduli.set_title(shortened(name, 45), fontsize=10)


def draw_identified_zeros(figure: Figure, runs: Mapping[str, Run], request: FigureRequest) -> None:
    """Plot the moduli of the zeros identified from windows of each run, over those of the plant."""
    axes = np.ravel(figure.subplots(len(runs), 1, sharex=True, squeeze=False))
    for axis, (name, run) in zip(axes, runs.items(), strict=True):
        last = run.steps if request.last is None else request.last
        steps = np.unique(np.linspace(request.first, last - 1, FROZEN).round().astype(int))
        draw_moduli(axis, steps, [plant_zeros(plant_at(run.plant, int(k))) for k in steps], "")
        windows = [w for w in windows_of(run) if request.first <= w.start and w.stop <= last]
        for window in windows:
            if window.zeros is not None:
                size = np.abs(window.zeros.zeros)
                axis.errorbar(
                    np.full(len(size), (window.start + window.stop) / 2), size,
                    yerr=np.minimum(1.96 * window.zeros.modulus_error, FARTHEST),
                    fmt="o", mfc="none", color=REQUESTED, ms=5, linewidth=0.8,
                )  # fmt: skip
        refused = sum(window.zeros is None for window in windows)
        note = f"; {refused} of {len(windows)} windows refused" if refused else ""
        axis.set_title(f"{shortened(name, 45)}: windows of 70 samples{note}",
                       fontsize=10)  # fmt: skip
        axis.set_ylim(0, FARTHEST / 2)
    axes[-1].set_xlabel("step $k$")


def _draw_fixed(figure: Figure, runs: Mapping[str, Run]) -> None:
    """Plot the zeros of constant plants, one plane for each."""
    figure.set_figheight(min(figure.get_figheight(), 1.25 * figure.get_figwidth() / len(runs)))
    for axis, (name, run) in zip(
        np.ravel(figure.subplots(1, len(runs), squeeze=False)), runs.items(), strict=True
    ):
        zeros = plant_zeros(plant_at(run.plant, 0))
        draw_circle(axis)
        near = zeros[np.abs(zeros) <= FARTHEST]
        axis.plot(near.real, near.imag, "o", mfc="none", mec=REQUESTED, ms=7, label="zeros")
        axis.set(xlabel="real", ylabel="imaginary")
        axis.set_aspect("equal", adjustable="datalim")
        moduli = ", ".join(f"{size:.4g}" for size in np.abs(zeros))
        axis.set_title(f"{shortened(name, 45)}\nmoduli {moduli or 'none'}",
                       fontsize=10)  # fmt: skip
        axis.grid(alpha=0.25)
