"""Equilibria of nonlinear plants."""

from __future__ import annotations

import attrs

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import array_like, number, reads, real_array, with_checks
from rcac_numeric.arrays._values import Result


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class OperatingPoint(Result):
    """A state and an input at which f(x, u) = 0.

    Parameters
    ----------
    x, u : arrays, shapes (n,) and (l_u,)
        In the units of the plant.

    Examples
    --------
    >>> from rcac_numeric.gallery import BoostConverter
    >>> BoostConverter().operating_point(duty=0.5).x
    array([ 4.8, 24. ])
    """

    x: Array = attrs.field(converter=array_like, metadata=reads(real_array))
    u: Array = attrs.field(converter=array_like, metadata=reads(real_array))


def require_positive(**parameters: float) -> None:
    """Raise unless a physical parameter is positive and finite."""
    for name, value in parameters.items():
        if not 0 < number(value, name) < float("inf"):
            raise InputError(f"{name} = {value:g}; it must be positive.")
