"""One-to-one matching of two sets of poles."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays._array_types import Array, ComplexArray


def pairing(targets: ComplexArray, available: ComplexArray) -> list[tuple[complex, complex]]:
    """Assign one available pole to each target pole with the least total distance."""
    distances = np.abs(targets[:, None] - available[None, :])
    rows, columns = np.arange(len(targets)), _nearest(distances)
    if columns is None:
        from scipy.optimize import linear_sum_assignment  # imported here: it takes 0.17 s

        rows, columns = linear_sum_assignment(distances)
    return [
        (complex(targets[i]), complex(available[j])) for i, j in zip(rows, columns, strict=True)
    ]


def _nearest(distances: Array) -> np.ndarray | None:
    """Return the nearest-neighbour assignment; optimal if it is one-to-one without ties."""
    if distances.shape[1] < 2 or not np.isfinite(distances).all():
        return None
    nearest = distances.argmin(axis=1)
    least, second = np.partition(distances, 1, axis=1)[:, :2].T
    if len(set(nearest)) < len(nearest) or not (least < second).all():
        return None
    return np.asarray(nearest)
