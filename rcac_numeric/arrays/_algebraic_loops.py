"""Well-posedness of algebraic loops."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays._array_types import Array


def closes(feedback: Array, feedthrough: Array) -> bool:
    """Whether I - F D is nonsingular beyond the rounding of the product and the difference."""
    loop = np.eye(len(feedback)) - feedback @ feedthrough
    if not loop.size:
        return True
    terms = 1.0 + np.max(np.abs(feedback) @ np.abs(feedthrough))
    rounding = (len(feedthrough) + 1) * len(loop) * np.finfo(float).eps * terms
    # The caller refuses entries beyond float64.
    return not np.isfinite(terms) or bool(np.linalg.svd(loop, compute_uv=False)[-1] > rounding)
