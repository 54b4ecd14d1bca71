"""The rounding of logged numbers: the number format that they had, and the printing."""

from __future__ import annotations

import math
from collections.abc import Sequence
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

# Decimal digits that each float64 number survives; a printed number of more is exact.
MOST_DIGITS = 15
# Fewer different values may have few digits by themselves, as those of a step have.
EVIDENCE = 10
MOST_VALUES = 20_000  # of a column are examined
FLOATS: dict[NumberFormat, tuple[type[np.floating], int]] = {
    "float16": (np.float16, 11),
    "float32": (np.float32, 24),
}
UNLIKELY = math.log(1e-6)  # chance that numbers have a number format by accident
MOST_LEVELS = 2**20  # of a converter; beyond, a floating format explains the values as well
LEAST_BITS = 5  # of a fraction that is not taken for printed decimals
LARGEST_DIVISOR = 6  # of the smallest difference between two levels


@dataclass(frozen=True)
class Rounding(Result):
    """Two roundings of logged numbers: their number format, and the printed digits.

    Attributes
    ----------
    number_format : {"float64", "float32", "float16", "fixed point", "integer"}
        The coarsest format that every number is consistent with.
    step : float
        Distance of two levels of a fixed-point format or a converter, 1 for integers; 0 otherwise.
    printing : {"exact", "digits", "decimals"}
    places : int
        Printed significant digits, or decimals; 0 if the numbers are exact.
    """

    number_format: NumberFormat = "float64"
    step: float = 0.0
    printing: Printing = "exact"
    places: int = 0

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
        return self == Rounding()

    @property
    def _unit(self) -> float:
        """Half a unit in the last place of the floating format, relative."""
        return 2.0 ** -FLOATS[self.number_format][1] if self.number_format in FLOATS else 0.0

    def error(self, values: ArrayLike, *, with_step: bool = False) -> Array:
        """Return a bound of the rounding error of each value.

        With `with_step` half a step is included: for a signal that was computed and then rounded to
        the levels, as the output of a converter. A measured signal, which the controller reads
        after the converter, has no such error.
        """
        size = np.abs(np.asarray(values, dtype=np.float64))
        bound = size * self._unit
        if self.printing == "decimals":
            bound = bound + 0.5 * 10.0**-self.places
        elif self.printing == "digits":
            place = np.floor(np.log10(np.where(size > 0, size, 1.0)))
            bound = bound + np.where(size > 0, 0.5 * 10.0 ** (place + 1 - self.places), 0.0)
        return bound + (0.5 * self.step if with_step else 0.0)

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
    than once in a million; fewer than ten different numbers without a text, those of a step for
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
    flat = np.asarray(values, dtype=np.float64).ravel()
    flat = flat[:: max(flat.size // MOST_VALUES, 1)]
    flat = np.unique(flat[np.isfinite(flat)])
    sizes = np.unique(np.abs(flat))
    sizes = sizes[(sizes > 1e-280) & (sizes < 1e280)]
    printing, places = _printing(sizes) if text is None else _printed(text)
    if printing == "decimals" and places == 0:
        return Rounding("integer", 1.0) if sizes.size >= EVIDENCE else Rounding()
    if sizes.size < EVIDENCE:
        number_format = _float_format(sizes, *_printing(sizes))
        return Rounding(number_format, 0.0, *(("exact", 0) if text is None else (printing, places)))
    if places >= LEAST_BITS and np.array_equal(
        np.ldexp(flat, places), np.rint(np.ldexp(flat, places))
    ):
        printing, places = "exact", 0  # a fraction with n bits has n decimals
    step = _step(flat, _spacing(flat, printing, places))
    if step:
        return Rounding("fixed point", step, printing, places)
    return Rounding(_float_format(sizes, printing, places), 0.0, printing, places)


def _printing(sizes: Array) -> tuple[Printing, int]:
    """Return how the numbers were printed, from their shortest decimals."""
    if not sizes.size:
        return "exact", 0
    decimals, digits, whole = 0, 0, -MOST_DIGITS
    for value in sizes.tolist():
        number = Decimal(repr(value)).normalize().as_tuple()
        exponent = int(number.exponent)
        digits = max(digits, len(number.digits))
        decimals = max(decimals, -exponent)
        whole = max(whole, len(number.digits) + exponent)
    # A number of 16 or 17 digits is as good as float64; so is a fixed-point number in binary.
    if decimals + whole <= min(max(digits, whole), MOST_DIGITS):
        return "decimals", decimals
    return ("digits", digits) if digits <= MOST_DIGITS else ("exact", 0)


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


def _spacing(values: Array, printing: Printing, places: int) -> Array:
    """Return the distance of each printed number from the next; a few units of float64 if exact."""
    if printing == "decimals":
        return np.full_like(values, 10.0**-places)
    size = np.abs(values)
    if printing == "digits":
        return np.asarray(10.0 ** (np.floor(np.log10(np.where(size > 0, size, 1.0))) + 1 - places))
    return 4 * np.spacing(size)


def _float_format(sizes: Array, printing: Printing, places: int) -> NumberFormat:
    """Return the coarsest floating format whose printed numbers these are."""
    if not sizes.size:
        return "float64"
    spacing = _spacing(sizes, printing, places)
    for name, (kind, bits) in FLOATS.items():
        unit = 2.0 ** (np.floor(np.log2(sizes)) - bits + 1)
        if np.log(np.minimum(spacing / unit, 1.0)).sum() > UNLIKELY:
            continue  # the printed digits are too few to tell
        with np.errstate(over="ignore", under="ignore"):
            nearest = sizes.astype(kind)
        if _agrees(sizes, nearest, printing, places):
            return name
    return "float64"


def _agrees(sizes: Array, nearest: np.ndarray, printing: Printing, places: int) -> bool:
    """Whether these are the numbers of a format, exact, in shortest form, or printed."""
    exact = nearest.astype(np.float64)
    if np.array_equal(exact, sizes):
        return True
    if not np.isfinite(exact).all() or printing == "exact":
        return False
    form = "g" if printing == "digits" else "f"
    # One number in the middle first, which refuses most columns without a long loop.
    for part in (slice(sizes.size // 2, sizes.size // 2 + 1), slice(None)):
        printed = [float(f"{v:.{places}{form}}") for v in exact[part].tolist()]
        shortest = [float(str(v)) for v in nearest[part]]
        pairs = zip(printed, shortest, sizes[part].tolist(), strict=True)
        if not all(value in pair for *pair, value in pairs):
            return False
    return True


def _step(values: Array, spacing: Array) -> float:
    """Return the distance of equally spaced levels that all values are on; 0 if there is none."""
    gaps = np.diff(values)
    smallest = float(gaps.min())
    if smallest <= 2 * float(spacing.max()):
        return 0.0  # the printed digits are the levels
    order = np.argsort(gaps)
    for divisor in range(1, LARGEST_DIVISOR + 1):
        step = _refined(gaps[order], smallest / divisor)
        levels = np.concatenate([[0.0], np.cumsum(np.rint(gaps / step))])
        if levels[-1] > MOST_LEVELS:
            return 0.0
        step = float(values[-1] - values[0]) / levels[-1]
        width = spacing + spacing[0] + spacing[-1]
        fits = np.abs(values - values[0] - levels * step) <= 0.5 * width
        if fits.all() and np.log(np.minimum(width / step, 1.0)).sum() < UNLIKELY:
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
