"""A loop transfer function and its margins: Nyquist's curve, Bode's plot, the disk."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from compensator_theory.results import DelayedStabilityMargins, EnclosedStabilityMargins
from compensator_theory.stability._margins import StabilityMargins
from rcac_numeric.analysis._classical import Margins
from rcac_numeric.analysis._disk import DiskMargin
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import (
    CIRCLE,
    INK,
    NARROW,
    REACHED,
    REQUESTED,
    SECOND,
    axes_of,
    checked_width,
    figure_of,
    tidy,
)

POINTS = 3000
FAR = 50.0  # abs(L) beyond which a Nyquist curve has left the picture
VIEWS = {"nyquist": 1, "bode": 2, "disk": 1, "all": 3}


@dataclass(frozen=True, eq=False)
class LoopCurve:
    r"""The loop transfer function L, closed by :math:`1 + L = 0`, and its margins in float64.

    Attributes
    ----------
    response : function
        From frequencies to L.
    lowest, highest : float
        The frequencies that are drawn.
    unit : str
        Of frequency.
    gain_crossovers, phase_crossovers : tuple of float
    gains : tuple of (frequency, factor)
        The gain margins.
    phase : (frequency, degrees) or None
        The phase margin, a lag where it is positive.
    disk : float or None
        alpha of the disk margin.
    """

    response: Callable[[Any], Any]
    lowest: float
    highest: float
    unit: str
    gain_crossovers: tuple[float, ...]
    phase_crossovers: tuple[float, ...]
    gains: tuple[tuple[float, float], ...]
    phase: tuple[float, float] | None
    disk: float | None


ExactMargins = StabilityMargins | DelayedStabilityMargins | EnclosedStabilityMargins


def plot_stability_margins(margins: ExactMargins, view: str = "all", **options: Any) -> Figure:
    """Draw a loop with its exact margins, as `StabilityMargins.plot` says."""
    return plot_loop(exact_curve(margins), view, **options)


def plot_margins(margins: Margins, view: str = "all", **options: Any) -> Figure:
    """The picture that `Margins.plot` describes."""
    return plot_loop(loop_curve(margins), view, **options)


def plot_disk_margin(
    margin: DiskMargin, *, ax: Axes | Sequence[Axes] | None = None, width: float = 5.0
) -> Figure:
    """The picture that `DiskMargin.plot` describes."""
    if not np.isfinite(margin.alpha):
        raise InputError("no factor makes the loop unstable: the disk margin is infinite.")
    if ax is not None:
        (axis,) = axes_of(ax, 1)
        draw_disk_region(axis, margin.alpha)
        return figure_of(axis)
    width = checked_width(width)
    figure = Figure(figsize=(width, 0.85 * width), layout="constrained")
    draw_disk_region(figure.subplots(), margin.alpha)
    tidy(figure)
    return figure


def plot_loop(
    curve: LoopCurve, view: str, *, ax: Axes | Sequence[Axes] | None = None, width: float = 11.0
) -> Figure:
    """Draw one view of a loop, or Nyquist's curve beside Bode's plot."""
    if view not in VIEWS:
        raise InputError(f"view = {view!r} is none of {', '.join(VIEWS)}.")
    if ax is not None:
        axes = axes_of(ax, VIEWS[view])
        _draw(axes, view, curve)
        return figure_of(axes[0])
    width = checked_width(width)
    narrow = width < NARROW
    if view == "all":
        figure = Figure(figsize=(width, 1.75 * width if narrow else 5.0), layout="constrained")
        grid = figure.add_gridspec(4 if narrow else 2, 1 if narrow else 2)
        first = figure.add_subplot(grid[:2, 0])
        rest = [grid[2, 0], grid[3, 0]] if narrow else [grid[0, 1], grid[1, 1]]
        upper = figure.add_subplot(rest[0])
        axes = [first, upper, figure.add_subplot(rest[1], sharex=upper)]
    else:
        width = min(width, 7.0)
        figure = Figure(figsize=(width, 0.85 * width if narrow else 5.0), layout="constrained")
        axes = list(np.ravel(figure.subplots(VIEWS[view], 1, sharex=True)))
    _draw(axes, view, curve)
    tidy(figure)
    return figure


def _draw(axes: list[Axes], view: str, curve: LoopCurve) -> None:
    if view in ("nyquist", "all"):
        draw_nyquist(axes[0], curve)
    if view in ("bode", "all"):
        draw_bode(axes[-2], axes[-1], curve)
    if view == "disk":
        draw_disk(axes[0], curve)


def draw_nyquist(axis: Axes, curve: LoopCurve) -> None:
    """Draw Nyquist's curve around -1, its crossovers, and the disk that it does not enter."""
    omega = _frequencies(curve)
    with np.errstate(all="ignore"):
        L = curve.response(omega)
    L = np.where(np.abs(L) < FAR, L, np.nan)
    span = 2.2  # half the width of what is shown, less where the margin would be a dot
    axis.plot(L.real, L.imag, color=REACHED, linewidth=1.4, label="$L$, positive frequencies")
    axis.plot(L.real, -L.imag, color=REACHED, linewidth=0.8, alpha=0.5)
    axis.plot(CIRCLE.real, CIRCLE.imag, color=INK, linewidth=0.5, linestyle=":")
    axis.plot([-1], [0], "+", color=REQUESTED, ms=12, mew=2, label="$-1$")
    if curve.disk is not None and curve.disk < 2:
        low = (2 - curve.disk) / (2 + curve.disk)
        ends = np.array([-1 / low, -low])  # where the factors of the disk put -1/f
        span = float(np.clip(3 * np.ptp(ends), 0.05, span))
        disk = ends.mean() + np.ptp(ends) / 2 * CIRCLE
        axis.fill(disk.real, disk.imag, color=REQUESTED, alpha=0.12, linewidth=0,
                  label=f"disk margin {curve.disk:.3g}")  # fmt: skip
    crossing = curve.response(np.array(curve.gain_crossovers))
    axis.plot(crossing.real, crossing.imag, "o", mfc="none", mec=REQUESTED, ms=7,
              label="gain crossovers")  # fmt: skip
    real = curve.response(np.array(curve.phase_crossovers)).real
    axis.plot(real, np.zeros_like(real), "s", mfc="none", mec=SECOND, ms=7,
              label="phase crossovers")  # fmt: skip
    middle = -0.6 if span > 1.5 else -1.0
    axis.set(
        xlim=(middle - span, middle + span), ylim=(-span, span), xlabel="real", ylabel="imaginary"
    )
    axis.set_aspect("equal")
    axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, frameon=False)
    axis.set_title("loop transfer function, closed by $1 + L = 0$", fontsize=10)


