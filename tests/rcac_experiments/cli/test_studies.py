"""The commands sweep, show and replay: what they print, write and end with."""

import json
import shutil

import pytest
from click.testing import CliRunner

from rcac_experiments.cli._main import main
from rcac_experiments.sweeps import read_table
from rcac_experiments.sweeps._chunk_files import decode, encode
from rcac_experiments.sweeps._directory import sealed
from rcac_experiments.sweeps._folder import Folder
from tests.support import old_stores, studies


def rcac(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studies")
    (folder / "study.toml").write_text(studies.FILE % {"steps": 60, "repetitions": 4})
    result = rcac("sweep", folder / "study.toml", "-o", folder / "s", "--workers", 0)
    assert result.exit_code == 0, result.output
    assert "All 24 runs completed." in result.stdout
    return folder / "s"


@pytest.mark.costly
def test_the_same_command_again_has_nothing_to_do(store):
    before = read_table(store)
    result = rcac("sweep", store.parent / "study.toml", "-o", store, "--workers", 0, "--json")
    loaded = json.loads(result.stdout)
    assert result.exit_code == 0 and loaded["study"]["stored"] == loaded["study"]["runs"] == 24
    assert loaded["outcomes"] == {"completed": 24} and read_table(store) == before


@pytest.mark.costly
def test_show_groups_draws_and_exports(store, tmp_path):
    picture, table = tmp_path / "map.svg", tmp_path / "runs.csv"
    options = ["--by", "R_theta,n_c", "--measure", "radius", "--plot", picture, "--export", table]
    result = rcac("show", store, *options)
    assert result.exit_code == 0, result.output
    assert "and radius of the completed runs" in " ".join(
        result.stdout.split()
    ) and picture.read_text().startswith("<?xml")
    assert len(table.read_text().splitlines()) == 25
    loaded = json.loads(rcac("show", store, "--by", "n_c", "--json").stdout)
    assert loaded["groups"]["n_c"] == [3, 6] and loaded["groups"]["runs"] == [12, 12]


@pytest.mark.costly
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--by", "gain"], "'gain' is no axis; the axes are R_theta, n_c"),
        (["--measure", "rmss"], "no column 'rmss'"),
        (["--export", "runs.xls"], "must end in one of .csv, .parquet"),
        (["--plot", "map.svg", "--by", ""], "one axis or two"),
    ],
)
def test_what_show_cannot_do_it_says(store, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    if "--plot" in arguments:
        (tmp_path / "one.toml").write_text(
            (studies.FILE % {"steps": 60, "repetitions": 1}).split("axes.R_theta")[0]
        )
        rcac("sweep", "one.toml", "-o", "one", "--workers", 0)
        store = tmp_path / "one"
    result = rcac("show", store, *arguments)
    assert result.exit_code == 2 and words in result.stderr


@pytest.mark.costly
def test_a_run_is_replayed(store, tmp_path):
    result = rcac("replay", store, 7, "--plot", tmp_path / "run.png")
    assert result.exit_code == 0 and "bit-identical to the stored run." in result.stdout
    assert (tmp_path / "run.png").stat().st_size > 1000
    loaded = json.loads(rcac("replay", store, 7, "--json").stdout)
    row = read_table(store)
    assert loaded["is_identical"] and loaded["repeated"]["rms"] == row["rms"][7]
    missing = rcac("replay", store, 24)
    assert missing.exit_code == 2 and "its runs are 0 to 23" in missing.stderr


def test_a_run_that_is_not_what_is_stored_ends_with_1(store, tmp_path):
    """As another version of the software might leave it: stored whole, with another number."""
    path = tmp_path / "other"
    shutil.copytree(store, path)
    with Folder(path) as opened:
        layout, (first, last) = opened.layout(1), opened.study.plan.chunk(1)
        file = path / "chunks" / "00000001.parquet"
        columns = decode(layout, 1, last - first + 1, file.read_bytes())
        file.write_bytes(sealed(encode(layout, 1, {**columns, "rms": 2 * columns["rms"]})))
    result = rcac("replay", path, 0)
    assert result.exit_code == 1 and "differs from the stored run: rms." in result.stdout


def test_a_measure_that_fails_is_seen_in_the_status(tmp_path):
    file = tmp_path / "study.toml"
    text = studies.FILE % {"steps": 60, "repetitions": 1}
    file.write_text(text.replace('{ measure = "rms" }', '{ measure = "coefficient", index = 8 }'))
    result = rcac("sweep", file, "-o", tmp_path / "s", "--workers", 0)
    assert result.exit_code == 1, result.output
    assert "3 runs have a recorded error." in result.stdout  # those with six coefficients
    assert "measure coefficient: InputError: index = 8" in result.stdout


def test_bad_files_end_with_2_before_anything_is_made(tmp_path):
    file, store = tmp_path / "study.toml", tmp_path / "s"
    text, few = (studies.FILE % {"steps": 60, "repetitions": n} for n in (10**9, 1))
    for changed, words in (
        (text, "6000000000 runs: 3 (R_theta) x 2 (n_c)"),
        (few.replace("controller.n_c", "controller.nc"), "unknown key 'nc' in [controller]"),
        ("", "is empty"),
        (few.partition("[study]")[0], "the table [study]"),
    ):
        file.write_text(changed)
        result = rcac("sweep", file, "-o", store)
        assert result.exit_code == 2 and words in result.stderr, result.stderr
        assert not store.exists()


@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_that_does_not_answer_is_named(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("rcac_experiments.cli._studies.CONNECTING", 0.2)
    (tmp_path / "study.toml").write_text(studies.FILE % {"steps": 60, "repetitions": 1})
    words = ("sweep", tmp_path / "study.toml", "-o", tmp_path / "s", "--scheduler")
    result = rcac(*words, "tcp://127.0.0.1:9")
    assert (
        result.exit_code == 2 and "--scheduler tcp://127.0.0.1:9 does not answer" in result.stderr
    )
    result = rcac(*words, "tcp://127.0.0.1:9", "--workers", 2)
    assert result.exit_code == 2 and "--workers counts local processes" in result.stderr
    assert not (tmp_path / "s").exists()


@pytest.mark.costly
def test_an_old_store_is_converted(store, tmp_path):
    old, new = tmp_path / "old.sqlite", tmp_path / "new"
    old_stores.write(store, old)
    for command in (("show", old), ("store", "check", old), ("replay", old, 1)):
        result = rcac(*command)
        assert result.exit_code == 2 and f"rcac store convert {old}" in result.stderr
    result = rcac("store", "convert", old, "-o", new, "--json")
    assert result.exit_code == 0 and json.loads(result.stdout)["done"] == 24
    assert studies.contents(new) == studies.contents(store)
    assert rcac("store", "check", new).exit_code == 0
    assert rcac("store", "convert", old, "-o", new).exit_code == 2
    (new / "chunks" / "00000001.parquet").write_bytes(b"PAR1")
    result = rcac("store", "check", new)
    assert result.exit_code == 1 and "with the same `rcac sweep`" in result.stdout
    assert rcac("sweep", store.parent / "study.toml", "-o", new, "--workers", 0).exit_code == 0
    assert studies.contents(new) == studies.contents(store)


def test_what_replaces_a_repair_is_named():
    result = rcac("store", "repair", "gain")
    assert result.exit_code == 2 and "`rcac sweep FILE -o FOLDER`" in result.stderr
    assert "No such command" in rcac("store", "mend", "gain").stderr
