"""Figures of plants: moving zeros, identified zeros, and plants of the gallery."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import StateSpace, lsim

from rcac_numeric.arrays._array_types import ComplexArray
from rcac_numeric.plants.gallery._continuous import ContinuousPlant
from rcac_numeric.plants.gallery._rohrs import sampling_zeros
from rcac_numeric.plants.gallery._zeros import ZeroPath
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import INK, REACHED, REQUESTED, SECOND, draw_circle, line_style

FARTHEST = 4.0  # zeros of larger modulus are left out of a picture of moduli


def plot_zero_path(path: ZeroPath) -> Figure:
    """Plot the zeros of a changing plant in the plane and by modulus, figures 3.4 and 3.5."""
    figure = Figure(figsize=(10, 4.4), layout="constrained")
    plane, moduli = figure.subplots(1, 2)
    draw_zeros(plane, list(path.zeros))
    draw_moduli(moduli, path.steps, list(path.zeros), "step $k$")
    return figure


def plot_continuous_plant(plant: ContinuousPlant, periods: Sequence[float]) -> Figure:
    """Plot poles and zeros in the s-plane, step responses, and the sampled plant's zeros."""
    figure = Figure(figsize=(12, 4), layout="constrained")
    plane, response, sampled = figure.subplots(1, 3)
    poles, zeros = plant.poles(), plant.zeros()
    plane.axvline(0, color=INK, linewidth=0.7)
    plane.plot(poles.real, poles.imag, "x", color=REACHED, ms=8, mew=1.6, label="poles")
    if len(zeros):
        plane.plot(zeros.real, zeros.imag, "o", mfc="none", mec=SECOND, ms=8, label="zeros")
        plane.legend(fontsize=8)
    plane.set(xlabel="real, rad/s", ylabel="imaginary, rad/s")
    plane.set_title("poles and zeros" if len(zeros) else "poles; there are no zeros", fontsize=10)
    plane.margins(0.15)
    plane.locator_params(nbins=6)
    _step_response(response, plant, poles)
    zeros_of_sampling = sampling_zeros(plant, periods)
    draw_moduli(sampled, np.asarray(periods), zeros_of_sampling, "sampling period, s")
    sampled.set_title("zeros of the sampled plant", fontsize=10)
    for axis in (plane, response):
        axis.grid(alpha=0.25)
    return figure


def _step_response(axis: Axes, plant: ContinuousPlant, poles: ComplexArray) -> None:
    """The step response over some time constants of the slowest or the fastest unstable pole."""
    growing, size = poles.real[poles.real > 1e-6], np.abs(poles[np.abs(poles) > 1e-6])
    decay = -poles.real[poles.real < -1e-6]
    slow, fast = min(size, default=1.0), max(size, default=1.0)
    lasting = max(6 / slow, min(5 / min(decay, default=slow), 12 * np.pi / fast))
    lasting = 3 / growing.max() if len(growing) else lasting
    time = np.linspace(0, lasting, 400)
    system = StateSpace(plant.A, plant.B, plant.C, plant.D)
    for j, source in enumerate(plant.inputs):
        drive = np.zeros((len(time), len(plant.inputs)))
        drive[:, j] = 1.0
        y = lsim(system, drive, time)[1].reshape(len(time), -1)
        for i, sink in enumerate(plant.outputs):
            (line,) = axis.plot(time, y[:, i], label=f"{source} to {sink}")
            line.set(**line_style(j * y.shape[1] + i))
    axis.set(xlabel="time, s", ylabel="output")
    axis.set_title("unit step response", fontsize=10)
    axis.locator_params(axis="x", nbins=5)
    if len(plant.inputs) * len(plant.outputs) > 1:
        axis.legend(fontsize=7)


def draw_zeros(axis: Axes, zeros: Sequence[ComplexArray]) -> None:
    """Draw zeros in the plane, the first ones as rings and the last ones filled."""
    draw_circle(axis)
    every = np.concatenate([np.zeros(0), *zeros])
    near = every[np.abs(every) <= FARTHEST]
    axis.plot(near.real, near.imag, ".", color=SECOND, ms=3, label="on the way")
    for values, name, fill in ((zeros[0], "first", "none"), (zeros[-1], "last", REQUESTED)):
        shown = values[np.abs(values) <= FARTHEST]
        axis.plot(shown.real, shown.imag, "o", mfc=fill, mec=REQUESTED, ms=7, label=name)
    axis.set(xlabel="real", ylabel="imaginary")
    right = near[near.real > 0]
    if len(right) == len(near) or len(right) == 0:
        axis.set_aspect("equal", adjustable="datalim")
    else:  # a zero near -1 would leave the others a point
        low, high = right.real.min() - 0.05, right.real.max() + 0.05
        tall = max(np.abs(right.imag).max(), 0.02) * 1.5
        axis.set(xlim=(low, high), ylim=(-tall, tall))
        axis.annotate(f"{len(zeros[0]) - (zeros[0].real > 0).sum()} further left",
                      (0.02, 0.03), xycoords="axes fraction", fontsize=8)  # fmt: skip
    axis.grid(alpha=0.25)
    axis.legend(fontsize=8)


def draw_moduli(axis: Axes, where: np.ndarray, zeros: Sequence[ComplexArray], label: str) -> None:
    """Draw moduli of zeros over steps or periods, and the unit circle."""
    axis.axhline(1, color=INK, linewidth=0.7)
    at = np.concatenate(
        [np.zeros(0), *(np.full(len(z), k) for k, z in zip(where, zeros, strict=True))]
    )
    size = np.abs(np.concatenate([np.zeros(0), *zeros]))
    near = size <= FARTHEST
    axis.plot(at[near], size[near], ".", color=REACHED, ms=4)
    axis.set(xlabel=label, ylabel="modulus of the zeros")
    axis.locator_params(axis="x", nbins=5)
    axis.grid(alpha=0.25)
