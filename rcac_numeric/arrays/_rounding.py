"""The rounding of logged numbers: the number format that they had, and the printing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Result

NumberFormat = Literal["float64", "float32", "float16", "fixed point", "integer"]
Printing = Literal["exact", "digits", "decimals"]

MOST_DIGITS = 11  # a text with more digits is as good as float64
UNWRITTEN = 10.0**-MOST_DIGITS  # relative unit of the last digit of such a text
# Fewer different values may have few digits by themselves, as those of a step have.
EVIDENCE = 10
MOST_VALUES = 20_000  # of a column are examined
FLOATS: dict[NumberFormat, tuple[type[np.floating], int]] = {
    "float16": (np.float16, 11),
    "float32": (np.float32, 24),
}  # the last is the finest
UNLIKELY = math.log(1e-9)  # chance that numbers have a number format by accident
# Levels are found from at least so many values, so many units of the last digit apart.
LEVELS, COARSER = 30, 8.0
COMPUTED = 4e-13  # relative to the largest value: rounding of levels that were computed
FINEST = 1e-9  # step, relative to the range
LEAST_BITS = 5  # of a fraction that is not taken for printed decimals
LARGEST_DIVISOR = 6  # of the smallest difference between two levels


@dataclass(frozen=True)
class Rounding(Result):
    """Two roundings of logged numbers: their number format, and the printed digits.

    The numbers were computed or measured in the format and then printed: the errors add up.

    Attributes
    ----------
    number_format : {"float64", "float32", "float16", "fixed point", "integer"}
        The coarsest format that every number is consistent with.
    step : float
        Distance of two levels of a fixed-point format or a converter, 1 for integers; 0 otherwise.
    printing : {"exact", "digits", "decimals"}
    places : int
        Printed significant digits, or decimals; 0 if the numbers are exact.
    may_be_single : bool
        Whether so few digits were printed that single precision cannot be excluded.
    """

    number_format: NumberFormat = "float64"
    step: float = 0.0
    printing: Printing = "exact"
    places: int = 0
    may_be_single: bool = False

    @property
    def quantum(self) -> float:
        """The coarser absolute spacing, of the number format or the printed decimals; 0 if none."""
        return max(self.step, 10.0**-self.places if self.printing == "decimals" else 0.0)

    @property
    def relative(self) -> float:
        """The coarser relative bound, of the number format or the printed digits; 0 if none."""
        printed = 0.5 * 10.0 ** (1 - self.places) if self.printing == "digits" else 0.0
        return max(self._unit, printed)

    @property
    def is_exact(self) -> bool:
        """Whether no rounding coarser than float64 was found."""
        return self.number_format == "float64" and self.printing == "exact"

    @property
    def sum_unit(self) -> float:
        """Relative rounding of one addition in a format coarser than float64; 0 if there is none.

        It is that of single precision where this cannot be excluded.
        """
        return max(self._unit, 2.0 ** -FLOATS["float32"][1] if self.may_be_single else 0.0)

    @property
    def _unit(self) -> float:
        """Half a unit in the last place of the floating format, relative."""
        return 2.0 ** -FLOATS[self.number_format][1] if self.number_format in FLOATS else 0.0

    def error(self, values: ArrayLike, *, with_step: bool = False) -> Array:
        """Return a bound of the rounding error of each value.

        With `with_step` a step is included: for a signal that was computed and then rounded or
        truncated to the levels, as the output of a converter. A measured signal, which the
        controller reads after the converter, has no such error.
        """
        size = np.abs(np.asarray(values, dtype=np.float64))
        bound = size * self._unit + 0.5 * _last_digit(size, self.printing, self.places)
        return np.asarray(bound + (self.step if with_step else 0.0))

    def __str__(self) -> str:
        names = {"float32": "in single precision", "float16": "in half precision",
                 "integer": "integers", "fixed point": f"in steps of {self.step:.6g}"}  # fmt: skip
        parts = [names[self.number_format]] if self.number_format in names else []
        if self.printing != "exact":
            parts.append(f"to {self.places} {self.printing}")
        return ", ".join(parts) or "in float64"


def rounding_of(values: ArrayLike, text: Sequence[str] | None = None) -> Rounding:
    """Find the number format and the printed digits of a column; both may be coarse.

    A format is reported where numbers of another one would agree with it by accident less often
    than once in a billion; fewer than ten different numbers without a text, those of a step for
    example, tell nothing.

    Parameters
    ----------
    values : array
        NaN and infinite entries are ignored.
    text : sequence of str, optional
        The numbers as they were printed, if known; zeros at their end count as digits.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.arrays._rounding import rounding_of
    >>> single = np.sqrt(np.arange(2, 400), dtype=np.float32)
    >>> print(rounding_of([float(f"{v:.9g}") for v in single]))
    in single precision, to 9 digits
    >>> print(rounding_of(np.round(np.arange(1024) * 5 / 1023, 4)))
    in steps of 0.00488759, to 4 decimals
    """
    flat, sizes = _sample(values)
    printing, places = _printing(sizes) if text is None else _printed(text)
    if sizes.size >= EVIDENCE:
        return _rounding(flat, sizes, printing, places)
    number_format = _few(sizes)
    return Rounding(number_format, 0.0, *(("exact", 0) if text is None else (printing, places)))


def roundings_of(signals: Mapping[str, Array]) -> dict[str, tuple[Rounding, ...]]:
    """Find the rounding of each column of each signal.

    A column with too few different numbers has the rounding of all columns of its signal; if these
    are too few, too, the coarsest digits of another column that it may have been printed with.
    """
    columns = {
        name: [values] if values.ndim == 1 else list(values.T) for name, values in signals.items()
    }
    known: dict[str, list[Rounding | None]] = {}
    for name, parts in columns.items():
        resolutions = [_resolution_of(part) for part in parts]
        whole = _resolution_of(signals[name]) if None in resolutions else None
        known[name] = [whole if one is None else one for one in resolutions]
    roundings = {one for row in known.values() for one in row if one is not None}
    printed = [one for one in roundings if one.printing != "exact"]
    printed.sort(key=lambda one: (one.places, one.printing, -one.sum_unit, one.number_format))

    def rounding(one: Rounding | None, part: Array) -> Rounding:
        if one is None:
            one = next((other for other in printed if _admits(other, part)), None)
        return rounding_of(part) if one is None else one

    return {
        name: tuple(rounding(*pair) for pair in zip(known[name], parts, strict=True))
        for name, parts in columns.items()
    }


def _resolution_of(values: Array) -> Rounding | None:
    """The rounding of numbers; None if there are too few."""
    flat, sizes = _sample(values)
    return _rounding(flat, sizes, *_printing(sizes)) if sizes.size >= EVIDENCE else None


def _admits(rounding: Rounding, values: Array) -> bool:
    """Whether all values may have been printed in this way."""
    _, sizes = _sample(values)
    places: Array = np.asarray(rounding.places)
    if rounding.printing == "digits":
        places = rounding.places - 1 - _exponents(sizes)
    return bool(sizes.size) and _fit(sizes, places)


def _sample(values: ArrayLike) -> tuple[Array, Array]:
    """The different values of a sample, and their sizes without the ends of the range."""
    flat = np.asarray(values, dtype=np.float64).ravel()
    flat = flat[:: max(flat.size // MOST_VALUES, 1)]
    flat = np.unique(flat[np.isfinite(flat)])
    sizes = np.unique(np.abs(flat))
    return flat, sizes[(sizes > 1e-280) & (sizes < 1e280)]


def _rounding(flat: Array, sizes: Array, printing: Printing, places: int) -> Rounding:
    """The rounding of enough numbers that were printed in this way."""
    if printing == "decimals" and places == 0:
        step = _step(flat, np.zeros_like(flat))
        return Rounding("fixed point", step) if step > 1.5 else Rounding("integer", 1.0)
    if places >= LEAST_BITS and np.array_equal(
        np.ldexp(flat, places), np.rint(np.ldexp(flat, places))
    ):
        printing, places = "exact", 0  # a fraction with n bits has n decimals
    step = _step(flat, _last_digit(np.abs(flat), printing, places))
    unit = _last_digit(sizes, printing, places) if printing != "exact" else UNWRITTEN * sizes
    may_be_single = False
    for name in FLOATS:
        may_be_single, is_certain = _may_come_from(sizes, unit, name)
        # Numbers of a format with one exponent have levels themselves, of its spacing.
        if is_certain and _chance(_spacing(sizes, name), step) > UNLIKELY:
            return Rounding(name, 0.0, printing, places)
    return Rounding("fixed point" if step else "float64", step, printing, places, may_be_single)


def _few(sizes: Array) -> NumberFormat:
    """The format of a few numbers, if it needs more digits than a person would type."""
    printing, places = _printing(sizes)
    unit = _last_digit(sizes, printing, places) if printing != "exact" else UNWRITTEN * sizes
    return next((name for name in FLOATS if _may_come_from(sizes, unit, name)[1]), "float64")


def _printing(sizes: Array) -> tuple[Printing, int]:
    """The format of printed numbers: the fewest decimals or significant digits that fit."""
    if not sizes.size:
        return "exact", 0
    exponents = _exponents(sizes)
    whole = int(exponents.max()) + 1
    digits = next((d for d in range(1, MOST_DIGITS + 1) if _fit(sizes, d - 1 - exponents)), None)
    decimals = next((d for d in range(MOST_DIGITS + 1) if _fit(sizes, np.asarray(d))), None)
    if decimals is not None and (digits is None or decimals + whole <= max(digits, whole)):
        return "decimals", decimals
    return ("exact", 0) if digits is None else ("digits", digits)


def _exponents(sizes: Array) -> Array:
    return np.asarray(np.floor(np.log10(sizes)).astype(int))


def _fit(sizes: Array, places: Array) -> bool:
    """Whether every value has no more than these decimal places."""
    scaled = sizes * 10.0 ** places.astype(np.float64)
    off = np.abs(scaled - np.rint(scaled))
    return bool(np.all((off <= 4e-15 * scaled) & (scaled < 1e12)))


def _printed(text: Sequence[str]) -> tuple[Printing, int]:
    """Return the printing of texts: a common number of decimals, or the most digits."""
    exponents, digits = set(), 0
    for entry in text[:: max(len(text) // MOST_VALUES, 1)]:
        try:
            number = Decimal(entry.strip().replace(",", ".").replace("D", "e").replace("d", "e"))
        except InvalidOperation:
            continue
        if number.is_finite() and number:
            exponents.add(int(number.as_tuple().exponent))
            digits = max(digits, len(number.as_tuple().digits))
    if not exponents or digits > MOST_DIGITS:
        return "exact", 0
    # %.4e has exponents that differ; %g leaves out the zeros at the end.
    is_fixed = len(exponents) == 1 and max(exponents) <= 0
    return ("decimals", -max(exponents)) if is_fixed else ("digits", digits)


def _last_digit(sizes: Array, printing: Printing, places: int) -> Array:
    """The unit of the last printed digit of each number; 0 if it is exact."""
    if printing == "decimals":
        return np.full_like(sizes, 10.0**-places)
    if printing == "digits":
        place = np.floor(np.log10(np.where(sizes > 0, sizes, 1.0)))
        return np.asarray(np.where(sizes > 0, 10.0 ** (place + 1 - places), 0.0))
    return np.zeros_like(sizes)


def _spacing(sizes: Array, name: NumberFormat) -> Array:
    """The distance of the nearest number of a format from the next."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        return np.abs(np.spacing(sizes.astype(FLOATS[name][0]))).astype(np.float64)


