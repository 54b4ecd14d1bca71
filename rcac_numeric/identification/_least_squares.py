"""Least squares of prediction errors by Levenberg and Marquardt, of any model.

Those of a Box-Jenkins model of a scalar record the kernel minimises, by the same rules
(kernel/identification/least_errors.hpp).
"""

from __future__ import annotations

from typing import Protocol, TypeVar

import numpy as np

from rcac_numeric.arrays._array_types import Array

DECREASE = 1e-2  # of N log(sum of squares): below it an iteration has settled
SETTLED = 0.1  # of DECREASE: a predicted decrease below it is not tried
WIDTHS = 6  # damping factors that are tried in an iteration


class ErrorPoint(Protocol):
    """Prediction errors at some coefficients."""

    @property
    def theta(self) -> Array:
        """The coefficients."""

    @property
    def e(self) -> Array:
        """The errors."""

    @property
    def square(self) -> float:
        """The sum of their squares."""

    def jacobian(self) -> Array | None:
        """The derivatives of e; None where they leave float64."""


P = TypeVar("P", bound=ErrorPoint)
P_co = TypeVar("P_co", bound=ErrorPoint, covariant=True)


class ErrorFunction(Protocol[P_co]):
    """Prediction errors as a function of coefficients."""

    def at(self, theta: Array) -> P_co | None:
        """The errors there; None where they leave float64."""

    def confined(self, theta: Array) -> Array:
        """The coefficients with stable filters."""


def minimised(
    errors: ErrorFunction[P], theta: Array, steps: int, iterations: int, kept: int = 0
) -> tuple[P, Array] | None:
    """The point of least errors from some coefficients, and its derivatives; None if it fails.

    By Levenberg and Marquardt; the first `kept` coefficients do not move.
    """
    point = errors.at(errors.confined(theta))
    J = None if point is None else point.jacobian()
    if point is None or J is None:
        return None
    damping = 1e-3
    for _ in range(iterations):
        H, slope = J @ J.T, J @ point.e
        size = np.sqrt(np.diag(H))
        size[size == 0] = 1.0
        H, slope = H / size / size[:, None], slope / size
        if kept:
            H[:kept], H[:, :kept], slope[:kept] = 0.0, 0.0, 0.0
            H[:kept, :kept] = np.eye(kept)
        has_settled, better = False, None
        for _ in range(WIDTHS):
            try:
                step = -np.linalg.solve(H + damping * np.eye(len(H)), slope)
            except np.linalg.LinAlgError:
                damping = 10 * damping
                continue
            gain = -(2 * slope + H @ step) @ step  # of the sum of squares, to first order
            if steps * gain < SETTLED * DECREASE * point.square:
                break
            step = step / size
            trial = errors.at(errors.confined(point.theta + step))
            if trial is not None and trial.square < point.square:
                has_settled = steps * (1 - trial.square / point.square) < DECREASE
                better, damping = trial, max(damping / 5, 1e-9)
                break
            damping = max(6 * damping, 1e-6)
        if better is None:
            break
        new = better.jacobian()
        if new is None:
            break
        point, J = better, new
        if has_settled:
            break
    return point, J
