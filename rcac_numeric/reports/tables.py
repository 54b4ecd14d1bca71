"""How numbers are written in tables on the terminal and in JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable

from rich import box
from rich.table import Table


def table_of(*columns: str) -> Table:
    """A table with a line under its heads and no frame."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for column in columns:
        table.add_column(column, overflow="fold")
    return table


def complex_text(value: complex) -> str:
    """A number with eight decimals."""
    if abs(value.imag) < 1e-300:
        return f"{value.real:.8f}"
    return f"{value.real:.8f} {'+' if value.imag > 0 else '-'} {abs(value.imag):.8f}j"


def complex_list(values: Iterable[complex]) -> str:
    """Several numbers with six digits."""
    return ", ".join(f"{v.real:.6g}" if v.imag == 0 else f"{v.real:.6g}{v.imag:+.6g}j"
                     for v in values) or "none"  # fmt: skip


def finite_or_none(value: float) -> float | None:
    """The number, or null in JSON, which knows no infinity and no NaN."""
    return value if math.isfinite(value) else None
