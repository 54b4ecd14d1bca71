"""Numbers as text for the page."""

from __future__ import annotations

import base64

import numpy as np

from rcac_numeric.arrays._array_types import Array


def in_base64(values: Array) -> str:
    """Encode numbers as little-endian float64 in base64."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes()).decode()
