"""Discrete nonlinear systems of python-control as plants made of functions."""

from __future__ import annotations

from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.plants.functions import FunctionPlant


def is_nonlinear(system: Any) -> bool:
    """Whether it is a system of python-control that is given by functions alone.

    Examples
    --------
    >>> import control
    >>> from rcac_numeric.plants.foreign.nonlinear import is_nonlinear
    >>> is_nonlinear(control.ss([[0.5]], [[1]], [[1]], [[0]], 1))
    False
    """
    is_control = type(system).__module__.split(".")[0] == "control"
    return is_control and hasattr(system, "dynamics") and not hasattr(system, "A")


def plant_of_nonlinear(system: Any, sample_time: float | None) -> FunctionPlant:
    """A discrete `nlsys`, or nonlinear `interconnect`, with w added to its inputs and y = z.

    Raises
    ------
    InputError
        Where it is in continuous time, has no dimensions, or its output depends on its input at
        once: the controller reads y(k) before u(k) is known.
    """
    kind = type(system).__name__
    if sample_time is not None or not system.isdtime(strict=True):
        raise InputError(
            f"this {kind} is nonlinear and cannot be sampled here; write its update for one step, "
            "control.nlsys(update, output, dt=0.01), and leave sample_time out."
        )
    n, l_u, l_y = system.nstates, system.ninputs, system.noutputs
    if not (l_u and l_y) or n is None:
        raise InputError(f"this {kind} does not say its inputs, outputs and states; name them.")
    period = 1.0 if system.dt is True else float(system.dt)
    plant = FunctionPlant(
        advance=Advance(system, period), output=Output(system, period),
        n=max(n, 1), l_u=l_u, l_w=l_u, l_y=l_y, l_z=l_y,
    )  # fmt: skip
    rng = np.random.default_rng(0)
    x = rng.standard_normal(n)
    at_rest = np.ravel(system.output(0.0, x, np.zeros(l_u)))
    if not np.array_equal(at_rest, np.ravel(system.output(0.0, x, rng.standard_normal(l_u)))):
        raise InputError(
            f"the output of this {kind} depends on its input at once; put one step of delay at its "
            "input."
        )
    return plant


class Advance:
    """The state at the next step: f(t, x, u + w)."""

    def __init__(self, system: Any, period: float) -> None:
        self.system, self.period = system, period

    def __call__(self, k: int, x: Array, u: Array, w: Array) -> Array:
        """Return x(k+1)."""
        return np.ravel(self.system.dynamics(k * self.period, x, u + w))


class Output:
    """The measurement, which is the performance variable too."""

    def __init__(self, system: Any, period: float) -> None:
        self.system, self.period = system, period

    def __call__(self, k: int, x: Array, w: Array) -> tuple[Array, Array]:
        """Return y(k) and z(k)."""
        y = np.ravel(self.system.output(k * self.period, x, np.zeros(self.system.ninputs)))
        return y, y
