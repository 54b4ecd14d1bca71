"""Interface of the updates of the controller coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from inspect import signature
from typing import ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._definite_matrices import constant_weight
from rcac_numeric.arrays._validation import reads, real_array
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._prior import PriorSamples
from rcac_numeric.targets._model import TargetModel


class Update(Value):
    """Base class of updates; the type of `ControllerSettings.update`."""

    name: ClassVar[str] = ""  # name in experiment files, reports and the kernel

    @property
    def keeps_covariance(self) -> bool:
        """Whether the update has a covariance that a reset can set back."""
        return False

    def require_size(self, l_theta: int) -> None:
        """Raise if a matrix of the update does not fit l_theta coefficients."""

    def require_problem(self, targets: Sequence[TargetModel], n_c: int, penalises: bool) -> None:
        """Raise if the update does not support these target models, n_c, or R_u."""

    def __repr__(self) -> str:
        """Return a repr with the settings that differ from their defaults."""
        words = []
        for name, parameter in signature(type(self)).parameters.items():
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                words.append(f"{name}=<{value.shape[0]} x {value.shape[1]}>")
            elif value != parameter.default:
                words.append(f"{name}={value!r}")
        return f"{type(self).__name__}({', '.join(words)})"


def weight(value: ArrayLike | PriorSamples, name: str, *, definite: bool = False) -> float | Array:
    """Converter: return a weight as a number or a symmetric matrix, of any size.

    R_theta may be a `PriorSamples` until `ControllerSettings` puts the matrix in its place.
    """
    if isinstance(value, PriorSamples):
        if definite:
            return cast(float, value)
        raise InputError(f"{name}: PriorSamples stands in place of R_theta alone.")
    array = real_array(value, name)
    size = len(array) if array.ndim else 1
    checked = constant_weight(array, name, size, definite=definite)
    return checked if array.ndim else float(array)


def weight_like(value: ArrayLike | PriorSamples) -> float | Array:
    """Typing stub: argument type of a weight."""
    return cast(float, value)


def optional_weight_like(value: ArrayLike | None) -> float | Array | None:
    """Typing stub: argument type of a weight that may be None."""
    return cast(float, value)


DEFINITE = reads(weight, definite=True)
