"""How numbers are written for people."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rcac_numeric.arrays.wording import shortened


def complex_text(value: complex) -> str:
    """A number with eight decimals."""
    if abs(value.imag) < 1e-300:
        return f"{value.real:.8f}"
    return f"{value.real:.8f} {'+' if value.imag > 0 else '-'} {abs(value.imag):.8f}j"


def complex_list(values: Iterable[complex]) -> str:
    """Several numbers with six digits."""
    return ", ".join(f"{v.real:.6g}" if v.imag == 0 else f"{v.real:.6g}{v.imag:+.6g}j"
                     for v in values) or "none"  # fmt: skip


def exact_text(value: Any) -> str:
    """An exact number as it is, or in twelve digits where that would be long."""
    text = str(value)
    return text if len(text) <= 28 else f"{rounded(value):.12g}"


def power_text(powers: dict[str, float]) -> str:
    """Mean squares by name, in three digits."""
    return shortened(
        ", ".join(
            f"{name} {value:.3g}" if value < float("inf") else f"{name} beyond float64"
            for name, value in powers.items()
        )
    )


def rounded(value: Any) -> float:
    """An exact number as a float64; infinite where it is beyond its range."""
    try:
        return float(value)
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
