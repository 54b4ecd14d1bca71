"""The two roundings of logged numbers: the arithmetic that they come from, and the digits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rcac_numeric.arrays._array_types import Array

MOST_DIGITS = 11  # a text with more digits is as good as float64
UNWRITTEN = 10.0**-MOST_DIGITS  # relative unit of the last digit of such a text
# Fewer values than these may have few digits by themselves, as those of a step have.
EVIDENCE = 10
SAMPLE = 20_000  # numbers of a column that are read
CHANCE = np.log(1e-9)  # that numbers of float64 look like those of a coarser arithmetic
FORMATS = {"half": np.float16, "single": np.float32}  # the last is the finest
HALF_UNIT = {"half": 2.0**-11, "single": 2.0**-24}  # relative
# A fixed-point lattice is found from at least so many values, on a step of so many units of the
# last digit.
LATTICE, COARSER = 30, 8.0
BY_FORMAT = 3.0  # half spacings of a floating-point format that a step exceeds


@dataclass(frozen=True)
class Resolution:
    """The rounding of one column of logged numbers.

    A number is rounded twice: by the arithmetic in which it was computed or measured, and by the
    digits with which it was written. The errors add up.

    Attributes
    ----------
    kind : {"exact", "decimals", "digits"}
        How it was written: all digits, a fixed number of decimals, or of significant digits.
    digits : int
        How many.
    arithmetic : {"", "single", "half"}
        The floating-point format before it was written; empty for float64.
    may_be_single : bool
        Whether so few digits were written that single precision cannot be excluded.
    step : float
        The step of a fixed-point number, a converter's count for instance; 0 for none.
    """

    kind: str = "exact"
    digits: int = 0
    arithmetic: str = ""
    may_be_single: bool = False
    step: float = 0.0

    @property
    def is_exact(self) -> bool:
        """Whether no rounding is coarser than that of float64."""
        return self.kind == "exact" and not self.arithmetic and not self.step

    @property
    def sum_unit(self) -> float:
        """The relative rounding of one addition in the arithmetic of the numbers."""
        if self.arithmetic:
            return HALF_UNIT[self.arithmetic]
        return HALF_UNIT["single"] if self.may_be_single else 0.0

    def error(self, values: Array, *, is_measured: bool = False) -> Array:
        """A bound of the error of each value.

        A converter rounds a measurement before the controller reads it, so that a fixed-point
        step is no error of a signal that `is_measured`.
        """
        size = np.abs(values)
        bound = 0.5 * self._unit(size) + size * HALF_UNIT.get(self.arithmetic, 0.0)
        if self.step and not is_measured:
            bound = bound + self.step  # whether it was rounded or truncated
        return np.asarray(bound)

    def _unit(self, size: Array) -> Array:
        """The unit of the last written digit."""
        if self.kind == "decimals":
            return np.full_like(size, 10.0**-self.digits)
        if self.kind == "digits":
            place = np.floor(np.log10(np.where(size > 0, size, 1.0)))
            return np.asarray(np.where(size > 0, 10.0 ** (place + 1 - self.digits), 0.0))
        return np.zeros_like(size)

    def admits(self, values: Array) -> bool:
        """Whether all values may have been written with these digits."""
        flat = _sizes(values)
        if self.kind == "exact" or not flat.size:
            return False
        places = self.digits if self.kind == "decimals" else self.digits - 1 - _exponents(flat)
        return _fit(flat, places)

    def __str__(self) -> str:
        words = []
        if self.arithmetic:
            words.append(f"in {self.arithmetic} precision")
        if self.step:
            words.append(f"in steps of {self.step:.4g}")
        if self.kind != "exact":
            words.append(f"to {self.digits} {self.kind}")
        return ", written ".join(words) or "in float64"


def resolutions_of(signals: Mapping[str, Array]) -> dict[str, tuple[Resolution, ...]]:
    """The rounding of each column of each signal.

    A column with too few different numbers has the rounding of all columns of its signal; if these
    are too few, too, the coarsest digits of another column that it may have been written with.
    """
    columns: dict[str, list[Resolution | None]] = {}
    for name, values in signals.items():
        parts = [values] if values.ndim == 1 else list(values.T)
        one_by_one = [_resolution(part) for part in parts]
        whole = None if all(one_by_one) else _resolution(values)
        columns[name] = [own or whole for own in one_by_one]
    written = {one for row in columns.values() for one in row if one and one.kind != "exact"}
    coarsest = sorted(written, key=lambda one: (one.digits, one.kind))
    known: dict[str, tuple[Resolution, ...]] = {}
    for name, row in columns.items():
        values = signals[name]
        parts = [values] if values.ndim == 1 else list(values.T)
        known[name] = tuple(
            own or next((one for one in coarsest if one.admits(part)), Resolution())
            for own, part in zip(row, parts, strict=True)
        )
    return known


def resolution_of(values: Array) -> Resolution:
    """The coarsest rounding that all of these numbers are consistent with.

    With fewer than ten different numbers, those of a step for example, nothing is concluded.
    """
    return _resolution(values) or Resolution()


def _resolution(values: Array) -> Resolution | None:
    """The rounding of numbers; None if there are too few for a conclusion."""
    flat = _sizes(values)
    if flat.size < EVIDENCE:
        return None
    exponents = _exponents(flat)
    whole = max(int(exponents.max()) + 1, 0)
    digits = next((d for d in range(1, MOST_DIGITS + 1) if _fit(flat, d - 1 - exponents)), None)
    decimals = next((d for d in range(MOST_DIGITS + 1) if _fit(flat, d)), None)
    written = Resolution()
    if decimals is not None and (digits is None or decimals + whole <= max(digits, whole)):
        written = Resolution("decimals", decimals)
    elif digits is not None:
        written = Resolution("digits", digits)
    if written == Resolution("decimals", 0):  # counts, of a converter for example
        return Resolution(step=_lattice(values, 0.0))
    unit = written._unit(flat) if written.kind != "exact" else UNWRITTEN * flat
    step = _lattice(values, float(unit.max()) if written.kind != "exact" else 0.0)
    may_be_single = False
    for name in FORMATS:
        may_be_single, is_certain = _may_come_from(flat, unit, name)
        # Numbers of a format with one exponent are a lattice themselves, of its spacing.
        if is_certain and step <= BY_FORMAT * HALF_UNIT[name] * float(flat.max()):
            return Resolution(written.kind, written.digits, name)
    return Resolution(written.kind, written.digits, "", may_be_single, step)


def _sizes(values: Array) -> Array:
    """The different absolute values of a sample of the numbers, without the range's end."""
    flat = np.abs(values).ravel()
    flat = np.unique(flat[:: max(flat.size // SAMPLE, 1)])
    return np.asarray(flat[(flat > 1e-280) & (flat < 1e280)])


def _exponents(flat: Array) -> Array:
    return np.asarray(np.floor(np.log10(flat)).astype(int))


def _fit(values: Array, places: int | Array) -> bool:
    """Whether every value has no more than these decimal places."""
    scaled = values * 10.0 ** np.asarray(places, dtype=np.float64)
    off = np.abs(scaled - np.rint(scaled))
    return bool(np.all((off <= 4e-15 * scaled) & (scaled < 1e12)))


def _may_come_from(flat: Array, unit: Array, name: str) -> tuple[bool, bool]:
    """Whether the numbers may be texts of a format, and whether that is no chance.

    A number is such a text if the nearest number of the format, written with the same digits or
    with as many as the format needs, is the number itself.
    """
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        nearest = flat.astype(FORMATS[name])
        back = nearest.astype(np.float64)
        spacing = np.abs(np.spacing(nearest)).astype(np.float64)
    if not np.isfinite(spacing).all():
        return False, False
    is_text = bool(np.all(np.abs(back - flat) <= 0.5 * unit * (1 + 1e-6)))
    if not is_text:
        shortest = nearest.astype("U32").astype(np.float64)
        is_text = bool(np.all(np.abs(shortest - flat) <= 4e-16 * flat))
    chance = np.log(np.minimum(unit / np.maximum(spacing, np.finfo(float).tiny), 1.0)).sum()
    return is_text, is_text and bool(chance < CHANCE)


def _lattice(values: Array, unit: float) -> float:
    """The step of which all numbers are multiples, but for an offset; 0 if there is none."""
    flat = np.unique(np.asarray(values, dtype=np.float64).ravel()[: 4 * SAMPLE])
    if flat.size < LATTICE:
        return 0.0
    flat = flat - flat[len(flat) // 2]
    step = float(np.diff(flat).min())
    if step <= COARSER * unit or step <= 1e-9 * float(np.abs(flat).max()):
        return 0.0
    # The least gap has the error of two written numbers: larger multiples determine the step.
    by_size = np.abs(flat[np.argsort(np.abs(flat))])
    for count in np.unique(np.geomspace(4, len(flat), 12).astype(int)):
        part = by_size[:count]
        multiples = np.rint(part / step)
        if not multiples.any():
            continue
        step = float(part @ multiples / (multiples @ multiples))
    rest = np.abs(flat - step * np.rint(flat / step))
    allowed = unit + 4e-13 * float(np.abs(flat).max())
    chance = len(flat) * np.log(min(2 * allowed / step, 1.0))
    return step if float(rest.max()) <= allowed and chance < CHANCE else 0.0
