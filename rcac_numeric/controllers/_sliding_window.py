"""The batch minimiser over the last steps."""

from __future__ import annotations

import attrs

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import integer, reads, with_checks
from rcac_numeric.controllers._forgetting import forgetting_factor
from rcac_numeric.controllers._update import DEFINITE, Update, weight_like


@attrs.frozen(eq=False, repr=False, slots=False, field_transformer=with_checks)
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

    R_theta: float | Array = attrs.field(converter=weight_like, metadata=DEFINITE)
    window: int = attrs.field(kw_only=True, metadata=reads(integer, at_least=1, at_most=1_000_000))
    lambda_: float = attrs.field(default=1.0, kw_only=True, metadata=reads(forgetting_factor))

    def require_size(self, l_theta: int) -> None:
        """Raise where R_theta does not fit l_theta coefficients."""
        constant_weight(self.R_theta, "R_theta", l_theta, definite=True)
