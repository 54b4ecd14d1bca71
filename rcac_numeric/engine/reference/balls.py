"""Numbers as balls that hold the exact result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from flint import arb, arb_mat
from numpy.typing import ArrayLike

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight

T = TypeVar("T")


def balls(values: ArrayLike) -> arb_mat:
    """float64 numbers, taken as exact."""
    array = np.asarray(values, dtype=np.float64)
    return arb_mat(*array.shape, [arb(float(v)) for v in array.ravel()])


def inverse_weight(R_theta: float | Array, l_theta: int) -> arb_mat:
    """P(0) = R_theta^{-1}."""
    return balls(constant_weight(R_theta, "R_theta", l_theta, definite=True)).inv()


def latest(first: T, changes: Mapping[int, T], k: int) -> T:
    """What is in force at step k: the first value, or that of the last change up to k."""
    return [first, *(value for step, value in sorted(changes.items()) if step <= k)][-1]
