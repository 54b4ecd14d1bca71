"""Decimation of long signals for figures."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays._array_types import Array

MANY = 2000  # points of a line; of longer signals each point is the largest of its neighbours


def thinned(k: np.ndarray, values: Array) -> tuple[np.ndarray, Array]:
    """Replace blocks of a long signal by their largest and smallest value; peaks stay."""
    size = len(values) // (MANY // 2)
    if size < 2:
        return k, values
    count = len(values) // size
    blocks = values[: count * size].reshape(count, size)
    steps = k[: count * size].reshape(count, size)
    rows = np.arange(count)[:, None]
    places = np.sort(np.stack([blocks.argmin(1), blocks.argmax(1)], 1), axis=1)
    rest = slice(count * size, None)
    return (
        np.concatenate([steps[rows, places].ravel(), k[rest]]),
        np.concatenate([blocks[rows, places].ravel(), values[rest]]),
    )
