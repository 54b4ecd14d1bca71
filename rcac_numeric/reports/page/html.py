"""A report as HTML: the same words as on a terminal."""

from __future__ import annotations

from html import escape
from itertools import groupby
from typing import Any

from rcac_numeric.arrays.wording import printable
from rcac_numeric.reports.page.rendering import rendered
from rcac_numeric.reports.sheets.sheet import Section, Sheet


def sheet_html(sheet: Sheet, level: int = 3) -> str:
    """The body of a report: its health, its sections and its notes, without the title.

    Parameters
    ----------
    sheet : Sheet
    level : int
        Of the headings of its sections.
    """
    sections = [
        {"title": section.title, "remark": section.remark, "groups": _groups(section)}
        for section in sheet.sections
    ]
    notes = sheet.notes.split("\n\n") if sheet.notes else []
    told: dict[str, Any] = {
        "health": sheet.health,
        "sections": sections,
        "notes": notes,
        "level": level,
    }
    return str(rendered("sheet.html", **told)).rstrip("\n")


def words(text: str) -> str:
    """Words of others as text of a page: no markup, no control characters."""
    return escape(printable(text))


def _groups(section: Section) -> list[tuple[str, list[object]]]:
    """Its blocks by their kind: facts that follow each other are one list."""
    grouped = groupby(section.blocks, lambda block: type(block).__name__)
    return [(kind, list(blocks)) for kind, blocks in grouped]
