"""A model that is two functions of the user."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    integer,
    optional_array_like,
    reads,
    real_array,
    with_checks,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.estimation._any_model import places_of_angles

Function = Callable[..., ArrayLike]


def _function(value: object, name: str) -> object:
    if not callable(value):
        raise InputError(f"{name} = {value!r} is not a function.")
    return value


OPTIONAL = reads(_function, optional=True)


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class NonlinearModel(Value):
    """x(k+1) = dynamics(k, x, u) + noise and y(k) = output(k, x, u) + noise, as Python functions.

    With `l_p` unknown parameters the functions take (k, x, u, p), and [x; p] is estimated
    jointly: p(k+1) = p(k) + noise, the chapter's fictitious dynamics.

    Parameters
    ----------
    dynamics : callable
        Returns x(k+1), shape (n_x,).
    output : callable
        Returns y(k), shape (l_y,).
    n_x, l_y : int
        Numbers of states and of measurements.
    l_u : int
        Number of known inputs.
    l_p : int
        Number of unknown parameters.
    dynamics_jacobian, output_jacobian : callable, optional
        Of the same arguments: the derivatives with respect to [x; p], shapes (n_x, n_x + l_p) and
        (l_y, n_x + l_p). Central differences without them.
    scale : array, shape (n_x + l_p,), optional
        How large the entries of [x; p] typically are, for the steps of the differences; 1 by
        default.
    angles : sequence of int
        Which measurements are angles, in radians: their innovations go the shorter way round.
    residual : callable, optional
        Of (y, expected), in place of y - expected, shape (l_y,): how far a measurement is from what
        was expected of it, where that is no difference.

    Raises
    ------
    InputError
        Where a function is none, a size is negative, or a scale is not positive.

    Examples
    --------
    >>> from rcac_numeric.estimation import EKF, NonlinearModel, estimate
    >>> model = NonlinearModel(  # x(k+1) = p x(k) + u(k) with an unknown p
    ...     lambda k, x, u, p: p * x + u, lambda k, x, u, p: x, n_x=1, l_y=1, l_u=1, l_p=1)
    >>> x, y = 0.0, []
    >>> for k in range(100):
    ...     y.append(x)
    ...     x = 0.7 * x + (-1) ** (k // 3)
    >>> u = [(-1) ** (k // 3) for k in range(100)]
    >>> estimates = estimate(EKF(model, Q=1e-9, R=1e-6), y=y, u=u)
    >>> round(float(estimates.x[-1, 1]), 4)
    0.7
    """

    dynamics: Function = attrs.field(metadata=reads(_function))
    output: Function = attrs.field(metadata=reads(_function))
    n_x: int = attrs.field(metadata=reads(integer, at_least=1))
    l_y: int = attrs.field(metadata=reads(integer, at_least=1))
    l_u: int = attrs.field(default=0, metadata=reads(integer))
    l_p: int = attrs.field(default=0, metadata=reads(integer))
    dynamics_jacobian: Function | None = attrs.field(default=None, metadata=OPTIONAL)
    output_jacobian: Function | None = attrs.field(default=None, metadata=OPTIONAL)
    scale: Array = attrs.field(default=None, converter=optional_array_like)
    angles: Sequence[int] = ()
    residual: Function | None = attrs.field(default=None, metadata=OPTIONAL)

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        size = self.n_x + self.l_p
        scale = np.ones(size) if self.scale is None else self.scale
        set_("scale", real_array(scale, "scale").reshape(-1))
        if self.scale.size != size or (self.scale <= 0).any():
            raise InputError(
                f"scale = {self.scale} must hold {size} positive numbers, one per entry."
            )
        set_("angles", places_of_angles(self.angles, self.l_y))
        if self.angles and self.residual is not None:
            raise InputError("give angles or a residual: the residual says how angles differ.")

    @property
    def n(self) -> int:
        """Number of entries of [x; p]."""
        return self.n_x + self.l_p

    @property
    def names(self) -> tuple[str, ...]:
        """x[0], x[1], ... and p[0], ..."""
        states = tuple(f"x[{i}]" for i in range(self.n_x))
        return states + tuple(f"p[{i}]" for i in range(self.l_p))

    def joint_dynamics(self, k: int, x: Array, u: Array) -> ArrayLike:
        """[x(k+1); p] from [x(k); p]."""
        if not self.l_p:
            return self.dynamics(k, x, u)
        state, parameters = x[: self.n_x], x[self.n_x :]
        return np.append(np.asarray(self.dynamics(k, state, u, parameters), float), parameters)

    def joint_output(self, k: int, x: Array, u: Array) -> ArrayLike:
        """y(k) from [x(k); p]."""
        if not self.l_p:
            return self.output(k, x, u)
        return self.output(k, x[: self.n_x], u, x[self.n_x :])

    def joint_dynamics_jacobian(self, k: int, x: Array, u: Array) -> ArrayLike:
        """The derivative of `joint_dynamics`, where one was given."""
        if self.dynamics_jacobian is None:
            raise InputError("this model has no dynamics_jacobian.")
        if not self.l_p:
            return self.dynamics_jacobian(k, x, u)
        upper = self.dynamics_jacobian(k, x[: self.n_x], u, x[self.n_x :])
        lower = np.eye(self.n)[self.n_x :]
        return np.vstack([np.asarray(upper, float), lower])

    def joint_output_jacobian(self, k: int, x: Array, u: Array) -> ArrayLike:
        """The derivative of `joint_output`, where one was given."""
        if self.output_jacobian is None:
            raise InputError("this model has no output_jacobian.")
        if not self.l_p:
            return self.output_jacobian(k, x, u)
        return self.output_jacobian(k, x[: self.n_x], u, x[self.n_x :])
