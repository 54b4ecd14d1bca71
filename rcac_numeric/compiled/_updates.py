"""Kernel arguments from updates as data.

Register a new update by a line in `ARGUMENTS`. Other classes are refused, also
subclasses of what is: the engine would run them without what they add.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, get_args

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import (
    full_weight,
    inverse,
    square_root_columns,
)
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.controllers._forgetting import (
    CappedForgetting,
    Forgetting,
    ScheduledForgetting,
    SubspaceForgetting,
    VariableRateForgetting,
)
from rcac_numeric.controllers._joint import JointUD
from rcac_numeric.controllers._memoryless import Gradient, Instantaneous
from rcac_numeric.controllers._recursive import UD, Covariance, RecursiveLeastSquares
from rcac_numeric.controllers._resets import CovarianceReset
from rcac_numeric.controllers._sliding_window import SlidingWindow
from rcac_numeric.controllers._update import Update

Event = tuple[int, str, float]


def kernel_arguments_of(
    update: str,
    P_0: Array,
    *,
    forgetting_factor: float = 1.0,
    forgetting: tuple[int, int, float, float] = (0, 0, 0.0, 1.0),
    reset: tuple[int, float, float, int, int] = (0, 0.0, 0.0, 10, 100),
    noise: Array | None = None,
    events: Sequence[Event] = (),
    window: int = 0,
    step_size: float = 0.0,
) -> dict[str, Any]:
    """Arguments of `_kernel.controller` for an update, by name.

    `update` is the kernel's name of it, `forgetting_factor` lambda at step 0; `forgetting` and
    `reset` belong to variable-rate forgetting and to covariance resets, and do nothing by default.
    `noise` has rows a with Q = sum a'a; `events` are scheduled changes of lambda and resets.
    """
    noise = np.zeros(0) if noise is None else noise
    return {
        "update": update, "P_0": P_0, "forgetting_factor": forgetting_factor,
        "forgetting": forgetting, "reset": reset, "noise": noise, "window": window,
        "step_size": step_size, "events": list(events),
    }  # fmt: skip


def kernel_update(update: Update, l_theta: int) -> dict[str, Any]:
    """Return the kernel arguments of an update of l_theta coefficients."""
    require_kind(update, "update", ARGUMENTS)
    return ARGUMENTS[type(update)](update, l_theta)


def require_kind(value: object, name: str, kinds: Iterable[type], who: str = "engine") -> None:
    """Raise unless the class of `value` is exactly one of the kinds."""
    known = [kind for kind in kinds if kind is not object]
    if type(value) not in known:
        raise InputError(
            f"{name} = {shortened(repr(value), 500)} is a {type(value).__name__}, which the {who} "
            f"does not run; it runs {', '.join(kind.__name__ for kind in known)}."
        )


def _window(update: SlidingWindow, l_theta: int) -> dict[str, Any]:
    return kernel_arguments_of(
        update.name,
        P_0=initial_covariance(update.R_theta, l_theta),
        forgetting_factor=update.lambda_,
        window=update.window,
    )


def _joint(update: JointUD, l_theta: int) -> dict[str, Any]:
    return kernel_arguments_of(
        update.name,
        P_0=initial_covariance(update.R_theta, l_theta),
        window=update.n_d,
        step_size=update.rho,
    )


def _instantaneous(update: Instantaneous, l_theta: int) -> dict[str, Any]:
    return kernel_arguments_of(update.name, P_0=initial_covariance(update.R_theta, l_theta))


def _gradient(update: Gradient, l_theta: int) -> dict[str, Any]:
    return kernel_arguments_of(
        update.name, P_0=np.zeros((l_theta, l_theta)), step_size=update.step_size
    )


def initial_covariance(R_theta: float | Array, l_theta: int) -> Array:
    """Return P(0) = R_theta^{-1}, exactly diagonal for a diagonal R_theta."""
    return inverse(full_weight(R_theta, l_theta))


def initial_variances(R_theta: float | Array, l_theta: int) -> Array:
    """Return the P(0) of the kernel: its diagonal if R_theta is a number."""
    if isinstance(R_theta, np.ndarray):
        return initial_covariance(R_theta, l_theta)
    return np.full(l_theta, 1.0 / R_theta)


def initial_forgetting_factor(lambda_: float | Forgetting) -> float:
    """Return lambda at step 0."""
    if isinstance(lambda_, ScheduledForgetting):
        return lambda_.initial
    if isinstance(lambda_, SubspaceForgetting | CappedForgetting):
        return lambda_.lambda_
    return 1.0 if isinstance(lambda_, VariableRateForgetting) else lambda_


def _recursive(update: RecursiveLeastSquares, l_theta: int) -> dict[str, Any]:
    rule, reset, beside = update.lambda_, update.reset, dict[str, Any]()
    require_kind(rule, "lambda_", (float, *get_args(Forgetting)))
    events: list[Event] = []
    if reset is not None:
        require_kind(reset, "reset", (CovarianceReset,))
        events += [(k, "reset", 0.0) for k in reset.at]
        beside["reset"] = reset.every, reset.trace_below, reset.growth, reset.short, reset.long
    if isinstance(rule, ScheduledForgetting):
        events += [(k, "forgetting", value) for k, value in rule.changes.items()]
    if update.process_noise is not None:
        Q = full_weight(update.process_noise, l_theta)
        beside["noise"] = np.ascontiguousarray(square_root_columns(Q).T)
    if isinstance(rule, VariableRateForgetting):
        beside["forgetting"] = rule.short, rule.long, rule.gain, rule.smallest
    name = update.name
    if isinstance(rule, SubspaceForgetting | CappedForgetting):
        name = "ud, subspace" if isinstance(rule, SubspaceForgetting) else "ud, capped"
    return kernel_arguments_of(
        name,
        P_0=initial_covariance(update.R_theta, l_theta),
        forgetting_factor=initial_forgetting_factor(rule),
        events=events,
        **beside,
    )


ARGUMENTS: dict[type[Update], Callable[[Any, int], dict[str, Any]]] = {
    UD: _recursive,
    Covariance: _recursive,
    SlidingWindow: _window,
    JointUD: _joint,
    Instantaneous: _instantaneous,
    Gradient: _gradient,
}
