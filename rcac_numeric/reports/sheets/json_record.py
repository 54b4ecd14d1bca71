"""A report for programs: the facts of its sections as one strict JSON object."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rcac_numeric.reports.sheets.sheet import Sheet


def as_dict(sheet: Sheet) -> dict[str, Any]:
    """The record of a report in JSON's own types.

    A complex number becomes [real, imaginary], an array a list, and null stands for what is
    infinite, not a number, or not known: strict JSON has no word for them.
    """
    plain = _plain(sheet.record)
    assert isinstance(plain, dict)
    return plain


def as_json(sheet: Sheet, indent: int | None = 2) -> str:
    """The record of a report as the text of one strict JSON object."""
    return json.dumps(as_dict(sheet), indent=indent, allow_nan=False)


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(name): _plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    raise TypeError(f"a report records {value!r}, which JSON cannot hold")
