"""The updates of an experiment file, each with the settings that are its own."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

from compensator_theory.errors import InputError
from rcac_experiments.format._signatures import Composed
from rcac_experiments.format._tables import Kinds, Table
from rcac_experiments.format._values import ByStep, Numbers, Real
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled._updates import ARGUMENTS
from rcac_numeric.controllers._forgetting import (
    Forgetting,
    ScheduledForgetting,
    SubspaceForgetting,
    VariableRateForgetting,
    forgetting_factor,
)
from rcac_numeric.controllers._prior import PriorSamples
from rcac_numeric.controllers._recursive import UD, Covariance, RecursiveLeastSquares
from rcac_numeric.controllers._resets import CovarianceReset
from rcac_numeric.controllers._update import weight

FACTOR = Real(forgetting_factor)


def weight_or_samples(
    R_theta: Annotated[
        float | Array | None,
        Numbers(check=partial(weight, definite=True)),
        "Weight of theta - theta(0); P(0) is its inverse.",
    ] = None,
    prior: Annotated[
        PriorSamples | None,
        Table(PriorSamples),
        "Instead of R_theta, and free of units: `{ samples = 100, y = 0.5 }`.",
    ] = None,
) -> Any:
    """R_theta of an update."""
    if (R_theta is None) == (prior is None):
        raise InputError("give R_theta or prior, one of the two.")
    return R_theta if prior is None else prior


def forgetting_of(
    lambda_: Annotated[float, FACTOR, "Forgetting factor, in (0, 1]."] = 1.0,
    lambda_changes: Annotated[
        dict[int, float] | None, ByStep(FACTOR), "lambda from each step on."
    ] = None,
    forgetting: Annotated[
        VariableRateForgetting | None,
        "lambda falls while z is larger than of late: `{ short = 10, long = 100, gain = 0.1 }`.",
    ] = None,
    subspace_lambda: Annotated[
        float | None,
        FACTOR,
        'lambda of subspace forgetting, which does not wind up; for "ud".',
    ] = None,
) -> float | Forgetting:
    """The one way of forgetting that the four keys together say."""
    if forgetting is None and subspace_lambda is None:
        return ScheduledForgetting(lambda_changes, lambda_) if lambda_changes else lambda_
    if lambda_ != 1 or lambda_changes or (forgetting is not None and subspace_lambda is not None):
        raise InputError(
            "give one of forgetting, subspace_lambda, and lambda with its changes, not two."
        )
    return SubspaceForgetting(subspace_lambda) if forgetting is None else forgetting  # type: ignore[arg-type]


def _recursive(update: type[RecursiveLeastSquares]) -> Table[RecursiveLeastSquares]:
    """An update by recursive least squares, whose four ways of forgetting are four keys."""
    return Table(
        Composed(update, R_theta=weight_or_samples, lambda_=forgetting_of),
        forms={
            "process_noise": Numbers(check=weight),
            "reset": Table(
                CovarianceReset, docs=dict.fromkeys(("short", "long"), "Steps of `growth`.")
            ),
        },
        docs={
            "process_noise": "Q of (2.46), added to P after every update.",
            "reset": "When P is set back to P(0): `{ at = [2000] }`.",
            "stop_where_unsupported": "The run ends at the first update that rounding decides.",
        },
    )


# Every update that the engine runs, by its own name; its fields say which keys it has.
UPDATES: Kinds[Any] = Kinds(
    {one.name: one for one in ARGUMENTS} | {one.name: _recursive(one) for one in (UD, Covariance)},
    default=UD.name,
)
