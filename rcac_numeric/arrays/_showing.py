"""Text and notebook views of a result.

A method `plot` or `_sheet` imports what shows the result when it is asked, so that a result loads
neither Matplotlib nor templates: with the functions below the only imports that go upwards.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from compensator_theory import figures
from compensator_theory._wording import in_a_line


def report_of(sheet: Any) -> str:
    """Return the report as text."""
    from rcac_numeric.reports._terminal import as_text

    return as_text(sheet)


def summary_of(sheet: Any) -> str:
    """Return the title and the verdict of a report, one sentence a line."""
    lines = (sheet.title + sheet.remark, *(text.words for text in sheet.health))
    return "\n".join(in_a_line(" ".join(line.split())) for line in lines)


def notebook_of(sheet: Any, draw: Callable[[], figures.Figure] | None = None) -> str:
    """Return the notebook view: the report and, if there is one, the figure."""
    from rcac_numeric.reports._displays import notebook_html

    return notebook_html(sheet, draw)
