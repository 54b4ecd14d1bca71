"""How theta is updated: each update with the settings that it has, and no others.

A new update is a class here, its kernel in kernel/updates, and a line in
`rcac_numeric.engine.compiled.updates`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from inspect import signature
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight
from rcac_numeric.arrays.validation import instance_of, integer, number, real_array
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.rules import (
    CovarianceReset,
    Forgetting,
    ScheduledForgetting,
    VariableRateForgetting,
    forgetting_factor,
)


class Update(Value):
    """An update of the controller coefficients; what `ControllerSettings` takes as `update`."""

    name: ClassVar[str] = ""  # in experiment files, reports and the kernel

    @property
    def keeps_covariance(self) -> bool:
        """Whether a covariance goes from step to step, which a reset can set back."""
        return False

    def require_size(self, l_theta: int) -> None:
        """Raise where a matrix of the update does not fit l_theta coefficients."""

    def __repr__(self) -> str:
        """The settings that differ from their defaults."""
        words = []
        for name, parameter in signature(type(self)).parameters.items():
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                words.append(f"{name}=<{value.shape[0]} x {value.shape[1]}>")
            elif value != parameter.default:
                words.append(f"{name}={value!r}")
        return f"{type(self).__name__}({', '.join(words)})"


@dataclass(frozen=True, eq=False, init=False, repr=False)
class RecursiveLeastSquares(Update):
    """What `UD` and `Covariance` have in common: the settings of the recursion (2.42)-(2.46)."""

    R_theta: float | Array
    lambda_: float | Forgetting
    process_noise: float | Array | None
    reset: CovarianceReset | None
    stop_where_unsupported: bool

    def __init__(
        self,
        R_theta: ArrayLike,
        *,
        lambda_: float | Forgetting = 1.0,
        process_noise: ArrayLike | None = None,
        reset: CovarianceReset | None = None,
        stop_where_unsupported: bool = False,
    ) -> None:
        set_ = partial(object.__setattr__, self)
        set_("R_theta", _weight(R_theta, "R_theta", definite=True))
        if not isinstance(lambda_, ScheduledForgetting | VariableRateForgetting):
            lambda_ = forgetting_factor(lambda_)
        set_("lambda_", lambda_)
        noise = process_noise
        set_("process_noise", None if noise is None else _weight(noise, "process_noise"))
        if noise is not None and lambda_ != 1.0:
            raise InputError("process_noise belongs to (2.46), that is to lambda_ = 1.")
        if reset is not None:
            instance_of(reset, "reset", CovarianceReset)
        set_("reset", reset)
        flag = instance_of(stop_where_unsupported, "stop_where_unsupported", bool)
        set_("stop_where_unsupported", flag)

    @property
    def keeps_covariance(self) -> bool:
        """True: P(k)."""
        return True

    def require_size(self, l_theta: int) -> None:
        """Raise where R_theta or Q does not fit l_theta coefficients."""
        constant_weight(self.R_theta, "R_theta", l_theta, definite=True)
        if self.process_noise is not None:
            constant_weight(self.process_noise, "process_noise", l_theta, definite=False)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class UD(RecursiveLeastSquares):
    """The recursion (2.42)-(2.45) with P = U D U' factorised (Bierman); the one to use.

    It agrees with 250-digit arithmetic to about 1e-13 where the covariance form loses its digits.

    Parameters
    ----------
    R_theta : float or array, shape (l_theta, l_theta)
        Weight of theta - theta(0) in (2.41); P(0) is its inverse. A number stands for that
        multiple of the identity.
    lambda_ : float, ScheduledForgetting or VariableRateForgetting
        Forgetting factor, in (0, 1].
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


@dataclass(frozen=True, eq=False, init=False, repr=False)
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


@dataclass(frozen=True, eq=False, init=False, repr=False)
class SlidingWindow(Update):
    """The batch minimiser over the last `window` updates.

    Their cost is (2.41) with (theta - theta(0))' R_theta (theta - theta(0)), which is not
    forgotten.

    Parameters
    ----------
    R_theta : float or array, shape (l_theta, l_theta)
        Weight of theta - theta(0).
    window : int
        Steps that are remembered, at least 1.
    lambda_ : float
        Forgetting factor inside the window, in (0, 1].

    Raises
    ------
    InputError
        Where R_theta is not positive definite, the window is empty, or lambda is out of range.

    Examples
    --------
    >>> from rcac_numeric import SlidingWindow
    >>> SlidingWindow(R_theta=1.0, window=20)
    SlidingWindow(R_theta=1.0, window=20)
    """

    name = "sliding window"

    R_theta: float | Array
    window: int
    lambda_: float

    def __init__(self, R_theta: ArrayLike, *, window: int, lambda_: float = 1.0) -> None:
        set_ = partial(object.__setattr__, self)
        set_("R_theta", _weight(R_theta, "R_theta", definite=True))
        set_("window", integer(window, "window", at_least=1, at_most=1_000_000))
        set_("lambda_", forgetting_factor(lambda_))

    def require_size(self, l_theta: int) -> None:
        """Raise where R_theta does not fit l_theta coefficients."""
        constant_weight(self.R_theta, "R_theta", l_theta, definite=True)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Instantaneous(Update):
    """The minimiser of one step's cost plus (theta - theta(k))' R_theta (theta - theta(k)).

    Parameters
    ----------
    R_theta : float or array, shape (l_theta, l_theta)
        Weight of theta - theta(k).

    Raises
    ------
    InputError
        Where R_theta is not positive definite.

    Examples
    --------
    >>> from rcac_numeric import Instantaneous
    >>> Instantaneous(R_theta=10.0)
    Instantaneous(R_theta=10.0)
    """

    name = "instantaneous"

    R_theta: float | Array

    def __init__(self, R_theta: ArrayLike) -> None:
        object.__setattr__(self, "R_theta", _weight(R_theta, "R_theta", definite=True))

    def require_size(self, l_theta: int) -> None:
        """Raise where R_theta does not fit l_theta coefficients."""
        constant_weight(self.R_theta, "R_theta", l_theta, definite=True)


@dataclass(frozen=True, eq=False, repr=False)
class Gradient(Update):
    """theta(k+1) = theta(k) - step_size Phi_f' [R_z zhat + R_u Phi_f theta(k)].

    Half the gradient of the cost of one step, without R_theta.

    Parameters
    ----------
    step_size : float
        Positive.

    Raises
    ------
    InputError
        Where the step size is not positive.

    Examples
    --------
    >>> from rcac_numeric import Gradient
    >>> Gradient(step_size=1e-3)
    Gradient(step_size=0.001)
    """

    name = "gradient"

    step_size: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "step_size", number(self.step_size, "step_size"))
        if self.step_size <= 0:
            raise InputError(f"step_size = {self.step_size} must be positive.")


def _weight(value: ArrayLike, name: str, *, definite: bool = False) -> float | Array:
    """A weight as a number or a symmetric matrix, checked before its size is known."""
    array = real_array(value, name)
    size = len(array) if array.ndim else 1
    checked = constant_weight(array, name, size, definite=definite)
    return checked if array.ndim else float(array)
