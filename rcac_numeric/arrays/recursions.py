"""The states of a linear recursion over many steps, some hundred instructions of Python for all."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays.array_types import Array

FEW = 1000  # steps that are taken one by one


def linear_states(A: Array, drive: Array) -> Array:
    """x(0), ..., x(N) of x(k+1) = A x(k) + d(k) from rest; shape (N + 1, n).

    Many steps are cut into m blocks of m. All blocks run side by side from rest; what the state at
    the beginning of a block adds, A^j x, follows. That is 2 sqrt(N) steps in place of N, and the
    same sums in another order.
    """
    steps, n = drive.shape
    if steps <= FEW:
        states = np.zeros((steps + 1, n))
        for k, d in enumerate(drive):
            states[k + 1] = A @ states[k] + d
        return states
    size = int(steps**0.5)
    blocks = -(-steps // size)
    padded = np.zeros((blocks * size, n))
    padded[:steps] = drive
    cut = padded.reshape(blocks, size, n)
    powers = np.empty((size + 1, n, n))
    powers[0] = np.eye(n)
    forced = np.zeros((blocks, size + 1, n))
    for j in range(size):
        powers[j + 1] = A @ powers[j]
        forced[:, j + 1] = forced[:, j] @ A.T + cut[:, j]
    starts = np.zeros((blocks + 1, n))
    for b in range(blocks):
        starts[b + 1] = powers[size] @ starts[b] + forced[b, size]
    whole = forced[:, 1:] + np.einsum("jab,cb->cja", powers[1:], starts[:-1])
    return np.concatenate([np.zeros((1, n)), whole.reshape(-1, n)[:steps]])
