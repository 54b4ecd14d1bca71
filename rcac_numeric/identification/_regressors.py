"""Recorded signals as the regressors of the mu-Markov model (3.8)."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import real_array, squarable


def regression(u: ArrayLike, y: ArrayLike, mu: int, n_mod: int) -> tuple[Array, Array]:
    """Regressors [recent u, older u, -older y] and present y of (3.8), row by row."""
    U, Y = as_signal(u, "u"), as_signal(y, "y")
    window = mu + n_mod
    older_y = -lagged(Y, window)[:, mu * Y.shape[1] :]
    return np.hstack([lagged(U, window), older_y]), Y[window - 1 :]


def as_signal(value: ArrayLike, name: str) -> Array:
    """A signal as an array of shape (steps, number of signals)."""
    array = squarable(real_array(value, name), name)
    array = array.reshape(-1, 1) if array.ndim == 1 else array
    if array.ndim != 2 or array.size == 0:
        raise InputError(f"{name} has shape {array.shape}; (steps, number of signals) is needed.")
    return array


def lagged(signal: Array, window: int) -> Array:
    """Rows [s(k)', s(k-1)', ..., s(k-window+1)'] for k = window-1, ..., steps-1."""
    rows = sliding_window_view(signal, window, axis=0)[:, :, ::-1]
    return np.ascontiguousarray(rows.transpose(0, 2, 1)).reshape(len(rows), -1)
