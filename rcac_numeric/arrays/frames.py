"""The tables of other libraries, loaded when they are asked for; none of them is needed."""

from __future__ import annotations

import importlib
from typing import Any

from compensator_theory.libraries import needed

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
    with needed(name.partition(".")[0]):
        return importlib.import_module(name)
