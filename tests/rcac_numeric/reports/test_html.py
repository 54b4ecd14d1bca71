"""Sheets and pictures as HTML: the order of what is said, themes, labels that stay words."""

import re

from matplotlib.figure import Figure

from rcac_numeric.reports._rendering import sheet_html
from rcac_numeric.reports._sheet import Fact, Section, Sheet, SheetTable, Text, cells
from rcac_numeric.reports._svg import COLOURS, svg_of
from tests.support.pages import Page


def test_a_legend_of_a_figure_has_no_face_of_its_own():
    """A white box behind it would stand out on a dark page."""
    figure = Figure(figsize=(3, 2))
    figure.subplots().plot([0, 1], label="x")
    figure.legend()
    assert "fill: #ffffff" not in svg_of(figure, "a", "A title").replace("opacity: 0", "")
    assert figure.legends[0].get_frame().get_alpha() == 0


def test_a_sheet_keeps_the_order_of_its_blocks():
    blocks = (
        Text("one"),
        Fact("two", "2"),
        SheetTable(("three",), (cells("3"),)),
        Text("four", "bad"),
    )
    result = Page(
        sheet_html(Sheet("", sections=(Section("Title", blocks, remark=": r"),), notes="n"))
    )
    assert result.text == "Title: r one two 2 three 3 four n"


def test_a_picture_follows_the_theme_and_keeps_its_labels():
    figure = Figure(figsize=(3, 2))
    axis = figure.subplots()
    axis.plot([0, 1, 2], [0.0, 0.05, 0.1], color="#0b62a3", label="x")
    axis.legend()
    one, other = (svg_of(figure, prefix, "A title") for prefix in "ab")
    assert "var(--c1)" in one and not [colour for colour in COLOURS if colour in one]
    assert "0.02" in Page(one).text, "labels are words, and no coordinates to be rounded"
    assert not set(Page(one).ids) & set(Page(other).ids)
    assert one == svg_of(figure, "a", "A title")
    longest = max(len(n.split(".")[1]) for n in re.findall(r"\d+\.\d+", "".join(_paths(one))))
    assert longest == 1


def _paths(svg):
    return [attributes["d"] for attributes in Page(svg).all("path")]
