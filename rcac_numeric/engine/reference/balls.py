"""Numbers as balls that hold the exact result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from flint import arb, arb_mat
from numpy.typing import ArrayLike

from compensator_theory.errors import DivergedError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.definite_matrices import constant_weight
from rcac_numeric.controllers.normalization import Normalization

T = TypeVar("T")


def held(value: arb, low: float, high: float, k: int) -> arb:
    """`value` moved into [low, high]."""
    if value > high:
        return arb(high)
    if value < low:
        return arb(low)
    if value <= high and value >= low:
        return value
    raise DivergedError(
        f"at step {k} a ball lies across a bound, {low:g} or {high:g}, so that it is not known "
        "whether it is met. Use more digits."
    )


def normalized(value: arb, by: Normalization) -> arb:
    """f(z) of a `Normalization`."""
    x, limit, pi = arb(by.slope) * value, arb(by.limit), arb.pi()
    if by.function == "rational":
        return x / (1 + abs(x) / limit)
    if by.function == "root":
        return x / (1 + (x / limit) ** 2).sqrt()
    if by.function == "arctan":
        return 2 * limit / pi * (pi * x / (2 * limit)).atan()
    if by.function == "tanh":
        return limit * (x / limit).tanh()
    return limit * (pi.sqrt() * x / (2 * limit)).erf()


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
