"""Elements of several figures: colours, a signal over time, a frequency response."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.analysis._match import IntercalatedMatch
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._wording import in_a_line, shortened
from rcac_numeric.plots._library import Axes, Figure, SymmetricalLogLocator

INK, REACHED, REQUESTED, SECOND = "#222222", "#0b62a3", "#d1495b", "#2a9d8f"
QUIET = "#7f7f7f"
NARROW = 6.0  # inches: below, panels stand one above the other and letters are smaller
NARROWEST = 3.0
CIRCLE = np.exp(1j * np.linspace(0, 2 * np.pi, 400))
# Okabe and Ito's colours, distinct for every kind of colour vision, and lines for black and white.
PALETTE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))
# An axis spans at least this factor in gain and these radians: rounding is to look like rounding.
LEAST_FACTOR, LEAST_PHASE = 2.0, 0.5
VANISHING = 1e-3  # of the median size of both responses together: below, a phase says nothing
DEEPEST = 1e-4  # of the peak: below, an axis of decades is linear
TICK_ROOM = 13.0  # points from the middle of a label of an axis to that of the next
DECADES = 1e3  # a peak so many times the median is drawn over decades


def line_style(index: int) -> dict[str, Any]:
    """Colour and dashes of the index-th of several lines in one pair of axes."""
    return {"color": PALETTE[index % len(PALETTE)], "linestyle": DASHES[index % len(DASHES)]}


def label_words(name: str) -> str:
    r"""Make a label of a user's name: one line, no control characters, no mathematics."""
    return in_a_line(name).replace("$", r"\$")


def draw_circle(axis: Axes) -> None:
    """Draw the unit circle."""
    axis.plot(CIRCLE.real, CIRCLE.imag, color=INK, linewidth=0.7)


def draw_title(figure: Figure, title: str) -> None:
    """Draw a user's title literally, dollars and backslashes too."""
    words = shortened(in_a_line(title), 120)
    figure.suptitle(words, fontsize=12, fontweight="bold", parse_math=False)


def draw_history(axis: Axes, values: Array, label: str, symbol: str) -> None:
    """Draw a signal over the step k, one line for each component."""
    for i, column in enumerate(values.T):
        axis.step(np.arange(len(column)), column, where="post", linewidth=1.1,
                  label=f"${symbol}_{i + 1}$", **line_style(i))  # fmt: skip
    if values.shape[1] > 1:
        axis.legend(fontsize=8)
    axis.set_ylabel(label)
    draw_over_decades(axis, [values])


class SpacedDecades(SymmetricalLogLocator):
    """Ticks at zero and at decades on both sides, without overlapping labels.

    It is asked when the picture is drawn, so that it fits whatever size the picture then has.
    """

    def __init__(self, axes: Axes, threshold: float) -> None:
        super().__init__(base=10, linthresh=threshold)
        self.set_params(numticks=7)
        self._axes = axes

    def __call__(self) -> list[float]:
        """The ticks: 0, then decades from the largest inwards while there is room."""
        ticks = [float(tick) for tick in super().__call__()]
        places = np.column_stack([np.zeros(len(ticks)), ticks])
        heights = self._axes.transData.transform(places)[:, 1]
        room = TICK_ROOM * self._axes.figure.dpi / 72
        shown_ticks: list[int] = []
        for i in sorted(range(len(ticks)), key=lambda i: (ticks[i] != 0, -abs(ticks[i]))):
            if all(abs(heights[i] - heights[j]) >= room for j in shown_ticks):
                shown_ticks.append(i)
        return sorted(ticks[i] for i in shown_ticks)


def draw_over_decades(axis: Axes, parts: Sequence[Array]) -> None:
    """Use a symmetric logarithmic axis if the peak is a thousand times the usual size."""
    sizes = np.abs(np.concatenate([part.ravel() for part in parts]))
    sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
    if not len(sizes):
        return
    peak, usual = float(sizes.max()), float(np.median(sizes))
    if peak < DECADES * usual:
        return
    threshold = max(usual, peak * DEEPEST)
    axis.set_yscale("symlog", linthresh=threshold, linscale=2)
    axis.yaxis.set_major_locator(SpacedDecades(axis, threshold))


