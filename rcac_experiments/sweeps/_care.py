"""Whether a store is whole, and making it whole again as far as that can be done."""

from __future__ import annotations

import os
import shutil
import sqlite3
import stat
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from rcac_experiments.sweeps._beside import DAMAGED, NOT_THROUGH
from rcac_experiments.sweeps._claims import is_gone
from rcac_experiments.sweeps._problems import StoreError, damaged, explained
from rcac_experiments.sweeps._store import (
    DONE,
    LEASED,
    LONGEST_LEASE,
    ChunkRow,
    Row,
    Store,
    cell_rows,
    chunk_fault,
    rows_fault,
    signals_fault,
)
from rcac_numeric.arrays._files import FLAGS, replacing
from rcac_numeric.arrays._values import Value

MOST_FAULTS = 100  # of SQLite's own check


@dataclass(frozen=True)
class StoreCheck(Value):
    """What a check of a store found.

    Attributes
    ----------
    path : str
    done, total : int
        Runs whose rows and signals are what was stored, and runs of the study.
    failed : int
        How many of the former failed.
    damaged : tuple of (int, int)
        Runs, the first and the last one of each chunk, that had ended and are not what was stored.
    faults : tuple of str
        All that is wrong, in words.
    repaired : bool
        Whether the damaged runs have been set free, to be run again.
    """

    path: str
    done: int
    total: int
    failed: int
    damaged: tuple[tuple[int, int], ...]
    faults: tuple[str, ...]
    repaired: bool = False

    @property
    def is_whole(self) -> bool:
        """Whether nothing is wrong."""
        return not self.faults

    def __str__(self) -> str:
        if not self.total:
            return f"{self.path}: no study was stored in it yet; nothing is damaged."
        words = f"{self.path}: {self.done} of {self.total} runs are stored and right"
        words += f", {self.failed} of them failed" if self.failed else ""
        if self.is_whole:
            return f"{words}; nothing is damaged."
        lost = sum(last - first + 1 for first, last in self.damaged)
        lines = [f"{words}; {lost} are damaged."] if lost else [f"{words}."]
        lines += self.faults
        if self.repaired:
            lines.append("What was right is kept; the rest is run again when the study is run.")
        return "\n".join(lines)


def check_store(store: str | Path) -> StoreCheck:
    """Read everything in a store and hold it against its digests and its plan.

    Nothing in the file is changed. That runs have not been run yet is no fault, nor that none has
    and not even the study is there, as where a sweep was killed before its first chunk.

    Raises
    ------
    StoreError
        Where the file is no store, or its study is damaged, so that nothing can be held against it.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_experiments.sweeps import Kept, Study, check_store, run_study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"}, "signals": {"w": {"step": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2, "R_theta": 1},
    ...     "run": {"steps": 50}}
    >>> store = tempfile.mkdtemp() + "/study.sqlite"
    >>> _ = run_study(Study(base, [], [Kept("steps")]), store, workers=0)
    >>> check_store(store).is_whole
    True
    """
    with Store(store, read_only=True) as opened:
        return _checked(opened)[0]


