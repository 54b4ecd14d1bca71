"""Control magnitude and rate saturation, figure 2.13."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import Read, real_array


@dataclass(frozen=True, eq=False, kw_only=True)
class Saturation:
    """Bounds on the control input and on its change in one step.

    u_a(k) is u(k) moved to within `rate` of u_a(k-1), then into [low, high]; u_a(-1) = 0. The
    plant receives u_a, and so do the regressor and the target-model filter of the controller.

    Parameters
    ----------
    low, high : float or array, shape (l_u,), optional
        Magnitude bounds.
    rate : float or array, shape (l_u,), optional
        Largest change in one step.

    Examples
    --------
    >>> from rcac_numeric import Saturation
    >>> Saturation(low=-0.2, high=0.2).bounds(l_u=1)
    (array([-0.2]), array([0.2]), array([inf]))
    """

    low: Read = None
    high: Read = None
    rate: Read = None

    def __post_init__(self) -> None:
        if self.low is None and self.high is None and self.rate is None:
            raise InputError("a saturation needs low, high or rate.")
        for name in ("low", "high", "rate"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, real_array(getattr(self, name), name).reshape(-1))
        widths = {b.size for b in (self.low, self.high, self.rate) if b is not None} - {1}
        if len(widths) > 1:
            raise InputError(f"low, high and rate have different sizes: {sorted(widths)}.")
        if self.low is not None and self.high is not None and np.any(self.low > self.high):
            raise InputError(f"low = {self.low} exceeds high = {self.high}.")
        if self.rate is not None and np.any(self.rate <= 0):
            raise InputError(f"rate = {self.rate} must be positive.")

    def bounds(self, l_u: int) -> tuple[Array, Array, Array]:
        """(low, high, rate) for every input, infinite where there is no bound."""
        return (
            self._sized("low", -np.inf, l_u),
            self._sized("high", np.inf, l_u),
            self._sized("rate", np.inf, l_u),
        )

    def _sized(self, name: str, default: float, l_u: int) -> Array:
        value = getattr(self, name)
        if value is None:
            return np.full(l_u, default)
        if value.size not in (1, l_u):
            raise InputError(f"{name} has {value.size} entries; l_u = {l_u}.")
        return np.broadcast_to(value, l_u).copy()