def draw_magnitude(axis: Axes, match: IntercalatedMatch) -> None:
    """Draw the gain of G_f and of the intercalated transfer function."""
    for i, j in np.ndindex(match.target.shape[1:]):
        axis.semilogy(match.omega, np.abs(match.target[:, i, j]), color=REQUESTED, linewidth=3.5,
                      alpha=0.45, label="$G_f$" if i == j == 0 else None)  # fmt: skip
        axis.semilogy(match.omega, np.abs(match.reached[:, i, j]), color=REACHED, linewidth=1.2,
                      label=r"$\tilde G_{z\tilde u}$" if i == j == 0 else None)  # fmt: skip
    widen(axis, LEAST_FACTOR)
    axis.set_ylabel("magnitude")
    axis.set_title(
        f"intercalated match: worst {match.worst:.2g}, median {match.median:.2g}", fontsize=10
    )
    axis.legend(fontsize=9)


def draw_phase(axis: Axes, match: IntercalatedMatch) -> None:
    """Draw their phases in radians, on one branch."""
    for i, j in np.ndindex(match.target.shape[1:]):
        requested, reached = phases(match.target[:, i, j], match.reached[:, i, j])
        axis.plot(match.omega, requested, color=REQUESTED, linewidth=3.5, alpha=0.45)
        jumps = np.abs(np.diff(reached, prepend=reached[:1])) > np.pi  # to the next branch
        axis.plot(match.omega, np.where(jumps, np.nan, reached), color=REACHED, linewidth=1.2)
    centre_at_least(axis, LEAST_PHASE)
    axis.set(xlabel=r"frequency $\omega$, rad/sample", ylabel="phase, rad")


def phases(requested: ComplexArray, reached: ComplexArray) -> tuple[Array, Array]:
    """Two phases over frequency, in radians, on one branch.

    A phase is known up to whole turns: the first one begins in (-pi, pi], the second one where
    their difference does. Where one of them almost vanishes rounding decides which way round the
    phase goes; the second one then stays on the branch next to the first, so that equal responses
    lie on each other.
    """
    with np.errstate(all="ignore"):
        first = np.unwrap(np.angle(requested))
        ratio = reached * np.conj(requested)
        difference, size = np.angle(ratio), np.abs(ratio)
        large = size > VANISHING * np.median(size)
    turns = np.round(np.diff(difference) / (2 * np.pi)) * (large[1:] & large[:-1])
    second = first + difference - 2 * np.pi * np.concatenate([[0.0], np.cumsum(turns)])
    return np.asarray(first), np.asarray(second)


def centre_at_least(axis: Axes, span: float) -> None:
    """Give an axis a least range, so that rounding is not magnified."""
    low, high = axis.get_ylim()
    if high - low < span:
        axis.set_ylim((low + high - span) / 2, (low + high + span) / 2)


def widen(axis: Axes, factor: float) -> None:
    """Give a logarithmic axis a least ratio of its ends."""
    low, high = axis.get_ylim()
    if 0 < low < high < factor * low:
        middle = (low * high) ** 0.5
        axis.set_ylim(middle / factor**0.5, middle * factor**0.5)


def axes_of(ax: Axes | Sequence[Axes], count: int) -> list[Axes]:
    """Return the user's axes; raise an error unless their number fits."""
    axes = list(np.ravel(np.array(ax, dtype=object)))
    if len(axes) != count:
        raise InputError(f"ax has {len(axes)} axes; {count} are drawn, one for each.")
    return axes


def figure_of(axis: Axes) -> Figure:
    """Return the figure of axes, which may be in a subfigure."""
    part = axis.figure
    assert part is not None
    whole: Figure = part.figure  # of the root, itself
    return whole


def checked_width(width: float) -> float:
    """Return the width of a figure in inches."""
    try:
        inches = float(width)
    except (TypeError, ValueError):
        raise InputError(f"width = {width!r} is no number of inches.") from None
    if not (np.isfinite(inches) and inches >= NARROWEST):
        raise InputError(f"width = {width} inches is too narrow; {NARROWEST} are needed.")
    return inches


def tidy(figure: Figure) -> None:
    """Draw faint grids and, where the figure is narrow, smaller letters."""
    for axis in figure.axes:
        axis.grid(alpha=0.25)
        axis.spines[["top", "right"]].set_visible(False)
        if figure.get_figwidth() < NARROW:
            axis.tick_params(labelsize=8)
            axis.xaxis.label.set_fontsize(8)
            axis.yaxis.label.set_fontsize(8)
            axis.title.set_fontsize(8)
