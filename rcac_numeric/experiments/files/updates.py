"""The updates of an experiment file, each with the settings that are its own."""

from __future__ import annotations

from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.controllers.updates.forgetting import (
    Forgetting,
    ScheduledForgetting,
    SubspaceForgetting,
    VariableRateForgetting,
)
from rcac_numeric.controllers.updates.recursive import UD, Covariance
from rcac_numeric.controllers.updates.resets import CovarianceReset
from rcac_numeric.engine.compiled.updates import ARGUMENTS
from rcac_numeric.experiments.format.lists import ByStep
from rcac_numeric.experiments.format.signatures import summary_of
from rcac_numeric.experiments.format.tables import Kinds, Table
from rcac_numeric.experiments.format.values import Numbers, Real


def _recursive(kind: type[UD] | type[Covariance]) -> Table[Any]:
    """The keys of an update whose four ways of forgetting are four keys in a file."""

    def make(
        R_theta: Any,
        *,
        lambda_: float = 1.0,
        lambda_changes: dict[int, float] | None = None,
        forgetting: VariableRateForgetting | None = None,
        subspace_lambda: float | None = None,
        process_noise: Any = None,
        reset: CovarianceReset | None = None,
        stop_where_unsupported: bool = False,
    ) -> UD | Covariance:
        """Put the sentence of the update here.

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
        subspace_lambda : number
            lambda of subspace forgetting, which does not wind up; for "ud".
        process_noise : number or matrix
            Q of (2.46), added to P after every update.
        reset : table
            When P is set back to P(0): `{ at = [2000] }`.
        stop_where_unsupported : bool
            The run ends at the first update that rounding decides.
        """
        return kind(
            R_theta,
            lambda_=_forgetting(lambda_, lambda_changes, forgetting, subspace_lambda),
            process_noise=process_noise,
            reset=reset,
            stop_where_unsupported=stop_where_unsupported,
        )

    sentence = "Put the sentence of the update here."
    make.__doc__ = (make.__doc__ or "").replace(sentence, summary_of(kind))
    return Table(make, forms=RECURSIVE)


RECURSIVE = {
    "R_theta": Numbers(),
    "lambda_changes": ByStep(Real()),
    "forgetting": Table(VariableRateForgetting),
    "process_noise": Numbers(),
    "reset": Table(CovarianceReset, docs=dict.fromkeys(("short", "long"), "Steps of `growth`.")),
}

# Every update that the engine runs, by its own name; its signature says which keys it has.
UPDATES: Kinds[Any] = Kinds(
    {kind.name: kind for kind in ARGUMENTS}
    | {kind.name: _recursive(kind) for kind in (UD, Covariance)},
    default=UD.name,
)


def _forgetting(
    lambda_: float,
    changes: dict[int, float] | None,
    rule: VariableRateForgetting | None,
    subspace_lambda: float | None,
) -> float | Forgetting:
    """The one way of forgetting that the four keys together say."""
    special = rule if subspace_lambda is None else SubspaceForgetting(subspace_lambda)
    if special is not None:
        if lambda_ != 1 or changes or (rule is not None and special is not rule):
            raise InputError(
                "give one of forgetting, subspace_lambda, and lambda with its changes, not two."
            )
        return special
    return ScheduledForgetting(changes, lambda_) if changes else lambda_
