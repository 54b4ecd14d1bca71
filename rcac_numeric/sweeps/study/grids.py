"""The values of an axis, as a file names them: a list, a range, a grid, decades, draws."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import integer
from rcac_numeric.sweeps.study.axes import LARGEST_AXIS, Axis, RandomAxis, pair, too_many

# What goes with each way to name values; one of the first is needed, and these beside it.
BESIDE: dict[str, str] = {
    "values": "",
    "range": "",
    "grid": "points",
    "decades": "points",
    "uniform": "draws",
    "log_uniform": "draws",
    "normal": "draws",
}


def axis_of(name: str, sets: str, given: dict[str, Any]) -> Axis | RandomAxis:
    """The axis that a table of [study.axes] describes.

    Raises
    ------
    InputError
        Where it names its values in no way or in two, or something beside them is missing.

    Examples
    --------
    >>> from rcac_numeric.sweeps.study.grids import axis_of
    >>> axis_of("R_theta", "controller.R_theta", {"decades": [-2, 0], "points": 3}).values
    (0.01, 0.1, 1.0)
    """
    ways = [way for way in BESIDE if way in given]
    if len(ways) != 1:
        said = f"has {' and '.join(ways)}" if ways else "does not say which values it takes"
        raise InputError(f"the axis {name!r} {said}; give one of {', '.join(BESIDE)}.")
    way = ways[0]
    beside = BESIDE[way]
    for extra in ("points", "draws"):
        if extra in given and extra != beside:
            raise InputError(f"the axis {name!r} has {extra}, which {way} does not take.")
    if beside and beside not in given:
        raise InputError(f"the axis {name!r} has {way} and needs {beside} too.")
    if beside == "draws":
        return RandomAxis(name, way, given[way], given["draws"], sets)
    return Axis(name, MAKERS[way](name, given[way], given.get("points")), sets)


def _listed(name: str, values: Any, points: int | None) -> list[Any]:
    return list(values)


def _range(name: str, ends: Any, points: int | None) -> list[int]:
    entries = [] if isinstance(ends, bool | int | float) else list(ends)
    if len(entries) not in (2, 3) or any(float(entry) != int(entry) for entry in entries):
        raise InputError(f"the axis {name!r}: range = {ends!r} must be [first, last] or "
                         "[first, last, step] in integers.")  # fmt: skip
    first, last, step = (*map(int, entries), 1)[:3]
    integer(step, f"the step of axis {name!r}", at_least=1)
    if last < first:
        raise InputError(f"the axis {name!r}: its range from {first} to {last} is empty.")
    if (count := (last - first) // step + 1) > LARGEST_AXIS:
        raise too_many(name, count)
    return list(range(first, last + 1, step))


def _grid(name: str, ends: Any, points: int | None) -> list[float]:
    low, high = pair(ends, f"the grid of axis {name!r}")
    count = _count(name, low, high, points)
    return [float(value) for value in np.linspace(low, high, count)]


def _decades(name: str, ends: Any, points: int | None) -> list[float]:
    low, high = pair(ends, f"the decades of axis {name!r}")
    count = _count(name, low, high, points)
    exponents = [float(value) for value in np.linspace(low, high, count)]
    # A whole power of ten is the float64 that is written 1e-40, in whatever order it is computed.
    return [float(f"1e{int(e)}") if e.is_integer() else 10.0**e for e in exponents]


def _count(name: str, low: float, high: float, points: int | None) -> int:
    count = integer(points, f"points of axis {name!r}", at_least=2)
    if count > LARGEST_AXIS:
        raise too_many(name, count)
    if not low < high:
        raise InputError(f"the axis {name!r} goes from {low} to {high}; give the least first.")
    return count


MAKERS: dict[str, Callable[[str, Any, int | None], list[Any]]] = {
    "values": _listed,
    "range": _range,
    "grid": _grid,
    "decades": _decades,
}
