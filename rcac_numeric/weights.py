"""The weights of the retrospective cost (2.41): constant matrices or functions of the signals."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.validation import Array, matrix, real_array


def constant_weight(value: ArrayLike, name: str, size: int, *, definite: bool) -> Array:
    """A symmetric weight, positive definite or semidefinite; a number means a multiple of I."""
    array = real_array(value, name)
    array = float(array) * np.eye(size) if array.ndim == 0 else matrix(array, name, (size, size))
    if not np.array_equal(array, array.T):
        raise InputError(f"{name} is not symmetric; use ({name} + {name}') / 2.")
    diagonal = np.diag(array)
    is_diagonal = np.array_equal(array, np.diag(diagonal))
    eigenvalues = diagonal if is_diagonal else np.linalg.eigvalsh(array)
    smallest = eigenvalues.min()
    if definite and smallest <= 0:
        raise InputError(f"{name} has the eigenvalue {smallest:.6g}; it must be positive definite.")
    if smallest < -1e-12 * max(abs(eigenvalues.max()), np.finfo(float).tiny):
        raise InputError(
            f"{name} has the eigenvalue {smallest:.6g}; it must be positive semidefinite."
        )
    with np.errstate(over="ignore"):
        invertible = not (definite and is_diagonal) or np.isfinite(1.0 / diagonal).all()
    if not invertible:
        raise InputError(f"{name} = {smallest:.3g} has no float64 inverse; use a larger weight.")
    return real_array(array, name)


def inverse(weight: Array) -> Array:
    """The inverse of a positive definite weight, exactly diagonal where the weight is."""
    diagonal = np.diag(weight)
    if np.array_equal(weight, np.diag(diagonal)):
        return np.diag(1.0 / diagonal)
    return np.ascontiguousarray(np.linalg.inv(weight))


def square_root_columns(weight: Array) -> Array:
    """Columns a_1, a_2, ... with weight = sum a_i a_i'; one column for each unit of rank."""
    diagonal = np.diag(weight)
    if np.array_equal(weight, np.diag(diagonal)):
        columns = np.diag(np.sqrt(diagonal))
        return np.ascontiguousarray(columns[:, diagonal > 0])
    values, vectors = np.linalg.eigh(weight)
    kept = values > len(values) * np.finfo(float).eps * values.max(initial=0.0)
    return np.ascontiguousarray(vectors[:, kept] * np.sqrt(values[kept]))
