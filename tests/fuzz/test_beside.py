"""Whatever stands under a name that a command opens or writes: it leads nowhere else.

docs/trust.md has the table of those names. What a stranger can put there comes out of an archive: a
text, a link, a hard link, a pipe, a folder, a journal that names another file. Each command then
gives the right answer or refuses in our words; nothing outside is touched, nothing waits.
"""

import os
import re
import signal
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from click.testing import CliRunner

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.cli._main import main
from rcac_experiments.dissertation._reproduction import KeptCases, reproduce
from rcac_experiments.sweeps import StoreError, check_store, read_table, run_study
from rcac_experiments.sweeps._beside import DAMAGED, SIDECARS, SUPER_JOURNAL
from rcac_experiments.sweeps._store import LARGEST_CHUNK, Store
from rcac_numeric.arrays import _files
from tests.support import studies

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="links and pipes of POSIX")

ROOT = Path(__file__).parents[2]
STUDY = """
[plant]
problem = "standard"
G = "1/(q - 0.9)"
[signals]
w = {white_noise = 1}
[target]
model = "fir"
[controller]
n_c = 2
[run]
steps = 20
[study]
seed = 3
repetitions = 2
keep = [{name = "rms", measure = "rms"}]
[study.axes]
R_theta = {sets = "controller.R_theta", values = [0.01, 1]}
"""


