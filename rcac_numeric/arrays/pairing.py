"""Which of two sets of numbers belong together."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays.array_types import ComplexArray


def pairing(wanted: ComplexArray, available: ComplexArray) -> list[tuple[complex, complex]]:
    """Assign to each wanted pole one available pole with the least total distance."""
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(np.abs(wanted[:, None] - available[None, :]))
    return [(complex(wanted[i]), complex(available[j])) for i, j in zip(rows, columns, strict=True)]
