"""Controllers whose steps are Python, and what they say of themselves for `simulate`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NoReturn, Protocol

from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Value


class Stepper(Protocol):
    """A controller that is at work."""

    @property
    def k(self) -> int:
        """Number of steps taken."""

    @property
    def theta(self) -> Array:
        """The parameters that made the last u, shape (l_theta,)."""

    def step(self, y: Array, r: Array) -> Array:
        """u(k), shape (l_u,), from y(k) and the command."""

    def save(self) -> Array:
        """Every number of its state, in one dimension."""

    def take_up(self, values: Array) -> None:
        """Go on from what `save` gave; ValueError where that is something else."""


class StepwiseController(Value, ABC):
    """A controller as data that is not compiled; `simulate` runs it, one step of Python each."""

    @property
    @abstractmethod
    def l_u(self) -> int:
        """Number of controls."""

    @property
    @abstractmethod
    def l_y(self) -> int:
        """Number of measurements."""

    @property
    @abstractmethod
    def l_r(self) -> int:
        """Number of commands."""

    @property
    @abstractmethod
    def l_theta(self) -> int:
        """Number of parameters that it adapts."""

    @abstractmethod
    def started(self) -> Stepper:
        """The controller at step 0."""

    def compensator_of(self, theta: ArrayLike) -> NoReturn:
        """Refused: its gains depend on more than theta."""
        raise InputError(
            f"a {type(self).__name__} is no compensator of its theta alone: its gains come from "
            "Riccati matrices that have a state. Look at u, z and theta of the run."
        )
