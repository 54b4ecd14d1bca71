"""What the name of a picture's file must be like."""

from __future__ import annotations

from pathlib import Path

from compensator_theory.errors import InputError

FORMATS = (".pdf", ".png", ".svg")


def require_picture_format(picture: Path) -> None:
    """Refuse a file that could not be drawn into, before anything long is run."""
    if picture.suffix.lower() not in FORMATS:
        raise InputError(f"--plot {picture}: the name must end in one of {', '.join(FORMATS)}.")
    if not picture.parent.is_dir():
        raise InputError(f"--plot {picture}: there is no folder {picture.parent}.")
