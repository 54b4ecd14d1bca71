"""Gain scheduling: fixed compensators over a scheduling variable."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Literal

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory._truth import Truth
from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    array_like,
    integer,
    items,
    number,
    one_of,
    reads,
    real_array,
    vector,
    with_checks,
)
from rcac_numeric.arrays._values import ShowsState
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._stepwise import StepwiseController

BETWEEN = 32  # subintervals at whose ends poles are computed
ROUNDING = 1e-6  # tolerance for poles that meet


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class GainSchedule(StepwiseController):
    r"""Compensators for values of a scheduling variable, interpolated between them.

    With s(k) the scheduling variable, held at the ends of the table outside it,

        u(k) = P_1(s(k)) u(k-1) + ... + P_nc(s(k)) u(k-n_c) + Q_0(s(k)) y(k) + ... ,

    the coefficients of (2.28) linear in s between two values. What is remembered are past u and y
    themselves, which all compensators share: none has a state of its own that could be out of
    date, and orders may differ. Where every compensator has integral action, s may even jump in
    a steady state with zero error and u does not move.

    Between two values every interpolated compensator is a compensator, but the loop that it
    closes is not implied to be stable by those at the ends: look at `at(s)` for some s, and s must
    change slowly beside the loop.

    Parameters
    ----------
    values : array, shape (M,)
        Of the scheduling variable, increasing; M >= 2.
    compensators : sequence of Compensator
        One for each value; from y to u, or from [y; r] to u.
    variable : {"y", "r"}
        Whether a measurement or a command is the scheduling variable.
    component : int
        Which entry of it.
    l_r : int
        How many of the compensators' inputs, the last ones, are commands.

    Raises
    ------
    InputError
        Where sizes do not fit, values do not increase, or what lies between two compensators has
        poles further out than both and than the unit circle.

    Notes
    -----
    W. J. Rugh and J. S. Shamma, Research on gain scheduling, Automatica 36(10), 2000.

    Examples
    --------
    >>> from rcac_numeric import Compensator, GainSchedule, Levels, exogenous, servo_plant, simulate
    >>> def integral(gain):  # u(k) = u(k-1) + gain (r - y)(k-1)
    ...     return Compensator(past_u=[[[1.0]]], past_y=[[[0.0, 0.0]], [[-gain, gain]]])
    >>> schedule = GainSchedule([0, 10], [integral(0.1), integral(0.5)], variable="r", l_r=1)
    >>> schedule.at(5.0).past_y[1]
    array([[-0.3,  0.3]])
    >>> controller = schedule.started()  # beside a device
    >>> [float(controller.step([0.0], [r])[0]) for r in (10.0, 0.0, 10.0)]
    [0.0, 1.0, 1.0]
    """

    values: Array = attrs.field(converter=array_like, metadata=reads(real_array))
    compensators: Sequence[Compensator] = attrs.field(metadata=reads(items, kind=Compensator))
    variable: Literal["y", "r"] = attrs.field(
        default="y", metadata=reads(one_of, choices=("y", "r"))
    )
    component: int = 0
    commands: int = attrs.field(default=0, alias="l_r")

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        set_("values", self.values.reshape(-1))
        count = len(self.compensators)
        if count != len(self.values) or count < 2:
            raise InputError(
                f"there are {len(self.values)} values and {count} compensators; at least two "
                "pairs are needed."
            )
        if not (np.diff(self.values) > 0).all():
            raise InputError(f"values = {self.values} must increase.")
        sizes = [(one.l_u, one.l_y) for one in self.compensators]
        for j, size in enumerate(sizes):
            if size != sizes[0]:
                raise InputError(
                    f"compensator {j} has (l_u, l_y) = {size}, compensator 0 {sizes[0]}: "
                    f"interpolation needs equal sizes."
                )
        set_("commands", integer(self.commands, "l_r", at_most=sizes[0][1]))
        width = self.l_y if self.variable == "y" else self.l_r
        if width == 0:
            raise InputError(
                f"variable = {self.variable!r}, and the compensators read no {self.variable}."
            )
        set_("component", integer(self.component, "component", at_most=width - 1))
        for j in range(count - 1):
            self._require_poles_between(j)

    @property
    def l_u(self) -> int:
        """Number of controls."""
        return self.compensators[0].l_u

    @property
    def l_y(self) -> int:
        """Number of measurements."""
        return self.compensators[0].l_y - self.commands

    @property
    def l_r(self) -> int:
        """Number of commands."""
        return self.commands

    @property
    def l_theta(self) -> int:
        """1: theta is the current value of the scheduling variable."""
        return 1

    @property
    def n_c(self) -> int:
        """The largest order."""
        return max(one.n_c for one in self.compensators)

    def at(self, value: float) -> Compensator:
        """Return the interpolated compensator at a value of the scheduling variable.

        Parameters
        ----------
        value : float
            Beyond the ends of the table it is that of the end.
        """
        low = np.interp(number(value, "value"), self.values, np.arange(len(self.values)))
        j = min(int(low), len(self.values) - 2)
        return self._between(j, float(low) - j)

    def compensator_of(self, theta: ArrayLike) -> Compensator:  # type: ignore[override]
        """Return the interpolated compensator; theta is the value of the scheduling variable."""
        return self.at(float(vector(theta, "theta", 1)[0]))

    def started(self) -> ScheduledSteps:
        """Return the controller at step 0, for `simulate` or for a device."""
        return ScheduledSteps(self)

    def _between(self, j: int, share: float) -> Compensator:
        first, second = self.compensators[j : j + 2]
        (P, Q), (P_next, Q_next) = (_padded(one, self.n_c) for one in (first, second))
        return Compensator((1 - share) * P + share * P_next, (1 - share) * Q + share * Q_next)

    def _require_poles_between(self, j: int) -> None:
        ends = self.compensators[j : j + 2]
        furthest = max(1.0, *(_radius(one) for one in ends))
        for share in np.arange(1, BETWEEN) / BETWEEN:
            radius = _radius(self._between(j, share))
            if radius > furthest * (1 + ROUNDING):
                value = (1 - share) * self.values[j] + share * self.values[j + 1]
                raise InputError(
                    f"between {self.values[j]:.6g} and {self.values[j + 1]:.6g} the compensator "
                    f"has a pole of size {radius:.6g} (at {value:.6g}), larger than at both ends: "
                    f"the two compensators are too different. Add a compensator between them."
                )


class ScheduledSteps(ShowsState, Truth):
    """A running gain schedule, returned by `GainSchedule.started`.

    It pickles and copies, and goes on bit for bit.

    Attributes
    ----------
    schedule : GainSchedule
    """

    SHOWN = ("k", "theta")

    def __init__(self, schedule: GainSchedule) -> None:
        self.schedule = schedule
        padded = [_padded(one, schedule.n_c) for one in schedule.compensators]
        self._P, self._Q = (np.array(part) for part in zip(*padded, strict=True))
        inputs = schedule.l_y + schedule.l_r
        self._u = np.zeros((schedule.n_c, schedule.l_u))
        self._y = np.zeros((schedule.n_c + 1, inputs))
        self._k, self._value = 0, float(schedule.values[0])

    @property
    def k(self) -> int:
        """Number of steps taken."""
        return self._k

    @property
    def theta(self) -> Array:
        """The scheduling variable of the last u, shape (1,); before it the first value."""
        return np.array([self._value])

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
        """
        schedule = self.schedule
        inputs = {"y": vector(y, "y", schedule.l_y), "r": vector(r, "r", schedule.l_r)}
        if u_applied is not None:
            applied = vector(u_applied, "u_applied", schedule.l_u)
            self._u[:1] = applied
        self._value = float(inputs[schedule.variable][schedule.component])
        places = np.arange(len(schedule.values))
        low = float(np.interp(self._value, schedule.values, places))
        j = min(int(low), len(places) - 2)
        share = low - j
        self._y[1:] = self._y[:-1].copy()
        self._y[0] = np.concatenate([inputs["y"], inputs["r"]])
        u = np.zeros(schedule.l_u)
        for weight, i in ((1 - share, j), (share, j + 1)):
            u += weight * np.einsum("ijk,ik->j", self._P[i], self._u)
            u += weight * np.einsum("ijk,ik->j", self._Q[i], self._y)
        if schedule.n_c:
            self._u[1:] = self._u[:-1].copy()
            self._u[0] = u
        self._k += 1
        return u

    def save(self) -> Array:
        """Return the state as numbers."""
        return np.concatenate([[self._k, self._value], self._u.ravel(), self._y.ravel()])

    def take_up(self, values: Array) -> None:
        """Restore the state that `save` returned."""
        if values.shape != (2 + self._u.size + self._y.size,):
            raise ValueError(f"{values.size} numbers do not fit this schedule")
        self._k, self._value = int(values[0]), float(values[1])
        self._u[...] = values[2 : 2 + self._u.size].reshape(self._u.shape)
        self._y[...] = values[2 + self._u.size :].reshape(self._y.shape)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (self.schedule, self.save())


def _rebuilt(schedule: GainSchedule, values: Array) -> ScheduledSteps:
    steps = ScheduledSteps(schedule)
    steps.take_up(values)
    return steps


def _padded(one: Compensator, order: int) -> tuple[Array, Array]:
    """Return the coefficients padded with zeros to an order."""
    more = ((0, order - one.n_c), (0, 0), (0, 0))
    return np.pad(one.past_u, more), np.pad(one.past_y, more)


def _radius(one: Compensator) -> float:
    return float(np.abs(one.poles()).max(initial=0.0))
