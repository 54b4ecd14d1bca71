"""What can go wrong with a file: damage, a full disk, another program's, another process."""

import os
import resource
import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_experiments.sweeps import (
    StoreError,
    export_table,
    load_study,
    read_table,
    run_study,
    sweep_overview,
)
from rcac_experiments.sweeps._chunk import RunRecord
from rcac_experiments.sweeps._claims import Claims, is_gone, this_owner
from rcac_experiments.sweeps._store import Store
from tests.support import studies

ROOT = Path(__file__).parents[3]


@pytest.fixture
def stored(tmp_path):
    path = tmp_path / "store.sqlite"
    run_study(studies.study(), path, workers=0)
    return path


@pytest.mark.costly
def test_a_damaged_header_is_named(stored):
    data = bytearray(stored.read_bytes())
    data[:16] = b"not a database!!"
    stored.write_bytes(data)
    for use in (read_table, lambda p: run_study(studies.study(), p, workers=0)):
        with pytest.raises(StoreError, match=r"is damaged or no store.*Nothing was changed"):
            use(stored)
    assert stored.read_bytes() == data


def test_a_number_that_was_changed_is_noticed(stored):
    """By SQLite's own checks it is whole."""
    with closing(sqlite3.connect(stored)) as connection:
        connection.execute("UPDATE run SET rms = rms * (1 + 1e-15) WHERE run = 50")
        connection.commit()
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    with pytest.raises(StoreError, match="are not what was stored"):
        read_table(stored)


def test_a_row_that_is_missing_is_noticed(stored):
    with closing(sqlite3.connect(stored)) as connection:
        connection.execute("DELETE FROM run WHERE run = 3")
        connection.commit()
    with pytest.raises(StoreError, match="119 rows of runs, where 120 runs have ended"):
        read_table(stored)


@pytest.mark.costly
@pytest.mark.parametrize("seed", range(8))
def test_flipped_bytes_never_change_a_number_silently(stored, seed):
    """Either an error of ours, or the table as it was: the byte was of nothing that is read."""
    before = read_table(stored)
    data = bytearray(stored.read_bytes())
    rng = np.random.default_rng(seed)
    for place in rng.integers(100, len(data), 20):
        data[place] ^= 1 << int(rng.integers(8))
    stored.write_bytes(data)
    try:
        after = read_table(stored)
    except StoreError:
        return
    assert all(np.array_equal(after[n], before[n], equal_nan=True) for n in before.measures)


def test_files_of_others_are_left_alone(tmp_path):
    other, text = tmp_path / "other.sqlite", tmp_path / "notes.txt"
    with closing(sqlite3.connect(other)) as connection:
        connection.execute("CREATE TABLE t (a)")
        connection.commit()
    text.write_text("a text of more than a few characters " * 20)
    for path in (other, text):
        before = path.read_bytes()
        with pytest.raises(StoreError, match="no store"):
            run_study(studies.study(1), path, workers=0)
        assert path.read_bytes() == before


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(StoreError, match="cannot be opened: is there such a folder"):
        run_study(studies.study(1), tmp_path / "nowhere" / "store.sqlite", workers=0)


@pytest.mark.costly
def test_a_full_disk_keeps_what_had_ended(tmp_path):
    """The system gives the file no more room; with more, the same command goes on."""
    file, store = tmp_path / "study.toml", tmp_path / "store.sqlite"
    file.write_text(studies.FILE % {"steps": 50, "repetitions": 500})

    def small_files():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (120_000, 120_000))

    command = [sys.executable, "-c", "from rcac_experiments.cli._main import main; main()", "sweep"]
    command += [str(file), "-o", str(store), "--workers", "0"]
    out = subprocess.run(command, capture_output=True, text=True, preexec_fn=small_files,
                         check=False, cwd=ROOT)  # fmt: skip
    assert out.returncode == 2 and "the disk is full" in out.stderr, out.stderr
    assert "Traceback" not in out.stderr
    before = read_table(store)
    assert 0 < len(before) < 3000
    run_study(load_study(file), store, workers=0)
    after = read_table(store)
    assert len(after) == 3000
    assert np.array_equal(after["rms"][: len(before)], before["rms"])


