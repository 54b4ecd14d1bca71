"""Tables of numbers in text files, with or without a row of names."""

from __future__ import annotations

import csv
from array import array
from pathlib import Path
from typing import TextIO

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._untrusted import ReadingLimit
from rcac_numeric.arrays._wording import shortened


def read_table(file: Path, *, named: bool) -> tuple[list[str], Array]:
    r"""Read the column names of a table and its numbers; shape (rows, columns)."""
    try:
        with _opened(file) as stream:
            head, row, delimiter = _first_row(file, stream)
        _require_room(file, delimiter)
        is_head = named or all(as_number(entry) is None for entry in row)
        names = _names(file, head, row) if is_head else []
        skipped = head if is_head else head - 1
        with _opened(file) as stream:
            for _ in range(skipped):
                stream.readline()
            table = _table(stream, delimiter)
        # Slower, but reports the line and the column of an error.
        if table is None or table.shape[1] != len(row):
            labels = names or [str(i) for i in range(1, len(row) + 1)]
            with _opened(file) as stream:
                table = _checked_table(file, stream, skipped, labels, delimiter)
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(
            f"{file} is not a text file of numbers: {shortened(str(error), 200)}."
        ) from None
    if not len(table):
        shown_names = f"the names {shortened(', '.join(names))} and " if names else ""
        raise InputError(f"{file} has {shown_names}no row of numbers.")
    return names, table


def as_number(text: str) -> float | None:
    """Return the number of a text, or None; Python's 1_000 is refused."""
    try:
        return None if "_" in text else float(text)
    except ValueError:
        return None


def _opened(file: Path) -> TextIO:
    return file.open(newline="", encoding="utf-8-sig")


def _first_row(file: Path, stream: TextIO) -> tuple[int, list[str], str]:
    """Return the number of the first nonempty line, its entries, and the separator."""
    for line, text in enumerate(stream, start=1):
        delimiter = next((d for d in ",;\t" if d in text), ",")
        row = [entry.strip() for entry in next(csv.reader([text], delimiter=delimiter), [])]
        if any(row):
            return line, row, delimiter
    raise InputError(f"{file} is empty.")


def _names(file: Path, line: int, row: list[str]) -> list[str]:
    if all(as_number(name) is not None for name in row):
        raise InputError(
            f"{file} begins with numbers; its first row must name the columns, for instance u,y,z."
        )
    if len(set(row)) < len(row) or not all(row):
        raise InputError(
            f"{file}, line {line}: the columns are named {shortened(', '.join(row))}; each needs a "
            "name of its own."
        )
    return row


def _table(stream: TextIO, delimiter: str) -> Array | None:
    """Return the remaining rows by NumPy's reader; None if an entry or a row is invalid."""
    place = stream.tell()
    while not (line := stream.readline()).strip("\r\n"):
        if not line:
            return np.empty((0, 0))  # NumPy would warn
    stream.seek(place)
    try:
        table = np.loadtxt(stream, delimiter=delimiter, comments=None, ndmin=2, quotechar='"')
    except ValueError:
        return None
    return np.asarray(table, dtype=np.float64)


def _require_room(file: Path, delimiter: str) -> None:
    """Raise if separators and line ends count more entries than the limit."""
    separator, count = delimiter.encode(), 0
    with file.open("rb") as stream:
        while piece := stream.read(2**20):
            count += piece.count(separator) + piece.count(b"\n") + piece.count(b"\r")
    ReadingLimit(file).take([count])


def _checked_table(
    file: Path, stream: TextIO, head: int, names: list[str], delimiter: str
) -> Array:
    entries = array("d")
    for line, row in enumerate(csv.reader(stream, delimiter=delimiter), 1):
        if line <= head or not any(row):
            continue
        if len(row) != len(names):
            raise InputError(
                f"{file}, line {line}: {len(row)} entries where {len(names)} are needed, one for "
                "each column."
            )
        entries.extend(_entry(file, line, n, entry) for n, entry in zip(names, row, strict=True))
    return np.array(entries, dtype=np.float64).reshape(-1, len(names))


def _entry(file: Path, line: int, name: str, entry: str) -> float:
    value = as_number(entry)
    if value is not None:
        return value
    hint = " Write decimals with a point." if as_number(entry.replace(",", ".")) is not None else ""
    raise InputError(
        f"{file}, line {line}, column {shortened(name, 60)}: {shortened(entry.strip(), 60)!r} is "
        f"not a number.{hint}"
    )
