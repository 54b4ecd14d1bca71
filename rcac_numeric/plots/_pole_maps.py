"""Pole-zero maps; distant points are arrows at the rim, with their values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from textwrap import fill
from typing import NamedTuple

import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.arrays._array_types import ComplexArray
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.plots._library import Axes, Figure
from rcac_numeric.plots._style import INK, REACHED, REQUESTED, SECOND, draw_circle

REACH = 1.3  # half the width of a map: what lies further out would make the unit circle a dot
ROOM = 1.4  # where words stand at the rim
DIGITS = 6  # to which points count as one
SAME_DIRECTION = 0.15  # radians within which far points share an arrow
NAMED = 3  # values at one arrow


class PoleGroup(NamedTuple):
    """One group of points: its legend, its label at the rim, its style."""

    label: str
    word: str
    values: ComplexArray
    marker: str
    colour: str
    size: float


def draw_plane(axis: Axes, groups: Sequence[PoleGroup], reach: float = REACH) -> None:
    r"""Draw points near the unit circle, and arrows at the rim for distant ones."""
    far = _far(groups, reach)
    draw_circle(axis)
    for group in groups:
        values = group.values[np.abs(group.values) <= reach]
        axis.plot(
            values.real, values.imag, group.marker, label=group.label, linestyle="none",
            mfc="none", mec=group.colour, ms=group.size, mew=1.5,
        )  # fmt: skip
    span = max(reach, ROOM) if far else reach
    axis.set(xlim=(-span, span), ylim=(-span, span), xlabel="real", ylabel="imaginary")
    axis.set_aspect("equal")
    axis.grid(alpha=0.25)
    for direction, words, colour in far:
        _draw_arrow(axis, direction, words, colour, span)


def complex_word(value: complex) -> str:
    """A complex number in three digits."""
    return f"{value.real:.3g}" if value.imag == 0 else f"{value:.3g}"


def largest_counts(channels: Iterable[ComplexArray]) -> ComplexArray:
    """Merge the points of several maps, each with its largest multiplicity."""
    most: Counter[complex] = Counter()
    for values in channels:
        most |= Counter(np.round(values.astype(np.complex128), DIGITS).tolist())
    return np.array(list(most.elements()), dtype=np.complex128)


def _far(groups: Sequence[PoleGroup], reach: float) -> list[tuple[float, list[str], str]]:
    """Direction, label and colour of each arrow; points in one direction share it."""
    points = []
    for group in groups:
        beyond = group.values[np.abs(group.values) > reach]
        values, counts = np.unique(np.round(beyond, DIGITS), return_counts=True)
        points += [
            (float(np.angle(v)) % (2 * np.pi), float(np.abs(v)), complex(v), int(count), group)
            for v, count in zip(values, counts, strict=True)
        ]
    distant: list[tuple[float, list[str], str]] = []
    for angle, _, value, count, group in sorted(points, key=lambda point: point[:2]):
        word = f"{group.word}\n{complex_word(value)}" + (f" x{count}" if count > 1 else "")
        if distant and angle - distant[-1][0] < SAME_DIRECTION:
            distant[-1][1].append(word)
        else:
            distant.append((angle, [word], group.colour))
    return distant


def _draw_arrow(axis: Axes, angle: float, words: list[str], colour: str, reach: float) -> None:
    towards = np.array([np.cos(angle), np.sin(angle)])
    rim = towards * reach / np.abs(towards).max()
    axis.annotate("", rim, 0.88 * rim,
                  arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.2})  # fmt: skip
    shown = words if len(words) <= NAMED else [*words[:NAMED], "..."]
    x, y = towards
    if abs(x) >= abs(y):  # at the sides narrow words, between the rim and the circle
        text, at, offset = "\n".join(shown), (np.sign(x) * reach, rim[1]), (-3 * np.sign(x), 5)
        places = "right" if x > 0 else "left", "bottom"
    else:
        text, at = ", ".join(shown).replace("\n", " "), (rim[0], 0.94 * rim[1])
        offset = (-6 * np.sign(x) if x else 6, 0)  # towards the middle, where there is room
        places = "right" if x > 0 else "left", "center"
    note = axis.annotate(text, at, offset, textcoords="offset points", fontsize=7, color=INK,
                         ha=places[0], va=places[1], linespacing=1.0)  # fmt: skip
    note.set_in_layout(False)  # long words over a narrow map would leave it no room


NARROWEST = 2.2  # inches of a map in which its words have room
LETTERS = 11  # of a title, for each inch


def draw_pole_maps(figure: Figure, runs: Mapping[str, LoopAnalysis]) -> None:
    """Draw a map for each run, with target poles of scalar loops."""
    width = figure.get_figwidth()
    columns = min(int(width // NARROWEST), len(runs))
    rows = -(-len(runs) // columns)
    figure.set_figheight(min(width / columns, 4.4) * rows + 0.5)
    axes = np.ravel(figure.subplots(rows, columns, squeeze=False))
    for axis, (name, analysed) in zip(axes, runs.items(), strict=False):
        _draw(axis, analysed)
        if len(runs) > 1:
            letters = int(LETTERS * min(width / columns, 4.4))
            axis.set_title(fill(shortened(name, 60), letters), fontsize=9)
    for axis in axes[len(runs) :]:
        axis.set_visible(False)
    handles, labels = axes[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, fontsize=8, loc="outside lower center", ncols=3)


def _draw(axis: Axes, analysed: LoopAnalysis) -> None:
    groups: dict[str, ComplexArray] = {}
    try:
        if not analysed.obstacle:
            comparison = analysed.comparison
            groups["requested"] = comparison.requested_poles
            groups["zeros"] = largest_counts(comparison.zeros.values())
            groups["poles"] = comparison.poles
        else:
            groups["poles"] = analysed.loop.poles()
    except CompensatorError as error:
        axis.annotate(shortened(str(error), 70), (0.5, 0.5), xycoords="axes fraction",
                      ha="center", fontsize=7, wrap=True)  # fmt: skip
    nothing = np.zeros(0, dtype=np.complex128)
    drawn = [
        PoleGroup(name, word, values[np.isfinite(values)], marker, colour, size)
        for name, word, marker, colour, size in (
            ("requested", "requested", "s", REQUESTED, 10.0),
            ("zeros", "zero", "o", SECOND, 7.0),
            ("poles", "pole", "x", REACHED, 7.0),
        )
        for values in [groups.get(name, nothing)]
    ]
    draw_plane(axis, drawn)
