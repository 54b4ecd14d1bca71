"""What several pictures are made of: the colours, a signal over time, a frequency response."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rcac_numeric.analysis.match import IntercalatedMatch

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, REACHED, WANTED, SECOND = "#222222", "#0b62a3", "#d1495b", "#2a9d8f"


def draw_history(axis: Axes, values: np.ndarray, label: str, symbol: str) -> None:
    """A signal over the step k, one line for each component."""
    for i, column in enumerate(values.T):
        axis.step(np.arange(len(column)), column, where="post", linewidth=1.1,
                  label=f"${symbol}_{i + 1}$")  # fmt: skip
    if values.shape[1] > 1:
        axis.legend(fontsize=8)
    axis.set_ylabel(label)


def draw_magnitude(axis: Axes, match: IntercalatedMatch) -> None:
    """The gain of G_f and of the intercalated transfer function."""
    for i, j in np.ndindex(match.wanted.shape[1:]):
        axis.semilogy(match.omega, np.abs(match.wanted[:, i, j]), color=WANTED, linewidth=3.5,
                      alpha=0.45, label="$G_f$" if i == j == 0 else None)  # fmt: skip
        axis.semilogy(match.omega, np.abs(match.reached[:, i, j]), color=REACHED, linewidth=1.2,
                      label=r"$\tilde G_{z\tilde u}$" if i == j == 0 else None)  # fmt: skip
    axis.set_ylabel("magnitude")
    axis.set_title(
        f"intercalated match: worst {match.worst:.2g}, median {match.median:.2g}", fontsize=10
    )
    axis.legend(fontsize=9)


def draw_phase(axis: Axes, match: IntercalatedMatch) -> None:
    """Their phase, in radians."""
    for i, j in np.ndindex(match.wanted.shape[1:]):
        for values, color, width, alpha in (
            (match.wanted[:, i, j], WANTED, 3.5, 0.45),
            (match.reached[:, i, j], REACHED, 1.2, 1.0),
        ):
            axis.plot(match.omega, np.unwrap(np.angle(values)), color=color, linewidth=width,
                      alpha=alpha)  # fmt: skip
    axis.set(xlabel=r"frequency $\omega$, rad/sample", ylabel="phase, rad")
