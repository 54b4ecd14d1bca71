"""The file of a study: opened, made, compared with what is asked for, grown."""

from __future__ import annotations

import json
import platform
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from rcac_numeric.sweeps.store.plan import (
    Block,
    Resolved,
    cells_of,
    first_block,
    grown,
    new_blocks,
)
from rcac_numeric.sweeps.store.problems import StoreError, damaged, explained
from rcac_numeric.sweeps.store.schema import (
    APPLICATION,
    DONE,
    FORMAT,
    FREE,
    create_tables,
    is_plain,
    quoted,
    read,
    stored,
)
from rcac_numeric.sweeps.study.canonical import canonical_json, digest
from rcac_numeric.sweeps.study.study import Study

PATIENCE = 60.0  # seconds that SQLite waits for another process
JOURNALS = {"wal": "WAL", "rollback": "DELETE"}


@dataclass(frozen=True)
class StudyRow:
    """What a store says of its study."""

    resolved: Resolved
    fingerprint: str
    file: str
    title: str
    versions: dict[str, str]
    instruction_set: str
    created: str
    chunk_size: int


class Store:
    """An open store.

    Parameters
    ----------
    path : path
    journal : {"wal", "rollback"}
        "rollback" for a file on a network file system, where one process alone may use it.
    read_only : bool

    Raises
    ------
    StoreError
        Where the file is no store, is damaged, or is in use.
    """

    def __init__(self, path: str | Path, journal: str = "wal", read_only: bool = False) -> None:
        self.path, self.journal = Path(path), journal
        if read_only and not self.path.is_file():
            raise StoreError(f"{path} cannot be read: there is no such file.")
        mode = "?mode=ro" if read_only else ""
        with explained(self.path):
            self.connection = sqlite3.connect(
                f"{self.path.absolute().as_uri()}{mode}",
                uri=True, timeout=PATIENCE, isolation_level=None, check_same_thread=False,
            )  # fmt: skip
        try:
            with explained(self.path):
                self._settle(read_only)
        except BaseException:
            self.connection.close()
            raise

    @property
    def is_new(self) -> bool:
        """Whether nothing was stored in it yet."""
        with explained(self.path):
            return not self.connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """One transaction: all of it is stored, or nothing."""
        with explained(self.path):
            self.connection.execute("BEGIN IMMEDIATE")
            try:
                yield self.connection
                self.connection.execute("COMMIT")
            except BaseException:
                if self.connection.in_transaction:  # where the disk is full it is over already
                    self.connection.execute("ROLLBACK")
                raise

    def create(self, study: Study, instruction_set: str, chunk_size: int) -> bool:
        """Write down the study, its cells and its chunks; False where another process just did."""
        resolved = study.resolved
        names = [axis["name"] for axis in resolved["axes"]]
        with self.writing() as connection:
            if not self.is_new:
                return False
            create_tables(connection, names, [kept["name"] for kept in resolved["keep"]])
            connection.execute(
                "INSERT INTO study VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                (
                    json.dumps(resolved), digest(canonical_json(resolved)),
                    str(Path(study.file).resolve()), study.title,
                    canonical_json(versions()), instruction_set,
                    time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()), chunk_size,
                ),
            )  # fmt: skip
            self._add_cells(resolved, None)
            self._add_block(first_block(resolved), chunk_size)
        return True

    def grow(self, study: Study) -> None:
        """Add what the study asks for and the store has not; refuse another study."""
        row = self.study
        new = grown(self.path, row.resolved, study.resolved)
        if canonical_json(new) == canonical_json(row.resolved):
            return
        for old_axis, new_axis in zip(row.resolved["axes"], new["axes"], strict=True):
            if is_plain(old_axis["values"]) != is_plain(new_axis["values"]):
                raise StoreError(
                    f"{self.path}: the new values of the axis {old_axis['name']} are of another "
                    "kind than those in the store. Use another file."
                )
        runs = sum(block.runs for block in self.blocks)
        with self.writing() as connection:
            connection.execute(
                "UPDATE study SET resolved = ?, fingerprint = ?",
                (json.dumps(new), digest(canonical_json(new))),
            )
            self._add_cells(new, row.resolved)
            for block in new_blocks(row.resolved, new, runs):
                self._add_block(block, row.chunk_size)

    @property
    def study(self) -> StudyRow:
        """What is said of the study."""
        with explained(self.path):
            row = self.connection.execute("SELECT * FROM study").fetchone()
        try:
            resolved, fingerprint, file, title, made_with, instructions, created, size = row
            return StudyRow(
                json.loads(resolved), fingerprint, file, title, json.loads(made_with),
                instructions, created, size,
            )  # fmt: skip
        except (TypeError, ValueError, IndexError) as error:
            raise StoreError(damaged(self.path, f"its study cannot be read ({error})")) from None

    @property
    def blocks(self) -> list[Block]:
        """Which runs there are."""
        with explained(self.path):
            rows = self.connection.execute("SELECT * FROM block ORDER BY first_run")
            return [Block(*row) for row in rows]

    def counts(self) -> tuple[int, int]:
        """Runs that are stored, and runs in all."""
        with explained(self.path):
            done, whole = self.connection.execute(
                "SELECT total((last - first + 1) * (state = ?)), total(last - first + 1) "
                "FROM chunk", (DONE,),
            ).fetchone()  # fmt: skip
        return int(done), int(whole)

    def close(self) -> None:
        """Let go of the file."""
        self.connection.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _settle(self, read_only: bool) -> None:
        execute, is_new = self.connection.execute, self.is_new
        application, form = (execute(f"PRAGMA {n}").fetchone()[0] for n in
                             ("application_id", "user_version"))  # fmt: skip
        if not is_new and application != APPLICATION:
            raise StoreError(damaged(self.path, "it is a database of another program"))
        if not is_new and form != FORMAT:
            raise StoreError(
                f"{self.path} is written in format {form}; this version reads {FORMAT}."
            )
        if read_only:
            if is_new:
                raise StoreError(f"{self.path} is empty: no study was stored in it.")
            return
        if self.journal == "rollback":
            execute("PRAGMA locking_mode = EXCLUSIVE")
        _patiently(lambda: execute(f"PRAGMA journal_mode = {JOURNALS[self.journal]}"))
        # With WAL a loss of power can take the last chunks, and never damages the file.
        execute("PRAGMA synchronous = NORMAL" if self.journal == "wal" else
                "PRAGMA synchronous = FULL")  # fmt: skip

    def _add_cells(self, resolved: Resolved, old: Resolved | None) -> None:
        axes = resolved["axes"]
        kinds = [is_plain(axis["values"]) for axis in axes]
        places = ", ".join("?" * (1 + len(axes)))
        first = self.connection.execute("SELECT count(*) FROM cell").fetchone()[0]
        self.connection.executemany(
            f"INSERT INTO cell VALUES ({places})",
            (
                (number, *(stored(v, kind) for v, kind in zip(values, kinds, strict=True)))
                for number, values in enumerate(cells_of(resolved, old), first)
            ),
        )

    def _add_block(self, block: Block, chunk_size: int) -> None:
        self.connection.execute(
            "INSERT INTO block VALUES (?, ?, ?, ?, ?)",
            (block.first_run, block.first_cell, block.cells,
             block.first_repetition, block.repetitions),
        )  # fmt: skip
        last = block.first_run + block.runs - 1
        self.connection.executemany(
            "INSERT INTO chunk (first, last, state, tries) VALUES (?, ?, ?, 0)",
            (
                (first, min(first + chunk_size - 1, last), FREE)
                for first in range(block.first_run, last + 1, chunk_size)
            ),
        )


def _patiently(change: Callable[[], object]) -> None:
    """What SQLite refuses at once while another process does the same."""
    for pause in (0.05, 0.2, 0.5, 1.0, 2.0):
        try:
            change()
        except sqlite3.OperationalError as error:
            if "locked" not in str(error):
                raise
            time.sleep(pause)
        else:
            return
    change()


def coordinates_in(store: Store, cells: range) -> dict[int, dict[str, Any]]:
    """The coordinates of some cells."""
    axes = store.study.resolved["axes"]
    kinds = [is_plain(axis["values"]) for axis in axes]
    columns = "".join(f", {quoted(axis['name'])}" for axis in axes)
    with explained(store.path):
        rows = store.connection.execute(
            f"SELECT cell{columns} FROM cell WHERE cell BETWEEN ? AND ?",
            (cells.start, cells.stop - 1),
        ).fetchall()
    return {
        row[0]: {
            axis["name"]: read(value, kind)
            for axis, kind, value in zip(axes, kinds, row[1:], strict=True)
        }
        for row in rows
    }


def versions() -> dict[str, str]:
    """What else decides the last bits of a result."""
    found = {"python": platform.python_version()}
    for name in ("compensator-theory", "numpy", "scipy"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