@pytest.fixture(autouse=True)
def in_time():
    """A pipe that is opened for reading waits for ever: the alarm ends it as a failure."""

    def late(*_):
        raise AssertionError("it waits")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, 60)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """A finished store in one file, and the same with one row edited."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "s.toml").write_text(STUDY)
    assert invoke("sweep", folder / "s.toml", "-o", folder / "s.sqlite", "--workers", "0")[0] == 0
    with closing(sqlite3.connect(folder / "s.sqlite")) as connection, connection:
        connection.execute("PRAGMA journal_mode = DELETE")
    whole = (folder / "s.sqlite").read_bytes()
    with closing(sqlite3.connect(folder / "s.sqlite")) as connection, connection:
        connection.execute("UPDATE run SET rms = 1 WHERE run = 3")
    return whole, (folder / "s.sqlite").read_bytes()


def invoke(*words):
    """Exit status and what was printed, of one command."""
    done = CliRunner().invoke(main, [str(word) for word in words])
    return done.exit_code, done.output + done.stderr


def in_rollback_mode(data):
    return data[:18] + b"\1\1" + data[20:]


def hot_journal(data, victim):
    """A rollback journal whose transaction spanned other files, and whose own journal is ours."""
    size = int.from_bytes(data[16:18], "big")
    head = SUPER_JOURNAL + b"".join(
        n.to_bytes(4, "big") for n in (0, 0, len(data) // size, 512, size)
    )
    name = os.fsencode(victim)
    total = sum(b - 256 * (b > 127) for b in name) & 0xFFFFFFFF
    numbers = [n.to_bytes(4, "big") for n in (2**30 // size + 1, len(name), total)]
    tail = numbers[0] + name + numbers[1] + numbers[2] + SUPER_JOURNAL
    return head.ljust(512, b"\0") + tail


KINDS = {
    "empty": lambda path, victim: path.write_bytes(b""),
    "text": lambda path, victim: path.write_text("words of others\n"),
    "link": lambda path, victim: path.symlink_to(victim),
    "dangling": lambda path, victim: path.symlink_to(victim.with_name("new.txt")),
    "hard link": lambda path, victim: path.hardlink_to(victim),
    "folder": lambda path, victim: path.mkdir(),
    "pipe": lambda path, victim: os.mkfifo(path),
}  # fmt: skip
MOVING = (".s.rcac-0badcafe.sqlite",)  # what a killed process left, or says that it did
COMMANDS = {
    "sweep": ("sweep", "s.toml", "-o", "s.sqlite", "--workers", "0"),
    "show": ("show", "s.sqlite", "--export", "s.csv"),
    "replay": ("replay", "s.sqlite", "3"),
    "check": ("store", "check", "s.sqlite"),
    "repair": ("store", "repair", "s.sqlite"),
}


def outside(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.fixture
def places(tmp_path, monkeypatch):
    """A folder that came from others, to work in, and one beside it that is ours."""
    got, ours = tmp_path / "got", tmp_path / "ours"
    got.mkdir()
    ours.mkdir()
    (ours / "notes.txt").write_text("mine\n")
    monkeypatch.chdir(got)
    return got, ours


def cleared(folder):
    for path in folder.iterdir():
        path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()


BESIDE = [
    *((command, end) for command in COMMANDS for end in (*SIDECARS, *MOVING)),
    *(("repair", end) for end in DAMAGED),
]


@pytest.mark.parametrize(("command", "end"), BESIDE)
def test_what_lies_beside_a_store_leads_nowhere(store, places, command, end):
    """Of 7 kinds each: right, or refused with a status of ours, and nothing outside is touched."""
    got, ours = places
    before = outside(ours)
    statuses = set()
    for kind, make in KINDS.items():
        cleared(got)
        data = store[command == "repair"]
        (got / "s.sqlite").write_bytes(data)
        (got / "s.toml").write_text(STUDY)
        beside = got / (end if end in MOVING else f"s.sqlite{end}")
        make(beside, ours / "notes.txt")
        status, said = invoke(*COMMANDS[command])
        assert status in (0, 2), (kind, status, said)
        assert outside(ours) == before, f"{kind}: touched"
        if status == 2:
            assert said.startswith("rcac: ") and beside.name in said, (kind, said)
        if status == 0 and command == "repair":
            assert (got / "s.sqlite.damaged").read_bytes() == data
            assert check_store("s.sqlite").is_whole
        statuses.add(status)
    assert 0 in statuses or (command == "repair" and end in DAMAGED)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_journal_that_names_another_file_is_refused(store, places, command):
    """SQLite would remove that file before it reads a row of the store."""
    got, ours = places
    data = in_rollback_mode(store[0])
    (got / "s.sqlite").write_bytes(data)
    (got / "s.toml").write_text(STUDY)
    (got / "s.sqlite-journal").write_bytes(hot_journal(data, ours / "notes.txt"))
    status, said = invoke(*COMMANDS[command])
    assert status == 2 and "SQLite would remove or write that" in said
    assert outside(ours) == {"notes.txt": b"mine\n"} and (got / "s.sqlite").read_bytes() == data


@pytest.mark.parametrize("application", [0, 7])
@pytest.mark.parametrize("command", COMMANDS)
def test_a_database_of_another_program_stays_as_it_is(places, command, application):
    """Also where it was interrupted: SQLite would put it in order while we say that we did not."""
    got, ours = places
    path, journal = got / "s.sqlite", got / "s.sqlite-journal"
    (got / "s.toml").write_text(STUDY)
    with closing(sqlite3.connect(ours / "its.sqlite", isolation_level=None)) as connection:
        for statement in (
            f"PRAGMA application_id = {application}", "PRAGMA cache_size = 1", "CREATE TABLE a (b)",
            "INSERT INTO a VALUES (zeroblob(50000))", "BEGIN", "UPDATE a SET b = zeroblob(60000)",
            "INSERT INTO a VALUES (zeroblob(90000))",
        ):  # fmt: skip
            connection.execute(statement)
        path.write_bytes((ours / "its.sqlite").read_bytes())
        journal.write_bytes((ours / "its.sqlite-journal").read_bytes())
    before = path.read_bytes(), journal.read_bytes()
    status, _ = invoke(*COMMANDS[command])
    assert status == 2 and (path.read_bytes(), journal.read_bytes()) == before
    with closing(sqlite3.connect(path)) as connection:  # the control
        connection.execute("SELECT count(*) FROM a").fetchone()
    assert path.read_bytes() != before[0]


def test_sqlite_itself_would_remove_it(store, places):
    """The control: without our look the file is gone, so the journal is what it should be."""
    got, ours = places
    (got / "s.sqlite").write_bytes(in_rollback_mode(store[0]))
    (got / "s.sqlite-journal").write_bytes(hot_journal(store[0], ours / "notes.txt"))
    with closing(sqlite3.connect(got / "s.sqlite")) as connection:
        connection.execute("SELECT * FROM study").fetchall()
    assert not outside(ours)


@pytest.mark.parametrize("command", COMMANDS)
def test_the_store_itself(store, places, command):
    """Absent, empty, a text, a link to a text or to nothing, a folder, a pipe."""
    got, ours = places
    before = outside(ours)
    for kind, make in {"absent": lambda *_: None, **KINDS}.items():
        cleared(got)
        (got / "s.toml").write_text(STUDY)
        make(got / "s.sqlite", ours / "notes.txt")
        if command == "sweep" and kind in ("absent", "empty", "dangling"):
            continue  # a store is made there: you named it, and a link that you name is followed
        status, said = invoke(*COMMANDS[command])
        if kind == "empty" and command in ("check", "repair"):
            assert status == 0 and "No study was stored in it yet" in said
        else:
            assert status == 2 and "s.sqlite" in said, (kind, status, said)
        assert outside(ours) == before, f"{kind}: touched"


READERS = (
    ("verify", "x.toml"), ("sweep", "x.toml", "-o", "new.sqlite"), ("observer", "x.toml"),
    ("place", "x.toml"), ("export", "x.toml", "-o", "c"), ("explore", "x.toml", "-o", "c.html"),
    ("check", "x.csv", "--n-c", "2"), ("check", "x.npz"), ("check", "x.mat", "--n-c", "2"),
    ("design", "x.csv"), ("show", "x.toml"), ("show", "x.npz"), ("replay", "x.csv", "0"),
)  # fmt: skip


@pytest.mark.parametrize("words", READERS, ids=" ".join)
def test_a_file_that_is_read_leads_nowhere(places, words):
    got, ours = places
    before = outside(ours)
    for kind, make in {"absent": lambda *_: None, **KINDS}.items():
        cleared(got)
        make(got / words[1], ours / "notes.txt")
        status, said = invoke(*words)
        assert status == 2, (kind, status, said)
        assert outside(ours) == before
        left = {path.name for path in got.iterdir()}
        assert left <= {words[1]}, f"{kind}: {left}"


def test_members_of_a_folder_are_written_neither_to_nor_through_a_link(places):
    """The folder is named by whoever asks; the names in it are ours."""
    got, ours = places
    before = outside(ours)
    for kind, make in KINDS.items():
        cleared(got)
        if kind in ("empty", "text", "hard link"):  # replaced by a new file, not written into
            make(got / "a.c", ours / "notes.txt")
            with _files.replacing(_files.member(got, "a.c")) as new:
                new.write_text("ours")
            assert (got / "a.c").read_text() == "ours"
        else:
            make(got / "a.c", ours / "notes.txt")
            with pytest.raises(InputError, match="no ordinary file"):
                _files.member(got, "a.c")
            (got / "src").symlink_to(ours)
            with pytest.raises(InputError, match="no ordinary folder"):
                _files.member(got, "src/a.c")
        assert outside(ours) == before, kind
    with pytest.raises(InputError, match=r"\.\."):
        _files.member(got, "../ours/notes.txt")
    link = got / "mine"
    link.symlink_to(ours)
    assert _files.member(link, "a.c") == link / "a.c"  # you named it


def test_kept_cases_and_pages_are_members(places):
    got, ours = places
    (got / "index.html").symlink_to(ours / "notes.txt")
    with pytest.raises(CompensatorError, match="no ordinary file"):
        reproduce([], got)
    assert outside(ours) == {"notes.txt": b"mine\n"}
    assert KeptCases(got)


def test_who_makes_a_folder_writes_its_members():
    """A folder's files under names of ours go through `member`, which makes the folder."""
    makers = {
        str(path.relative_to(ROOT))
        for package in ("compensator_theory", "rcac_numeric", "rcac_experiments")
        for path in (ROOT / package).rglob("*.py")
        if re.search(r"mkdir\(.*parents|makedirs\(", path.read_text("utf-8"))
    }
    assert makers == {"rcac_numeric/arrays/_files.py", "rcac_experiments/cli/_verify.py"}


