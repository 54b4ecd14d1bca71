"""Damaged and hostile folders: each is read as it was written, refused, or computed again.

`python benchmarks/sweep_faults.py --only hostile` tries 4000.
"""

import os
import random
import shutil
import sys

import pytest

from rcac_experiments.sweeps import StoreError, check_store, read_table, run_study
from rcac_experiments.sweeps import _folder as folders
from rcac_experiments.sweeps import _reader as reader
from rcac_experiments.sweeps._table import table_in
from tests.support import hostile_folders as hostile
from tests.support import studies

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="links and pipes of POSIX")

STUDY = studies.study(
    4, base={**studies.BASE, "run": {"steps": 30}}, keep_signals=["y"], title="a study"
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A finished store, and its table."""
    path = studies.stored(STUDY, tmp_path_factory.mktemp("whole") / "study", 3)
    return path, read_table(path)


@pytest.fixture
def foreign(whole, tmp_path):
    """A folder that came from others, and a file of ours beside it."""
    (tmp_path / "ours").mkdir()
    victim = tmp_path / "ours" / "notes.txt"
    victim.write_text("mine\n")
    return tmp_path / "got", victim


def renewed(whole, received):
    shutil.rmtree(received, ignore_errors=True)
    shutil.copytree(whole, received)


def tried(path, table):
    """What reading, a check and the same study make of it: never another table."""
    message = []
    for use in (check_store, read_table, lambda path: run_study(STUDY, path, workers=0)):
        try:
            result = use(path)
        except StoreError:
            message.append("refused")
            continue
        if use is read_table:
            assert result == table
            message.append("same table")
        elif use is check_store:
            message.append("whole" if result.is_whole else "named")
        else:
            assert read_in_process(path) == table
            message.append("computed again")
    return message


@pytest.mark.parametrize("damage", hostile.DAMAGE)
def test_bytes_that_change_are_seen_and_computed_again(
    whole, foreign, damage, monkeypatch, in_full
):
    """In this process: 1.5 10^5 tries in others found no byte of a footer that ends it."""
    monkeypatch.setattr(folders, "read_guarded", reader.read_in_process)
    rng = random.Random(damage.__name__)
    path, victim = foreign
    observed = []
    for _ in range(500 if in_full else 12):
        renewed(whole[0], path)
        damage(path, rng, victim)
        observed.append(tried(path, whole[1]))
    assert any(words[1] == "refused" for words in observed)
    if damage is not hostile.bits_of_the_study and damage is not hostile.truncated:
        assert all(words[2] == "computed again" for words in observed)


@pytest.mark.costly
@pytest.mark.cases(3)
@pytest.mark.parametrize("kind", hostile.HOSTILE)
def test_a_hostile_folder_leads_nowhere(whole, foreign, kind):
    """Named by a check, in the child; nothing of ours is touched, and a chunk computed again."""
    path, victim = foreign
    renewed(whole[0], path)
    hostile.HOSTILE[kind](path, random.Random(kind), victim)
    modules, mine = set(sys.modules), sorted(victim.parent.iterdir())
    try:
        assert not check_store(path).is_whole
    except StoreError as error:
        assert len(str(error)) < 2000 and kind not in COMPUTED
    try:
        run_study(STUDY, path, workers=0)
        assert read_in_process(path) == whole[1]
    except StoreError:
        assert kind not in COMPUTED
    assert victim.read_text() == "mine\n" and sorted(victim.parent.iterdir()) == mine
    assert "antigravity" not in set(sys.modules) - modules


def read_in_process(path):
    with folders.Folder(path) as store:
        return table_in(store, guarded=False)


# Only a chunk is damaged, and an ordinary file can take its place.
COMPUTED = {
    "a chunk in another's place", "a chunk of another study", "a column missing",
    "a column too many", "a column in float32", "2*10^6 rows in zstd", "10^9 claimed rows",
    "a text of 5 MB in each row, in zstd", "a text of 0.9 MB in each row, by dictionary",
    "other runs, right digest", "other coordinates, right digest",
    "a failure with a number, right digest",
}  # fmt: skip


def test_a_child_that_ends_names_its_chunk(whole, monkeypatch):
    """Where two have ended, the rest is not read."""
    expected = []

    def ends_at_the_third(folder, some):
        expected.append([number for number, _, _ in some])
        return {number: "" for number, _, _ in some[:2]}

    monkeypatch.setattr(reader, "_faults_by_child", ends_at_the_third)
    report = check_store(whole[0])
    assert [numbers[0] for numbers in expected] == [1, 4] and report.total == STUDY.runs
    words = ["" if "memory or time" in fault else "not read" for fault in report.faults]
    assert words == ["", "", *["not read"] * (len(expected[0]) - 6)] and report.done == 4 * 3
    with pytest.raises(StoreError, match=r"the runs 6 to 8 .*Repeat the damaged runs"):
        read_table(whole[0])


@pytest.mark.parametrize("says", ["", "echo ready", "echo ready; echo '[1, \"\"]'"])
def test_a_child_that_is_silent_is_left(whole, tmp_path, monkeypatch, says):
    """As on a drive that does not answer, where nothing that it waits for ever ends."""
    child = tmp_path / "child"
    child.write_text(f"#!/bin/sh\n{says}\nexec sleep 1000\n")
    child.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(child))
    monkeypatch.setattr(reader, "TIMEOUT", 0.2)
    if not says:
        with pytest.raises(StoreError, match="does not start"):
            check_store(whole[0])
        return
    report = check_store(whole[0])
    assert report.damaged[0] == ((0, 2) if says == "echo ready" else (3, 5))
    assert "memory or time" in report.faults[0] and "not read" in report.faults[-1]


def test_the_child_and_this_process_read_the_same(whole, monkeypatch):
    guarded = read_table(whole[0])
    monkeypatch.setattr(folders, "read_guarded", reader.read_in_process)
    assert read_table(whole[0]) == guarded == whole[1]


def test_nothing_is_imported_from_the_folder_that_one_stands_in(whole, foreign, monkeypatch):
    path, victim = foreign
    renewed(whole[0], path)
    for name in ("pyarrow", "numpy", "rcac_experiments"):
        (path / f"{name}.py").write_text(f"open({str(victim)!r}, 'w').close()")
    monkeypatch.chdir(path)
    assert read_table(".") == whole[1] and victim.read_text() == "mine\n"
