"""How an exact result draws itself without importing what draws it."""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any

from compensator_theory import figures
from compensator_theory.errors import InputError

# A picture is made of floats, and none is made in this half. What draws enters itself in this group
# of entry points.
GROUP = "compensator_theory.pictures"


def picture_of(result: object, **options: Any) -> figures.Figure:
    """Return the picture of a result."""
    for one in entry_points(group=GROUP):
        drawn: figures.Figure = one.load()(result, **options)
        return drawn
    raise InputError(
        "nothing that is installed draws exact results: pip install compensator-theory[plot]."
    )
