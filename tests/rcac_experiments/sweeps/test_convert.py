"""Stores of version 0.2, SQLite files: made into folders as they are, or refused."""

import json
import os
import random
import shutil
import sqlite3
import sys
from contextlib import closing, suppress

import pytest

from rcac_experiments.sweeps import (
    StoreError,
    check_store,
    convert_store,
    read_table,
    replay_run,
    run_study,
)
from rcac_experiments.sweeps import _folder as folders
from rcac_experiments.sweeps import _reader as reader
from rcac_experiments.sweeps._canonical import canonical_json, digest
from tests.support import old_stores, studies

STUDY = studies.study(
    8, base={**studies.BASE, "run": {"steps": 30}}, keep_signals=["y"], title="a study"
)


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """A folder, and the old store with the same in it."""
    folder = tmp_path_factory.mktemp("made")
    studies.stored(STUDY, folder / "study", 8)
    old_stores.write(folder / "study", folder / "old.sqlite")
    return folder / "study", folder / "old.sqlite"


def same_rows(new, before):
    """Every chunk that was made is that of before, and only what was named is not there."""
    result, expected = studies.contents(new / "chunks"), studies.contents(before / "chunks")
    assert result.items() <= expected.items()
    return len(expected) - len(result)


def test_an_old_store_becomes_the_folder_that_the_study_makes(stores, tmp_path):
    """File by file; its runs keep their numbers, so a replay finds them."""
    before = stores[1].read_bytes()
    converted = convert_store(stores[1], tmp_path / "new")
    assert converted.is_whole and converted.done == converted.total == STUDY.runs
    assert studies.contents(tmp_path / "new") == studies.contents(stores[0])
    assert read_table(tmp_path / "new") == read_table(stores[0])
    assert replay_run(tmp_path / "new", 17).is_identical and stores[1].read_bytes() == before


def test_failures_and_growth_and_what_has_not_run_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr("rcac_experiments.sweeps._sweep._chunk_size", lambda *of: 2)
    folder, values = tmp_path / "study", [1.0, studies.RAISING]
    for repetitions in (1, 4):
        study = studies.over_R_theta(values, studies.raising, repetitions)
        run_study(study, folder, workers=0)
    (folder / "chunks" / "00000002.parquet").unlink()
    old_stores.write(folder, tmp_path / "old")
    converted = convert_store(tmp_path / "old", tmp_path / "new")
    assert converted.is_whole and (converted.done, converted.total, converted.failed) == (6, 8, 4)
    assert studies.contents(tmp_path / "new") == studies.contents(folder)
    assert run_study(study, tmp_path / "new", workers=0).failed == 4


@pytest.mark.parametrize("end", ["-journal", "-wal", "-shm"])
@pytest.mark.parametrize("kind", ["empty", "text", "link", "dangling", "pipe", "folder"])
def test_what_lies_beside_an_old_store_is_refused(stores, tmp_path, end, kind):
    """SQLite would read, write or remove it, or what it leads to."""
    path, victim = tmp_path / "old.sqlite", tmp_path / "notes.txt"
    shutil.copy(stores[1], path)
    victim.write_text("mine")
    beside = tmp_path / f"old.sqlite{end}"
    {
        "empty": lambda: beside.write_bytes(b""), "text": lambda: beside.write_text("words"),
        "link": lambda: beside.symlink_to(victim), "pipe": lambda: os.mkfifo(beside),
        "dangling": lambda: beside.symlink_to(tmp_path / "new.txt"), "folder": beside.mkdir,
    }[kind]()  # fmt: skip
    link = tmp_path / "named"
    link.symlink_to(path)
    for name in (path, link):
        with pytest.raises(StoreError, match=f"sqlite{end} lies beside|named{end} lies beside"):
            convert_store(name, tmp_path / "new")
    assert victim.read_text() == "mine" and not (tmp_path / "new").exists()