def _chance(widths: Array, step: float | Array) -> float:
    """The logarithm of the chance that numbers are within these widths of a grid."""
    ratio = np.minimum(widths / np.maximum(step, np.finfo(float).tiny), 1.0)
    return float(np.log(np.maximum(ratio, np.finfo(float).tiny)).sum())


def _may_come_from(sizes: Array, unit: Array, name: NumberFormat) -> tuple[bool, bool]:
    """Whether the numbers may be texts of a format, and whether that is no chance.

    A number is such a text if the nearest number of the format, printed with the same digits or
    with as many as the format needs, is the number itself.
    """
    spacing = _spacing(sizes, name)
    if not np.isfinite(spacing).all():
        return False, False
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        nearest = sizes.astype(FLOATS[name][0])
    back = nearest.astype(np.float64)
    is_text = bool(np.all(np.abs(back - sizes) <= 0.5 * unit * (1 + 1e-6)))
    if not is_text:
        shortest = nearest.astype("U32").astype(np.float64)
        is_text = bool(np.all(np.abs(shortest - sizes) <= 4e-16 * sizes))
    return is_text, is_text and _chance(unit, spacing) < UNLIKELY


def _step(values: Array, last_digit: Array) -> float:
    """Return the distance of equally spaced levels that all values are on; 0 if there is none."""
    if values.size < LEVELS:
        return 0.0
    gaps, extent = np.diff(values), float(values[-1] - values[0])
    smallest = float(gaps.min())
    unit = float(last_digit.max())
    if smallest <= COARSER * unit:  # the printed digits are the levels, or some of them
        is_fixed = unit == float(last_digit.min())
        every = int(np.gcd.reduce(np.rint(gaps / unit).astype(np.int64))) if is_fixed else 1
        return every * unit if values.size * math.log(every) > -UNLIKELY else 0.0
    order = np.argsort(gaps)
    width = last_digit + last_digit[0] + last_digit[-1]
    width = width + 2 * COMPUTED * float(np.abs(values).max())
    for divisor in range(1, LARGEST_DIVISOR + 1):
        step = _refined(gaps[order], smallest / divisor)
        if step <= FINEST * extent:
            return 0.0
        levels = np.concatenate([[0.0], np.cumsum(np.rint(gaps / step))])
        step = extent / levels[-1]
        fits = np.abs(values - values[0] - levels * step) <= 0.5 * width
        if fits.all() and _chance(width, step) < UNLIKELY:
            return float(step)
    return 0.0


def _refined(gaps: Array, step: float) -> float:
    """Return the step of ascending gaps, from the small ones, whose number of steps is certain."""
    ends = np.unique(np.geomspace(1, gaps.size, num=min(gaps.size, 12)).astype(int))
    for first, last in pairwise([0, *ends.tolist()]):
        counts = np.rint(gaps[:last] / step)
        if last > first and counts.sum():
            step = float(gaps[:last].sum() / counts.sum())
    return step
