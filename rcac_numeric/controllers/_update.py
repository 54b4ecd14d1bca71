"""What every update of the controller coefficients is."""

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
    """An update of the controller coefficients; what `ControllerSettings` takes as `update`."""

    name: ClassVar[str] = ""  # in experiment files, reports and the kernel

    @property
    def keeps_covariance(self) -> bool:
        """Whether a covariance goes from step to step, which a reset can set back."""
        return False

    def require_size(self, l_theta: int) -> None:
        """Raise where a matrix of the update does not fit l_theta coefficients."""

    def require_problem(self, targets: Sequence[TargetModel], n_c: int, penalises: bool) -> None:
        """Raise where the update is not for these target models, n_c, or a weight R_u."""

    def __repr__(self) -> str:
        """The settings that differ from their defaults."""
        words = []
        for name, parameter in signature(type(self)).parameters.items():
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                words.append(f"{name}=<{value.shape[0]} x {value.shape[1]}>")
            elif value != parameter.default:
                words.append(f"{name}={value!r}")
        return f"{type(self).__name__}({', '.join(words)})"


def weight(value: ArrayLike | PriorSamples, name: str, *, definite: bool = False) -> float | Array:
    """A weight as a number or a symmetric matrix, checked before its size is known.

    R_theta may be a `PriorSamples` until `ControllerSettings` puts the matrix in its place.
    """
    if isinstance(value, PriorSamples):
        if definite:
            return cast(float, value)
        raise InputError(f"{name}: PriorSamples stands in the place of R_theta alone.")
    array = real_array(value, name)
    size = len(array) if array.ndim else 1
    checked = constant_weight(array, name, size, definite=definite)
    return checked if array.ndim else float(array)


def weight_like(value: ArrayLike | PriorSamples) -> float | Array:
    """What a field takes that `weight` reads; for type checkers."""
    return cast(float, value)


def optional_weight_like(value: ArrayLike | None) -> float | Array | None:
    """The same of a field that may be None."""
    return cast(float, value)


DEFINITE = reads(weight, definite=True)
