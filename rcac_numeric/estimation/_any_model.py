"""The protocol of the models of estimators."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, runtime_checkable

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import integer, items


@runtime_checkable
class AnyModel(Protocol):
    """x(k+1) = f(k, x(k), u(k)) + noise and y(k) = h(k, x(k), u(k)) + noise.

    Unknown parameters are the last entries of x, where they stay what they are but for noise.
    """

    @property
    def n(self) -> int:
        """Number of entries of x, parameters included."""

    @property
    def l_u(self) -> int:
        """Number of known inputs."""

    @property
    def l_y(self) -> int:
        """Number of measurements."""

    @property
    def names(self) -> tuple[str, ...]:
        """The entries of x in words."""


def places_of_angles(value: Iterable[int], l_y: int) -> tuple[int, ...]:
    """The indices of the measurements that are angles in radians."""
    places = tuple(integer(place, "angles") for place in items(value, "angles"))
    for place in places:
        if not 0 <= place < l_y:
            raise InputError(f"angles names measurement {place}; there are {l_y}, counted from 0.")
    return tuple(sorted(set(places)))


def any_model(value: object) -> AnyModel:
    """Return `value` if it is a model, else raise an error."""
    if isinstance(value, type) or not isinstance(value, AnyModel):
        raise InputError(
            f"model = {value!r} is no model: use LinearModel, SymbolicModel or NonlinearModel."
        )
    return value