def draw_bode(gain: Axes, phase: Axes, curve: LoopCurve) -> None:
    """Draw gain and phase of L, with a line for each margin from the curve to where it ends."""
    omega = _frequencies(curve)
    with np.errstate(all="ignore"):
        L = curve.response(omega)
        size = np.abs(L)
    finite = np.isfinite(L) & (size > 0)
    degrees = np.degrees(np.unwrap(np.angle(L[finite])))
    if len(degrees) and degrees[0] > 179:
        degrees = degrees - 360  # a plant of two integrators begins at -180
    gain.loglog(omega[finite], size[finite], color=REACHED, linewidth=1.3)
    phase.semilogx(omega[finite], degrees, color=REACHED, linewidth=1.3)
    gain.axhline(1, color=INK, linewidth=0.7)
    _show_half_turns(phase, degrees)
    for w in curve.gain_crossovers:
        gain.plot(w, 1, "o", mfc="none", mec=REQUESTED, ms=6)
    words = []
    for w, factor in curve.gains:
        gain.plot([w, w], [1 / factor, 1], color=SECOND, linewidth=2)
        gain.plot(w, 1 / factor, "s", mfc="none", mec=SECOND, ms=6)
        words.append(f"{factor:.3g} at {w:.3g}")
    margin = "gain margins " if len(words) > 1 else "gain margin "
    gain.set_title(margin + " and ".join(words) if words else "no gain margin", fontsize=10)
    if curve.phase is None:
        phase.set_title("no gain crossover", fontsize=10)
    else:
        w, turn = curve.phase
        at = np.interp(np.log(w), np.log(omega[finite]), degrees)
        phase.plot([w, w], [at - turn, at], color=REQUESTED, linewidth=2)
        phase.plot(w, at, "o", mfc="none", mec=REQUESTED, ms=6)
        phase.set_title(f"phase margin {turn:.3g} degrees at {w:.3g}", fontsize=10)
    gain.set(ylabel="gain of $L$")
    phase.set(ylabel="phase, degrees", xlabel=rf"frequency $\omega$, {curve.unit}")
    if not gain.get_shared_x_axes().joined(gain, phase):
        phase.set_xlim(gain.get_xlim())
    else:
        gain.tick_params(labelbottom=False)


