"""Stores of version 0.2 and before, which were SQLite files: read once, and made into a folder.

All that is known of them is here, and goes with a later version.
"""

from __future__ import annotations

import json
import math
import os
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.libraries import require_library
from rcac_experiments.sweeps._canonical import canonical_json, digest
from rcac_experiments.sweeps._check import StoreCheck
from rcac_experiments.sweeps._chunk import FAILED, RunRecord
from rcac_experiments.sweeps._folder import SQLITE, Folder
from rcac_experiments.sweeps._plan import Stage
from rcac_experiments.sweeps._problems import StoreError
from rcac_experiments.sweeps._study_file import NO_STUDY, StoredStudy, plan_of
from rcac_numeric.arrays._array_types import Array

OLD_FORMAT = 2
APPLICATION = 0x52434143  # "RCAC"
DONE = 2  # the state of a chunk that has ended
BESIDE = ("-journal", "-wal", "-shm")  # what SQLite reads, writes and removes by itself
Row = tuple[Any, ...]

# Compared letter by letter: a store holds these tables and nothing else, no view and no trigger.
FIXED = {
    "study": "CREATE TABLE study (resolved TEXT, fingerprint TEXT, file TEXT, title TEXT, "
    "versions TEXT, instruction_set TEXT, created TEXT, chunk_size INTEGER, stages TEXT, "
    "mixed TEXT, origin TEXT, digest TEXT)",
    "chunk": "CREATE TABLE chunk (chunk INTEGER PRIMARY KEY, first INTEGER, last INTEGER, "
    "state INTEGER, owner TEXT, until REAL, tries INTEGER, failed INTEGER, seconds REAL, "
    "digest TEXT)",
    "trajectory": "CREATE TABLE trajectory (run INTEGER, name TEXT, shape TEXT, float64 BLOB, "
    "PRIMARY KEY (run, name)) WITHOUT ROWID",
}


class _Damaged(Exception):
    """Some runs are not what was stored; why."""


@dataclass(frozen=True)
class _Old:
    """An old store that is open: its study, and what its chunks are bound to."""

    path: Path
    connection: sqlite3.Connection
    about: StoredStudy
    origin: str

    def records(self, number: int) -> list[RunRecord]:
        """The runs of a chunk that has ended; none where it has not. Raises `_Damaged`."""
        first, last = self.about.plan.chunk(number)
        try:
            chunks = self._rows("SELECT * FROM chunk WHERE chunk = ?", (number,), 1)
            between = "WHERE run BETWEEN ? AND ? ORDER BY run"
            rows = self._rows(f"SELECT * FROM run {between}", (first, last), last - first + 1)
            if len(chunks) != 1 or chunks[0][:3] != (number, first, last):
                raise _Damaged("their chunk is not where it belongs")
            _, _, _, state, _, _, tries, failed, seconds, bound = chunks[0]
            if state != DONE:
                if rows or bound is not None:
                    raise _Damaged("they have not ended, and have rows")
                return []
            if bound != _digest([self.origin, (number, first, last, tries, failed, seconds), rows]):
                raise _Damaged("they are not what was stored")
            # From here on only who can compute digests comes: the numbers are what he wrote.
            if [row[:3] for row in rows] != self.about.plan.places(number):
                raise _Damaged("they are not those of the study")
            return [self._record(row) for row in rows]
        except sqlite3.Error as error:
            raise _Damaged(f"SQLite cannot read them ({error})") from None
        except (TypeError, ValueError, AttributeError, OverflowError) as error:
            raise _Damaged(f"something in them is of another kind ({error})") from None

    def _rows(self, statement: str, values: tuple[int, ...], most: int) -> list[Row]:
        found = self.connection.execute(statement, values).fetchmany(most + 1)
        if len(found) > most:
            raise _Damaged("there are more rows than runs")
        return found

    def _record(self, row: Row) -> RunRecord:
        run, _, _, outcome, words, of_signals, *numbers = row
        if not (type(outcome) is str and type(words) is str and type(of_signals) in (str, _NONE)):
            raise _Damaged("they hold what is no text")
        if not {type(number) for number in numbers} <= {float, _NONE}:
            raise _Damaged("they hold what is no number")
        kept = self.about.resolved["keep_signals"]
        signals = self._rows(
            "SELECT name, shape, float64 FROM trajectory WHERE run = ? ORDER BY name", (run,),
            len(kept),
        )  # fmt: skip
        if _digest_of_signals(signals) != of_signals or (
            signals and sorted(kept) != [name for name, _, _ in signals]
        ):
            raise _Damaged("their signals are not what was stored")
        if outcome in FAILED:
            if of_signals is not None or any(number is not None for number in numbers):
                raise _Damaged("some failed and did not")
            return RunRecord(run, outcome, words, [], {})
        values = [math.nan if number is None else number for number in numbers]
        return RunRecord(run, outcome, words, values, dict(map(_signal, signals)))


