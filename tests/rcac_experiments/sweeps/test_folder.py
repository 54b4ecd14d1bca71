"""The folder of a study: what others read in it, what can go wrong with it, what is refused."""

import io
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_experiments.sweeps import (
    Axis,
    Metric,
    StoreError,
    check_store,
    export_table,
    load_study,
    read_table,
    replay_run,
    run_study,
    sweep_overview,
)
from rcac_experiments.sweeps import _directory as directory
from rcac_experiments.sweeps import _sweep as sweep
from rcac_experiments.sweeps._chunk_files import Layout, decode, encode
from rcac_experiments.sweeps._directory import ZEROS, Directory
from rcac_experiments.sweeps._problems import Damaged
from rcac_experiments.sweeps._study_file import begun, read_text, text_of
from tests.support import studies

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A finished store of several chunks, which nobody changes."""
    return studies.stored(studies.study(), tmp_path_factory.mktemp("stored") / "study", 8)


@pytest.fixture
def small_chunks(monkeypatch):
    monkeypatch.setattr(sweep, "_chunk_size", lambda study, first, pool: 7)


def copied(stored, tmp_path):
    shutil.copytree(stored, tmp_path / "study")
    return tmp_path / "study"


def test_others_read_the_chunks_without_us(stored):
    pandas = pytest.importorskip("pandas")
    table = read_table(stored)
    frame = pandas.read_parquet(stored / "chunks").sort_values("run")
    for name in table.columns:
        assert np.array_equal(frame[name], table[name]), name
    assert json.loads((stored / "study.json").read_bytes())["study"]["seed"] == 3


def test_a_failed_run_is_a_row_without_numbers(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    study = studies.over_R_theta([1.0, studies.RAISING], studies.raising)
    run_study(study, tmp_path / "s", workers=0)
    rows = parquet.read_table(tmp_path / "s" / "chunks").sort_by("run").to_pylist()
    assert [row["outcome"] for row in rows] == ["completed", "measure failed"]
    assert rows[1]["rms"] is None and rows[0]["rms"] is not None and "seventh" in rows[1]["failure"]


def test_an_axis_that_grows_into_other_numbers_stays_one_column(tmp_path, small_chunks):
    """Whole numbers first, then others, then a text: float64 as long as all are numbers."""
    parquet = pytest.importorskip("pyarrow.parquet")
    store = tmp_path / "s"
    for values in ([1, 2], [1, 2, 2.5]):
        axis = Axis("R_theta", values, sets="controller.R_theta")
        run_study(studies.study(2, axes=[axis]), store, workers=0)
    assert parquet.read_table(store / "chunks")["R_theta"].to_pylist().count(2.5) == 2
    assert read_table(store)["R_theta"].tolist() == [1, 1, 2, 2, 2.5, 2.5]


@pytest.mark.parametrize("damage", ["a number", "a row", "a file", "the study", "no study"])
def test_what_is_damaged_is_named_and_computed_again(stored, tmp_path, damage):
    path, before = copied(stored, tmp_path), read_table(stored)
    chunk = path / "chunks" / "00000003.parquet"
    if damage == "a file":
        chunk.unlink()
        assert check_store(path).is_whole and len(read_table(path)) == 112
    elif damage == "the study":
        text = (path / "study.json").read_text()
        (path / "study.json").write_text(text.replace('"seed": 3', '"seed": 4'))
        for use in (check_store, read_table, lambda p: run_study(studies.study(), p, workers=0)):
            with pytest.raises(StoreError, match=r"study.json is invalid \(it is not what"):
                use(path)
        return
    elif damage == "no study":
        (path / "study.json").unlink()
        with pytest.raises(StoreError, match=r"it has no study\.json, and contains other files"):
            run_study(studies.study(), path, workers=0)
        return
    else:
        data = bytearray(chunk.read_bytes())
        data[data.index(b"completed") if damage == "a row" else 40] ^= 1
        chunk.write_bytes(data)
        report = check_store(path)
        assert report.damaged == ((16, 23),) and "runs 16 to 23 (00000003.parquet)" in str(report)
        for use in (read_table, sweep_overview, lambda p: replay_run(p, 17)):
            with pytest.raises(StoreError, match="is damaged: the runs 16 to 23"):
                use(path)
        assert replay_run(path, 15).is_identical
    assert run_study(studies.study(), path, workers=0).done == 120
    assert read_table(path) == before and check_store(path).is_whole
    assert studies.contents(path) == studies.contents(stored)


def test_other_files_among_the_chunks_are_named(stored, tmp_path):
    path = copied(stored, tmp_path)
    shutil.copy(path / "chunks" / "00000001.parquet", path / "chunks" / "00000099.parquet")
    report = check_store(path)
    assert (
        not report.is_whole and not report.damaged and "00000099.parquet is no" in report.faults[0]
    )
    assert read_table(path) == read_table(stored)


def test_things_of_others_are_left_alone(tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "notes.txt").write_text("mine")
    (tmp_path / "text").write_text("a text")
    (tmp_path / "old").write_bytes(b"SQLite format 3\0" + bytes(100))
    (tmp_path / "case").mkdir()
    (tmp_path / "case" / "study.toml").write_text(studies.FILE % {"steps": 50, "repetitions": 1})
    before = studies.contents(tmp_path)
    for name, words in (
        ("full", "contains other files"), ("text", "it is a file"),
        ("case", "contains other files"),
        ("old", "rcac store convert"), ("nowhere/else", "check that the folder exists"),
    ):  # fmt: skip
        with pytest.raises(StoreError, match=words) as caught:
            run_study(studies.study(1), tmp_path / name, workers=0)
        assert str(caught.value).count(str(tmp_path / name)) <= 2
    assert studies.contents(tmp_path) == before
    for name in ("none", "no\0ne"):
        with pytest.raises(StoreError, match=r"^\S+ cannot be read: there is no such folder\.$"):
            read_table(tmp_path / name)


def test_a_folder_that_may_only_be_read_is_read_and_finished(stored, tmp_path, monkeypatch):
    """Nothing is written into a finished store, not even for a moment."""

    def refused(*arguments, **options):
        raise PermissionError(13, "read only")

    for name in ("mkdir", "link", "rename", "unlink"):
        monkeypatch.setattr(directory.os, name, refused)
    real = os.open

    def only_to_read(path, flags, *mode, **more):
        return refused() if flags & os.O_WRONLY else real(path, flags, *mode, **more)

    monkeypatch.setattr(directory.os, "open", only_to_read)
    assert run_study(studies.study(), stored, workers=0).done == 120
    assert len(read_table(stored)) == 120 and check_store(stored).is_whole
    with pytest.raises(StoreError, match="cannot be written"):
        run_study(studies.study(21), stored, workers=0)


def test_what_a_killed_process_was_writing_goes_after_an_hour(stored, tmp_path):
    path = copied(stored, tmp_path)
    old, new = (path / "chunks" / f".00000001.parquet.{end}.part" for end in ("0bad", "1bad"))
    for part in (old, new):
        part.write_bytes(b"PAR1")
    os.utime(old, (time.time() - 4000,) * 2)
    assert check_store(path).is_whole and read_table(path) == read_table(stored)
    run_study(studies.study(), path, workers=0)
    assert not old.exists() and new.exists()


def test_a_file_is_replaced_whole_and_what_changed_in_it_is_seen(tmp_path):
    """Whatever bit of a file is flipped, before anything interprets it."""
    folder, data = Directory(tmp_path), b'{"a": "x", "digest": "%s"}' % ZEROS
    for value in (b"1", b"2"):
        folder.put("a", data.replace(b"x", value))
        assert folder.read("a", 99).startswith(b'{"a": "%s", "digest": ' % value)
    assert os.listdir(tmp_path) == ["a"]
    whole = (tmp_path / "a").read_bytes()
    for i in range(8 * len(whole)):
        changed = bytearray(whole)
        changed[i // 8] ^= 1 << i % 8
        (tmp_path / "a").write_bytes(changed)
        with pytest.raises(Damaged, match="not what was written"):
            folder.read("a", 99)
    for size in range(len(whole)):
        (tmp_path / "a").write_bytes(whole[:size])
        with pytest.raises(Damaged):
            folder.read("a", 99)


@pytest.mark.costly
def test_a_full_disk_keeps_what_had_ended(tmp_path):
    """The system gives no file more room; with more, the same command goes on."""
    file, store = tmp_path / "study.toml", tmp_path / "store"
    text = studies.FILE % {"steps": 50, "repetitions": 500}
    file.write_text(text.replace("seed = 5", "seed = 5\nkeep_signals = ['z']"))

    def small_files():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    command = [sys.executable, "-c", "from rcac_experiments.cli._main import main; main()", "sweep"]
    command += [str(file), "-o", str(store), "--workers", "0"]
    out = subprocess.run(command, capture_output=True, text=True, preexec_fn=small_files,
                         check=False, cwd=ROOT)  # fmt: skip
    assert out.returncode == 2 and "the disk is full" in out.stderr, out.stderr
    assert "Traceback" not in out.stderr and check_store(store).is_whole
    assert not list((store / "chunks").glob(".*"))
    assert run_study(load_study(file), store, workers=0).done == 3000


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(exclude_categories=["Cs"]), max_size=5),
    lambda inner: st.lists(inner, max_size=3)
    | st.dictionaries(st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=3),
                      inner, max_size=3),
    max_leaves=6,
)  # fmt: skip


@given(values=st.lists(plain, min_size=1, max_size=4, unique_by=repr), extra=plain)
def test_a_study_file_says_all_of_a_study(values, extra):
    """Whatever its axes and tables hold: texts, nulls, nested tables, integers of any length."""
    try:
        axes = [Axis("some", values, sets="controller.some")]
    except InputError:  # 1 and 1.0 are one value
        return
    base = {**studies.BASE, "notes": extra} if extra != {} else studies.BASE
    about = begun(studies.study(2, base=base, axes=axes), "avx2", 8)
    assert read_text(text_of(about)) == about


LAYOUT = Layout("s", (("run", "integer"), ("x", "number"), ("why", "text"), ("is", "truth"),
                      ("z.values", "numbers"), ("z.shape", "integers")))  # fmt: skip
rows = st.tuples(
    st.integers(-(2**63), 2**63 - 1), st.none() | st.floats(allow_nan=False),
    st.none() | st.text(st.characters(exclude_categories=["Cs"])), st.booleans(),
    st.none() | st.lists(st.floats(), max_size=4),
)  # fmt: skip


@given(st.lists(rows, min_size=1, max_size=6))
def test_a_chunk_reads_back_bit_for_bit(rows):
    run, x, why, truth, z = map(list, zip(*rows, strict=True))
    shapes = [None if values is None else [len(values)] for values in z]
    columns = dict(zip(dict(LAYOUT.columns), (run, x, why, truth, z, shapes), strict=True))
    data = encode(LAYOUT, 3, columns)
    assert data == encode(LAYOUT, 3, columns)
    result = decode(LAYOUT, 3, len(rows), data)
    assert result["run"].tolist() == run and result["why"] == why and result["is"].tolist() == truth
    expected = np.array([np.nan if value is None else value for value in x])
    assert result["x"].tobytes() == expected.tobytes()
    table = pytest.importorskip("pyarrow.parquet").read_table(io.BytesIO(data)).to_pydict()
    assert repr(table["z.values"]) == repr(z) and table["z.shape"] == shapes  # repr: nan is nan
    for layout, number in ((LAYOUT, 4), (Layout("t", LAYOUT.columns), 3)):
        with pytest.raises(Damaged, match="another study or chunk"):
            decode(layout, number, len(rows), data)


def test_signals_too_long_for_a_file_are_refused_before_it_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr("rcac_experiments.sweeps._chunk_files.MOST_BYTES", 5000)
    study = studies.study(8, keep_signals=["z"])
    with pytest.raises(StoreError, match=r"cannot be stored.*Keep fewer signals"):
        run_study(study, tmp_path / "s", workers=0)
    assert not list((tmp_path / "s" / "chunks").iterdir())


def test_without_pyarrow_the_extra_is_named_before_anything_runs(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"pyarrow is not installed.*\[studies\]"):
        run_study(studies.study(1), tmp_path / "s", workers=0)
    assert not (tmp_path / "s").exists()


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
    table = read_table(stored)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(InputError, match=rf"{library} is not installed.*\[pandas\]"):
        table.to_xarray()


def test_one_parquet_file_holds_the_table(stored, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    export_table(stored, tmp_path / "runs.parquet")
    back, table = parquet.read_table(tmp_path / "runs.parquet"), read_table(stored)
    assert back.column_names == list(table.columns)
    assert np.array_equal(back["rms"].to_numpy(), table["rms"])


def test_an_overview_of_a_store_that_still_grows(tmp_path):
    path = tmp_path / "store"

    def press(progress):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(studies.study(), path, workers=0, progress=press)
    overview = sweep_overview(path)
    assert overview.done == 0 and overview.total == 120
    assert "0 of 120 runs are finished" in overview.report()


def test_a_study_without_axes_and_measures(tmp_path):
    run_study(studies.study(3, axes=[], keep=[]), tmp_path / "s", workers=0)
    assert read_table(tmp_path / "s")["repetition"].tolist() == [0, 1, 2]
    assert Metric("rms") == Metric("rms")
