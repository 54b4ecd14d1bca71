"""To how many digits a log was written, as its numbers show it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcac_numeric.arrays.array_types import Array

# A log with more digits than these is as good as float64.
MOST_DIGITS = 11
# Fewer values than these may have few digits by themselves, as those of a step have.
EVIDENCE = 10
# At most so many numbers of a signal are looked at.
SAMPLE = 20_000
HALF_SINGLE = 2.0**-24


@dataclass(frozen=True)
class Resolution:
    """How far a logged number may be from the one that was meant.

    Attributes
    ----------
    kind : {"exact", "single", "decimals", "digits"}
        float64, single precision, a fixed number of decimals, or of significant digits.
    digits : int
        How many.
    """

    kind: str = "exact"
    digits: int = 0

    def error(self, values: Array) -> Array:
        """A bound of the error of each value."""
        size = np.abs(values)
        if self.kind == "decimals":
            return np.full_like(size, 0.5 * 10.0**-self.digits)
        if self.kind == "digits":
            place = np.floor(np.log10(np.where(size > 0, size, 1.0)))
            return np.where(size > 0, 0.5 * 10.0 ** (place + 1 - self.digits), 0.0)
        return size * (HALF_SINGLE if self.kind == "single" else 0.0)

    def __str__(self) -> str:
        if self.kind in ("exact", "single"):
            return {"exact": "in float64", "single": "in single precision"}[self.kind]
        return f"to {self.digits} {self.kind}"


def resolution_of(values: Array) -> Resolution:
    """The coarsest way of writing numbers that all of these could have been written in.

    The chance that numbers which were not rounded look as if they were is nil from ten different
    ones on. With fewer, those of a step for example, nothing is concluded.
    """
    flat = np.abs(values).ravel()
    flat = np.unique(flat[:: max(flat.size // SAMPLE, 1)])
    flat = flat[(flat > 1e-280) & (flat < 1e280)]
    if flat.size < EVIDENCE:
        return Resolution()
    exponents = np.floor(np.log10(flat)).astype(int)
    whole = max(int(exponents.max()) + 1, 0)
    digits = next((d for d in range(1, MOST_DIGITS + 1) if _fit(flat, d - 1 - exponents)), None)
    decimals = next((d for d in range(MOST_DIGITS + 1) if _fit(flat, d)), None)
    if decimals == 0:
        return Resolution()  # counts, of an analog-to-digital converter for example
    if decimals is not None and (digits is None or decimals + whole <= max(digits, whole)):
        return Resolution("decimals", decimals)
    if digits is not None:
        return Resolution("digits", digits)
    with np.errstate(over="ignore", under="ignore"):
        is_single = np.array_equal(flat.astype(np.float32).astype(np.float64), flat)
    return Resolution("single") if is_single else Resolution()


def _fit(values: Array, places: int | Array) -> bool:
    """Whether every value has no more than these decimal places."""
    scaled = values * 10.0 ** np.asarray(places, dtype=np.float64)
    off = np.abs(scaled - np.rint(scaled))
    return bool(np.all((off <= 4e-15 * scaled) & (scaled < 1e12)))
