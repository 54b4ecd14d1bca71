"""Checks of single settings of a controller."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import integer, number
from rcac_numeric.controllers.structure import Structure
from rcac_numeric.targets.model import TargetModel


def require_target(model: Any, structure: Structure, first: TargetModel) -> None:
    """Raise where `model` does not fit the structure, or the first of several models."""
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


def require_covariance(update: str) -> None:
    """Raise where `update` keeps no covariance from step to step."""
    if update not in ("ud", "covariance"):
        raise InputError(f'update = "{update}" has no covariance that could be reset.')


def forgetting_factor(value: Any) -> float:
    """`value` as a number in (0, 1]."""
    factor = number(value, "lambda")
    if not 0 < factor <= 1:
        raise InputError(f"lambda = {factor} is not in (0, 1].")
    return factor


def changes_by_step(changes: Any, name: str) -> dict[int, Any]:
    """A mapping from steps to values, sorted by step."""
    if changes is None:
        return {}
    if not isinstance(changes, Mapping):
        raise InputError(f"{name} = {changes!r} must map steps to values, such as {{1000: ...}}.")
    read = {integer(k, f"a step of {name}", at_least=1): v for k, v in changes.items()}
    return dict(sorted(read.items()))


def interval(pair: Any) -> tuple[int, int | None]:
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