_NONE = type(None)


def convert_store(old: str | Path, folder: str | Path) -> StoreCheck:
    """Make the folder of a study from a store of an earlier version, an SQLite file.

    The file is read as it stands, and nothing in it or beside it is changed. Its runs keep their
    numbers; those that are not what was stored are left out, named in the answer, and computed
    when the study is run into the folder.

    Parameters
    ----------
    old : path
    folder : path
        Made where there is none; one that holds a study already is refused.

    Raises
    ------
    StoreError
        Where the file is no such store, something lies beside it that SQLite left there, its study
        is damaged, or the folder cannot be used.

    Examples
    --------
    >>> from rcac_experiments.sweeps import convert_store
    >>> convert_store("study.toml", "study")
    Traceback (most recent call last):
        ...
    rcac_experiments.sweeps._problems.StoreError: study.toml cannot be read: there is no such file.
    """
    require_library("pyarrow")
    path = Path(old)
    with _opened(path) as store, Folder(folder, make=True) as new:
        if not new.is_new:
            raise StoreError(f"{folder} holds a study already; give a folder that is not there.")
        new.begin(store.about)
        plan, done, failed = store.about.plan, 0, 0
        damaged: list[tuple[int, int]] = []
        faults: list[str] = []
        for number in range(1, plan.chunks + 1):
            try:
                records = store.records(number)
            except _Damaged as fault:
                damaged.append(plan.chunk(number))
                faults.append("the runs {} to {}: {}".format(*plan.chunk(number), fault))
                continue
            if records:
                new.put(number, records)
                done += len(records)
                failed += sum(record.failed for record in records)
    return StoreCheck(str(folder), done, plan.runs, failed, tuple(damaged), tuple(faults))


@contextmanager
def _opened(path: Path) -> Iterator[_Old]:
    """An old store, read only; nothing that lies beside it is looked at by SQLite."""
    size = _require_old(path)
    uri = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
    try:
        connection = sqlite3.connect(uri, uri=True)
    except sqlite3.Error as error:
        raise StoreError(f"{path} cannot be read: {error}.") from None
    try:
        try:
            about, origin = _study(connection)
            if max(about.plan.chunks, about.plan.stages[-1].cells) > size:  # each takes some bytes
                raise ValueError(f"{size} bytes cannot hold its chunks and cells")
        except (sqlite3.Error, *NO_STUDY) as error:
            raise StoreError(
                f"{path} is damaged or no store of an earlier version: {error}. Nothing was "
                "changed. Take it from a copy, or run the study into a folder."
            ) from None
        yield _Old(path, connection, about, origin)
    finally:
        connection.close()


