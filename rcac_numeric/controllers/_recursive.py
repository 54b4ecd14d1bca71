"""Recursive least squares, factorised and as printed."""

from __future__ import annotations

import attrs

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import instance_of, reads, with_checks
from rcac_numeric.controllers._forgetting import (
    CappedForgetting,
    Forgetting,
    SubspaceForgetting,
    forgetting_factor,
)
from rcac_numeric.controllers._resets import CovarianceReset
from rcac_numeric.controllers._update import (
    DEFINITE,
    Update,
    optional_weight_like,
    weight,
    weight_like,
)


def _factor_or_rule(value: float | Forgetting, name: str) -> float | Forgetting:
    return value if isinstance(value, Forgetting) else forgetting_factor(value, name)


@attrs.frozen(eq=False, repr=False, slots=False, field_transformer=with_checks)
class RecursiveLeastSquares(Update):
    """Base class of `UD` and `Covariance`: settings of the recursion (2.42)-(2.46)."""

    R_theta: float | Array = attrs.field(converter=weight_like, metadata=DEFINITE)
    lambda_: float | Forgetting = attrs.field(
        default=1.0, kw_only=True, metadata=reads(_factor_or_rule)
    )
    process_noise: float | Array | None = attrs.field(
        default=None, kw_only=True, converter=optional_weight_like,
        metadata=reads(weight, optional=True),
    )  # fmt: skip
    reset: CovarianceReset | None = attrs.field(
        default=None, kw_only=True, metadata=reads(instance_of, optional=True, kind=CovarianceReset)
    )
    stop_where_unsupported: bool = attrs.field(
        default=False, kw_only=True, metadata=reads(instance_of, kind=bool)
    )

    def __attrs_post_init__(self) -> None:
        on_factors = isinstance(self.lambda_, SubspaceForgetting | CappedForgetting)
        if on_factors and not isinstance(self, UD):
            name = type(self.lambda_).__name__
            raise InputError(f"{name} works on the factors of P = U D U'; use UD.")
        if self.process_noise is not None and self.lambda_ != 1.0:
            raise InputError("process_noise belongs to (2.46), that is to lambda_ = 1.")

    @property
    def keeps_covariance(self) -> bool:
        """True: P(k) goes from step to step."""
        return True

    def require_size(self, l_theta: int) -> None:
        """Raise where R_theta or Q does not fit l_theta coefficients."""
        constant_weight(self.R_theta, "R_theta", l_theta, definite=True)
        if self.process_noise is not None:
            constant_weight(self.process_noise, "process_noise", l_theta, definite=False)


@attrs.frozen(eq=False, repr=False, slots=False, field_transformer=with_checks)
class UD(RecursiveLeastSquares):
    """The recursion (2.42)-(2.45) with P = U D U' factorised (Bierman); the one to use.

    It agrees with 250-digit arithmetic to about 1e-13 where the covariance form loses its digits,
    in every direction of theta that the data excite. In the others, such as those of inputs that
    act on z alike, each step moves theta by some eps/R_theta of the error, and `loop_health` says
    how far that went.

    Parameters
    ----------
    R_theta : float, array of shape (l_theta, l_theta), or PriorSamples
        Weight of theta - theta(0) in (2.41); P(0) is its inverse. A number stands for that
        multiple of the identity, and is in the units of z, u and y; `PriorSamples` is not. No
        value is right for all plants, so none is the default: `design` makes one of a model or a
        log, `cold_start` of what else is known.
    lambda_ : float, or a Forgetting
        Forgetting factor, in (0, 1]; or ScheduledForgetting, VariableRateForgetting,
        SubspaceForgetting, CappedForgetting. With a number below 1 P grows without bound while the
        data are poor, and the next disturbance meets a gain that no data support; with
        `CappedForgetting` and `SubspaceForgetting` it does not.
    process_noise : float or array, shape (l_theta, l_theta), optional
        Q of (2.46), added to P after every update; with lambda = 1.
    reset : CovarianceReset, optional
        When P is set back to P(0).
    stop_where_unsupported : bool
        End the run at the first update that rounding decides (see `Run.guard_count`).

    Raises
    ------
    InputError
        Where R_theta is not positive definite, lambda is not in (0, 1], or process noise meets
        forgetting.

    Examples
    --------
    >>> from rcac_numeric import UD
    >>> UD(R_theta=1e-6)
    UD(R_theta=1e-06)
    >>> UD(R_theta=0.2, lambda_=0.999).lambda_
    0.999
    """

    name = "ud"


@attrs.frozen(eq=False, repr=False, slots=False, field_transformer=with_checks)
class Covariance(RecursiveLeastSquares):
    """The recursion (2.42)-(2.45) with P as printed, which is what published work ran.

    Rounding makes P indefinite for R_theta of about 1e-14 and less, which acts as a hidden
    covariance reset (docs/arithmetic.md). Parameters and errors are those of `UD`.

    Parameters
    ----------
    R_theta : float or array, shape (l_theta, l_theta)
        Weight of theta - theta(0) in (2.41); P(0) is its inverse.
    lambda_ : float, ScheduledForgetting or VariableRateForgetting
        Forgetting factor, in (0, 1].
    process_noise : float or array, shape (l_theta, l_theta), optional
        Q of (2.46), added to P after every update; with lambda = 1.
    reset : CovarianceReset, optional
        When P is set back to P(0).
    stop_where_unsupported : bool
        End the run at the first update that rounding decides (see `Run.guard_count`).

    Examples
    --------
    >>> from rcac_numeric import Covariance
    >>> Covariance(R_theta=1e-20)
    Covariance(R_theta=1e-20)
    """

    name = "covariance"
