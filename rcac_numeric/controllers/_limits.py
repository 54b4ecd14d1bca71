"""Limits that a controller applies to its own u."""

from __future__ import annotations

import attrs
import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import optional_array_like, with_checks
from rcac_numeric.arrays._values import Value
from rcac_numeric.plants._saturation import BOUND


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class ControlLimits(Value):
    """Bounds of u and of its change in one step, up and down, kept in the compiled step.

    u(k) is moved into [u(k-1) - fall, u(k-1) + rise], then into [low, high]; the limited u, not
    the requested one, enters the regressor and the target-model filter. For
    `Controller`; a plant with an actuator of its own is simulated with `Saturation`.

    Parameters
    ----------
    low, high : float or array, shape (l_u,), optional
        Bounds of u.
    rise, fall : float or array, shape (l_u,), optional
        Largest change up and down in one step; positive.

    Raises
    ------
    InputError
        Where none is given, low exceeds high, or a rate is not positive.

    Examples
    --------
    >>> from rcac_numeric import ControlLimits
    >>> ControlLimits(low=0.0, high=1.0, rise=0.1).bounds(1)  # a valve that shuts at once
    (array([0.]), array([1.]), array([0.1]), array([inf]))
    """

    low: Array | None = attrs.field(default=None, converter=optional_array_like, metadata=BOUND)
    high: Array | None = attrs.field(default=None, converter=optional_array_like, metadata=BOUND)
    rise: Array | None = attrs.field(default=None, converter=optional_array_like, metadata=BOUND)
    fall: Array | None = attrs.field(default=None, converter=optional_array_like, metadata=BOUND)

    def __attrs_post_init__(self) -> None:
        if all(value is None for value in (self.low, self.high, self.rise, self.fall)):
            raise InputError("limits need low, high, rise or fall.")
        if self.low is not None and self.high is not None and np.any(self.low > self.high):
            raise InputError(f"low = {self.low} exceeds high = {self.high}.")
        for name, rate in (("rise", self.rise), ("fall", self.fall)):
            if rate is not None and np.any(rate <= 0):
                raise InputError(f"{name} = {rate} must be positive.")

    def bounds(self, l_u: int) -> tuple[Array, Array, Array, Array]:
        """(low, high, rise, fall) for every input, infinite where there is no bound."""
        bounds = []
        limits = {"low": (self.low, -np.inf), "high": (self.high, np.inf)}
        limits |= {"rise": (self.rise, np.inf), "fall": (self.fall, np.inf)}
        for name, (value, default) in limits.items():
            if value is not None and value.size not in (1, l_u):
                raise InputError(f"{name} has {value.size} entries; l_u = {l_u}.")
            full = np.full(l_u, default) if value is None else np.broadcast_to(value, l_u).copy()
            bounds.append(full)
        return bounds[0], bounds[1], bounds[2], bounds[3]
