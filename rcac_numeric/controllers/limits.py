"""What a controller keeps its own u to, before anybody applies it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import real_array
from rcac_numeric.arrays.values import Value


@dataclass(frozen=True, eq=False, init=False)
class ControlLimits(Value):
    """Bounds of u and of its change in one step, up and down, kept in the compiled step.

    u(k) is moved into [u(k-1) - fall, u(k-1) + rise], then into [low, high]; what is left of it,
    and not what was asked for, stands in the regressor and in the target-model filter. For
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

    low: Array | None
    high: Array | None
    rise: Array | None
    fall: Array | None

    def __init__(
        self,
        low: ArrayLike | None = None,
        high: ArrayLike | None = None,
        rise: ArrayLike | None = None,
        fall: ArrayLike | None = None,
    ) -> None:
        set_ = partial(object.__setattr__, self)
        given = {"low": low, "high": high, "rise": rise, "fall": fall}
        for name, value in given.items():
            set_(name, None if value is None else real_array(value, name).reshape(-1))
        if all(value is None for value in given.values()):
            raise InputError("limits need low, high, rise or fall.")
        if self.low is not None and self.high is not None and np.any(self.low > self.high):
            raise InputError(f"low = {self.low} exceeds high = {self.high}.")
        for name, rate in (("rise", self.rise), ("fall", self.fall)):
            if rate is not None and np.any(rate <= 0):
                raise InputError(f"{name} = {rate} must be positive.")

    def bounds(self, l_u: int) -> tuple[Array, Array, Array, Array]:
        """(low, high, rise, fall) for every input, infinite where there is no bound."""
        made = []
        limits = {"low": (self.low, -np.inf), "high": (self.high, np.inf)}
        limits |= {"rise": (self.rise, np.inf), "fall": (self.fall, np.inf)}
        for name, (value, default) in limits.items():
            if value is not None and value.size not in (1, l_u):
                raise InputError(f"{name} has {value.size} entries; l_u = {l_u}.")
            full = np.full(l_u, default) if value is None else np.broadcast_to(value, l_u).copy()
            made.append(full)
        return made[0], made[1], made[2], made[3]
