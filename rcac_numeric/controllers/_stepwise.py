"""Interface of controllers with Python steps."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import singledispatch
from typing import NoReturn, Protocol

from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Value


class Stepper(Protocol):
    """Protocol of a running controller."""

    @property
    def k(self) -> int:
        """Number of completed steps."""

    @property
    def theta(self) -> Array:
        """The parameters of the last u, shape (l_theta,)."""

    def step(self, y: Array, r: Array) -> Array:
        """u(k), shape (l_u,), from y(k) and the command."""

    def save(self) -> Array:
        """Return the state as a one-dimensional array."""

    def take_up(self, values: Array) -> None:
        """Restore the state that `save` returned; raise ValueError for another size."""


@singledispatch
def stepper_of(settings: StepwiseController) -> Stepper:
    """Return the controller at step 0; registered where steps need what the settings do not."""
    return settings.started()


class StepwiseController(Value, ABC):
    """Base class of controllers as data whose steps `simulate` runs in Python."""

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
        """Number of adapted parameters."""

    def started(self) -> Stepper:
        """Return the controller at step 0, for `stepper_of`."""
        raise NotImplementedError

    def compensator_of(self, theta: ArrayLike) -> NoReturn:
        """Raise: the gains depend on more than theta."""
        raise InputError(
            f"a {type(self).__name__} is no compensator of its theta alone: its gains come from "
            "Riccati matrices that have a state. Look at u, z and theta of the run."
        )
