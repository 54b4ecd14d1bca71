"""The figure of an LQG controller: poles of the loop and response of the controller."""

from __future__ import annotations

import numpy as np

from rcac_numeric.analysis._lqg import LQG
from rcac_numeric.plots._library import Figure
from rcac_numeric.plots._pole_maps import PoleGroup, draw_plane
from rcac_numeric.plots._style import (
    LEAST_FACTOR,
    LEAST_PHASE,
    centre_at_least,
    line_style,
    widen,
)

BEYOND = 1e4  # times the median gain: what is above is a pole on the unit circle


def plot_lqg(design: LQG) -> Figure:
    """Plot the poles of regulator and estimator, and gain and phase of the controller."""
    figure = Figure(figsize=(10, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[1, 1.25])
    poles, gain = figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1])
    phase = figure.add_subplot(grid[1, 1], sharex=gain)
    groups = []
    for i, (name, marker, part) in enumerate(
        (("regulator", "x", design.regulator), ("estimator", "+", design.estimator))
    ):
        words = f"{name}, radius {np.abs(part.poles).max(initial=0.0):.3g}"
        groups.append(PoleGroup(words, "pole", part.poles, marker, line_style(i)["color"], 9))
    draw_plane(poles, groups, reach=1.15)
    poles.set_title("closed-loop poles", fontsize=10)
    poles.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2,
                 frameon=False)  # fmt: skip
    A, B, C, D = design.state_space
    omega = np.linspace(1e-3, np.pi, 1500)
    pencils = np.exp(1j * omega)[:, None, None] * np.eye(len(A)) - A
    with np.errstate(all="ignore"):
        response = C @ np.linalg.solve(pencils, np.broadcast_to(B, (len(omega), *B.shape))) + D
        for index, (i, j) in enumerate(np.ndindex(response.shape[1:])):
            entry, style = response[:, i, j], line_style(index)
            label = f"$y_{j + 1}$ to $u_{i + 1}$" if response[0].size > 1 else None
            gain.semilogy(omega, np.abs(entry), linewidth=1.3, label=label, **style)
            phase.plot(omega, np.degrees(np.unwrap(np.angle(entry))), linewidth=1.3, **style)
    usual = np.median(np.abs(response[np.isfinite(response)])) if response.size else 0.0
    if usual and gain.get_ylim()[1] > BEYOND * usual:  # a pole on the circle takes all the axis
        gain.set_ylim(top=BEYOND * usual)
    widen(gain, LEAST_FACTOR)
    centre_at_least(phase, np.degrees(LEAST_PHASE))
    if response[0].size > 1:
        gain.legend(fontsize=8)
    gain.set_ylabel("gain of $G_c$")
    gain.set_title(f"controller, $J$ = {design.cost.value:.6g}", fontsize=10)
    phase.set(ylabel="phase, degrees", xlabel=r"frequency $\omega$, rad/sample")
    for axis in figure.axes:
        axis.grid(alpha=0.25)
    return figure
