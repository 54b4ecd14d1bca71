"""The weights of the retrospective cost (2.41): constant matrices or functions of the signals."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import matrix, real_array

LARGEST = np.finfo(float).max


def constant_weight(value: ArrayLike, name: str, size: int, *, definite: bool) -> Array:
    """Return a symmetric positive (semi)definite weight; a number means a multiple of I."""
    array = real_array(value, name)
    multiple = float(array) if array.ndim == 0 else -1.0
    # A nonnegative scalar needs no further check.
    if multiple > 1 / LARGEST or (multiple == 0 and not definite):
        return real_array(multiple * np.eye(size), name)
    array = float(array) * np.eye(size) if array.ndim == 0 else matrix(array, name, (size, size))
    if not np.array_equal(array, array.T):
        raise InputError(f"{name} is not symmetric; use ({name} + {name}') / 2.")
    diagonal = np.diag(array)
    is_diagonal = np.array_equal(array, np.diag(diagonal))
    if definite and not is_diagonal and diagonal.min() > 0:
        _require_definite_in_float64(array, name)
        smallest = diagonal.min()
    else:
        eigenvalues = diagonal if is_diagonal else np.linalg.eigvalsh(array)
        smallest = eigenvalues.min()
        if definite and smallest <= 0:
            raise _indefinite(name, smallest)
        if smallest < -1e-12 * max(abs(eigenvalues.max()), np.finfo(float).tiny):
            raise InputError(
                f"{name} has the eigenvalue {smallest:.6g}; it must be positive semidefinite."
            )
    with np.errstate(over="ignore"):
        invertible = not definite or np.isfinite(inverse(array)).all()
    if not invertible:
        raise InputError(f"{name} = {smallest:.3g} has no float64 inverse; use a larger weight.")
    return real_array(array, name)


def full_weight(weight: float | Array, size: int) -> Array:
    """Return a checked weight as a full matrix."""
    return weight if isinstance(weight, np.ndarray) else weight * np.eye(size)


def inverse(weight: Array) -> Array:
    """Return the inverse of a positive definite weight; exactly diagonal for a diagonal weight."""
    diagonal = np.diag(weight)
    if np.array_equal(weight, np.diag(diagonal)):
        return np.diag(1.0 / diagonal)
    scale = 1.0 / np.sqrt(diagonal)
    inverted = np.linalg.inv(weight * scale * scale[:, None]) * scale * scale[:, None]
    return np.ascontiguousarray((inverted + inverted.T) / 2)


def _indefinite(name: str, eigenvalue: float) -> InputError:
    return InputError(f"{name} has the eigenvalue {eigenvalue:.6g}; it must be positive definite.")


def _require_definite_in_float64(weight: Array, name: str) -> None:
    """Raise if the weight is singular to working precision.

    The test scales to a unit diagonal, which is exact: a graded weight such as
    diag(1, 1e-20) is far from singular.
    """
    scale = 1.0 / np.sqrt(np.diag(weight))
    smallest = float(np.linalg.eigvalsh(weight * scale * scale[:, None]).min())
    rounding = 16 * len(weight) * np.finfo(float).eps
    if smallest < -rounding:
        raise _indefinite(name, np.linalg.eigvalsh(weight).min())
    if smallest <= rounding:
        raise InputError(
            f"{name} is singular to working precision in float64: scaled to a unit diagonal "
            f"its smallest eigenvalue is {smallest:.1e}. Use a better conditioned one, such as "
            f"{name} plus a small multiple of the identity."
        )


def square_root_columns(weight: Array) -> Array:
    """Return columns a_1, a_2, ... with weight = sum a_i a_i', one for each unit of rank."""
    diagonal = np.diag(weight)
    if np.array_equal(weight, np.diag(diagonal)):
        columns = np.diag(np.sqrt(diagonal))
        return np.ascontiguousarray(columns[:, diagonal > 0])
    values, vectors = np.linalg.eigh(weight)
    positive = values > len(values) * np.finfo(float).eps * values.max(initial=0.0)
    return np.ascontiguousarray(vectors[:, positive] * np.sqrt(values[positive]))
