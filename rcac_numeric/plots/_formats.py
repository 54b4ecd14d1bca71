"""File formats of figures."""

from __future__ import annotations

import io
from pathlib import Path

from compensator_theory import figures
from compensator_theory.errors import InputError
from compensator_theory.libraries import require_library
from rcac_numeric.arrays._files import replacing

FORMATS = (".pdf", ".png", ".svg")


def require_picture_format(picture: Path) -> None:
    """Raise an error for an unsupported file before a long run."""
    require_library("matplotlib")
    if picture.suffix.lower() not in FORMATS:
        raise InputError(f"--plot {picture}: the name must end in one of {', '.join(FORMATS)}.")
    if not picture.parent.is_dir():
        raise InputError(f"--plot {picture}: there is no folder {picture.parent}.")


def save(figure: figures.Figure, picture: Path) -> None:
    """Save a figure; the old file stays until the new one is complete."""
    drawn = io.BytesIO()  # matplotlib's writers do not say in their own words that a disk is full
    figure.savefig(drawn, format=picture.suffix[1:].lower(), dpi=130)
    with replacing(picture) as new:
        new.write_bytes(drawn.getbuffer())