def _require_old(path: Path) -> int:
    """Refuse what is no SQLite file, and one with something beside it; the bytes of the file."""
    try:
        is_ordinary = path.is_file() or not os.path.lexists(os.path.realpath(path))
        if is_ordinary:
            with path.open("rb") as file:
                head, size = file.read(len(SQLITE)), os.fstat(file.fileno()).st_size
    except FileNotFoundError:
        raise StoreError(f"{path} cannot be read: there is no such file.") from None
    except OSError as error:
        raise StoreError(f"{path} cannot be read: {error.strerror}.") from None
    except ValueError as error:  # a null character in the path
        raise StoreError(f"{str(path)!r} cannot be read: {error}.") from None
    if not is_ordinary:
        raise StoreError(f"{path} is no store of an earlier version: it is no ordinary file.")
    if head != SQLITE:
        raise StoreError(
            f"{path} is damaged or no store of an earlier version: it does not begin as an SQLite "
            "file. Nothing was changed."
        )
    for end in BESIDE:
        if os.path.lexists(os.path.realpath(path) + end):
            raise StoreError(
                f"{path.name}{end} lies beside {path}: results wait in it, or it is from others "
                "and leads elsewhere. Nothing was changed. If the store is yours, give its last "
                "command once more to the version that wrote it; else remove that file."
            )
    return size


def _study(connection: sqlite3.Connection) -> tuple[StoredStudy, str]:
    """What the store says of its study; raises one of `NO_STUDY`, or SQLite's own error."""
    execute = connection.execute
    execute("PRAGMA trusted_schema = OFF")
    execute("PRAGMA cell_size_check = ON")
    application, form = (
        execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")
    )
    if application != APPLICATION:
        raise ValueError("it is a database of another program")
    if form != OLD_FORMAT:
        raise ValueError(f"it is written in format {form}, and {OLD_FORMAT} is read")
    found = {
        name: sql if kind == "table" else ""
        for kind, name, sql in execute("SELECT type, name, sql FROM sqlite_master").fetchmany(9)
    }
    if not FIXED.items() <= found.items():
        raise ValueError("its tables are not those of a store")
    rows = execute("SELECT * FROM study").fetchmany(2)
    if len(rows) != 1 or rows[0][-1] != _digest(list(rows[0][:-1])):
        raise ValueError("its study is not what was written")
    (resolved, fingerprint, file, title, made_with, instructions, created, chunk_size, stages,
     mixed, origin, _) = rows[0]  # fmt: skip
    resolved, made_with, stages, mixed = map(json.loads, (resolved, made_with, stages, mixed))
    texts = [fingerprint, file, title, instructions, created, origin, *made_with, *mixed]
    if not all(type(text) is str for text in [*texts, *made_with.values()]):
        raise TypeError("something in it is of another kind")
    if fingerprint != digest(canonical_json(resolved)) or type(mixed) is not list:
        raise ValueError("its fingerprint is that of another one")
    plan = plan_of(resolved, tuple(Stage(tuple(n), r) for n, r in stages), chunk_size)
    about = StoredStudy(resolved, file, title, made_with, instructions, created, plan, tuple(mixed))
    coordinates = "".join(f', "{name}"' for name in about.axes)
    measures = "".join(f', "{name}" REAL' for name in about.measures)
    if found != {
        **FIXED,
        "cell": f"CREATE TABLE cell (cell INTEGER PRIMARY KEY{coordinates})",
        "run": "CREATE TABLE run (run INTEGER PRIMARY KEY, cell INTEGER, repetition INTEGER, "
        f"outcome TEXT, failure TEXT, signals_digest TEXT{measures})",
    }:
        raise ValueError("its tables are not those of a store")
    return about, origin


def _signal(row: Row) -> tuple[str, Array]:
    name, shape, data = row
    sizes = [int(n) for n in shape.split(",")]
    if min(sizes) < 0:
        raise ValueError("a signal has no such shape")
    return name, np.frombuffer(data, "<f8").reshape(sizes)


def _digest(value: Any) -> str:
    text = json.dumps(value, separators=(",", ":"))
    return blake2b(text.encode(), digest_size=16).hexdigest()


def _digest_of_signals(signals: Sequence[Row]) -> str | None:
    if not signals:
        return None
    found = blake2b(digest_size=16)
    for name, shape, data in signals:
        head = json.dumps([name, shape, len(data)]).encode()
        found.update(len(head).to_bytes(8, "little") + head)
        found.update(data)
    return found.hexdigest()
