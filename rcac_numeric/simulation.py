"""The closed loop at full speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import ImproperError, InputError
from rcac_numeric import _kernel
from rcac_numeric.compensators import Compensator
from rcac_numeric.controller_settings import ControllerSettings
from rcac_numeric.plants import Plant
from rcac_numeric.validation import Array, integer, number, signal_array


@dataclass(frozen=True, eq=False)
class Run:
    """A closed-loop run and its evidence.

    Attributes
    ----------
    plant, settings : what was asked for.
    w, u, y, z : arrays, shape (steps, width)
        The signals at k = 0, ..., steps-1.
    theta : array, shape (ceil(steps / stride), l_theta)
        theta[j] made u(j * stride).
    theta_final : array, shape (l_theta,)
        The coefficients after the last completed step.
    outcome : {"completed", "diverged"}
        Where a loop diverged, the arrays end before the failed step.
    guard_count, guard_first_step : int
        Updates decided by rounding and the first such step (-1: none): for "ud", a direction
        that the data excite by no more than their rounding errors while R_theta is so small that
        theta follows them; for "covariance", Upsilon not positive. Not zero: the data cannot
        support this R_theta in this arithmetic.
    """

    plant: Plant
    settings: ControllerSettings
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

    @property
    def steps(self) -> int:
        """Number of completed steps."""
        return len(self.u)

    @property
    def compensator(self) -> Compensator:
        """The controller after the last completed step."""
        return self.settings.structure.compensator(self.theta_final)

    def compensator_at(self, k: int) -> Compensator:
        """The controller that made u(k), for k a multiple of the stride."""
        row, rest = divmod(integer(k, "k"), self.stride)
        if rest or row >= len(self.theta):
            raise InputError(
                f"theta({k}) was not kept; it is kept at multiples of {self.stride} below "
                f"{self.steps}."
            )
        return self.settings.structure.compensator(self.theta[row])

    def __repr__(self) -> str:
        return f"Run({self.outcome}, steps={self.steps}, {self.plant!r})"


def simulate(
    plant: Plant,
    settings: ControllerSettings,
    w: ArrayLike,
    *,
    x_0: Array | None = None,
    stride: int = 1,
    divergence_limit: float = 1e100,
) -> Run:
    """Run a controller on a plant.

    Parameters
    ----------
    plant : Plant
    settings : ControllerSettings
    w : array, shape (steps, l_w)
        The exogenous input; its length is the number of steps.
    x_0 : array, shape (n,), optional
        Initial state; zero by default.
    stride : int
        theta is kept at every stride-th step.
    divergence_limit : float
        The loop counts as diverged where an entry of u, y, z, x or theta exceeds it in size.

    Raises
    ------
    InputError
        Where sizes do not fit.
    ImproperError
        Where u(k) and y(k) depend on each other.

    Examples
    --------
    >>> from rcac_numeric import *
    >>> plant = servo_plant("(q - 0.85)/((q - 0.8)*(q - 0.9))")
    >>> settings = ControllerSettings(structure=iir(n_c=3), target=fir_target(plant), R_theta=0.2)
    >>> run = simulate(plant, settings, exogenous([step(), step(0), step(0)], steps=1000))
    >>> run
    Run(completed, steps=1000, Plant(n=2, l_u=1, l_w=3, l_y=1, l_z=1))
    >>> bool(abs(run.z[-1, 0]) < 0.01)
    True
    """
    w = signal_array(w, "w", plant.l_w)
    check_sizes(plant, settings)
    steps, stride = len(w), integer(stride, "stride", at_least=1)
    limit = number(divergence_limit, "divergence_limit")
    if limit <= 0:
        raise InputError(f"divergence_limit = {limit} must be positive.")
    controller = settings.kernel()
    u, y, z = (np.empty((steps, width)) for width in (plant.l_u, plant.l_y, plant.l_z))
    theta = np.empty((-(-steps // stride), settings.structure.l_theta))
    done = _kernel.simulate(controller, plant.simulator(x_0), w, limit, u, y, z, theta, stride)
    last = len(theta) if done == steps else done // stride + 1
    final = np.asarray(controller.theta)
    return Run(
        plant=plant,
        settings=settings,
        w=w[:done],
        u=u[:done],
        y=y[:done],
        z=z[:done],
        theta=theta[: min(last, -(-done // stride))],
        theta_final=final if done == steps else theta[last - 1].copy(),
        stride=stride,
        outcome="completed" if done == steps else "diverged",
        guard_count=controller.guard_count,
        guard_first_step=controller.guard_first_step,
    )


def check_sizes(plant: Plant, settings: ControllerSettings) -> None:
    """Raise where a plant and a controller do not fit together."""
    structure, target = settings.structure, settings.target
    pairs = {
        "l_u": (plant.l_u, structure.l_u),
        "l_y": (plant.l_y, structure.l_y),
        "l_z": (plant.l_z, target.l_z),
    }
    for name, (of_plant, of_controller) in pairs.items():
        if of_plant != of_controller:
            raise InputError(
                f"the plant has {name} = {of_plant} and the controller {name} = {of_controller}."
            )
    if structure.measures_first and np.any(plant.D_0):
        raise ImproperError(
            "the controller is exactly proper (k_c = 0) and D_0 is not zero, so u(k) and y(k) "
            "depend on each other. Use k_c = 1."
        )