def edited(path, sql, *values):
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute(sql, values)


LEASED = (
    "UPDATE chunk SET state = 1, owner = 'other/1/1/ab', until = ?, tries = 0, failed = 0, "
    "seconds = NULL, digest = NULL WHERE chunk = 1"
)


@pytest.mark.parametrize("until", [9e99, float("inf"), 4e9])
def test_a_lease_that_lasts_for_ever_is_none(tmp_path, until):
    """The host's clock was wrong, or somebody wrote it so: the same command goes on."""
    path = tmp_path / "s.sqlite"
    run_study(studies.study(2), path, workers=0)
    edited(path, LEASED, until)
    edited(path, "DELETE FROM run WHERE run <= (SELECT last FROM chunk WHERE chunk = 1)")
    run_study(studies.study(2), path, workers=0)
    assert check_store(path).is_whole and len(read_table(path)) == studies.study(2).runs


COLUMNS = [
    *((column, value) for column in ("until", "seconds") for value in ("x", b"\0", -1.0)
      if (column, value) != ("until", -1.0)),
    *((column, value) for column in ("tries", "failed") for value in ("x", b"\0", -1, 1.5, 10**9)
      if (column, value) != ("tries", 10**9)),
    *((column, value) for column in ("owner", "digest") for value in (b"\0",)),
]  # fmt: skip


