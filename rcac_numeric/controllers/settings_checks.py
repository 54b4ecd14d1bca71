"""What the settings of a controller must be, one by one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight
from rcac_numeric.arrays.validation import integer
from rcac_numeric.controllers.bounds import CoefficientBounds
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.controllers.updates.joint import JointUD
from rcac_numeric.controllers.updates.update import Update
from rcac_numeric.controllers.weights import SignalWeight
from rcac_numeric.targets.model import TargetModel

# R(k, y, z, u), a number or a matrix.
WeightFunction = Callable[[int, Array, Array, Array], ArrayLike]
Weight = Array | SignalWeight | WeightFunction


def weight(
    value: ArrayLike | SignalWeight | WeightFunction, name: str, l_z: int, *, definite: bool
) -> Weight:
    """A weight of (2.41) as it is kept."""
    if isinstance(value, SignalWeight):
        if definite and value.constant == 0:
            raise InputError(
                f"{name} = z_squared z'z is not positive definite at z = 0; give constant."
            )
        return value
    if callable(value):
        return value
    return constant_weight(value, name, l_z, definite=definite)


def require_target(model: object, structure: Structure, first: TargetModel) -> None:
    """Raise where a target model does not fit the structure, or the first of several."""
    if not isinstance(model, TargetModel):
        raise InputError(
            f"target = {model!r}: use fir_target, pole_placement_target or target_model."
        )
    if model.l_u != structure.l_u:
        raise InputError(
            f"the target model has {model.l_u} columns and the structure {structure.l_u} "
            "control inputs; G_f must be l_z x l_u."
        )
    if model.l_z != first.l_z:
        raise InputError(f"the target models have {first.l_z} and {model.l_z} rows.")


def require_reflectable(structure: Structure) -> None:
    """Raise where the poles of a structure do not determine its coefficients of u."""
    if structure.l_u != 1:
        raise InputError(
            f"reflect_poles needs l_u = 1; this structure has l_u = {structure.l_u}, "
            "where reflecting the roots of det D_c does not determine the coefficients."
        )
    lags = sorted(tap.delay for tap in structure.taps if tap.signal == "u")
    if not lags or lags != list(range(1, len(lags) + 1)):
        raise InputError(
            "reflect_poles needs the taps u(k-1), ..., u(k-n) without gaps; this "
            f"{structure.name} structure has the lags {lags} of u."
        )


def interval(pair: tuple[int, int | None]) -> tuple[int, int | None]:
    """A pair (start, stop) of steps; stop may be None."""
    try:
        start, stop = pair
    except (TypeError, ValueError):
        raise InputError(
            f"freeze has the entry {pair!r}; pairs (start, stop) are needed."
        ) from None
    first = integer(start, "start of freeze")
    if stop is not None and integer(stop, "stop of freeze") <= first:
        raise InputError(f"freeze has the empty interval ({start}, {stop}).")
    return first, stop


def require_bounds(
    bounds: CoefficientBounds, structure: Structure, update: Update, theta_0: Array, reflects: bool
) -> None:
    """Raise where bounds do not fit the structure, the update, theta(0) or pole reflection."""
    low, high = bounds.box(structure)
    outside = np.flatnonzero((theta_0 < low) | (theta_0 > high))
    if len(outside):
        i = int(outside[0])
        raise InputError(
            f"theta_0[{i}] = {theta_0[i]:g} is outside its bounds {low[i]:g} and {high[i]:g}; "
            "start inside them."
        )
    if reflects:
        raise InputError(
            "reflect_poles moves the coefficients of u to where bounds may not let them be; use "
            "one of the two."
        )
    if isinstance(update, JointUD) and bounds.method == "metric":
        raise InputError(
            "JointUD fits D_f with theta, and the metric of P would move both; use bounds with "
            'method = "clip".'
        )


def require_fixed(fixed: Compensator, structure: Structure) -> None:
    """Raise where a compensator in parallel does not have the controller's inputs and outputs."""
    widths, wanted = (fixed.l_u, fixed.l_y), (structure.l_u, structure.l_y + structure.l_r)
    if widths != wanted:
        raise InputError(
            f"fixed has {widths[1]} inputs and {widths[0]} outputs; beside this structure it reads "
            f"[y; r] with {wanted[1]} components and adds to u with {wanted[0]}."
        )
