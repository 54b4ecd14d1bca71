"""Updates from the cost of the current step only."""

from __future__ import annotations

import attrs

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import number, reads, with_checks
from rcac_numeric.controllers._update import DEFINITE, Update, weight_like


@attrs.frozen(eq=False, repr=False, slots=False, field_transformer=with_checks)
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

    R_theta: float | Array = attrs.field(converter=weight_like, metadata=DEFINITE)

    def require_size(self, l_theta: int) -> None:
        """Raise where R_theta does not fit l_theta coefficients."""
        constant_weight(self.R_theta, "R_theta", l_theta, definite=True)


@attrs.frozen(eq=False, repr=False, slots=False, field_transformer=with_checks)
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

    step_size: float = attrs.field(metadata=reads(number))

    def __attrs_post_init__(self) -> None:
        if self.step_size <= 0:
            raise InputError(f"step_size = {self.step_size} must be positive.")