def repair_store(store: str | Path) -> StoreCheck:
    """Keep what is right in a store, and let the rest be run again.

    The store is written anew, with the chunks of runs that are what was stored; the damaged file
    stays beside it, its name followed by ``.damaged``. Whoever runs the study next runs what is
    missing, and the table is that of an undisturbed store.

    Raises
    ------
    StoreError
        Where the file is no store, its study is damaged, somebody is at work on it, or the
        damaged file of an earlier repair is still there.

    Examples
    --------
    >>> import contextlib, sqlite3, tempfile
    >>> from rcac_experiments.sweeps import Kept, Study, read_table, repair_store, run_study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"}, "signals": {"w": {"step": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2, "R_theta": 1},
    ...     "run": {"steps": 50}}
    >>> study, store = Study(base, [], [Kept("steps")]), tempfile.mkdtemp() + "/study.sqlite"
    >>> _ = run_study(study, store, workers=0)
    >>> with contextlib.closing(sqlite3.connect(store)) as connection, connection:
    ...     _ = connection.execute("UPDATE run SET steps = 49")
    >>> repair_store(store).damaged
    ((0, 0),)
    >>> _ = run_study(study, store, workers=0)
    >>> read_table(store)["steps"].tolist()
    [50.0]
    """
    path = Path(os.path.realpath(store))  # what lies beside a store lies where the file is
    kept = [path.with_name(path.name + end) for end in DAMAGED]
    with Store(store, read_only=True) as opened:
        found, right = _checked(opened)
        if found.is_whole:
            return found
        for aside in kept:
            if os.path.lexists(aside):
                raise StoreError(
                    f"{aside} is there already, from an earlier repair; move it, so that nothing "
                    "is lost."
                )
        _require_unused(opened, right)
        with replacing(path) as new:
            with Store(new, "rollback") as made:
                _write(made, opened, right)
            opened.close()
            # What is not yet in the file itself stands in the second.
            for suffix, aside in zip(("", "-wal"), kept, strict=True):
                _copy(path.with_name(path.name + suffix), aside)
            for suffix in ("-wal", "-shm"):
                path.with_name(path.name + suffix).unlink(missing_ok=True)
    return StoreCheck(
        found.path, found.done, found.total, found.failed, found.damaged, found.faults, True
    )


def _copy(source: Path, new: Path) -> None:
    """An ordinary file, if it is there, into one that is made by it; through no link."""
    with suppress(FileNotFoundError):
        handle = os.open(source, os.O_RDONLY | NOT_THROUGH)
        with open(handle, "rb") as old:
            if stat.S_ISREG(os.fstat(handle).st_mode):
                with open(os.open(new, FLAGS, 0o600), "wb") as made:
                    shutil.copyfileobj(old, made)


def _checked(store: Store) -> tuple[StoreCheck, list[ChunkRow]]:
    """What is wrong, and the chunks with which nothing is: those that have ended and are right."""
    if store.is_new:
        return StoreCheck(str(store.path), 0, 0, 0, (), ()), []
    plan = store.study.plan
    for count, what in ((plan.chunks, "chunks of runs"), (plan.cells, "cells")):
        if count > store.bytes_held:  # each takes some bytes
            raise StoreError(damaged(store.path, f"it cannot hold the {count} {what}"))
    faults = _of_sqlite(store)
    right: list[ChunkRow] = []
    broken: list[tuple[int, int]] = []
    known = _chunks(store, faults)
    done = failed = 0
    for number in range(1, plan.chunks + 1):
        chunk = known.pop(number, None)
        first, last = plan.chunk(number)
        if chunk is None:
            fault = f"the chunk {number} of its runs is not there"
        else:
            fault = chunk_fault(plan, number, chunk) or _fault(store, chunk)
        if fault:
            faults.append(f"runs {first} to {last}: {fault}")
            broken.append((first, last))
        elif chunk is not None:
            right.append(chunk)
            if chunk.state == DONE:
                done, failed = done + last - first + 1, failed + chunk.failed
    faults += [f"there is a chunk {number} of runs that the study has not" for number in known]
    faults += _of_tables(store, [chunk for chunk in right if chunk.state == DONE], not broken)
    check = StoreCheck(
        str(store.path), done, plan.runs, failed, tuple(broken), tuple(dict.fromkeys(faults))
    )
    return check, right


def _of_sqlite(store: Store) -> list[str]:
    """What SQLite finds wrong with its own pages."""
    try:
        with explained(store.path):
            rows = store.connection.execute(f"PRAGMA integrity_check({MOST_FAULTS})").fetchall()
    except StoreError as error:
        return [str(error)]
    return [f"the file's own structure: {words}" for (words,) in rows if words != "ok"]


