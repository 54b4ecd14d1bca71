"""The figure of mode estimates."""

from __future__ import annotations

import numpy as np

from rcac_numeric.estimation._estimates import ModeEstimates
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._style import line_style


def plot_modes(estimates: ModeEstimates) -> Figure:
    """Plot each entry of x with +- two standard deviations, and the probabilities below."""
    n = estimates.x.shape[1]
    figure = Figure(figsize=(9, 2 + 1.6 * n), layout="constrained")
    axes = figure.subplots(n + 1, 1, sharex=True)
    k = np.arange(len(estimates.x))
    for i, (axis, name) in enumerate(zip(axes, estimates.settings.model.names, strict=False)):
        low, high = (estimates.x[:, i] + sign * 2 * estimates.deviation[:, i] for sign in (-1, 1))
        style = line_style(0)
        axis.fill_between(k, low, high, step="post", color=style["color"], alpha=0.2, linewidth=0)
        axis.step(k, estimates.x[:, i], where="post", linewidth=1.1, **style)
        axis.set_ylabel(name)
    for j, probability in enumerate(estimates.probabilities.T):
        axes[-1].step(
            k, probability, where="post", linewidth=1.1, label=f"mode {j}", **line_style(j)
        )
    axes[-1].set(ylabel="probability", xlabel="step $k$", ylim=(-0.05, 1.05))
    axes[-1].legend(fontsize=8)
    for axis in axes:
        axis.grid(alpha=0.25)
    return figure
