"""The updates of an experiment file, each with the settings that are its own."""

from __future__ import annotations

from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.controllers.rules import (
    CovarianceReset,
    ScheduledForgetting,
    VariableRateForgetting,
)
from rcac_numeric.controllers.updates import UD, Covariance, Gradient, Instantaneous, SlidingWindow
from rcac_numeric.experiments.format.lists import ByStep
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Integer, Numbers, Real


def _ud(
    R_theta: Any,
    *,
    lambda_: float = 1.0,
    lambda_changes: dict[int, float] | None = None,
    forgetting: VariableRateForgetting | None = None,
    process_noise: Any = None,
    reset: CovarianceReset | None = None,
    stop_where_unsupported: bool = False,
) -> UD:
    """The recursive update (2.42)-(2.45) with P = U D U' factorised.

    Parameters
    ----------
    R_theta : number or matrix
        Weight of theta - theta(0); P(0) is its inverse.
    lambda_ : number
        Forgetting factor, in (0, 1].
    lambda_changes : list of [step, lambda]
        lambda from each step on.
    forgetting : table
        lambda falls while z is larger than of late: `{ short = 10, long = 100, gain = 0.1 }`.
    process_noise : number or matrix
        Q of (2.46), added to P after every update.
    reset : table
        When P is set back to P(0): `{ at = [2000] }`.
    stop_where_unsupported : bool
        The run ends at the first update that rounding decides.
    """
    return UD(
        R_theta,
        lambda_=_forgetting(lambda_, lambda_changes, forgetting),
        process_noise=process_noise,
        reset=reset,
        stop_where_unsupported=stop_where_unsupported,
    )


def _covariance(
    R_theta: Any,
    *,
    lambda_: float = 1.0,
    lambda_changes: dict[int, float] | None = None,
    forgetting: VariableRateForgetting | None = None,
    process_noise: Any = None,
    reset: CovarianceReset | None = None,
    stop_where_unsupported: bool = False,
) -> Covariance:
    """The same with P as printed, which loses positive definiteness where R_theta is small."""
    return Covariance(
        R_theta,
        lambda_=_forgetting(lambda_, lambda_changes, forgetting),
        process_noise=process_noise,
        reset=reset,
        stop_where_unsupported=stop_where_unsupported,
    )


def _sliding_window(R_theta: Any, *, window: int, lambda_: float = 1.0) -> SlidingWindow:
    """The batch minimiser over the last updates and of the distance to theta(0).

    Parameters
    ----------
    window : int
        How many updates it remembers.
    """
    return SlidingWindow(R_theta, window=window, lambda_=lambda_)


def _instantaneous(R_theta: Any) -> Instantaneous:
    """The cost of one step plus the distance to theta(k)."""
    return Instantaneous(R_theta)


def _gradient(step_size: float) -> Gradient:
    """A step against the gradient of the cost of one step; it reads no R_theta.

    Parameters
    ----------
    step_size : number
        How far.
    """
    return Gradient(step_size)


NUMBERS = {"R_theta": Numbers()}
RECURSIVE = {
    **NUMBERS,
    "lambda_changes": ByStep(Real()),
    "forgetting": Table(VariableRateForgetting),
    "process_noise": Numbers(),
    "reset": Table(CovarianceReset, docs=dict.fromkeys(("short", "long"), "Steps of `growth`.")),
}

UPDATES: Kinds[Any] = Kinds(
    {
        "ud": Table(_ud, forms=RECURSIVE),
        "covariance": Table(_covariance, forms=RECURSIVE),
        "sliding window": Table(_sliding_window, forms={**NUMBERS, "window": Integer(1)}),
        "instantaneous": Table(_instantaneous, forms=NUMBERS),
        "gradient": _gradient,
    },
    default="ud",
)


def _forgetting(
    lambda_: float, changes: dict[int, float] | None, rule: VariableRateForgetting | None
) -> float | ScheduledForgetting | VariableRateForgetting:
    """The one way of forgetting that the three keys together say."""
    if rule is not None:
        if lambda_ != 1 or changes:
            raise InputError("give either forgetting or lambda and its changes, not both.")
        return rule
    return ScheduledForgetting(changes, lambda_) if changes else lambda_
