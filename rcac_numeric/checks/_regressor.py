"""The regressor of logged signals for a controller structure."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.controllers._regressor import regressor_of
from rcac_numeric.controllers._structure import Structure


def regressor(structure: Structure, log: ControllerLog) -> Array:
    """phi(k) of (2.29), from the logged signals and zero before; shape (steps, taps)."""
    return regressor_of(structure, {"u": log.u, "y": log.y, "r": log.r}, np.asarray)


def require_fit(log: ControllerLog, structure: Structure) -> None:
    """Raise an error if widths or coefficients of a log do not fit the structure."""
    words = f"this {structure.name} structure with n_c = {structure.n_c}"
    for name, width in (("u", structure.l_u), ("y", structure.l_y), ("r", structure.l_r)):
        signal = getattr(log, name)
        if width and signal is None:
            raise InputError(f"{log.source}: {words} reads {name}, which the log does not hold.")
        if width and signal.shape[1] != width:
            raise InputError(
                f"{log.source}: {name} has {signal.shape[1]} components; {words} has l_{name} = "
                f"{width}."
            )
    assert log.theta is not None
    size = log.theta.shape[-1]
    if size != structure.l_theta:
        hint = "Check n_c, k_c and the kind of structure."
        if size == log.steps and structure.l_theta == 1:
            hint = f"One coefficient over time has the shape ({log.steps}, 1)."
        raise InputError(
            f"{log.source}: theta has {size} coefficients; {words}, l_u = {structure.l_u}, l_y = "
            f"{structure.l_y} has {structure.l_theta}. {hint}"
        )
