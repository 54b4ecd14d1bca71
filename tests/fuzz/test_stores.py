"""Damaged stores: each is read as it was written, or refused in words; `--long` tries 10^4.

Three sorts: bytes that changed, rows that were edited, and edits by somebody who computes every
digest anew. Of the last the numbers are what the file says, but rows still fit the plan, nothing
crashes and nothing is imported.
"""

import json
import random
import sqlite3
import sys
from contextlib import closing, suppress

import numpy as np
import pytest

from rcac_experiments.sweeps import StoreError, check_store, read_table, repair_store, run_study
from rcac_experiments.sweeps._canonical import canonical_json, digest
from rcac_experiments.sweeps._chunk import FAILED
from rcac_experiments.sweeps._store import DONE, Store, chunk_digest, digest_of, signals_digest
from rcac_numeric.arrays._values import replaced as replace
from tests.support import studies

STUDY = studies.study(
    8, base={**studies.BASE, "run": {"steps": 30}}, keep_signals=["y"], title="a study"
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A finished store in one file, what is in it, and the same half done."""
    path = tmp_path_factory.mktemp("whole") / "store.sqlite"
    run_study(STUDY, path, workers=0)
    in_one_file(path)
    return path.read_bytes(), contents(path)


def in_one_file(path):
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        connection.execute("PRAGMA journal_mode = DELETE")


def contents(path):
    """The table, and all signals."""
    table = read_table(path)
    with Store(path, read_only=True) as store:
        signals = [store.signals(row)["y"].copy() for rows in store.all_rows() for row in rows]
    return table, signals


def dump(path):
    with closing(sqlite3.connect(path)) as connection:
        connection.text_factory = bytes
        tables = [name for (name,) in connection.execute("SELECT name FROM sqlite_master")]
        return {
            name: connection.execute(f'SELECT * FROM "{name.decode()}"').fetchall()
            for name in tables
            if name not in (b"i", b"t")
        }


def same(a, b):
    return a[0] == b[0] and len(a[1]) == len(b[1]) and all(map(np.array_equal, a[1], b[1]))


def page_size(data):
    return int.from_bytes(data[16:18], "big")


def flipped(data, rng, page):
    size = page_size(data)
    for _ in range(rng.choice([1, 1, 1, 4, 50])):
        data[page * size + rng.randrange(size)] ^= 1 << rng.randrange(8)
    return data


def truncated(data, rng, page):
    return data[: rng.randrange(1, len(data))]


def swapped(data, rng, page):
    size = page_size(data)
    other = rng.randrange(len(data) // size)
    a, b = (slice(i * size, i * size + size) for i in (page, other))
    data[a], data[b] = data[b], data[a]
    return data


def overwritten(data, rng, page):
    """By zeros, noise, or another page; a piece of it or all."""
    size = page_size(data)
    start = page * size + rng.choice([0, rng.randrange(size)])
    length = min(rng.choice([8, 200, size]), page * size + size - start)
    source = rng.randrange(len(data) - length)
    new = rng.choice([bytes(length), rng.randbytes(length), data[source : source + length]])
    data[start : start + length] = new
    return data


@pytest.mark.parametrize("damage", [flipped, truncated, swapped, overwritten])
def test_bytes_that_change_are_seen(whole, tmp_path, damage, in_full):
    """Page after page; what is not refused is what was stored, and the check says it is whole."""
    data, before = whole
    rng = random.Random(damage.__name__)
    pages = len(data) // page_size(data)
    path = tmp_path / "store.sqlite"
    refused = 0
    for i in range({flipped: 5500}.get(damage, 1000) if in_full else 25):
        path.write_bytes(damage(bytearray(data), rng, i % pages))
        try:
            assert same(contents(path), before), f"{damage.__name__} {i}: changed in silence"
        except StoreError:
            refused += 1
            assert seen(path)
            continue
        # What neither table nor signals show, the check may still find: coordinates in SQL.
        seen(path)
    assert refused


def seen(path):
    """Whether a check refuses the file or names what is wrong."""
    try:
        return not check_store(path).is_whole
    except StoreError:
        return True


@pytest.mark.parametrize("seed", range(6))
def test_what_is_damaged_is_run_again(whole, tmp_path, seed, in_full):
    """After a repair the same study ends with the same table, and only what was damaged is run."""
    data, before = whole
    rng = random.Random(seed)
    path = tmp_path / "store.sqlite"
    repaired = 0
    for i in range(60 if in_full else 3):
        for file in tmp_path.iterdir():
            file.unlink()
        damaged = bytearray(data)
        flipped(damaged, rng, 1 + rng.randrange(len(data) // page_size(data) - 1))
        path.write_bytes(damaged)
        try:
            found = repair_store(path)
        except StoreError as error:
            assert "study" in str(error) or "tables" in str(error)  # nothing to hold it against
            continue
        if found.is_whole:
            continue
        repaired += 1
        assert (tmp_path / "store.sqlite.damaged").read_bytes() == damaged
        assert check_store(path).is_whole and check_store(path).done == found.done
        run_study(STUDY, path, workers=0)
        assert same(contents(path), before), (seed, i)
    assert repaired or not in_full


SQL = (
    "UPDATE chunk SET state = 3 WHERE chunk = 2", "UPDATE chunk SET state = 0 WHERE chunk = 2",
    "UPDATE chunk SET state = 1 WHERE chunk = 2", "UPDATE chunk SET last = last - 1",
    "UPDATE chunk SET first = first + 1 WHERE chunk = 2", "UPDATE chunk SET failed = 1",
    "UPDATE chunk SET tries = 2", "UPDATE chunk SET seconds = seconds + 1",
    "UPDATE chunk SET owner = 'me'", "DELETE FROM chunk WHERE chunk = 2",
    "INSERT INTO chunk VALUES (99, 0, 5, 0, NULL, NULL, 0, 0, NULL, NULL)",
    "UPDATE run SET rms = rms * (1 + 1e-15) WHERE run = 9", "UPDATE run SET cell = 0",
    "UPDATE run SET repetition = 0 WHERE run = 9", "DELETE FROM run WHERE run = 9",
    "UPDATE run SET outcome = CAST(x'ff' AS TEXT) WHERE run = 9", "UPDATE run SET rms = x'00'",
    "INSERT INTO run (run) VALUES (1000)", "UPDATE run SET signals_digest = NULL WHERE run = 9",
    "UPDATE run SET run = 1000 WHERE run = 9", "UPDATE study SET title = 'another'",
    "UPDATE study SET resolved = replace(resolved, '30', '31')", "DELETE FROM study",
    "UPDATE study SET stages = '[]'", "INSERT INTO study SELECT * FROM study",
    "UPDATE study SET versions = '{}'", "UPDATE study SET digest = 'nonsense'",
    "CREATE VIEW more AS SELECT 1", "CREATE TABLE more (a)", "DROP TABLE cell",
    "CREATE TRIGGER t AFTER UPDATE ON chunk BEGIN DELETE FROM run; END",
    "CREATE INDEX i ON run (rms)", "ALTER TABLE run ADD COLUMN more REAL",
    "ALTER TABLE run RENAME COLUMN rms TO rsm", "DROP TABLE trajectory",
)  # fmt: skip
# Seen by who reads the signals, or by the check alone.
OF_SIGNALS = (
    "UPDATE trajectory SET float64 = zeroblob(length(float64)) WHERE run = 9",
    "UPDATE trajectory SET shape = '1,30' WHERE run = 9", "DELETE FROM trajectory WHERE run = 9",
    "UPDATE trajectory SET name = 'z' WHERE run = 9",
)  # fmt: skip
OF_THE_CHECK = (
    "UPDATE cell SET R_theta = 0.05", "DELETE FROM cell WHERE cell = 3",
    "INSERT INTO trajectory VALUES (1000, 'y', '1', zeroblob(8))",
)  # fmt: skip


@pytest.mark.costly
@pytest.mark.parametrize("sql", [*SQL, *OF_SIGNALS, *OF_THE_CHECK])
def test_rows_that_are_edited_are_seen(whole, tmp_path, sql):
    """By who has no digest: SQLite finds nothing wrong."""
    data, before = whole
    path = tmp_path / "store.sqlite"
    path.write_bytes(data)
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(sql)
        connection.commit()
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    assert seen(path)
    if sql in OF_THE_CHECK:
        assert same(contents(path), before)
        return
    with pytest.raises(StoreError):
        contents(path)
    # Going on reads no rows that have ended; what it says, it hides and repairs nothing.
    edited = dump(path)
    with suppress(StoreError):
        run_study(STUDY, path, workers=0)
    assert dump(path) == edited
    with pytest.raises(StoreError):
        contents(path)


ODD = [None, "", "x", "\0", "1.5", b"\xff", -1, 0, 1, 3, 2**62, 1e400, -0.0, 5e-324, [], {}, True,
       [[]], {"function": "antigravity:fly", "source": ""}, "__import__('antigravity')", 10**30,
       "../../etc/passwd.csv", "'); DROP TABLE run; --"]  # fmt: skip


def edited(value, rng):
    """One thing in JSON data replaced, removed or doubled."""
    if isinstance(value, dict) and value and rng.random() < 0.9:
        key = rng.choice(list(value))
        if rng.random() < 0.1:
            return {k: v for k, v in value.items() if k != key}
        return {**value, key: edited(value[key], rng)}
    if isinstance(value, list) and value and rng.random() < 0.9:
        i = rng.randrange(len(value))
        if rng.random() < 0.2:
            return rng.choice([value[:i] + value[i + 1 :], [*value, value[i]]])
        return [*value[:i], edited(value[i], rng), *value[i + 1 :]]
    return rng.choice([odd for odd in ODD if not isinstance(odd, bytes)])


def edit_with_digests(path, rng):
    """Change anything of a store, and compute every digest again, as anybody can."""
    with closing(sqlite3.connect(path)) as connection, connection:
        execute = connection.execute
        what = rng.choice(["study", "study", "run", "chunk", "trajectory"])
        if what == "study":
            row = list(execute("SELECT * FROM study").fetchone()[:-1])
            i = rng.choice([0, 0, 0, 0, *range(len(row))])
            if i in (0, 4, 8, 9):
                row[i] = json.dumps(edited(json.loads(row[i]), rng))
            else:
                row[i] = rng.choice([odd for odd in ODD if not isinstance(odd, list | dict)])
            if i == 0 and rng.random() < 0.9:
                with suppress(ValueError):
                    row[1] = digest(canonical_json(json.loads(row[0])))
            try:
                execute("UPDATE study SET resolved=?, fingerprint=?, file=?, title=?, versions=?, "
                        "instruction_set=?, created=?, chunk_size=?, stages=?, mixed=?, origin=?, "
                        "digest=?", (*row, digest_of(row)))  # fmt: skip
            except (OverflowError, TypeError, ValueError, sqlite3.Error):
                return
            return
        column = rng.choice({
            "run": ["run", "cell", "repetition", "outcome", "failure", "rms", "steps"],
            "chunk": ["first", "last", "tries", "failed", "seconds", "state"],
            "trajectory": ["name", "shape", "float64"],
        }[what])  # fmt: skip
        plain = [odd for odd in ODD if not isinstance(odd, list | dict) and odd != 10**30]
        value = rng.choice([*plain, *FAILED, "completed"])
        key = "run" if what == "trajectory" else "rowid"
        try:
            execute(f"UPDATE {what} SET {column} = ? WHERE {key} % 3 = 0", (value,))
        except sqlite3.Error:
            return
    with closing(sqlite3.connect(path)) as connection, connection:
        recompute(connection)


def recompute(connection):
    """Every digest as the rows now stand."""
    execute = connection.execute
    origin = execute("SELECT origin FROM study").fetchone()[0]
    for (run,) in execute("SELECT run FROM run").fetchall():
        found = execute("SELECT name, shape, float64 FROM trajectory WHERE run = ? ORDER BY name",
                        (run,)).fetchall()  # fmt: skip
        try:
            execute("UPDATE run SET signals_digest = ? WHERE run = ?", (signals_digest(found), run))
        except TypeError:
            continue
    for chunk in execute("SELECT * FROM chunk").fetchall():
        number, first, last, _, _, _, tries, failed, seconds, _ = chunk
        rows = execute("SELECT * FROM run WHERE run BETWEEN ? AND ? ORDER BY run", (first, last))
        try:
            new = digest_of([origin, (number, first, last, tries, failed, seconds), list(rows)])
        except TypeError:
            continue
        execute("UPDATE chunk SET digest = ? WHERE chunk = ?", (new, number))


@pytest.mark.costly
def test_right_digests_make_no_wrong_plan_and_no_crash(whole, tmp_path, in_full):
    data, _ = whole
    rng = random.Random(4)
    path = tmp_path / "store.sqlite"
    read = 0
    for _i in range(1500 if in_full else 40):
        path.write_bytes(data)
        edit_with_digests(path, rng)
        modules = set(sys.modules)
        for use in (contents, check_store, lambda p: run_study(STUDY, p, workers=0)):
            try:
                use(path)
            except StoreError:
                continue
            if use is contents:
                read += 1
                table = contents(path)[0]
                with Store(path, read_only=True) as store:
                    plan = store.study.plan
                    runs = sorted([*table["run"].tolist(), *table.failed["run"].tolist()])
                    ended = [c for c in store.chunks() if c.state == DONE]
                    assert runs == [r for c in ended for r in range(c.first, c.last + 1)]
                    assert [plan.place(run)[0] for run in table["run"].tolist()] == (
                        table["cell"].tolist()
                    )
        assert "antigravity" not in sys.modules
        assert not {name for name in set(sys.modules) - modules if "rcac" not in name} & {
            "antigravity", "click.termui"
        }  # fmt: skip
    assert read


def test_a_chunk_of_another_store_is_none_of_this(whole, tmp_path):
    """The same study run twice: rows, digest and all, but not the store that they were made in."""
    data, _ = whole
    path, other = tmp_path / "store.sqlite", tmp_path / "other.sqlite"
    path.write_bytes(data)
    other.write_bytes(data)
    with Store(other) as store, store.writing():
        store.write_study(replace(store.refreshed(), origin="of another time"))
    with pytest.raises(StoreError, match="not what was stored"):
        read_table(other)
    with Store(path, read_only=True) as store:
        chunk = store.chunks()[0]
        assert chunk_digest(store.study, chunk, store.rows(chunk)) == chunk.digest
