"""Tables and systems of other libraries, loaded when they are asked for; none is needed."""

from __future__ import annotations

import importlib
from typing import Any

from compensator_theory.libraries import needed
from rcac_numeric.arrays._array_types import Array

# Their types: a checker that has not got the libraries has not got these.
DataFrame = Any  # of pandas
Dataset = Any  # of xarray
StateSpace = Any  # of python-control


def imported(name: str) -> Any:
    """A library that a result can be handed to."""
    with needed(name.partition(".")[0]):
        return importlib.import_module(name)


def control_state_space(
    A: Array, B: Array, C: Array, D: Array, sample_time: float | None
) -> StateSpace:
    """A discrete state space of python-control; without a sample time its dt is True."""
    from control import ss  # a second of import time, paid only here

    return ss(A, B, C, D, True if sample_time is None else sample_time)
