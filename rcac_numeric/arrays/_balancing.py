"""Scales of the states that make rows and columns of a matrix similar in size."""

from __future__ import annotations

import numpy as np
from scipy.linalg import matrix_balance

from rcac_numeric.arrays._array_types import Array


def balancing_scales(A: Array) -> Array:
    """Return powers of two s for which A[i, j] s[j] / s[i] is balanced; A must be finite.

    Examples
    --------
    >>> from rcac_numeric.arrays._balancing import balancing_scales, scaled_states
    >>> A = np.array([[1.0, 2.0**140], [2.0**-140, 1.0]])
    >>> sizes = scaled_states(A, balancing_scales(A))
    >>> bool(sizes.min() >= 0.5 and sizes.max() <= 2)
    True
    """
    with np.errstate(invalid="ignore"):  # SciPy makes indices of the scales, of 1e20 too
        _, (scale, _) = matrix_balance(A, permute=False, separate=True)
    return np.asarray(scale)


def scaled_states(A: Array, scale: Array) -> Array:
    """Return A[i, j] s[j] / s[i] by exponents: no product of two numbers leaves float64."""
    powers = np.rint(np.log2(scale)).astype(int)
    return np.asarray(np.ldexp(A, powers - powers[:, None]))
