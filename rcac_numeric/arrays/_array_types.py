"""Array types of the numeric package."""

from __future__ import annotations

from typing import Any

import numpy as np

# Written out: from NumPy 2.5 on type checkers do not resolve NDArray to an array.
Array = np.ndarray[tuple[Any, ...], np.dtype[np.float64]]
ComplexArray = np.ndarray[tuple[Any, ...], np.dtype[np.complex128]]
