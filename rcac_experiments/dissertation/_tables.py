"""The tables of a numbered example, for evidence about its file."""

from __future__ import annotations

import tomllib
from importlib import resources
from typing import Any


def example_table(number: str) -> dict[str, Any]:
    """The tables of an example's file, nothing of it built.

    Examples
    --------
    >>> from rcac_experiments.dissertation._tables import example_table
    >>> example_table("4.7")["id"]
    '4.7'
    """
    folder = resources.files("rcac_experiments.dissertation").joinpath("example_files")
    return tomllib.loads(folder.joinpath(f"{number}.toml").read_text("utf-8"))
