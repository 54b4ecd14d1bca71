"""The base of recursive fits: updates, states, and the accuracy of theta."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import number, real_array
from rcac_numeric.arrays._values import ShowsState
from rcac_numeric.compiled._estimators import Arx


def floor_of(R_theta: float) -> float:
    """Return R_theta; raise an error unless it is positive with a reciprocal in float64."""
    value = number(R_theta, "R_theta")
    if not 1e-300 < value < 1e300:
        raise InputError(f"R_theta = {value:g} must be positive.")
    return value


class RecursiveRegression(ShowsState):
    """z(k) = phi(k) theta + e(k) by the controller's own update, UD recursive least squares."""

    SHOWN: ClassVar[tuple[str, ...]] = ("k",)

    def __init__(self, kernel: Arx, **settings: float) -> None:
        self._kernel, self._settings = kernel, settings

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle as an independent fit in the same state."""
        if not np.isfinite(self.P).all():
            raise DivergedError(
                "the identification left the range of float64, so that there is no state to copy; "
                "make a new one, with u and z scaled."
            )
        return _rebuilt, (type(self), self._settings, self.state)

    def update(self, u: ArrayLike, z: ArrayLike) -> None:
        """Update with u(k) and z(k) of one step or of several."""
        one, other = (real_array(v, name).reshape(-1) for v, name in ((u, "u"), (z, "z")))
        if one.size != other.size:
            raise InputError(f"u has {one.size} values and z {other.size}; one of each a step.")
        if not self._kernel.take(one, other):
            raise DivergedError("the identification left the range of float64; scale u and z.")

    @property
    def k(self) -> int:
        """The number of steps so far."""
        return int(self._kernel.k)

    @property
    def P(self) -> Array:
        """The covariance of theta divided by `variance`, for white e."""
        return np.asarray(self._kernel.P)

    @property
    def variance(self) -> float:
        """The variance of the equation error e, over the steps in memory."""
        return float(self._kernel.variance)

    @property
    def state(self) -> Array:
        """Everything that later steps depend on."""
        return self._kernel.save()

    def restore(self, state: Array) -> None:
        """Go back, or forward, to a state of a model with the same settings."""
        try:
            self._kernel.restore(state)
        except (TypeError, ValueError):
            raise InputError(
                "that is not the `state` of a model with the same orders; nothing was restored."
            ) from None


def _rebuilt(
    kind: type[RecursiveRegression], settings: dict[str, float], state: Array
) -> RecursiveRegression:
    regression = kind(**settings)  # type: ignore[arg-type]
    regression.restore(state)
    return regression
