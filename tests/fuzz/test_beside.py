"""Whatever stands under a name that a command opens or writes: it leads nowhere else.

docs/trust.md says how each kind is treated. What a stranger can put there comes out of an archive:
a text, a link, a hard link, a pipe, a folder. Each command then gives the right answer or refuses
in our words; nothing outside is touched, nothing waits.
"""

import os
import re
import shutil
import signal
from pathlib import Path

import pytest
from click.testing import CliRunner

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.cli._main import main
from rcac_experiments.dissertation._reproduction import CompletedCases, reproduce
from rcac_numeric.arrays import _files

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
    """A finished store."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "s.toml").write_text(STUDY)
    assert invoke("sweep", folder / "s.toml", "-o", folder / "s", "--workers", "0")[0] == 0
    return folder / "s"


def invoke(*words):
    """Exit status and what was printed, of one command."""
    done = CliRunner().invoke(main, [str(word) for word in words])
    return done.exit_code, done.output + done.stderr


KINDS = {
    "empty": lambda path, victim: path.write_bytes(b""),
    "text": lambda path, victim: path.write_text("words of others\n"),
    "link": lambda path, victim: path.symlink_to(victim),
    "dangling": lambda path, victim: path.symlink_to(victim.with_name("new.txt")),
    "hard link": lambda path, victim: path.hardlink_to(victim),
    "folder": lambda path, victim: path.mkdir(),
    "pipe": lambda path, victim: os.mkfifo(path),
}  # fmt: skip
COMMANDS = {
    "sweep": ("sweep", "s.toml", "-o", "s", "--workers", "0"),
    "show": ("show", "s", "--export", "s.csv"),
    "replay": ("replay", "s", "0"),
    "check": ("store", "check", "s"),
}
# Names in a store, and one beside it that a killed process left, or says that it did.
CHUNK = "s/chunks/00000001.parquet"
NAMES = ("s/study.json", "s/chunks", CHUNK, "s/chunks/.00000001.parquet.0badcafe.part")
NAMES += ("s/chunks/notes.parquet", "s/.study.json.0badcafe.part", ".s.rcac-0badcafe.csv")


def outside(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.fixture
def places(tmp_path, monkeypatch):
    """A folder that came from others, to work in, and one beside it that is ours."""
    received, ours = tmp_path / "got", tmp_path / "ours"
    received.mkdir()
    ours.mkdir()
    (ours / "notes.txt").write_text("mine\n")
    monkeypatch.chdir(received)
    return received, ours


def cleared(folder):
    for path in folder.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


@pytest.mark.costly
@pytest.mark.cases(8)
@pytest.mark.parametrize(
    ("command", "name"), [(command, name) for command in COMMANDS for name in NAMES]
)
def test_what_lies_in_a_store_leads_nowhere(store, places, command, name):
    """Of 7 kinds each: right, or refused with a status of ours, and nothing outside is touched."""
    received, ours = places
    before = outside(ours)
    for kind, make in KINDS.items():
        cleared(received)
        shutil.copytree(store, received / "s")
        (received / "s.toml").write_text(STUDY)
        path = received / name
        if path.is_dir():
            shutil.rmtree(path)
        path.unlink(missing_ok=True)
        make(path, ours / "notes.txt")
        status, message = invoke(*COMMANDS[command])
        assert status in (0, 1, 2), (kind, status, message)
        assert outside(ours) == before, f"{kind}: touched"
        assert status != 2 or message.startswith("rcac: "), (kind, message)
        if name == CHUNK:
            expected = {"sweep": 2 * (kind == "folder"), "check": 1}.get(command, 2)
            assert status == expected, (kind, status, message)
        elif name == "s/study.json":
            assert status == 2, (kind, message)
        elif name.endswith((".part", ".csv")):
            assert status == 0, (kind, message)


@pytest.mark.costly
@pytest.mark.parametrize("command", COMMANDS)
def test_the_store_itself(store, places, command):
    """Absent, empty, a text, a link to a text or to nothing, a folder, a pipe."""
    received, ours = places
    before = outside(ours)
    for kind, make in {"absent": lambda *_: None, **KINDS}.items():
        cleared(received)
        (received / "s.toml").write_text(STUDY)
        make(received / "s", ours / "notes.txt")
        if command == "sweep" and kind in ("absent", "folder"):
            continue  # a store is made there
        status, message = invoke(*COMMANDS[command])
        if kind == "folder" and command == "check":
            assert status == 0 and "The store contains no study yet" in message
        else:
            assert status == 2 and "s" in message, (kind, status, message)
        assert outside(ours) == before, f"{kind}: touched"


@pytest.mark.costly
def test_a_link_that_you_name_is_followed(store, places):
    received, _ = places
    (received / "s").symlink_to(store)
    assert invoke("show", "s")[0] == 0 and invoke("replay", "s", "3")[0] == 0


READERS = (
    ("verify", "x.toml"), ("sweep", "x.toml", "-o", "new"), ("observer", "x.toml"),
    ("place", "x.toml"), ("export", "x.toml", "-o", "c"), ("explore", "x.toml", "-o", "c.html"),
    ("check", "x.csv", "--n-c", "2"), ("check", "x.npz"), ("check", "x.mat", "--n-c", "2"),
    ("design", "x.csv"), ("show", "x.toml"), ("show", "x.npz"), ("replay", "x.csv", "0"),
)  # fmt: skip


@pytest.mark.parametrize("words", READERS, ids=" ".join)
def test_a_file_that_is_read_leads_nowhere(places, words):
    received, ours = places
    before = outside(ours)
    for kind, make in {"absent": lambda *_: None, **KINDS}.items():
        cleared(received)
        make(received / words[1], ours / "notes.txt")
        status, message = invoke(*words)
        assert status == 2, (kind, status, message)
        assert outside(ours) == before
        left = {path.name for path in received.iterdir()}
        assert left <= {words[1]}, f"{kind}: {left}"


def test_members_of_a_folder_are_written_neither_to_nor_through_a_link(places):
    """The folder is named by whoever asks; the names in it are ours."""
    received, ours = places
    before = outside(ours)
    for kind, make in KINDS.items():
        cleared(received)
        if kind in ("empty", "text", "hard link"):  # replaced by a new file, not written into
            make(received / "a.c", ours / "notes.txt")
            with _files.replacing(_files.member(received, "a.c")) as new:
                new.write_text("ours")
            assert (received / "a.c").read_text() == "ours"
        else:
            make(received / "a.c", ours / "notes.txt")
            with pytest.raises(InputError, match="not a regular file"):
                _files.member(received, "a.c")
            (received / "src").symlink_to(ours)
            with pytest.raises(InputError, match="not a regular folder"):
                _files.member(received, "src/a.c")
        assert outside(ours) == before, kind
    with pytest.raises(InputError, match=r"\.\."):
        _files.member(received, "../ours/notes.txt")
    link = received / "mine"
    link.symlink_to(ours)
    assert _files.member(link, "a.c") == link / "a.c"  # you named it


def test_kept_cases_and_pages_are_members(places):
    received, ours = places
    (received / "index.html").symlink_to(ours / "notes.txt")
    with pytest.raises(CompensatorError, match="not a regular file"):
        reproduce([], received)
    assert outside(ours) == {"notes.txt": b"mine\n"}
    assert CompletedCases(received)


def test_who_makes_a_folder_writes_its_members():
    """A folder's files under names of ours go through `member`, which makes the folder."""
    makers = {
        str(path.relative_to(ROOT))
        for package in ("compensator_theory", "rcac_numeric", "rcac_experiments")
        for path in (ROOT / package).rglob("*.py")
        if re.search(r"mkdir\(.*parents|makedirs\(", path.read_text("utf-8"))
    }
    assert makers == {"rcac_numeric/arrays/_files.py", "rcac_experiments/cli/_verify.py"}
