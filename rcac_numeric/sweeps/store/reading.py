"""What is in a store, read back and held against its checksums."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.sweeps.store.claims import checksum
from rcac_numeric.sweeps.store.problems import StoreError, damaged, explained
from rcac_numeric.sweeps.store.schema import DONE, is_plain, quoted, read
from rcac_numeric.sweeps.store.store import Store

Row = tuple[Any, ...]


def stored_runs(store: Store) -> Iterator[list[Row]]:
    """The rows of each chunk that has ended, by increasing run.

    Raises
    ------
    StoreError
        Where a row is not what was written.
    """
    with explained(store.path):
        chunks = store.connection.execute(
            "SELECT first, last, crc FROM chunk WHERE state = ? ORDER BY first", (DONE,)
        ).fetchall()
        for first, last, crc in chunks:
            rows = store.connection.execute(
                "SELECT * FROM run WHERE run BETWEEN ? AND ? ORDER BY run", (first, last)
            ).fetchall()
            if checksum(rows) != crc:
                raise StoreError(
                    damaged(store.path, f"the runs {first} to {last} are not what was stored")
                )
            yield rows


def cell_columns(store: Store) -> dict[str, NDArray[Any]]:
    """The coordinates of all cells: an array for each axis, by the number of the cell."""
    columns: dict[str, NDArray[Any]] = {}
    for axis in store.study.resolved["axes"]:
        plain = is_plain(axis["values"])
        with explained(store.path):
            rows = store.connection.execute(
                f"SELECT {quoted(axis['name'])} FROM cell ORDER BY cell"
            )
            columns[axis["name"]] = column([read(value, plain) for (value,) in rows])
    return columns


def column(values: list[Any]) -> NDArray[Any]:
    """An array of one kind: integers, floats, texts, truth values; else of objects."""
    kinds = {type(value) for value in values}
    if kinds <= {int} or kinds <= {bool} or kinds <= {str}:
        return np.array(values)
    if kinds <= {int, float}:
        return np.array(values, dtype=np.float64)
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array


def stored_run(store: Store, run: int) -> Row:
    """One row.

    Raises
    ------
    StoreError
        Where there is no such run, or it has not ended yet.
    """
    with explained(store.path):
        chunk = store.connection.execute(
            "SELECT first, last, crc, state FROM chunk WHERE ? BETWEEN first AND last", (run,)
        ).fetchone()
        if chunk is None:
            raise StoreError(
                f"{store.path} has no run {run}; its runs are 0 to {store.counts()[1] - 1}."
            )
        if chunk[3] != DONE:
            raise StoreError(f"run {run} of {store.path} has not been run yet.")
        rows = store.connection.execute(
            "SELECT * FROM run WHERE run BETWEEN ? AND ? ORDER BY run", chunk[:2]
        ).fetchall()
    if checksum(rows) != chunk[2]:
        raise StoreError(damaged(store.path, f"the chunk of run {run} is not what was stored"))
    row: Row = rows[bisect_right([r[0] for r in rows], run) - 1]
    return row


def stored_signals(store: Store, run: int) -> dict[str, Array]:
    """The signals of one run that were kept."""
    with explained(store.path):
        rows = store.connection.execute(
            "SELECT name, shape, float64 FROM trajectory WHERE run = ?", (run,)
        ).fetchall()
    return {
        name: np.frombuffer(data, "<f8").reshape([int(n) for n in shape.split(",")])
        for name, shape, data in rows
    }
