"""Reports as data: text, order and numbers, for a terminal and for JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from rcac_numeric.arrays._wording import shortened

# A renderer may dim what is quiet; warning and bad must catch the eye.
Level = Literal["plain", "quiet", "good", "warning", "bad"]
Record = Mapping[str, Any]


@dataclass(frozen=True)
class Text:
    """A sentence, or an entry of a table."""

    words: str
    level: Level = "plain"


@dataclass(frozen=True)
class Fact:
    """A name and its value in words, unit included; neighbours are written as two columns."""

    name: str
    value: str
    level: Level = "plain"


# An entry of a table: its lines.
Cell = tuple[Text, ...]


@dataclass(frozen=True)
class SheetTable:
    """Rows of entries under heads; a head names the unit of its column."""

    heads: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    has_names: bool = False  # in the first column, to be copied: none is broken over lines


Block = Text | Fact | SheetTable


@dataclass(frozen=True)
class Section:
    """A section of a report: blocks for people, and the same facts as a record for programs.

    Attributes
    ----------
    title, remark : str
        The remark continues the title in weaker type.
    blocks : tuple of Text, Fact or SheetTable
    record : mapping
        Names and values: numbers, complex numbers, arrays, texts, None, lists and mappings of
        them. The records of all sections together are the record of the sheet.
    """

    title: str = ""
    blocks: tuple[Block, ...] = ()
    record: Record = field(default_factory=dict)
    remark: str = ""


@dataclass(frozen=True)
class Sheet:
    """A report.

    Attributes
    ----------
    title, remark : str
    health : tuple of Text
        The lines that a reader must not miss, printed first.
    sections : tuple of Section
    notes : str
    """

    title: str
    remark: str = ""
    health: tuple[Text, ...] = ()
    sections: tuple[Section, ...] = ()
    notes: str = ""

    @property
    def record(self) -> dict[str, Any]:
        """The facts of all sections as one nested mapping."""
        whole: dict[str, Any] = {}
        for section in self.sections:
            _merge(whole, section.record)
        return whole


def cells(*entries: str | Text | Iterable[Text]) -> tuple[Cell, ...]:
    """Return a row of a table: each entry is text, a Text with its level, or several lines."""
    return tuple(
        (Text(entry),) if isinstance(entry, str)
        else (entry,) if isinstance(entry, Text)
        else tuple(entry)
        for entry in entries
    )  # fmt: skip


def _merge(whole: dict[str, Any], record: Record) -> None:
    for name, value in record.items():
        known = whole.get(name)
        if isinstance(known, dict) and isinstance(value, Mapping):
            _merge(known, value)
        elif name in whole:
            raise ValueError(f"two sections of a report record {name!r}")
        else:
            whole[name] = dict(value) if isinstance(value, Mapping) else value


def counted(number: int, noun: str) -> str:
    """A number with its noun, which takes an s in the plural."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


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


def as_dict(sheet: Sheet) -> dict[str, Any]:
    """The record of a report in the types of JSON.

    A complex number becomes [real, imaginary], an array a list; infinity, NaN and None become
    null, since strict JSON has no infinity and no NaN.
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
