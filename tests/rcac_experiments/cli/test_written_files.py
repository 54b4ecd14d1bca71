"""What is written replaces the old file as a whole, or leaves it whole."""

import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import pytest

from compensator_theory.errors import InputError
from rcac_numeric import load_run
from rcac_numeric.arrays._files import replacing

RCAC = "from rcac_experiments.cli._main import main; main()"
CHECK = ["check", "examples/octave/rcac_loop.mat", "--n-c", "4", "--plot"]
OLD = b"the picture of yesterday"


def test_the_new_file_has_the_permissions_of_the_old_one(tmp_path):
    file = tmp_path / "log.csv"
    file.write_bytes(OLD)
    file.chmod(0o640)
    with replacing(file) as new:
        assert new.parent == file.parent and new.suffix == file.suffix and new != file
        new.write_text("new")
        assert file.read_bytes() == OLD
    assert file.read_text() == "new" and file.stat().st_mode & 0o777 == 0o640
    mask = os.umask(0o027)
    try:
        with replacing(tmp_path / "other") as new:
            new.write_text("new")
    finally:
        os.umask(mask)
    assert (tmp_path / "other").stat().st_mode & 0o777 == 0o640


def test_an_exception_leaves_the_old_file_and_nothing_else(tmp_path):
    file = tmp_path / "log.csv"
    file.write_bytes(OLD)
    with pytest.raises(ZeroDivisionError), replacing(file) as new:
        new.write_text("half")
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == [file] and file.read_bytes() == OLD


def test_what_a_killed_process_was_writing_is_removed_by_the_next(tmp_path):
    file, alien = tmp_path / "log.csv", tmp_path / ".log.rcac-x.y.csv"
    for path in (file, alien):
        path.write_bytes(OLD)
    code = (
        "import os, sys; from rcac_numeric.arrays._files import replacing\n"
        "with replacing(sys.argv[1]) as new:\n    new.write_text('half'); os.kill(os.getpid(), 9)"
    )
    for _ in range(2):
        subprocess.run([sys.executable, "-c", code, str(file)], check=False)
        (left,) = set(tmp_path.iterdir()) - {file, alien}
        assert left.read_text() == "half" and file.read_bytes() == OLD
    with replacing(file) as mine:
        assert mine != left and not left.exists()
        with replacing(file) as other:
            assert mine.exists(), "who writes it is alive"
            other.write_text("second")
        mine.write_text("third")
    assert file.read_text() == "third" and set(tmp_path.iterdir()) == {file, alien}


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "folder").mkdir()
    file, link = tmp_path / "folder" / "a.csv", tmp_path / "a.csv"
    file.write_bytes(OLD)
    link.symlink_to(file)
    with replacing(link) as new:
        new.write_text("new")
    assert link.is_symlink() and file.read_text() == "new"


def test_what_cannot_be_written_is_named(tmp_path):
    for path in (tmp_path / "none" / "a.csv", tmp_path):
        with pytest.raises(InputError, match="cannot be written"), replacing(path) as new:
            new.write_text("new")


@pytest.mark.costly
def test_a_full_disk_leaves_the_old_picture(tmp_path, in_full):
    """A limit of the size of files stands for the disk: the same error from the same call."""
    for suffix in ("png", "pdf", "svg") if in_full else ("svg",):
        picture = tmp_path / f"old.{suffix}"
        picture.write_bytes(OLD)
        ended = subprocess.run(
            [sys.executable, "-B", "-c", RCAC, *CHECK, str(picture)], capture_output=True,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192)),
            text=True, check=False, env={**os.environ, "MPLCONFIGDIR": str(tmp_path / "cache")},
        )  # fmt: skip
        assert ended.returncode == 2, ended.stderr
        assert "cannot be written: File too large" in ended.stderr
        assert "Traceback" not in ended.stderr and picture.read_bytes() == OLD
    assert {p.name for p in tmp_path.iterdir()} <= {"old.png", "old.pdf", "old.svg", "cache"}


@pytest.mark.slow
def test_a_kill_leaves_one_of_the_two_pictures(tmp_path, in_full):
    """The moment is chosen by what the process does: from the first byte of the new file on."""
    picture = tmp_path / "old.png"
    for delay in [0, 0.01, 0.03] * (8 if in_full else 1):
        picture.write_bytes(OLD)
        process = subprocess.Popen(
            [sys.executable, "-c", RCAC, *CHECK, str(picture)], stdout=subprocess.DEVNULL
        )
        while process.poll() is None and not _others(tmp_path, picture):
            time.sleep(0.002)
        time.sleep(delay)
        process.kill()
        process.wait()
        bytes = picture.read_bytes()
        assert bytes == OLD or (bytes.startswith(b"\x89PNG") and bytes.endswith(b"IEND\xaeB`\x82"))
        for left in _others(tmp_path, picture):
            left.unlink()


def _others(folder: Path, picture: Path) -> list[Path]:
    return [path for path in folder.iterdir() if path != picture]


@pytest.mark.slow
@pytest.mark.parametrize("option", ["--save", "--page", "--plot"])
def test_files_come_also_where_nobody_reads_the_report(tmp_path, option):
    """As behind `| head -1`: the pipe closes after the first line."""
    file = tmp_path / {"--save": "run.npz", "--page": "page.html", "--plot": "a.svg"}[option]
    command = [sys.executable, "-c", RCAC, "verify", "2.2", option, str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 141
    assert [p.name for p in tmp_path.iterdir()] == [file.name]
    if option == "--save":
        assert load_run(file).steps > 0


@pytest.mark.skipif(sys.platform == "win32", reason="there are no such permissions")
def test_the_umask_is_never_asked_for(tmp_path, monkeypatch):
    """To read it is to set it, for every thread: the system takes it off by itself."""

    def refuse(mask):
        raise AssertionError("the umask belongs to the whole process")

    monkeypatch.setattr(os, "umask", refuse)
    for _ in range(2):  # a new file, and one that is replaced
        with replacing(tmp_path / "log.csv") as new:
            new.write_text("u,y")