def _show_half_turns(phase: Axes, degrees: Any) -> None:
    """Draw lines at odd multiples of 180 degrees, and ticks at multiples of 90 degrees."""
    low, high = (degrees.min(), degrees.max()) if len(degrees) else (-180.0, 0.0)
    step = 45 if high - low < 300 else 90 * (1 + int((high - low) / 720))
    bottom, top = np.floor(low / step - 0.1) * step, np.ceil(high / step + 0.1) * step
    if bottom > -180 > low - 90:
        bottom = -180 - step / 4
    phase.set_ylim(bottom, top)
    phase.set_yticks(np.arange(np.ceil(bottom / step) * step, top + 1, step))
    for k in range(int((bottom - 180) // 360) - 1, int((top + 180) // 360) + 1):
        if bottom <= 360 * k + 180 <= top:
            phase.axhline(360 * k + 180, color=INK, linewidth=0.7)


def draw_disk(axis: Axes, curve: LoopCurve) -> None:
    """Draw the gains and turns that together leave the loop stable, by its disk margin."""
    if curve.disk is None:
        raise InputError("there is no disk margin: the loop is unstable, or none was requested.")
    draw_disk_region(axis, curve.disk)
    for _, factor in curve.gains:
        axis.plot(factor, 0, "s", mfc="none", mec=SECOND, ms=7, label="gain margins")
    if curve.phase is not None:
        axis.plot(
            1, abs(curve.phase[1]), "o", mfc="none", mec=REQUESTED, ms=7, label="phase margin"
        )
    axis.set_ylim(0, 1.08 * max(axis.get_ylim()[1], abs(curve.phase[1]) if curve.phase else 0))
    handles = dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))
    axis.legend(handles.values(), handles, fontsize=8, loc="best", frameon=False)


