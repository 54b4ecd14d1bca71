"""What a closed-loop run leaves behind."""

from __future__ import annotations

import math
from dataclasses import dataclass

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import integer
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.engine.compatibility import AnyController
from rcac_numeric.engine.live.changes import AppliedChange
from rcac_numeric.engine.states import SavedState
from rcac_numeric.plants.any_plant import AnyPlant
from rcac_numeric.plants.saturation import Saturation

# How a run may end, in the order of the kernel's numbers.
OUTCOMES = (
    "completed",
    "diverged",
    "overflow",
    "plant not finite",
    "plant failed",
    "unsupported R_theta",
)  # and "weight failed", which the kernel does not tell from "overflow", and "interrupted"


@dataclass(frozen=True, eq=False)
class Run(Value):
    """A closed-loop run and its evidence.

    Attributes
    ----------
    plant, settings : what was asked for.
    w, u, y, z : arrays, shape (steps, width)
        The signals at k = first_step, first_step + 1, ....
    u_applied : array, shape (steps, l_u)
        What the actuator made of u; u itself without saturation.
    theta : array, shape (ceil(steps / stride), l_theta)
        theta[j] made u at step first_step + j * stride.
    theta_final : array, shape (l_theta,)
        The coefficients after the last completed step.
    outcome : str
        "completed"; "diverged" (a signal, a state or a coefficient exceeded the limit);
        "overflow" (the update left the range of float64: with lambda < 1 P grows like lambda^-k in
        directions without excitation, which a `reset` or lambda = 1 prevents); "plant not
        finite"; "plant failed" (a function returned nonzero or raised); "weight failed" (a weight
        that is a function raised or returned no weight); "unsupported R_theta" (an
        update was decided by rounding and the settings ask to stop there); "interrupted" (Ctrl-C).
        The arrays end before the failed step.
    guard_count, guard_first_step : int
        Updates decided by rounding and the first such step (-1: none): for UD, a direction
        that the data excite by no more than their rounding errors while R_theta is so small that
        theta follows them; for Covariance, Upsilon not positive. Not zero: the data cannot
        support this R_theta in this arithmetic.
    reflections, resets : int
        Updates after which poles were reflected (6.2.2), and covariance resets.
    state : SavedState, optional
        From which `simulate` continues bit for bit; None where the run failed.
    failure : str
        What a function of the plant or of a weight raised; empty where none did.
    changes : tuple of AppliedChange
        What was changed in the controller while it ran, and why.
    """

    plant: AnyPlant
    settings: AnyController
    w: Array
    u: Array
    y: Array
    z: Array
    theta: Array
    theta_final: Array
    stride: int
    outcome: str
    guard_count: int
    guard_first_step: int
    u_applied: Array
    reflections: int = 0
    resets: int = 0
    first_step: int = 0
    state: SavedState | None = None
    saturation: Saturation | None = None
    x_0: Array | None = None
    divergence_limit: float = math.inf
    failure: str = ""
    changes: tuple[AppliedChange, ...] = ()

    @property
    def steps(self) -> int:
        """Number of completed steps."""
        return len(self.u)

    @property
    def compensator(self) -> Compensator:
        """The controller after the last completed step."""
        return self.settings.compensator_of(self.theta_final)

    def compensator_at(self, k: int) -> Compensator:
        """The controller that made u(k), for a step at which theta was kept."""
        row, rest = divmod(integer(k, "k") - self.first_step, self.stride)
        if rest or not 0 <= row < len(self.theta):
            raise InputError(
                f"theta({k}) was not kept; it is kept at multiples of {self.stride} below "
                f"{self.steps}."
            )
        return self.settings.compensator_of(self.theta[row])

    def __repr__(self) -> str:
        return f"Run({self.outcome}, steps={self.steps}, {self.plant!r})"
