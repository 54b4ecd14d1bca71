"""How an exact result draws itself without importing what draws it."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from compensator_theory import figures

# A picture is made of floats, and none is made in this half. An exact result asks the table of the
# other half, by name, when its first picture is asked for.
TABLE = "rcac_numeric.reports.page.displays"


def picture_of(result: object, **options: Any) -> figures.Figure:
    """Return the picture of a result.

    Examples
    --------
    >>> from compensator_theory import root_locus
    >>> from compensator_theory.showing import picture_of
    >>> len(picture_of(root_locus("1/(s*(s + 1))", feedback=-1)).axes)
    1
    """
    drawn: figures.Figure = import_module(TABLE).picture_of(result, **options)
    return drawn
