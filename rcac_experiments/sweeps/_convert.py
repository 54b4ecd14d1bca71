"""Convert the stores of version 0.2 and earlier, which are SQLite files, to folders.

A later version will remove this module.
"""

from __future__ import annotations

import json
import math
import os
import sqlite3
from contextlib import closing
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
from rcac_experiments.sweeps._problems import Damaged, StoreError
from rcac_experiments.sweeps._study_file import NO_STUDY, StoredStudy, plan_of

OLD_FORMAT, APPLICATION = 2, 0x52434143  # "RCAC"
DONE = 2  # the state of a chunk that has ended
BESIDE = ("-journal", "-wal", "-shm")  # what SQLite reads, writes and removes by itself
Row = tuple[Any, ...]

# Compared letter by letter: a store holds these tables and nothing else, no view and no trigger.
TABLES = {
    "study": "resolved TEXT, fingerprint TEXT, file TEXT, title TEXT, versions TEXT, "
    "instruction_set TEXT, created TEXT, chunk_size INTEGER, stages TEXT, mixed TEXT, origin TEXT, "
    "digest TEXT)",
    "chunk": "chunk INTEGER PRIMARY KEY, first INTEGER, last INTEGER, state INTEGER, owner TEXT, "
    "until REAL, tries INTEGER, failed INTEGER, seconds REAL, digest TEXT)",
    "trajectory": "run INTEGER, name TEXT, shape TEXT, float64 BLOB, PRIMARY KEY (run, name)) "
    "WITHOUT ROWID",
    "cell": "cell INTEGER PRIMARY KEY{axes})",
    "run": "run INTEGER PRIMARY KEY, cell INTEGER, repetition INTEGER, outcome TEXT, failure TEXT, "
    "signals_digest TEXT{measures})",
}