@pytest.mark.parametrize("kind", ["absent", "empty", "text", "folder", "pipe", "other"])
def test_what_is_no_old_store_is_refused(tmp_path, kind):
    path = tmp_path / "old.sqlite"
    with closing(sqlite3.connect(tmp_path / "other")) as connection, connection:
        connection.execute("CREATE TABLE t (a)")
    make = {
        "absent": lambda: None, "empty": path.touch, "text": lambda: path.write_text("words"),
        "folder": path.mkdir, "pipe": lambda: os.mkfifo(path),
        "other": lambda: shutil.move(tmp_path / "other", path),
    }  # fmt: skip
    make[kind]()
    with pytest.raises(StoreError, match=r"old\.sqlite"):
        convert_store(path, tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_a_folder_with_a_study_is_left_alone(stores):
    before = studies.contents(stores[0])
    with pytest.raises(StoreError, match="contains a study"):
        convert_store(stores[1], stores[0])
    assert studies.contents(stores[0]) == before


def page_size(data):
    return int.from_bytes(data[16:18], "big")


def flipped(data, rng, page):
    for _ in range(rng.choice([1, 1, 1, 4, 50])):
        data[page * page_size(data) + rng.randrange(page_size(data))] ^= 1 << rng.randrange(8)
    return data


def truncated(data, rng, page):
    return data[: rng.randrange(1, len(data))]


def swapped(data, rng, page):
    size = page_size(data)
    other = rng.randrange(len(data) // size)
    a, b = (slice(i * size, i * size + size) for i in (page, other))
    data[a], data[b] = data[b], data[a]
    return data


@pytest.mark.parametrize("damage", [flipped, truncated, swapped])
def test_bytes_that_change_are_left_out_and_named(stores, tmp_path, damage, in_full):
    """Page after page: what is made of it is what was stored."""
    data, rng = stores[1].read_bytes(), random.Random(damage.__name__)
    path, new = tmp_path / "old.sqlite", tmp_path / "new"
    refused = 0
    for i in range(2000 if in_full else 25):
        shutil.rmtree(new, ignore_errors=True)
        path.write_bytes(damage(bytearray(data), rng, i % (len(data) // page_size(data))))
        try:
            converted = convert_store(path, new)
        except StoreError:
            refused += 1
            continue
        assert same_rows(new, stores[0]) == len(converted.damaged) == len(converted.faults)
        refused += not converted.is_whole
    assert refused


SQL = (
    "UPDATE chunk SET state = 3 WHERE chunk = 2", "UPDATE chunk SET state = 0 WHERE chunk = 2",
    "UPDATE chunk SET last = last - 1", "UPDATE chunk SET first = first + 1 WHERE chunk = 2",
    "UPDATE chunk SET failed = 1", "UPDATE chunk SET tries = 2", "UPDATE chunk SET digest = NULL",
    "UPDATE chunk SET seconds = seconds + 1", "DELETE FROM chunk WHERE chunk = 2",
    "UPDATE run SET rms = rms * (1 + 1e-15) WHERE run = 9", "UPDATE run SET cell = 0",
    "UPDATE run SET repetition = 0 WHERE run = 9", "DELETE FROM run WHERE run = 9",
    "UPDATE run SET outcome = CAST(x'ff' AS TEXT) WHERE run = 9", "UPDATE run SET rms = x'00'",
    "UPDATE run SET signals_digest = NULL WHERE run = 9",
    "UPDATE run SET run = 1000 WHERE run = 9", "UPDATE study SET title = 'another'",
    "UPDATE study SET resolved = replace(resolved, '30', '31')", "DELETE FROM study",
    "UPDATE study SET stages = '[]'", "INSERT INTO study SELECT * FROM study",
    "CREATE VIEW more AS SELECT 1", "CREATE TABLE more (a)", "DROP TABLE cell",
    "CREATE TRIGGER t AFTER UPDATE ON chunk BEGIN DELETE FROM run; END",
    "CREATE INDEX i ON run (rms)", "ALTER TABLE run ADD COLUMN more REAL",
    "ALTER TABLE run RENAME COLUMN rms TO rsm", "DROP TABLE trajectory",
    "UPDATE trajectory SET float64 = zeroblob(length(float64)) WHERE run = 9",
    "UPDATE trajectory SET shape = '1,30' WHERE run = 9", "DELETE FROM trajectory WHERE run = 9",
    "UPDATE trajectory SET name = 'z' WHERE run = 9",
)  # fmt: skip


@pytest.mark.parametrize("sql", SQL)
def test_rows_that_are_edited_are_left_out_and_named(stores, tmp_path, sql):
    """By who has no digest: SQLite finds nothing wrong."""
    path, new = tmp_path / "old.sqlite", tmp_path / "new"
    shutil.copy(stores[1], path)
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute(sql)
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    with suppress(StoreError):
        converted = convert_store(path, new)
        assert converted.damaged and same_rows(new, stores[0]) == len(converted.damaged)
        run_study(STUDY, new, workers=0)
        assert studies.contents(new) == studies.contents(stores[0])


ODD = [None, "", "x", "\0", "1.5", -1, 0, 1, 3, 2**62, 1e400, -0.0, 5e-324, [], {}, True, [[]],
       {"function": "antigravity:fly", "source": ""}, "__import__('antigravity')", 10**30,
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
    return rng.choice(ODD)


def test_right_digests_make_no_wrong_plan_and_no_crash(stores, tmp_path, in_full, monkeypatch):
    """A study edited by somebody who computes every digest anew: a whole folder, or none."""
    monkeypatch.setattr(folders, "read_guarded", reader.read_in_process)
    rng = random.Random(4)
    path, new = tmp_path / "old.sqlite", tmp_path / "new"
    for _ in range(1500 if in_full else 40):
        shutil.rmtree(new, ignore_errors=True)
        shutil.copy(stores[1], path)
        with closing(sqlite3.connect(path)) as connection, connection:
            row = list(connection.execute("SELECT * FROM study").fetchone()[:-1])
            i = rng.choice([0, 0, 0, 0, *range(len(row))])
            row[i] = (
                json.dumps(edited(json.loads(row[i]), rng)) if i in (0, 4, 8, 9)
                else rng.choice([odd for odd in ODD if not isinstance(odd, list | dict)])
            )  # fmt: skip
            with suppress(ValueError, TypeError, OverflowError, sqlite3.Error):
                row[1] = digest(canonical_json(json.loads(row[0])))
                columns = ", ".join(name[1] for name in connection.execute(
                    "PRAGMA table_info(study)"))  # fmt: skip
                connection.execute("DELETE FROM study")
                connection.execute(
                    f"INSERT INTO study ({columns}) VALUES ({old_stores.places(12)})",
                    (*row, old_stores.digest(row)),
                )
        with suppress(StoreError):
            convert_store(path, new)
            assert check_store(new).is_whole
        assert "antigravity" not in sys.modules
