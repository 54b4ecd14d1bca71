"""Optional libraries (pandas, xarray, python-control), imported on first use."""

from __future__ import annotations

import importlib
from typing import Any

from compensator_theory.libraries import needed
from rcac_numeric.arrays._array_types import Array

# Without the libraries a type checker cannot resolve these types.
DataFrame = Any  # of pandas
Dataset = Any  # of xarray
StateSpace = Any  # of python-control


def imported(name: str, extra: str = "") -> Any:
    """Import an optional library, or raise InputError with the extra that installs it."""
    with needed(name.partition(".")[0], extra):
        return importlib.import_module(name)


def control_state_space(
    A: Array, B: Array, C: Array, D: Array, sample_time: float | None
) -> StateSpace:
    """Return a discrete python-control state space; dt = True without a sample time."""
    from control import ss  # imported here: it takes one second

    return ss(A, B, C, D, True if sample_time is None else sample_time)