def _chunks(store: Store, faults: list[str]) -> dict[int, ChunkRow]:
    """The chunks that can be read, by their number."""
    plan = store.study.plan
    try:
        with explained(store.path):
            rows = store.connection.execute("SELECT * FROM chunk ORDER BY chunk").fetchall()
        return {row[0]: ChunkRow(*row) for row in rows}
    except StoreError as error:
        faults.append(f"the table of chunks cannot be read as a whole ({error})")
    found = {}
    for number in range(1, plan.chunks + 1):
        try:
            with explained(store.path):
                row = store.connection.execute(
                    "SELECT * FROM chunk WHERE chunk = ?", (number,)
                ).fetchone()
        except StoreError:
            continue
        if row is not None:
            found[number] = ChunkRow(*row)
    return found


def _fault(store: Store, chunk: ChunkRow) -> str:
    """What is wrong with a chunk's rows and signals."""
    try:
        rows = _rows(store, chunk)
        if chunk.state != DONE:
            return "they have not ended, and have rows" if rows else ""
        if fault := rows_fault(store.study, chunk, rows):
            return fault
        for row in rows:
            if fault := signals_fault(store.study, row, store.stored_signals(row[0])):
                return fault
    except StoreError as error:
        return str(error)
    return ""


def _rows(store: Store, chunk: ChunkRow) -> list[Row]:
    with explained(store.path):
        return store.connection.execute(
            "SELECT * FROM run WHERE run BETWEEN ? AND ? ORDER BY run", (chunk.first, chunk.last)
        ).fetchall()


def _of_tables(store: Store, ended: list[ChunkRow], all_right: bool) -> list[str]:
    """What is wrong with tables as a whole: rows that nothing speaks of, and other coordinates."""
    faults = []
    expected = sum(chunk.last - chunk.first + 1 for chunk in ended)
    kept = len(store.study.resolved["keep_signals"])
    try:
        with explained(store.path):
            execute = store.connection.execute
            runs = execute("SELECT count(*) FROM run").fetchone()[0]
            with_signals = execute("SELECT count(signals_digest) FROM run").fetchone()[0]
            signals = execute("SELECT count(*) FROM trajectory").fetchone()[0]
            cells = execute("SELECT * FROM cell ORDER BY cell")
            others = sum(a != b for a, b in zip(cells, cell_rows(store.study.plan), strict=True))
    except (StoreError, ValueError, sqlite3.Error) as error:
        return [f"a table cannot be read to its end, or has other rows ({error})"]
    if all_right and runs != expected:
        faults.append(f"there are {runs} rows of runs, where {expected} runs have ended")
    if all_right and signals != with_signals * kept:
        faults.append("there are signals of runs that kept none")
    if others:
        faults.append(f"the coordinates of {others} cells in the table `cell` are other ones")
    return faults


def _require_unused(store: Store, chunks: list[ChunkRow]) -> None:
    at_work = [
        chunk for chunk in chunks
        if chunk.state == LEASED and 0 < (chunk.until or 0) - time.time() <= LONGEST_LEASE
        and not is_gone(str(chunk.owner))
    ]  # fmt: skip
    if at_work:
        raise StoreError(f"a process is at work on {store.path}; repair it when that has ended.")


def _write(new: Store, old: Store, right: list[ChunkRow]) -> None:
    """All that is right of an old store into a new file."""
    about = old.study
    by_number = {chunk.chunk: chunk for chunk in right if chunk.state == DONE}
    with new.writing() as connection:
        new.create_as(about)
        new.add_chunks(1, about.plan)
        for chunk in by_number.values():
            connection.execute(
                "UPDATE chunk SET state = ?, tries = ?, failed = ?, seconds = ?, digest = ? "
                "WHERE chunk = ?",
                (DONE, chunk.tries, chunk.failed, chunk.seconds, chunk.digest, chunk.chunk),
            )
            rows = _rows(old, chunk)
            places = ", ".join("?" * (6 + len(about.measures)))
            connection.executemany(f"INSERT INTO run VALUES ({places})", rows)
            connection.executemany(
                "INSERT INTO trajectory VALUES (?, ?, ?, ?)",
                ((row[0], *signal) for row in rows for signal in old.stored_signals(row[0])),
            )
