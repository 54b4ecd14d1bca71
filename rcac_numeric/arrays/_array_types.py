"""The arrays of the numeric half, by name."""

from __future__ import annotations

from typing import Any

import numpy as np

# In full and not as NDArray, which no longer says from NumPy 2.5 on that it is an array.
Array = np.ndarray[tuple[Any, ...], np.dtype[np.float64]]
ComplexArray = np.ndarray[tuple[Any, ...], np.dtype[np.complex128]]