@pytest.mark.parametrize(("column", "value"), COLUMNS)
def test_a_column_of_another_kind_is_a_fault(tmp_path, column, value):
    """Type and range of each column of a chunk; the check names it, the repair removes it."""
    path = tmp_path / "s.sqlite"
    run_study(studies.study(2), path, workers=0)
    if column in ("until", "owner"):
        edited(path, LEASED, 1.0)
        edited(path, "DELETE FROM run WHERE run <= (SELECT last FROM chunk WHERE chunk = 1)")
    edited(path, f"UPDATE chunk SET {column} = ? WHERE chunk = 1", value)
    found = check_store(path)
    assert not found.is_whole and "runs 0 to" in found.faults[0]
    with pytest.raises(StoreError):
        read_table(path)
    assert invoke("store", "repair", path)[0] == 0
    run_study(studies.study(2), path, workers=0)
    assert check_store(path).is_whole and len(read_table(path)) == studies.study(2).runs


def test_a_chunk_of_any_size_is_refused_before_its_runs_are_listed(tmp_path, monkeypatch):
    """Right digests, 10^9 repetitions in one chunk, no row: nothing of that size is made."""
    path = tmp_path / "s.sqlite"
    study = studies.study(LARGEST_CHUNK + 1)
    with Store(path) as store:
        monkeypatch.setattr("rcac_experiments.sweeps._store.LARGEST_CHUNK", 10**9)
        store.create(study, "", 10**9)
    monkeypatch.undo()
    with pytest.raises(StoreError, match=r"a chunk of 1000000000 runs"):
        check_store(path)


def test_a_store_in_a_folder_that_may_not_be_written_is_read(tmp_path, monkeypatch):
    """An archive, a CD, a colleague's share: SQLite would make files beside it."""
    path = tmp_path / "s.sqlite"
    run_study(studies.study(2), path, workers=0)
    before = read_table(path)
    for end in SIDECARS:
        path.with_name(path.name + end).unlink(missing_ok=True)
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert read_table(path) == before and check_store(path).is_whole
    assert list(tmp_path.iterdir()) == [path]
