"""From an update as data to the arguments that the kernel makes it from.

A new update is registered here: `@kernel_update.register(YourUpdate)`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import singledispatch

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight, inverse, square_root_columns
from rcac_numeric.controllers.rules import (
    CovarianceReset,
    Forgetting,
    ScheduledForgetting,
    VariableRateForgetting,
)
from rcac_numeric.controllers.updates import (
    UD,
    Covariance,
    Gradient,
    Instantaneous,
    RecursiveLeastSquares,
    SlidingWindow,
)

Event = tuple[int, str, float]


@dataclass(frozen=True)
class KernelUpdate:
    """What `_kernel.controller` wants to know of an update.

    Attributes
    ----------
    name : str
        The kernel's name of it.
    P_0 : array, shape (l_theta, l_theta)
    forgetting_factor : float
        lambda at step 0.
    forgetting, reset : tuples
        Of variable-rate forgetting and of covariance resets; the defaults do nothing.
    noise : array, shape (rank of Q, l_theta) or empty
        Rows a with Q = sum a'a.
    events : list of (step, kind, number)
        Scheduled changes of lambda and resets.
    """

    name: str
    P_0: Array
    forgetting_factor: float = 1.0
    forgetting: tuple[int, int, float, float] = (0, 0, 0.0, 1.0)
    reset: tuple[int, float, float, int, int] = (0, 0.0, 0.0, 10, 100)
    noise: Array = field(default_factory=lambda: np.zeros(0))
    events: tuple[Event, ...] = ()
    window: int = 0
    step_size: float = 0.0


@singledispatch
def kernel_update(update: object, l_theta: int) -> KernelUpdate:
    """The kernel's arguments for an update of l_theta coefficients.

    Raises
    ------
    InputError
        Where the update is of no kind that is registered.
    """
    kinds = [kind.__name__ for kind in kernel_update.registry if kind is not object]
    raise InputError(f"update = {update!r} is none that the engine runs: {', '.join(kinds)}.")


@kernel_update.register(UD)
def _(update: UD, l_theta: int) -> KernelUpdate:
    return _recursive(update, l_theta)


@kernel_update.register(Covariance)
def _(update: Covariance, l_theta: int) -> KernelUpdate:
    return _recursive(update, l_theta)


@kernel_update.register(SlidingWindow)
def _(update: SlidingWindow, l_theta: int) -> KernelUpdate:
    return KernelUpdate(
        update.name,
        P_0=initial_covariance(update.R_theta, l_theta),
        forgetting_factor=update.lambda_,
        window=update.window,
    )


@kernel_update.register(Instantaneous)
def _(update: Instantaneous, l_theta: int) -> KernelUpdate:
    return KernelUpdate(update.name, P_0=initial_covariance(update.R_theta, l_theta))


@kernel_update.register(Gradient)
def _(update: Gradient, l_theta: int) -> KernelUpdate:
    return KernelUpdate(update.name, P_0=np.zeros((l_theta, l_theta)), step_size=update.step_size)


def initial_covariance(R_theta: float | Array, l_theta: int) -> Array:
    """P(0) = R_theta^{-1}, exactly diagonal where R_theta is."""
    return inverse(constant_weight(R_theta, "R_theta", l_theta, definite=True))


def initial_forgetting_factor(lambda_: float | Forgetting) -> float:
    """Lambda before any rule has changed it."""
    if isinstance(lambda_, ScheduledForgetting):
        return lambda_.initial
    return 1.0 if isinstance(lambda_, VariableRateForgetting) else lambda_


def _recursive(update: RecursiveLeastSquares, l_theta: int) -> KernelUpdate:
    rule, reset = update.lambda_, update.reset or CovarianceReset()
    events: list[Event] = [(k, "reset", 0.0) for k in reset.at]
    if isinstance(rule, ScheduledForgetting):
        events += [(k, "forgetting", value) for k, value in rule.changes.items()]
    noise = np.zeros(0)
    if update.process_noise is not None:
        Q = constant_weight(update.process_noise, "process_noise", l_theta, definite=False)
        noise = np.ascontiguousarray(square_root_columns(Q).T)
    forgetting = (0, 0, 0.0, 1.0)
    if isinstance(rule, VariableRateForgetting):
        forgetting = (rule.short, rule.long, rule.gain, rule.smallest)
    return KernelUpdate(
        update.name,
        P_0=initial_covariance(update.R_theta, l_theta),
        forgetting_factor=initial_forgetting_factor(rule),
        forgetting=forgetting,
        reset=(reset.every, reset.trace_below, reset.growth, reset.short, reset.long),
        noise=noise,
        events=tuple(events),
    )
