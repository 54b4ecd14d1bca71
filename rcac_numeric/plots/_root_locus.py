"""The figure of a root locus: branches by python-control, exact points marked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from compensator_theory.stability._root_locus import RootLocus
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import (
    INK,
    NARROW,
    QUIET,
    REQUESTED,
    SECOND,
    axes_of,
    checked_width,
    draw_circle,
    figure_of,
    tidy,
)

ROOM = 1.25  # of what is shown to what is marked
NEAR = np.geomspace(1e-8, 1, 150)  # shares of a gain


def plot_root_locus(
    locus: RootLocus, *, ax: Axes | Sequence[Axes] | None = None, width: float = 6.0
) -> Figure:
    """Draw the branches for positive gains, as `RootLocus.plot` says."""
    if ax is not None:
        (axis,) = axes_of(ax, 1)
        _draw(axis, locus)
        return figure_of(axis)
    width = checked_width(width)
    figure = Figure(figsize=(width, 1.2 * width if width < NARROW else 5.4), layout="constrained")
    _draw(figure.subplots(), locus)
    tidy(figure)
    return figure


def _draw(axis: Axes, locus: RootLocus) -> None:
    N, D = ([float(c) for c in p.all_coeffs()] for p in (locus.numerator, locus.denominator))
    discrete = locus.time == "discrete"
    breaks = [(point, _gain(point)) for point in locus.breaks if _gain(point) > 0]
    crossings = [(c, float(c.gain_enclosure)) for c in locus.crossings or ()]
    crossings = [(c, k) for c, k in crossings if k > 0 and c.frequency is not None]
    import control  # it needs Matplotlib when it is imported

    loop = control.tf(N, D, True if discrete else 0)
    sampled = control.root_locus_map(loop).gains
    marked = [k for _, k in breaks + crossings]
    finest = max([*marked, float(sampled[-1]) if np.isfinite(sampled[-1]) else 1.0])
    smooth = np.geomspace(1e-4 * finest, 1e2 * finest, 800)  # python-control's ends where it fills
    near = np.concatenate([-NEAR, NEAR])  # a root leaves a break like the square root of the gain
    around = [k * (1 + near) for _, k in breaks]
    gains = np.concatenate([[0.0], sampled[np.isfinite(sampled)], marked, smooth, *around])
    gains = np.unique(gains[gains >= 0])
    branches = control.root_locus_map(loop, gains).loci
    for i, branch in enumerate(branches.T):
        axis.plot(branch.real, branch.imag, linewidth=1.4, label="_", color=f"C{i % 10}")
    poles, zeros = np.roots(D), np.roots(N)
    places = np.array([complex(p.value) for p, _ in breaks] + _places(crossings, discrete))
    shown = np.concatenate([poles, zeros, places, [0.0]])
    _limit(axis, shown, discrete)
    if discrete:
        draw_circle(axis)
    else:
        axis.axvline(0, color=INK, linewidth=0.7)
    _draw_asymptotes(axis, locus)
    axis.plot(poles.real, poles.imag, "x", color=INK, ms=8, mew=1.6, label="poles")
    if len(zeros):
        axis.plot(zeros.real, zeros.imag, "o", mfc="none", mec=INK, ms=7, label="zeros")
    if locus.hidden.degree() > 0:
        hidden = np.roots([float(c) for c in locus.hidden.all_coeffs()])
        axis.plot(hidden.real, hidden.imag, "*", color=QUIET, ms=8, label="hidden")
    for i, (point, gain) in enumerate(breaks):
        _mark(axis, complex(point.value), gain, "D", SECOND, "branches meet" if i == 0 else "_")
    for i, (crossing, gain) in enumerate(crossings):
        place = _places([(crossing, gain)], discrete)[0]
        label = "boundary of stability" if i == 0 else "_"
        _mark(axis, place, gain, "s", REQUESTED, label)
    axis.set(xlabel="real", ylabel="imaginary")
    axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2, frameon=False)


def _mark(axis: Axes, place: complex, gain: float, marker: str, colour: str, label: str) -> None:
    """Mark a point and its conjugate, with the gain at the upper one."""
    places = np.array([place, place.conjugate()] if place.imag else [place])
    axis.plot(places.real, places.imag, marker, mfc="none", mec=colour, ms=7, mew=1.5, label=label,
              linestyle="none")  # fmt: skip
    left, right = axis.get_xlim()
    beside = -1 if place.real > left + 0.7 * (right - left) else 1  # towards the middle
    axis.annotate(f"k = {gain:.4g}", (place.real, abs(place.imag)), (6 * beside, 6), fontsize=8,
                  ha="left" if beside > 0 else "right", textcoords="offset points",
                  color=INK)  # fmt: skip


def _draw_asymptotes(axis: Axes, locus: RootLocus) -> None:
    if locus.centroid is None or len(locus.asymptotes) == 1:  # the real axis itself
        return
    centre = float(locus.centroid)
    across = float(np.ptp(axis.get_xlim()) + np.ptp(axis.get_ylim()))
    for i, angle in enumerate(locus.asymptotes):
        end = centre + across * np.exp(1j * float(angle))
        axis.plot([centre, end.real], [0, end.imag], color=QUIET, linewidth=0.9, linestyle="--",
                  label="asymptotes" if i == 0 else "_")  # fmt: skip


def _limit(axis: Axes, shown: Any, discrete: bool) -> None:
    """Limit the axes to the marked points, with equal scales."""
    if discrete:
        shown = np.concatenate([shown, [1 + 1j, -1 - 1j]])
    middle = (shown.real.max() + shown.real.min()) / 2
    half = ROOM * max(np.ptp(shown.real) / 2, np.abs(shown.imag).max(), 1e-9)
    axis.set(xlim=(middle - half, middle + half), ylim=(-half, half))
    axis.set_aspect("equal")


def _places(crossings: Any, discrete: bool) -> list[complex]:
    frequencies = [float(c.frequency) for c, _ in crossings]
    return [complex(np.exp(1j * w)) if discrete else 1j * w for w in frequencies]


def _gain(point: Any) -> float:
    """The gain of a breakaway point, rounded; evaluating a CRootOf sets mpmath's precision."""
    exact = point.gain
    return float(exact.eval_rational(n=20) if hasattr(exact, "eval_rational") else exact)
