"""A report as data: what is said, in which order, with which numbers; not how it is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

# plain and quiet are said, good is confirmed, warning and bad must not be missed.
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
class Table:
    """Rows of entries under heads; a head names the unit of its column."""

    heads: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


Block = Text | Fact | Table


@dataclass(frozen=True)
class Section:
    """What belongs together: for people the blocks, for programs the same facts as a record.

    Attributes
    ----------
    title, remark : str
        The remark continues the title, and is said less loudly.
    blocks : tuple of Text, Fact or Table
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
        What its reader must not miss, said first.
    sections : tuple of Section
    notes : str

    Examples
    --------
    >>> from rcac_numeric.reports.sheets.sheet import Section, Sheet, Text
    >>> from rcac_numeric.reports.sheets.json_record import as_json
    >>> from rcac_numeric.reports.sheets.terminal import as_text
    >>> loop = Section("The loop", (Text("radius 0.5"),), {"loop": {"radius": 0.5}})
    >>> sheet = Sheet("A case", sections=(loop,))
    >>> print(as_text(sheet))
    A case
    <BLANKLINE>
    The loop
      radius 0.5
    >>> print(as_json(sheet, indent=None))
    {"loop": {"radius": 0.5}}
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
    """A row of a table: each entry a word, a sentence with a level, or several lines."""
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
