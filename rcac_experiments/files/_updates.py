"""The updates of an experiment file, each with the settings that are its own."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any, ClassVar

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.format._parts import Shorthand
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
from rcac_numeric.controllers._recursive import UD, Covariance
from rcac_numeric.controllers._resets import CovarianceReset
from rcac_numeric.controllers._update import weight

FACTOR = Real(forgetting_factor)


@attrs.frozen(eq=False)
class Recursive(Shorthand):
    """An update by recursive least squares, whose four ways of forgetting are four keys."""

    kind: ClassVar[type[UD] | type[Covariance]]

    R_theta: Annotated[
        float | Array | None,
        Numbers(check=partial(weight, definite=True)),
        "Weight of theta - theta(0); P(0) is its inverse.",
    ] = None
    prior: Annotated[
        PriorSamples | None,
        Table(PriorSamples),
        "In the place of R_theta, of the same worth in any units: `{ samples = 100, y = 0.5 }`.",
    ] = None
    lambda_: Annotated[float, FACTOR, "Forgetting factor, in (0, 1]."] = 1.0
    lambda_changes: Annotated[
        dict[int, float] | None,
        ByStep(FACTOR),
        "lambda from each step on.",
    ] = None
    forgetting: Annotated[
        VariableRateForgetting | None,
        "lambda falls while z is larger than of late: `{ short = 10, long = 100, gain = 0.1 }`.",
    ] = None
    subspace_lambda: Annotated[
        float | None,
        FACTOR,
        'lambda of subspace forgetting, which does not wind up; for "ud".',
    ] = None
    process_noise: Annotated[
        float | Array | None,
        Numbers(check=weight),
        "Q of (2.46), added to P after every update.",
    ] = None
    reset: Annotated[
        CovarianceReset | None,
        Table(CovarianceReset, docs=dict.fromkeys(("short", "long"), "Steps of `growth`.")),
        "When P is set back to P(0): `{ at = [2000] }`.",
    ] = None
    stop_where_unsupported: Annotated[
        bool,
        "The run ends at the first update that rounding decides.",
    ] = False

    def made(self) -> UD | Covariance:
        """The update."""
        if (self.R_theta is None) == (self.prior is None):
            raise InputError("give R_theta or prior, one of the two.")
        return self.kind(
            self.R_theta if self.prior is None else self.prior,  # type: ignore[arg-type]
            lambda_=self._forgetting(),
            process_noise=self.process_noise,
            reset=self.reset,
            stop_where_unsupported=self.stop_where_unsupported,
        )

    def _forgetting(self) -> float | Forgetting:
        """The one way of forgetting that the four keys together say."""
        rule, subspace, changes = self.forgetting, self.subspace_lambda, self.lambda_changes
        if rule is None and subspace is None:
            return ScheduledForgetting(changes, self.lambda_) if changes else self.lambda_
        if self.lambda_ != 1 or changes or (rule is not None and subspace is not None):
            raise InputError(
                "give one of forgetting, subspace_lambda, and lambda with its changes, not two."
            )
        return SubspaceForgetting(subspace) if rule is None else rule  # type: ignore[arg-type]


@attrs.frozen(eq=False)
class RecursiveUD(Recursive):
    """The recursion (2.42)-(2.45) with P = U D U' factorised (Bierman); the one to use."""

    kind = UD


@attrs.frozen(eq=False)
class RecursiveCovariance(Recursive):
    """The recursion (2.42)-(2.45) with P as printed, which is what published work ran."""

    kind = Covariance


# Every update that the engine runs, by its own name; its fields say which keys it has.
UPDATES: Kinds[Any] = Kinds(
    {one.name: one for one in ARGUMENTS}
    | {UD.name: RecursiveUD, Covariance.name: RecursiveCovariance},
    default=UD.name,
)
