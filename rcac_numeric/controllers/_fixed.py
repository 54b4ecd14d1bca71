"""Fixed controllers: LQG, a logged controller, or the final controller of RCAC."""

from __future__ import annotations

import attrs
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import integer, reads, real_array, with_checks
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator, compensator_of


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class FixedController(Value):
    """A compensator as a controller that `simulate` runs.

    Parameters
    ----------
    compensator : Compensator, or a transfer function in q
        From y to u, or from [y; r] to u.
    l_r : int
        How many of its inputs, the last ones, are commands.
    k_w : int
        First step with control; u = 0 before. 0 by default.

    Raises
    ------
    InputError
        Where it is no compensator, or has fewer inputs than commands.

    Examples
    --------
    >>> from rcac_numeric import FixedController, WhiteNoise, exogenous, lqg_controller, simulate
    >>> from rcac_numeric import standard_plant
    >>> plant = standard_plant("1/(q - 1.2)")
    >>> w = exogenous([WhiteNoise()], steps=1000)
    >>> run = simulate(plant, FixedController(lqg_controller(plant).compensator), w)
    >>> run.outcome, bool(abs(run.z).max() < 10)
    ('completed', True)
    """

    compensator: Compensator = attrs.field(converter=compensator_of)
    l_r: int = attrs.field(default=0, metadata=reads(integer))
    k_w: int = attrs.field(default=0, metadata=reads(integer))

    def __attrs_post_init__(self) -> None:
        if self.l_r > self.compensator.l_y:
            raise InputError(
                f"the compensator has {self.compensator.l_y} inputs; l_r = {self.l_r} of them "
                "cannot be commands."
            )

    @property
    def l_theta(self) -> int:
        """0: no coefficient is adapted."""
        return 0

    def compensator_of(self, theta: ArrayLike = ()) -> Compensator:
        """Return the compensator; `theta` must be empty."""
        if real_array(theta, "theta").size:
            raise InputError("a fixed controller has no adapted coefficients; pass an empty theta.")
        return self.compensator
