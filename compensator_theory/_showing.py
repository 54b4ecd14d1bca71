"""Pictures of exact results, without an import of the plotting package."""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any

from compensator_theory import figures
from compensator_theory.errors import InputError

# This package has no floats and draws nothing; a plotting package registers in this group of entry
# points.
GROUP = "compensator_theory.pictures"


def picture_of(result: object, **options: Any) -> figures.Figure:
    """Return the picture of a result."""
    for one in entry_points(group=GROUP):
        try:
            draw = one.load()
        except ModuleNotFoundError as error:
            if (error.name or "").partition(".")[0] != one.name:
                raise
            raise InputError(
                "pictures need the numeric half, rcac_numeric; this installation has the exact "
                "half alone"
            ) from None
        drawn: figures.Figure = draw(result, **options)
        return drawn
    raise InputError(
        "no installed package draws exact results: pip install compensator-theory[plot]."
    )
