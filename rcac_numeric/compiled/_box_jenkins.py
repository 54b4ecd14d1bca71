"""Prediction errors of Box-Jenkins and ARMAX models, by the kernel."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled import _kernel
from rcac_numeric.compiled._kernel import BoxJenkinsErrors

__all__ = ["BoxJenkinsErrors", "box_jenkins_errors"]


def box_jenkins_errors(
    y: Array, u: Array, levels: Array, weights: Array | None, theta: Array,
    orders: tuple[int, int, int, int], *, differences: bool, armax: bool, sinusoid: bool,
    dependent: float,
) -> BoxJenkinsErrors | None:  # fmt: skip
    """Errors at the coefficients of A, B, C, D and a frequency; None where they leave float64.

    `levels` are rows of a free size. Of a free row of which the others leave less than `dependent`
    of its norm nothing is projected out.
    """
    contiguous = [np.ascontiguousarray(one, dtype=np.float64) for one in (y, u, levels, theta)]
    by = np.zeros(0) if weights is None else np.ascontiguousarray(weights, dtype=np.float64)
    return _kernel.box_jenkins_errors(
        y=contiguous[0], u=contiguous[1], levels=contiguous[2], weights=by, theta=contiguous[3],
        orders=orders, differences=differences, armax=armax, sinusoid=sinusoid,
        dependent=dependent,
    )  # fmt: skip
