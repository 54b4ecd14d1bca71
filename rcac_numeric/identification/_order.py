"""The order of a model from the singular values of a Hankel matrix."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer


def hankel_matrix(parameters: Array, first: int, rows: int, columns: int) -> Array:
    """The block Hankel matrix [H_(first + i + j)]."""
    blocks = [[parameters[first + i + j] for j in range(columns)] for i in range(rows)]
    return np.asarray(np.block(blocks), dtype=np.float64)


def order_from_singular_values(
    H: Array, error: Array, order: int | None = None
) -> tuple[int, Array]:
    """The order from the Hankel matrix of H_1, H_2, ..., and its singular values.

    n = number of singular values above the Frobenius norm of the matrix of standard errors
    """
    if len(H) < 3:
        raise InputError(
            f"there are {len(H)} Markov parameters; at least H_0, H_1, H_2 are needed."
        )
    rows = len(H) // 2
    columns = len(H) - 1 - rows
    K = hankel_matrix(H, 1, rows, columns)
    size: Array = np.asarray(np.linalg.svd(K, compute_uv=False), dtype=np.float64)
    if order is not None:
        n = integer(order, "order")
        if n > size.size:
            raise InputError(
                f"order = {n}, but {len(H)} Markov parameters give a Hankel matrix of rank "
                f"{size.size} at most. Estimate more of them: a larger mu."
            )
        if n and size[n - 1] == 0:
            raise InputError(
                f"order = {n}, but the Hankel matrix has rank {np.count_nonzero(size)}; lower it."
            )
        return n, size
    largest = float(np.abs(H).max())
    errors = np.maximum(error, np.finfo(float).eps * largest * max(K.shape))
    unit = largest or 1.0  # squares of very large or small numbers leave float64
    threshold = unit * float(np.linalg.norm(hankel_matrix(errors / unit, 1, rows, columns)))
    return int((size > threshold).sum()), size
