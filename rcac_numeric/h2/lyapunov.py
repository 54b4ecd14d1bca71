"""The discrete-time Lyapunov equation of a stable matrix, by doubling."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays.array_types import Array


def stein_solution(A: Array, Q: Array) -> Array:
    """X = A X A' + Q, as the sum of A^k Q A'^k, for a spectral radius below 1.

    Each step doubles the number of terms, X <- X + F X F' and F <- F F. Unlike a linear solve it
    keeps a positive semidefinite X so, and the relative accuracy of badly scaled entries; where
    the sum leaves float64 its entries are infinite or NaN, for the caller to refuse.

    Parameters
    ----------
    A, Q : arrays of shape (n, n)
        Q symmetric.

    Notes
    -----
    Source: (4.23); R. A. Smith, SIAM J. Appl. Math. 16 (1968) 198-201.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.h2.lyapunov import stein_solution
    >>> stein_solution(np.array([[0.6]]), np.array([[1.0]]))  # 1 / (1 - 0.36)
    array([[1.5625]])
    """
    X, power = np.array(Q, dtype=np.float64), np.array(A, dtype=np.float64)
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        for _ in range(64):  # 2^64 terms: more than any spectral radius in float64 asks for
            added = power @ X @ power.T
            X = X + (added + added.T) / 2
            if not np.abs(added).max(initial=0.0) > 1e-18 * np.abs(X).max(initial=0.0):
                break
            power = power @ power
    return X