def convert_store(old: str | Path, folder: str | Path) -> StoreCheck:
    """Convert a store of an earlier version, an SQLite file, to the folder of a study.

    The file and its folder are not changed. Runs keep their numbers; damaged runs are omitted, are
    listed in the result, and are computed when the study is run into the new folder.

    Parameters
    ----------
    old : path
    folder : path
        It is made if it does not exist; a folder with a study is refused.

    Raises
    ------
    StoreError
        If the file is no such store, if SQLite left a journal beside it, if its study is damaged,
        or if the folder cannot be used.

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
    size = _require_old(path)
    damaged, faults, done, failed = [], [], 0, 0
    # Read only, and nothing that lies beside it is looked at by SQLite.
    uri = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
    with closing(sqlite3.connect(uri, uri=True)) as connection:
        try:
            about, origin = _study(connection)
            if max(about.plan.chunks, about.plan.stages[-1].cells) > size:  # each takes some bytes
                raise ValueError(f"{size} bytes cannot hold its chunks and cells")
        except (sqlite3.Error, *NO_STUDY) as error:
            raise StoreError(
                f"{path} is damaged or no store of an earlier version: {error}. Nothing was "
                "changed. Take it from a copy, or run the study into a folder."
            ) from None
        plan = about.plan
        with Folder(folder, make=True) as new:
            if not new.is_new:
                raise StoreError(f"{folder} contains a study; give a new folder.")
            new.begin(about)
            for number in range(1, plan.chunks + 1):
                try:
                    records = _records(connection, about, origin, number)
                except (Damaged, sqlite3.Error, *NO_STUDY) as fault:
                    first, last = plan.chunk(number)
                    damaged.append((first, last))
                    faults.append(f"the runs {first} to {last}: {fault}")
                    continue
                if records:
                    new.put(number, records)
                    done += len(records)
                    failed += sum(record.failed for record in records)
    return StoreCheck(str(folder), done, plan.runs, failed, tuple(damaged), tuple(faults))


def _require_old(path: Path) -> int:
    """Return the bytes of a SQLite file; refuse others, and one with a journal beside it."""
    try:
        is_ordinary = path.is_file() or not os.path.lexists(os.path.realpath(path))
        if is_ordinary:
            with path.open("rb") as file:
                head, size = file.read(len(SQLITE)), os.fstat(file.fileno()).st_size
    except FileNotFoundError:
        raise StoreError(f"{path} cannot be read: there is no such file.") from None
    except (OSError, ValueError) as error:  # a null character in the path is the latter
        raise StoreError(f"{str(path)!r} cannot be read: {error}.") from None
    if not is_ordinary or head != SQLITE:
        raise StoreError(
            f"{path} is damaged or no store of an earlier version: it does not begin as an SQLite "
            "file. Nothing was changed."
        )
    for end in BESIDE:
        if os.path.lexists(os.path.realpath(path) + end):
            raise StoreError(
                f"{path.name}{end} lies beside {path}: it may contain unwritten results, or come "
                "from "
                "others. Nothing was changed. If the store is yours, run its last command again "
                "with "
                "the version that wrote it; otherwise remove that file."
            )
    return size


def _study(connection: sqlite3.Connection) -> tuple[StoredStudy, str]:
    """Read the study of the store; raise one of `NO_STUDY`, or an error of SQLite."""
    execute = connection.execute
    execute("PRAGMA trusted_schema = OFF")
    execute("PRAGMA cell_size_check = ON")
    form = [execute(f"PRAGMA {it}").fetchone()[0] for it in ("application_id", "user_version")]
    if form != [APPLICATION, OLD_FORMAT]:
        raise ValueError("it is a database of another program, or in another format")
    tables = dict(execute("SELECT name, sql FROM sqlite_master").fetchmany(9))
    if tables.get("study") != f"CREATE TABLE study ({TABLES['study']}":
        raise ValueError("its tables are not those of a store")
    rows = execute("SELECT * FROM study").fetchmany(2)
    if len(rows) != 1 or rows[0][-1] != _digest(list(rows[0][:-1])):
        raise ValueError("its study does not match its digest")
    (resolved, fingerprint, file, title, used_versions, instructions, created, chunk_size, stages,
     mixed, origin, _) = rows[0]  # fmt: skip
    resolved, used_versions, stages, mixed = map(
        json.loads, (resolved, used_versions, stages, mixed)
    )
    texts = [fingerprint, file, title, instructions, created, origin, *used_versions, *mixed]
    if not all(type(text) is str for text in [*texts, *used_versions.values()]):
        raise TypeError("an entry has the wrong type")
    if fingerprint != digest(canonical_json(resolved)) or type(mixed) is not list:
        raise ValueError("its fingerprint does not match its study")
    plan = plan_of(resolved, tuple(Stage(tuple(n), r) for n, r in stages), chunk_size)
    about = StoredStudy(
        resolved, file, title, used_versions, instructions, created, plan, tuple(mixed)
    )
    columns = {
        "axes": "".join(f', "{name}"' for name in about.axes),
        "measures": "".join(f', "{name}" REAL' for name in about.measures),
    }
    if tables != {
        name: f"CREATE TABLE {name} ({words.format(**columns)}" for name, words in TABLES.items()
    }:
        raise ValueError("its tables are not those of a store")
    return about, origin


def _records(
    connection: sqlite3.Connection, about: StoredStudy, origin: str, number: int
) -> list[RunRecord]:
    """Read the runs of a completed chunk; raise `Damaged` or other errors."""

    def rows_of(statement: str, values: Row, most: int) -> list[Row]:
        rows = connection.execute(f"SELECT {statement}", values).fetchmany(most + 1)
        if len(rows) > most:
            raise Damaged("there are more rows than runs")
        return rows

    def signals_of(run: int, bound: str | None) -> dict[str, Any]:
        stored = rows_of("name, shape, float64 FROM trajectory WHERE run = ? ORDER BY name",
                         (run,), len(names))  # fmt: skip
        if _digest_of_signals(stored) != bound or (stored and names != [row[0] for row in stored]):
            raise Damaged("their signals do not match their digest")
        return {
            name: np.frombuffer(data, "<f8").reshape([abs(int(n)) for n in shape.split(",")])
            for name, shape, data in stored
        }

    names = sorted(about.resolved["keep_signals"])
    first, last = about.plan.chunk(number)
    chunks = rows_of("* FROM chunk WHERE chunk = ?", (number,), 1)
    between = "* FROM run WHERE run BETWEEN ? AND ? ORDER BY run"
    rows = rows_of(between, (first, last), last - first + 1)
    if len(chunks) != 1 or chunks[0][:3] != (number, first, last):
        raise Damaged("the row of their chunk is missing or wrong")
    _, _, _, state, _, _, tries, failed, seconds, bound = chunks[0]
    if state != DONE and not rows and bound is None:
        return []
    signed = [origin, (number, first, last, tries, failed, seconds), rows]
    if state != DONE or bound != _digest(signed):
        raise Damaged("they do not match their digest")
    # From here on only who can compute digests comes: the numbers are what he wrote.
    if [row[:3] for row in rows] != about.plan.places(number):
        raise Damaged("their numbers are not those of the plan")
    records = []
    for run, _, _, outcome, words, of_signals, *numbers in rows:
        if not {type(outcome), type(words)} <= {str} or not set(map(type, numbers)) <= KINDS:
            raise Damaged("they hold an entry that is neither text nor number")
        if outcome in FAILED and any(n is not None for n in (of_signals, *numbers)):
            raise Damaged("a failed run has values")
        values = [math.nan if n is None else n for n in numbers if outcome not in FAILED]
        records.append(RunRecord(run, outcome, words, values, signals_of(run, of_signals)))
    return records


KINDS = {float, type(None)}


def _digest(value: Any) -> str:
    text = json.dumps(value, separators=(",", ":"))
    return blake2b(text.encode(), digest_size=16).hexdigest()


def _digest_of_signals(signals: list[Row]) -> str | None:
    digest = blake2b(digest_size=16)
    for name, shape, data in signals:
        head = json.dumps([name, shape, len(data)]).encode()
        digest.update(len(head).to_bytes(8, "little") + head)
        digest.update(data)
    return digest.hexdigest() if signals else None
