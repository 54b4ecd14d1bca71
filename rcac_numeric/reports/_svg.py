"""Figures as small SVG inside a page, in the page's colours."""

from __future__ import annotations

import html
import io
import re
import threading

from compensator_theory import figures
from rcac_numeric.arrays._wording import in_a_line

# What our pictures are drawn in, and the page's own colours.
COLOURS = {
    "#000000": "var(--ink)", "#222222": "var(--ink)", "#0b62a3": "var(--c1)",
    "#d1495b": "var(--c2)", "#2a9d8f": "var(--c3)", "#1f77b4": "var(--c1)",
    "#ff7f0e": "var(--c4)", "#2ca02c": "var(--c3)", "#d62728": "var(--c2)",
    "#9467bd": "var(--c5)", "#8c564b": "var(--c6)", "#e377c2": "var(--c7)",
    "#7f7f7f": "var(--quiet)", "#bcbd22": "var(--c8)", "#17becf": "var(--c9)",
    "#0072b2": "var(--c1)", "#d55e00": "var(--c2)", "#009e73": "var(--c3)",
    "#cc79a7": "var(--c7)", "#56b4e9": "var(--c9)", "#e69f00": "var(--c4)",
    "#b0b0b0": "var(--line)", "#cccccc": "var(--line)",
}  # fmt: skip
STYLE = {
    "svg.fonttype": "none",  # words stay words: found by a search, in the reader's own font
    "svg.hashsalt": "rcac",  # the same picture has the same text every time
    "path.simplify_threshold": 0.5,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "legend.facecolor": "none",
    "legend.edgecolor": "none",
    "savefig.facecolor": "none",
    "font.size": 9,
}
_DRAWING = threading.Lock()  # Matplotlib's settings are those of the process: one page at a time
_NUMBER = re.compile(r"-?\d+\.\d{2,}")
# Where rounding cannot be seen; the words of a label are no coordinates.
_COORDINATES = re.compile(r'\b(?:d|x|y)="[^"]*"|\btranslate\([^)]*\)')
_ID = re.compile(r'\bid="([^"]+)"')
_REFERENCE = re.compile(r'(?:url\(#|xlink:href="#|href="#)([^")]+)')


def svg_of(figure: figures.Figure, prefix: str, title: str) -> str:
    """The SVG of a figure for a page."""
    import matplotlib as mpl  # a third of a second, for those who draw

    drawn = io.StringIO()
    with _DRAWING, mpl.rc_context(STYLE):
        figure.patch.set_alpha(0)
        for axis in figure.axes:
            axis.patch.set_alpha(0)
        for legend in [*(axis.get_legend() for axis in figure.axes), *figure.legends]:
            if legend is not None:
                legend.get_frame().set_alpha(0)
        figure.savefig(drawn, format="svg", metadata={"Date": None, "Creator": None})
    return _named(_small(_with_unique_ids(_in_colours(drawn.getvalue()), prefix)), prefix, title)


def _in_colours(text: str) -> str:
    """Replace colours by the variables of the page."""
    for colour, variable in COLOURS.items():
        text = text.replace(colour, variable)
    return text


def _with_unique_ids(text: str, prefix: str) -> str:
    """Prefix the used ids and remove the others: two figures must not share an id."""
    used = set(_REFERENCE.findall(text))
    text = _ID.sub(lambda m: f'id="{prefix}-{m[1]}"' if m[1] in used else "", text)
    return _REFERENCE.sub(lambda m: m[0].removesuffix(m[1]) + f"{prefix}-{m[1]}", text)


def _small(text: str) -> str:
    """Shorten the SVG: tenths of a point, no metadata, no style."""
    text = re.sub(
        r"<\?xml.*?\?>|<!DOCTYPE.*?>|<metadata>.*?</metadata>|<style.*?</style>",
        "",
        text,
        flags=re.S,
    )
    text = _COORDINATES.sub(lambda part: _NUMBER.sub(_rounded, part[0]), text)
    return re.sub(r"\s*\n\s*", "\n", text).strip()


def _rounded(number: re.Match[str]) -> str:
    return f"{float(number[0]):.1f}".removesuffix(".0")


def _named(text: str, prefix: str, title: str) -> str:
    box = re.search(r'viewBox="([^"]+)"', text)
    inside = re.sub(r"^.*?<svg[^>]*>|</svg>\s*$", "", text, flags=re.S)
    size = f' viewBox="{box[1]}"' if box else ""
    return (
        f'<svg id="{prefix}" role="img" aria-labelledby="{prefix}-title"{size} '
        'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">'
        f'<title id="{prefix}-title">{html.escape(in_a_line(title))}</title>{inside}</svg>'
    )
