"""The tables of other libraries, loaded when they are asked for; none of them is needed."""

from __future__ import annotations

import importlib
from typing import Any

from compensator_theory.errors import InputError

# Their types: a checker that has not got the libraries has not got these.
DataFrame = Any  # of pandas
Dataset = Any  # of xarray


def imported(name: str) -> Any:
    """A library that a result can be handed to.

    Raises
    ------
    InputError
        Where it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        raise InputError(
            f"{name} is not installed: `pip install compensator-theory[pandas]` brings it. A CSV "
            "file needs nothing more."
        ) from None
