"""Updates of the reference in ball arithmetic, as printed in the text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np
from flint import arb, arb_mat
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.controllers._bounds import CertifiedBounds, ellipsoid_radii
from rcac_numeric.controllers._forgetting import (
    ScheduledForgetting,
)
from rcac_numeric.controllers._memoryless import Gradient, Instantaneous
from rcac_numeric.controllers._normalization import Normalization
from rcac_numeric.controllers._recursive import UD, Covariance, RecursiveLeastSquares
from rcac_numeric.controllers._resets import CovarianceReset
from rcac_numeric.controllers._update import Update

T = TypeVar("T")


def clamped(value: arb, low: float, high: float, k: int) -> arb:
    """Return `value` clamped to [low, high]."""
    if value > high:
        return arb(high)
    if value < low:
        return arb(low)
    if value <= high and value >= low:
        return value
    raise DivergedError(
        f"at step {k} a ball lies across a bound, {low:g} or {high:g}, so that the clamp is "
        f"undecided. Use more digits."
    )


CUTS, NEARLY = 4, 1e-6  # as in kernel/controller/coefficient_bounds.hpp


def inside(
    theta: arb_mat, bounds: CertifiedBounds, times: Callable[[arb_mat], arb_mat], k: int
) -> arb_mat:
    """Return theta moved into the ellipsoid: four cuts in the metric of P, then the radius."""
    center, L = balls(bounds.center.reshape(-1, 1)), balls(bounds.factor)
    limit, aim = map(arb, ellipsoid_radii(bounds))
    delta = theta - center
    v = L.solve(delta)
    square = (v.transpose() * v)[0, 0]
    if not _exceeds(square, limit**2, k):
        return theta
    for _ in range(CUTS):
        if not _exceeds(square, limit**2 * (1 + arb(NEARLY)), k):
            break
        normal = L.transpose().solve(v)
        moved = times(normal)
        delta = delta - moved * ((square - limit**2) / (2 * (normal.transpose() * moved)[0, 0]))
        v = L.solve(delta)
        square = (v.transpose() * v)[0, 0]
    return center + delta * (aim / square.sqrt())


def _exceeds(value: arb, bound: arb, k: int) -> bool:
    if value > bound or value <= bound:
        return bool(value > bound)
    raise DivergedError(
        f"at step {k} a ball lies across the boundary of the ellipsoid of theta, so that the "
        "projection is undecided. Use more digits."
    )


def normalized(value: arb, by: Normalization) -> arb:
    """Return f(z) of a `Normalization`."""
    x, limit, pi = arb(by.slope) * value, arb(by.limit), arb.pi()
    if by.function == "rational":
        return x / (1 + abs(x) / limit)
    if by.function == "root":
        return x / (1 + (x / limit) ** 2).sqrt()
    if by.function == "arctan":
        return 2 * limit / pi * (pi * x / (2 * limit)).atan()
    if by.function == "tanh":
        return limit * (x / limit).tanh()
    return limit * (pi.sqrt() * x / (2 * limit)).erf()


def balls(values: ArrayLike) -> arb_mat:
    """Return float64 numbers as exact balls."""
    array = np.asarray(values, dtype=np.float64)
    return arb_mat(*array.shape, [arb(float(v)) for v in array.ravel()])


def inverse_weight(R_theta: float | Array, l_theta: int) -> arb_mat:
    """P(0) = R_theta^{-1}."""
    return balls(constant_weight(R_theta, "R_theta", l_theta, definite=True)).inv()


def latest(first: T, changes: Mapping[int, T], k: int) -> T:
    """Return the value at step k: the initial one, or that of the last change up to k."""
    return [first, *(value for step, value in sorted(changes.items()) if step <= k)][-1]


@dataclass(frozen=True)
class BallData:
    """Data of an update at step k, which is `age` steps after the first one.

    Attributes
    ----------
    Phi_f, R_z : arb_mat
    W : arb_mat
        R_z + R_u.
    residual : arb_mat
        z - u_f.
    """

    k: int
    age: int
    Phi_f: arb_mat
    R_z: arb_mat
    W: arb_mat
    residual: arb_mat


class BallUpdate(Protocol):
    """One update of theta."""

    def begin(self, k: int) -> None:
        """Apply the scheduled events of step k."""

    def step(self, data: BallData, theta: arb_mat) -> arb_mat:
        """theta(k+1) from theta(k)."""

    def times(self, x: arb_mat) -> arb_mat:
        """P(k) x, for the gradient its step size times x."""


def ball_update(update: Update, l_theta: int) -> BallUpdate:
    """An update in balls."""
    # Exact type: a subclass may change the update.
    if type(update) not in BALL_UPDATES:
        raise InputError(
            f"the reference does not know the update {type(update).__name__}; it knows "
            f"{', '.join(kind.__name__ for kind in BALL_UPDATES)}."
        )
    return BALL_UPDATES[type(update)](update, l_theta)


class BallRecursion:
    """(2.42)-(2.48) as printed: `UD` and `Covariance` are the same without rounding."""

    def __init__(self, update: RecursiveLeastSquares, l_theta: int) -> None:
        rule, reset = update.lambda_, update.reset
        # Exact type: a subclass may change the rule.
        known = type(rule) in (float, ScheduledForgetting)
        if not isinstance(rule, float | ScheduledForgetting) or not known:
            raise InputError(
                f"the reference does not know the forgetting {type(rule).__name__}; leave it out."
            )
        if reset is not None and type(reset) is not CovarianceReset:
            raise InputError(
                f"the reference does not know the reset {type(reset).__name__}; leave it out."
            )
        if reset and (reset.trace_below or reset.growth):
            raise InputError(
                "the reference does not know a covariance reset by trace_below or growth; leave "
                "it out."
            )
        self._rule, self._reset = rule, reset
        self._P = self._P_0 = inverse_weight(update.R_theta, l_theta)
        noise = update.process_noise
        self._noise = (
            None
            if noise is None
            else balls(constant_weight(noise, "process_noise", l_theta, definite=False))
        )

    def begin(self, k: int) -> None:
        """Scheduled resets."""
        if self._reset and k in self._reset.at:
            self._P = self._P_0

    def step(self, data: BallData, theta: arb_mat) -> arb_mat:
        """(2.45), and (2.43) for the covariance."""
        every = self._reset.every if self._reset else 0
        if every and data.age > 0 and data.age % every == 0:
            self._P = self._P_0
        lam = arb(self._factor(data.k))
        theta, gain = _corrected(self._P, lam, data, theta)
        self._P = (self._P - gain * (data.Phi_f * self._P)) * (1 / lam)
        if self._noise is not None:
            self._P = self._P + self._noise
        return theta

    def times(self, x: arb_mat) -> arb_mat:
        """P(k) x."""
        return self._P * x

    def _factor(self, k: int) -> float:
        if not isinstance(self._rule, ScheduledForgetting):
            return self._rule
        return latest(self._rule.initial, self._rule.changes, k)


class BallInstantaneous:
    """(2.45) with P(k) = P(0) and lambda = 1 at every step."""

    def __init__(self, update: Instantaneous, l_theta: int) -> None:
        self._P = inverse_weight(update.R_theta, l_theta)

    def begin(self, k: int) -> None:
        """Nothing is scheduled."""

    def step(self, data: BallData, theta: arb_mat) -> arb_mat:
        """The minimiser of the cost of one step."""
        return _corrected(self._P, arb(1), data, theta)[0]

    def times(self, x: arb_mat) -> arb_mat:
        """P(0) x."""
        return self._P * x


class BallGradient:
    """A step down the slope of the cost of one step."""

    def __init__(self, update: Gradient, l_theta: int) -> None:
        self._step_size = arb(update.step_size)

    def begin(self, k: int) -> None:
        """Nothing is scheduled."""

    def step(self, data: BallData, theta: arb_mat) -> arb_mat:
        """Theta - step_size Phi_f' [R_z zhat + R_u Phi_f theta]."""
        F = data.Phi_f
        slope = F.transpose() * (data.W * F * theta + data.R_z * data.residual)
        return theta - slope * self._step_size

    def times(self, x: arb_mat) -> arb_mat:
        """The step size times x."""
        return x * self._step_size


BALL_UPDATES: dict[type[Update], Callable[[Any, int], BallUpdate]] = {
    UD: BallRecursion,
    Covariance: BallRecursion,
    Instantaneous: BallInstantaneous,
    Gradient: BallGradient,
}


def _corrected(P: arb_mat, lam: arb, data: BallData, theta: arb_mat) -> tuple[arb_mat, arb_mat]:
    """theta(k+1) and the gain P Phi_f' Upsilon^{-1}."""
    PF = P * data.Phi_f.transpose()
    try:
        W_inverse = data.W.inv()
        gain = PF * (W_inverse * lam + data.Phi_f * PF).inv()
    except ZeroDivisionError:
        raise DivergedError(
            f"the balls have lost every digit at step {data.k}: Upsilon contains a singular "
            f"matrix. Use more digits or fewer steps, and check whether the loop diverges in "
            f"float64."
        ) from None
    return theta - gain * (data.Phi_f * theta + W_inverse * data.R_z * data.residual), gain
