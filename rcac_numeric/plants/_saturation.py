"""Control magnitude and rate saturation, figure 2.13."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    items,
    number,
    optional_array_like,
    reads,
    real_array,
    with_checks,
)
from rcac_numeric.arrays._values import Value


def _bound(value: ArrayLike, name: str) -> Array:
    return real_array(value, name).reshape(-1)


BOUND = reads(_bound, optional=True)


@attrs.frozen(eq=False, kw_only=True, slots=False, field_transformer=with_checks)
class Saturation(Value):
    """Bounds on the control input and on its change in one step.

    u_a(k) is u(k) moved to within `rate` of u_a(k-1), then into [low, high]; u_a(-1) = 0. The
    plant receives u_a, and so do the regressor and the target-model filter of the controller.

    Parameters
    ----------
    low, high : float or array, shape (l_u,), optional
        Magnitude bounds.
    rate : float or array, shape (l_u,), optional
        Largest change in one step.

    Raises
    ------
    InputError
        Where no bound is given, sizes differ, low exceeds high, or a rate is not positive.

    Examples
    --------
    >>> from rcac_numeric import Saturation
    >>> Saturation(low=-0.2, high=0.2).bounds(l_u=1)
    (array([-0.2]), array([0.2]), array([inf]))
    """

    low: Array | None = attrs.field(default=None, converter=optional_array_like, metadata=BOUND)
    high: Array | None = attrs.field(default=None, converter=optional_array_like, metadata=BOUND)
    rate: Array | None = attrs.field(default=None, converter=optional_array_like, metadata=BOUND)

    def __attrs_post_init__(self) -> None:
        bounds = [b for b in (self.low, self.high, self.rate) if b is not None]
        if not bounds:
            raise InputError("a saturation needs low, high or rate.")
        widths = {b.size for b in bounds} - {1}
        if len(widths) > 1:
            raise InputError(f"low, high and rate have different sizes: {sorted(widths)}.")
        if self.low is not None and self.high is not None and np.any(self.low > self.high):
            raise InputError(f"low = {self.low} exceeds high = {self.high}.")
        if self.rate is not None and np.any(self.rate <= 0):
            raise InputError(f"rate = {self.rate} must be positive.")

    def bounds(self, l_u: int) -> tuple[Array, Array, Array]:
        """(low, high, rate) for every input, infinite where there is no bound."""
        return (
            _sized(self.low, "low", -np.inf, l_u),
            _sized(self.high, "high", np.inf, l_u),
            _sized(self.rate, "rate", np.inf, l_u),
        )


def _sized(value: Array | None, name: str, default: float, l_u: int) -> Array:
    if value is None:
        return np.full(l_u, default)
    if value.size not in (1, l_u):
        raise InputError(f"{name} has {value.size} entries; l_u = {l_u}.")
    return np.broadcast_to(value, l_u).copy()


def limits_of(u_limits: Any) -> Saturation | None:
    """Read the limits of u from (low, high) or a Saturation."""
    if u_limits is None or isinstance(u_limits, Saturation):
        return u_limits
    limits = items(u_limits, "u_limits")
    if len(limits) != 2:
        raise InputError(f"u_limits = {u_limits!r}: give (low, high), or a Saturation with rates.")
    low, high = (
        None if limit in (-math.inf, math.inf) else number(limit, f"{side} of u")
        for limit, side in zip(limits, ("low", "high"), strict=True)
    )
    return Saturation(low=low, high=high)
