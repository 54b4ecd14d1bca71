"""A store as version 0.2 wrote it, an SQLite file of format 2, with what a folder holds."""

import json
import sqlite3
from contextlib import closing
from hashlib import blake2b

import numpy as np
import pyarrow
from pyarrow import parquet

from rcac_experiments.sweeps._chunk import FAILED
from rcac_experiments.sweeps._chunk_files import INTEGERS, NUMBERS, decode
from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._reader import file_of

ORIGIN = "0123456789abcdef"


def write(folder, path):
    """Every chunk of a folder, and its study, into an SQLite file."""
    with Folder(folder) as store, closing(sqlite3.connect(path)) as connection, connection:
        about = store.study
        tables(connection, about)
        study(connection, about)
        for number in range(1, about.plan.chunks + 1):
            chunk(connection, store, number)


def tables(connection, about):
    axes = "".join(f', "{name}"' for name in about.axes)
    measures = "".join(f', "{name}" REAL' for name in about.measures)
    for statement in (
        "CREATE TABLE study (resolved TEXT, fingerprint TEXT, file TEXT, title TEXT, "
        "versions TEXT, instruction_set TEXT, created TEXT, chunk_size INTEGER, stages TEXT, "
        "mixed TEXT, origin TEXT, digest TEXT)",
        "CREATE TABLE chunk (chunk INTEGER PRIMARY KEY, first INTEGER, last INTEGER, "
        "state INTEGER, owner TEXT, until REAL, tries INTEGER, failed INTEGER, seconds REAL, "
        "digest TEXT)",
        "CREATE TABLE trajectory (run INTEGER, name TEXT, shape TEXT, float64 BLOB, "
        "PRIMARY KEY (run, name)) WITHOUT ROWID",
        f"CREATE TABLE cell (cell INTEGER PRIMARY KEY{axes})",
        "CREATE TABLE run (run INTEGER PRIMARY KEY, cell INTEGER, repetition INTEGER, "
        f"outcome TEXT, failure TEXT, signals_digest TEXT{measures})",
        "PRAGMA user_version = 2",
        f"PRAGMA application_id = {0x52434143}",
    ):
        connection.execute(statement)


def study(connection, about):
    """The row of the study, with its digest."""
    row = [
        json.dumps(about.resolved), about.fingerprint, about.file, about.title,
        json.dumps(about.versions), about.instruction_set, about.created, about.plan.chunk_size,
        json.dumps([[list(s.lengths), s.repetitions] for s in about.plan.stages]),
        json.dumps(about.mixed), ORIGIN,
    ]  # fmt: skip
    connection.execute("DELETE FROM study")
    connection.execute(f"INSERT INTO study VALUES ({places(12)})", (*row, digest(row)))


def chunk(connection, store, number):
    """The rows of a chunk that has ended, or of one that is free."""
    about = store.study
    first, last = about.plan.chunk(number)
    free = "INSERT INTO chunk VALUES (?, ?, ?, 0, NULL, NULL, 0, 0, NULL, NULL)"
    connection.execute(free, (number, first, last))
    if number not in store.numbers():
        return
    data, layout = store.chunks.read(file_of(number), 10**9), store.layout(number)
    columns = decode(layout, number, last - first + 1, data)
    signals = parquet.read_table(pyarrow.BufferReader(data), columns=layout.of(NUMBERS, INTEGERS))
    columns |= signals.to_pydict()
    rows = []
    for i, place in enumerate(about.plan.places(number)):
        signals = []
        for name in sorted(about.resolved["keep_signals"]):
            if (shape := columns[f"{name}.shape"][i]) is not None:
                values = np.asarray(columns[f"{name}.values"][i]).astype("<f8").tobytes()
                signals.append((name, ",".join(map(str, shape)), values))
        for signal in signals:
            connection.execute("INSERT INTO trajectory VALUES (?, ?, ?, ?)", (place[0], *signal))
        numbers = [float(columns[name][i]) for name in about.measures]
        rows.append((
            *place, columns["outcome"][i], columns["failure"][i], digest_of_signals(signals),
            *(None if np.isnan(number) else number for number in numbers),
        ))  # fmt: skip
    connection.executemany(f"INSERT INTO run VALUES ({places(len(rows[0]))})", rows)
    failed = sum(outcome in FAILED for outcome in columns["outcome"])
    result = digest([ORIGIN, (number, first, last, 0, failed, 0.25), rows])
    connection.execute(
        "UPDATE chunk SET state = 2, failed = ?, seconds = 0.25, digest = ? WHERE chunk = ?",
        (failed, result, number),
    )


def places(count):
    return ", ".join("?" * count)


def digest(value):
    text = json.dumps(value, separators=(",", ":"))
    return blake2b(text.encode(), digest_size=16).hexdigest()


def digest_of_signals(signals):
    if not signals:
        return None
    result = blake2b(digest_size=16)
    for name, shape, data in signals:
        head = json.dumps([name, shape, len(data)]).encode()
        result.update(len(head).to_bytes(8, "little") + head)
        result.update(data)
    return result.hexdigest()
