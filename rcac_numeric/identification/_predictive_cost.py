"""Predictive cost adaptive control, step by step: a recursive ARX model and its gain."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory._truth import Truth
from compensator_theory.errors import DivergedError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, vector
from rcac_numeric.arrays._values import ShowsState
from rcac_numeric.compiled._estimators import make_arx
from rcac_numeric.controllers._predictive_cost import (
    PredictiveCost,
    bounded_controls,
    estimate_of,
    gains_of,
    prediction_of,
    riccati_overflow,
    rolled_out,
)
from rcac_numeric.controllers._stepwise import stepper_of


class PredictiveCostController(ShowsState, Truth):
    """Predictive cost adaptive control beside a simulator or a device of your own.

    It pickles and copies, and goes on bit for bit.

    Parameters
    ----------
    settings : PredictiveCost

    Examples
    --------
    >>> from rcac_numeric import PredictiveCost, PredictiveCostController
    >>> settings = PredictiveCost(order=1, horizon=10, R=0.1, problem="tracking")
    >>> controller = PredictiveCostController(settings)
    >>> y = 0.0
    >>> for k in range(50):
    ...     (u,) = controller.step(y, r=1.0)
    ...     y = 1.2 * y + 0.5 * float(u)
    >>> round(y, 3), controller.theta.round(3)
    (1.0, array([0.5, 1.2]))
    """

    SHOWN = ("k", "theta")

    def __init__(self, settings: PredictiveCost) -> None:
        self.settings = instance_of(settings, "settings", PredictiveCost)
        self._models = [
            make_arx(
                order=settings.order, R_theta=settings.R_theta,
                forgetting_factor=settings.lambda_, l_u=settings.l_u, l_y=settings.l_y,
                target=i, theta_0=row,
            )
            for i, row in enumerate(settings.theta_0)
        ]  # fmt: skip
        self._u = np.zeros((settings.order, settings.l_u))
        self._y = np.zeros((settings.order, settings.l_y))
        self._k = 0

    @property
    def k(self) -> int:
        """Number of steps taken."""
        return self._k

    @property
    def theta(self) -> Array:
        """The coefficients that made the last u, shape (l_theta,)."""
        return np.concatenate([np.asarray(one.theta) for one in self._models])

    @property
    def covariance(self) -> Array:
        """P of the least squares, shape (n (l_u + l_y),) * 2; every output has the same."""
        return np.asarray(self._models[0].P)

    def step(self, y: ArrayLike, r: ArrayLike = (), u_applied: ArrayLike | None = None) -> Array:
        """u(k) from the measurement and the command.

        Parameters
        ----------
        y : array, shape (l_y,)
        r : array, shape (l_r,)
        u_applied : array, shape (l_u,), optional
            What became of u(k-1), where an actuator did not follow it.

        Returns
        -------
        array, shape (l_u,)

        Raises
        ------
        InputError
            Where a size does not fit or an entry is not finite; nothing has moved.
        DivergedError
            Where the model or the Riccati recursion leaves the range of float64.
        """
        settings = self.settings
        measured = vector(y, "y", settings.l_y)
        command = vector(r, "r", settings.l_r)
        if u_applied is not None:
            self._u[0] = vector(u_applied, "u_applied", settings.l_u)
        if self._k:
            self._identify()
        u = self._control(command if settings.l_r else np.zeros(settings.l_y))
        output = command - measured if settings.problem == "servo" else measured
        for past, value in ((self._u, u), (self._y, output)):
            past[1:] = past[:-1].copy()
            past[0] = value
        self._k += 1
        return u

    def _identify(self) -> None:
        """Update the rows of the model with the last u and y."""
        for model in self._models:
            if not model.take(self._u[0], self._y[0]):
                raise DivergedError(
                    "the identification left the range of float64; scale u and y, or choose a "
                    "larger R_theta."
                )

    def _control(self, command: Array) -> Array:
        """Return u(k) for the model of now."""
        settings, past_u = self.settings, self._u[0]
        theta = self.theta
        b, a = settings.model(theta)
        estimate = estimate_of(b, a, self._u, self._y)
        prediction = prediction_of(settings, theta)
        gains = gains_of(settings, prediction)
        state = np.concatenate([estimate, past_u, command])
        u = gains[0] @ state
        if not np.isfinite(u).all():
            raise riccati_overflow()
        if settings.limits is None:
            return np.asarray(u)
        low, high, rise, fall = settings.limits.bounds(settings.l_u)
        first_low = np.clip(past_u - fall, low, high)
        first_high = np.clip(past_u + rise, low, high)
        if settings.limited_by == "saturation":
            return np.asarray(np.clip(u, first_low, first_high))
        bounds = np.tile(low, (settings.horizon, 1)), np.tile(high, (settings.horizon, 1))
        bounds[0][0], bounds[1][0] = first_low, first_high
        controls = rolled_out(prediction, gains, state)
        if (controls < bounds[0]).any() or (controls > bounds[1]).any():
            controls = bounded_controls(settings, prediction, state, *bounds)
        return np.asarray(np.clip(controls[0], first_low, first_high))

    def save(self) -> Array:
        """Return the state as numbers."""
        models = [np.asarray(one.save()) for one in self._models]
        return np.concatenate([[self._k], self._u.ravel(), self._y.ravel(), *models])

    def take_up(self, values: Array) -> None:
        """Restore the state that `save` returned."""
        if values.shape != self.save().shape:
            raise ValueError(f"{values.size} numbers do not fit this controller")
        first, second = 1 + self._u.size, 1 + self._u.size + self._y.size
        for model, part in zip(
            self._models, np.split(values[second:], len(self._models)), strict=True
        ):
            model.restore(np.ascontiguousarray(part))
        self._k = int(values[0])
        self._u[...] = values[1:first].reshape(self._u.shape)
        self._y[...] = values[first:second].reshape(self._y.shape)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (self.settings, self.save())


def _rebuilt(settings: PredictiveCost, values: Array) -> PredictiveCostController:
    steps = PredictiveCostController(settings)
    steps.take_up(values)
    return steps


@stepper_of.register
def _controller(settings: PredictiveCost) -> PredictiveCostController:
    return PredictiveCostController(settings)