def draw_disk_region(axis: Axes, alpha: float) -> None:
    r"""Draw the factors :math:`(1 + d/2)/(1 - d/2)`, abs(d) < alpha, by gain and turn."""
    d = min(alpha, 1.98) * CIRCLE[: len(CIRCLE) // 2 + 1]
    factor = (1 + d / 2) / (1 - d / 2)
    gain, turn = np.abs(factor), np.degrees(np.angle(factor))
    axis.fill_between(gain, 0, turn, color=REACHED, alpha=0.2, linewidth=0,
                      label=f"stable, by disk margin {alpha:.3g}")  # fmt: skip
    axis.plot(gain, turn, color=REACHED, linewidth=1.2)
    axis.plot(1, 0, "+", color=INK, ms=9)
    axis.set_xscale("log")
    low = float(gain.min())
    axis.set_xlim(low * 0.8, 1.25 / low)
    places = [
        p for p in (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50) if low * 0.8 <= p <= 1.25 / low
    ]
    axis.set_xticks(places, [f"{p:g}" for p in places])
    axis.minorticks_off()
    axis.set_ylim(bottom=0)
    axis.set(xlabel="factor of the gain", ylabel="turn of the phase, degrees")
    axis.set_title("gain and phase that may change together", fontsize=10)


def _frequencies(curve: LoopCurve) -> Any:
    """Frequencies evenly spaced by ratio and, near the highest, by difference; crossovers too."""
    low, high = curve.lowest, curve.highest
    parts = [np.geomspace(low, high, POINTS), np.linspace(low, high, POINTS)]
    inside = [w for w in (*curve.gain_crossovers, *curve.phase_crossovers) if low <= w <= high]
    return np.unique(np.concatenate([*parts, np.array(inside, dtype=float)]))


def exact_curve(margins: ExactMargins) -> LoopCurve:
    """The curve of exact margins, rounded once."""
    numbers = margins.exponentials if isinstance(margins, EnclosedStabilityMargins) else ()
    N, D = (
        [float(c.subs(numbers)) for c in p.all_coeffs()]
        for p in (margins.numerator, margins.denominator)
    )
    discrete = margins.time == "discrete"
    late = float(margins.dead_time) if isinstance(margins, DelayedStabilityMargins) else 0.0

    def response(omega: Any) -> Any:
        points = np.exp(1j * omega) if discrete else 1j * omega
        with np.errstate(all="ignore"):
            return np.polyval(N, points) / np.polyval(D, points) * np.exp(-1j * late * omega)

    gains = [(float(c.frequency), c) for c in margins.gain_crossovers]
    turns = [(float(c.frequency), c) for c in margins.phase_crossovers if c.frequency is not None]
    ends: list[tuple[float, float]] = []
    if isinstance(margins, DelayedStabilityMargins | EnclosedStabilityMargins):
        nearest = [margins.gain_down, margins.gain_up] if margins.is_stable else []
        ends = [
            (float(margin.frequency), float(margin.value))
            for margin in nearest
            if margin is not None and margin.frequency is not None
        ]
    elif margins.gains is not None:
        for end in (float(margins.gains.lower), float(margins.gains.upper)):
            near = [
                (w, end)
                for w, c in turns
                if np.isclose(float(c.gain_enclosure), end, rtol=1e-12, atol=0)
            ]
            ends += near[:1]
    least = min(((w, c.degrees) for w, c in gains), key=lambda pair: abs(pair[1]), default=None)
    features = np.abs(np.concatenate([np.roots(N), np.roots(D), [w for w, _ in gains + turns]]))
    features = features[(features > 1e-12) & np.isfinite(features)]
    if discrete:
        low, high = min([1e-2, *(w / 10 for w, _ in gains + turns if w)]), np.pi
    else:
        low, high = (features.min() / 10, features.max() * 10) if len(features) else (0.01, 100.0)
    return LoopCurve(
        response, float(low), float(high), "rad/sample" if discrete else "rad/s",
        tuple(w for w, _ in gains), tuple(w for w, _ in turns if w), tuple(e for e in ends if e[0]),
        least if margins.is_stable else None, None,
    )  # fmt: skip


def loop_curve(margins: Margins) -> LoopCurve:
    """The curve of a loop and its margins."""
    crossovers = (*margins.gain_crossovers, *margins.phase_crossovers)
    low = min([1e-2, *(float(w) / 10 for w in crossovers if w > 0)])
    ends = [b for b in (margins.gain_down, margins.gain_up) if b is not None]
    phase = margins.phase
    turn = None
    if phase is not None and np.isfinite(phase.value):
        turn = float(phase.frequency), phase.value * (1 if phase is margins.phase_lag else -1)
    return LoopCurve(
        response=margins.loop.response,
        lowest=low,
        highest=np.pi,
        unit="rad/sample",
        gain_crossovers=tuple(map(float, margins.gain_crossovers)),
        phase_crossovers=tuple(map(float, margins.phase_crossovers)),
        gains=tuple(
            (float(b.frequency), float(b.value))
            for b in ends
            if 0 < b.value < np.inf and 0 < b.frequency < np.inf
        ),
        phase=turn,
        disk=None if margins.disk is None else margins.disk.alpha,
    )
