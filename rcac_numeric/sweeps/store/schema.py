"""The tables of a store, and what stands in their columns."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Sequence
from typing import Any

FORMAT = 1
APPLICATION = 0x52434143  # "RCAC": what `file` and SQLite know the file by
FREE, LEASED, DONE = 0, 1, 2  # states of a chunk

FIXED = """
CREATE TABLE study (resolved TEXT, fingerprint TEXT, file TEXT, title TEXT, versions TEXT,
    instruction_set TEXT, created TEXT, chunk_size INTEGER);
CREATE TABLE block (first_run INTEGER PRIMARY KEY, first_cell INTEGER, cells INTEGER,
    first_repetition INTEGER, repetitions INTEGER);
CREATE TABLE chunk (chunk INTEGER PRIMARY KEY, first INTEGER, last INTEGER, state INTEGER,
    owner TEXT, until REAL, tries INTEGER, crc INTEGER, seconds REAL);
CREATE INDEX chunks_by_state ON chunk (state, chunk);
CREATE TABLE trajectory (run INTEGER, name TEXT, shape TEXT, float64 BLOB,
    PRIMARY KEY (run, name)) WITHOUT ROWID;
"""


def create_tables(connection: sqlite3.Connection, axes: Sequence[str], kept: Sequence[str]) -> None:
    """Make the empty tables; a column for every axis and for every measure."""
    for statement in FIXED.split(";"):
        connection.execute(statement)
    coordinates = "".join(f", {quoted(name)}" for name in axes)
    connection.execute(f"CREATE TABLE cell (cell INTEGER PRIMARY KEY{coordinates})")
    measures = "".join(f", {quoted(name)} REAL" for name in kept)
    connection.execute(
        "CREATE TABLE run (run INTEGER PRIMARY KEY, cell INTEGER, repetition INTEGER, "
        f"outcome TEXT, failure TEXT{measures})"
    )
    connection.execute(f"PRAGMA user_version = {FORMAT}")
    connection.execute(f"PRAGMA application_id = {APPLICATION}")


def quoted(name: str) -> str:
    """A column's name, be it a word of SQL's too."""
    return f'"{name}"'


def is_plain(values: Iterable[Any]) -> bool:
    """Whether the values of an axis stand in their column as they are; others stand as JSON."""
    return all(isinstance(v, str | float) or (type(v) is int and abs(v) < 2**63) for v in values)


def stored(value: Any, plain: bool) -> Any:
    """A coordinate as it stands in its column."""
    return value if plain else json.dumps(value)


def read(value: Any, plain: bool) -> Any:
    """A coordinate from its column."""
    return value if plain else json.loads(value)
