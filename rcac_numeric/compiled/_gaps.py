"""Prediction errors of signals with missing steps, by the kernel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled import _kernel


def errors_with_gaps(
    signals: Array, whitener: Array, C: Array, observed: NDArray[np.bool_]
) -> tuple[Array, float]:
    """Errors of signals of noise C/whitener, each over the root of its variance, and log det.

    Shape (signals, steps); 0 where a step is missing. The noise is 0 before the first step.
    """
    contiguous = [np.ascontiguousarray(one, dtype=np.float64)
                  for one in (signals, whitener, C, observed)]  # fmt: skip
    errors, logarithms = _kernel.errors_with_gaps(
        signals=contiguous[0], whitener=contiguous[1], C=contiguous[2], observed=contiguous[3]
    )
    return errors.reshape(signals.shape), float(logarithms)