def test_a_lease_that_ran_out_is_taken_over_and_the_first_result_stays(stored):
    with Store(stored) as store:
        first = store.chunks()[0]
        store.set_free([(first.chunk, first.first, first.last)])
        slow = Claims(store)
        claim = slow.take()
        assert claim is not None and slow.take() is None
        with store.writing() as connection:
            connection.execute("UPDATE chunk SET until = 1 WHERE state = 1")
        quick = Claims(store)
        assert quick.others and quick.take_over() == 1 and quick.take() == claim
        records = [RunRecord(i, "completed", "", [0.0] * 3, {}) for i in range(claim.last + 1)]
        assert slow.finish(claim, records, 1.0)
        assert not quick.finish(claim, records, 2.0)
        assert store.chunks()[0].seconds == 1.0
        with pytest.raises(StoreError, match="stored twice"), store.writing() as connection:
            connection.execute("INSERT INTO run (run) VALUES (0)")
        slow.close()
        quick.close()


@pytest.mark.costly
def test_who_is_gone_is_seen():
    process = subprocess.run(
        [sys.executable, "-c",
         "from rcac_experiments.sweeps._claims import this_owner; print(this_owner())"],
        capture_output=True, text=True, check=True, cwd=ROOT,
    )  # fmt: skip
    gone, here = process.stdout.strip(), this_owner()
    assert is_gone(gone) and not is_gone(here)
    machine, pid, start, nonce = here.rsplit("/", 3)
    assert is_gone(f"{machine}/{pid}/{int(start or 0) + 1}/{nonce}") == bool(start)
    assert not is_gone(f"elsewhere/{pid}/{start}/{nonce}") and not is_gone("nonsense")
    assert int(pid) == os.getpid()


def test_with_a_rollback_journal_one_process_alone(tmp_path, monkeypatch):
    path = tmp_path / "store.sqlite"
    assert run_study(studies.study(2), path, workers=0, journal="rollback").done == 12
    assert not list(tmp_path.glob("*-wal"))
    monkeypatch.setattr("rcac_experiments.sweeps._store.PATIENCE", 0.1)
    with Store(path, "rollback") as first:
        with first.writing():
            pass
        with pytest.raises(StoreError, match="in use by another process"):
            run_study(studies.study(3), path, workers=0, journal="rollback")
    assert run_study(studies.study(3), path, workers=0, journal="rollback").done == 18


def test_an_export_reads_back_as_the_table(stored, tmp_path):
    pandas = pytest.importorskip("pandas")
    table = read_table(stored)
    frame = table.to_pandas()
    assert list(frame.columns) == [name for name in table.columns if name != "run"]
    export_table(stored, tmp_path / "runs.csv")
    back = pandas.read_csv(tmp_path / "runs.csv", keep_default_na=False, dtype=str)
    for name in ("run", "R_theta", "noise", "rms", "late"):
        assert np.array_equal([float(text) for text in back[name]], table[name])
    array = table.to_xarray()
    assert array["rms"].dims == ("R_theta", "noise", "repetition")
    one = table.where(R_theta=1.0, noise=2)
    assert np.array_equal(array["rms"].sel(R_theta=1.0, noise=2).values, one["rms"])


@pytest.mark.parametrize("library", ["pandas", "xarray"])
def test_a_missing_library_is_named(stored, monkeypatch, library):
    """xarray imports pandas itself, and would say so in its own words."""
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(InputError, match=rf"{library} is not installed.*\[pandas\]"):
        read_table(stored).to_xarray()


def test_parquet_holds_the_table(stored, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    export_table(stored, tmp_path / "runs.parquet")
    back, table = parquet.read_table(tmp_path / "runs.parquet"), read_table(stored)
    assert back.column_names == list(table.columns)
    assert np.array_equal(back["rms"].to_numpy(), table["rms"])


def test_an_overview_of_a_store_that_still_grows(tmp_path):
    path = tmp_path / "store.sqlite"

    def press(progress):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(studies.study(), path, workers=0, progress=press)
    overview = sweep_overview(path)
    assert overview.done == 0 and overview.total == 120
    assert "0 of 120 runs have been run" in overview.report()
