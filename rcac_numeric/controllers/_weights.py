"""Weights of the retrospective cost (2.41): constant, following the signals, or a function."""

from __future__ import annotations

from collections.abc import Callable

import attrs
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import number, reads, with_checks


def _not_negative(value: object, name: str) -> float:
    read = number(value, name)
    if read < 0:
        raise InputError(f"{name} = {read} must not be negative.")
    return read


@attrs.frozen(slots=False, field_transformer=with_checks)
class SignalWeight:
    """A weight that follows z, evaluated in the kernel.

    ``R(k) = (constant + z_squared z(k)'z(k)) / (1 + nu |z(k)|)^2 I``

    The text uses R_u = e_0(k)^2 so that a large error slows the adaptation down (section 2.3.4).
    As R_z, nu makes the row of a step weigh less the larger z is: the normalisation to prefer.

    Parameters
    ----------
    z_squared, constant : float
        Not negative; one of them positive.
    nu : float
        Not negative; 1/nu is the size of z (Euclidean, where there are several) at which the
        weight is a quarter.

    Raises
    ------
    InputError
        Where a number is negative, or there is nothing that nu could scale.

    Examples
    --------
    >>> from rcac_numeric import SignalWeight
    >>> SignalWeight(z_squared=0.1)
    SignalWeight(z_squared=0.1, constant=0.0, nu=0.0)
    >>> SignalWeight(constant=1, nu=0.3)
    SignalWeight(z_squared=0.0, constant=1.0, nu=0.3)
    """

    z_squared: float = attrs.field(default=0.0, metadata=reads(_not_negative))
    constant: float = attrs.field(default=0.0, metadata=reads(_not_negative))
    nu: float = attrs.field(default=0.0, metadata=reads(_not_negative))

    def __attrs_post_init__(self) -> None:
        if self.nu and not (self.z_squared or self.constant):
            raise InputError(f"nu = {self.nu:g} scales a weight of zero; give constant.")


# R(k, y, z, u), a number or a matrix.
WeightFunction = Callable[[int, Array, Array, Array], ArrayLike]
Weight = Array | SignalWeight | WeightFunction


def weight(
    value: ArrayLike | SignalWeight | WeightFunction, name: str, l_z: int, *, definite: bool
) -> Weight:
    """Converter: return a weight of (2.41)."""
    if isinstance(value, SignalWeight):
        if definite and value.constant == 0:
            raise InputError(
                f"{name} = z_squared z'z is not positive definite at z = 0; give constant."
            )
        return value
    if callable(value):
        return value
    return constant_weight(value, name, l_z, definite=definite)
