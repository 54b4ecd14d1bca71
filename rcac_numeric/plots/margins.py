"""Pictures of margins: the Nyquist curve near -1, and gain and phase over frequency."""

from __future__ import annotations

import numpy as np

from rcac_numeric.margins.classical import Margins
from rcac_numeric.plots.library import Axes, Figure
from rcac_numeric.plots.style import INK, REACHED, SECOND, WANTED


def plot_margins(margins: Margins) -> Figure:
    """The Nyquist curve of L near -1 beside its gain and phase, with the margins marked.

    Examples
    --------
    >>> import control
    >>> from rcac_numeric import stability_margins
    >>> L = control.tf([0.3], [1.0, -1.0], True)
    >>> len(stability_margins(L, feedback=-1).plot().axes)
    3
    """
    figure = Figure(figsize=(11, 5), layout="constrained")
    grid = figure.add_gridspec(2, 2)
    draw_nyquist(figure.add_subplot(grid[:, 0]), margins)
    gain, phase = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    omega = np.linspace(1e-4, np.pi, 2000)
    with np.errstate(all="ignore"):
        L = margins.loop.response(omega)
        gain.semilogy(omega, np.abs(L), color=REACHED, linewidth=1.3)
        phase.plot(omega, np.degrees(np.unwrap(np.angle(L))), color=REACHED, linewidth=1.3)
    gain.axhline(1, color=INK, linewidth=0.7)
    for axis, found, colour in (
        (gain, margins.gain_crossovers, WANTED), (phase, margins.phase_crossovers, SECOND),
    ):  # fmt: skip
        for w in found:
            axis.axvline(w, color=colour, linewidth=0.9, linestyle="--")
        axis.grid(alpha=0.25)
    gain.set(ylabel="gain of $L$")
    gain.set_title("gain crossovers", fontsize=10, color=WANTED)
    phase.set(ylabel="phase, degrees", xlabel=r"frequency $\omega$, rad/sample")
    phase.set_title("phase crossovers", fontsize=10, color=SECOND)
    return figure


def draw_nyquist(axis: Axes, margins: Margins) -> None:
    """The curve L(e^{j omega}) around -1 and the disk that it leaves free."""
    omega = np.concatenate([np.geomspace(1e-5, 1e-2, 500), np.linspace(1e-2, np.pi, 4000)])
    with np.errstate(all="ignore"):
        L = margins.loop.response(omega)
    span = 2.2  # half the width of what is shown, less where the margin would be a dot
    L = np.where(np.abs(L) < 50, L, np.nan)
    axis.plot(L.real, L.imag, color=REACHED, linewidth=1.4, label="$L$, positive frequencies")
    axis.plot(L.real, -L.imag, color=REACHED, linewidth=0.8, alpha=0.5)
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 400))
    axis.plot(circle.real, circle.imag, color=INK, linewidth=0.5, linestyle=":")
    axis.plot([-1], [0], "+", color=WANTED, ms=12, mew=2, label="$-1$")
    if margins.disk is not None and margins.disk.alpha < 2:
        low, high = margins.disk.gain
        ends = np.array([-1 / low, -1 / high])  # where the factors of the disk put -1/f
        span = float(np.clip(3 * np.ptp(ends), 0.05, span))
        disk = ends.mean() + np.ptp(ends) / 2 * circle
        axis.fill(disk.real, disk.imag, color=WANTED, alpha=0.12, linewidth=0,
                  label=f"disk margin {margins.disk.alpha:.3g}")  # fmt: skip
    crossing = margins.loop.response(margins.gain_crossovers)
    axis.plot(crossing.real, crossing.imag, "o", mfc="none", mec=WANTED, ms=7,
              label="gain crossovers")  # fmt: skip
    real = margins.loop.response(margins.phase_crossovers).real
    axis.plot(real, np.zeros_like(real), "s", mfc="none", mec=SECOND, ms=7,
              label="phase crossovers")  # fmt: skip
    middle = -0.6 if span > 1.5 else -1.0
    axis.set(
        xlim=(middle - span, middle + span), ylim=(-span, span), xlabel="real", ylabel="imaginary"
    )
    axis.set_aspect("equal")
    axis.grid(alpha=0.25)
    axis.legend(fontsize=8, loc="upper right")
    axis.set_title("loop transfer function, closed by $1 + L = 0$", fontsize=10)
