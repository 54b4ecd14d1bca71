"""Every command of `rcac` ended at any moment: the right status, no traceback, whole files.

Ctrl-C, a request to end, a kill, a full disk, a limit of the size of files, a reader that goes
away; each at a moment drawn at random from the command's own run. By default two of the six for
the quick commands; `--long` interrupts each of all commands 102 times.
"""

import os
import random
import re
import resource
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from functools import partial

import pytest

# Ctrl-C before the first line of ours is Python's; the program says when it has come that far.
BEGIN = """
import os, resource, signal
signal.signal(signal.SIGINT, lambda *_: os._exit(130))  # until main() has an answer of its own
from rcac_experiments.cli.__main__ import main
resource.setrlimit(resource.RLIMIT_FSIZE, {limits})
os.write({begun}, b".")
main()
"""
NO_LIMITS = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
COMMANDS = {
    "list": ["list"],
    "schema": ["schema"],
    "place": ["place", "--plant", "4/((s + 1)*(s + 3))", "--poles", "-6, -5, -4, -2"],
    "observer": ["observer", "--plant", "4/(s**2+4*s+3)", "--compensator", "8/(s**2+13*s+49)"],
    "verify": ["verify", "2.2", "--plot"],
    "check": ["check", "examples/octave/rcac_loop.mat", "--n-c", "4", "--plot"],
}  # fmt: skip
QUICK = ("list", "schema", "place")
OLD = b"the picture of yesterday"
TIMES = 17  # for each of six kinds of interruption, with --long
FULL = "rcac: the output cannot be written: No space left on device.\n"
MESSAGE = re.compile(r"(rcac: .* cannot be written: (File too large|No space left on device)\.\n)?")


@dataclass
class Ended:
    status: int
    out: bytes
    err: str


class Subject:
    """A command that can be started again and again, with what an undisturbed run of it gives."""

    def __init__(self, name, folder):
        self.picture = folder / "picture.png" if "--plot" in COMMANDS[name] else None
        self.arguments = [*COMMANDS[name], *([str(self.picture)] if self.picture else [])]
        self.environment = {**os.environ, "MPLCONFIGDIR": str(folder / "cache")}
        self.folder = folder
        self.renew()
        if self.picture:
            self.run(lambda process: None)  # fills the cache
        start = time.monotonic()
        self.whole = self.run(lambda process: None)
        self.seconds = time.monotonic() - start
        assert self.whole.status == 0 and not self.whole.err

    def renew(self):
        if self.picture:
            self.picture.write_bytes(OLD)

    def run(self, interrupt, output=subprocess.PIPE, limits=NO_LIMITS):
        """Start it, interrupt it once it is our program, and wait for its end."""
        read, write = os.pipe()
        code = BEGIN.format(limits=limits, begun=write)
        process = subprocess.Popen(
            [sys.executable, "-B", "-c", code, *self.arguments], stdout=output,
            stderr=subprocess.PIPE, pass_fds=[write], env=self.environment,
        )  # fmt: skip
        os.close(write)
        os.read(read, 1)
        os.close(read)
        interrupt(process)
        out, err = process.communicate()
        return Ended(process.returncode, out or b"", err.decode())

    def require_whole_files(self):
        """The picture is the old one or a new one; a later run leaves nothing else beside it."""
        if self.picture is None:
            return
        bytes = self.picture.read_bytes()
        is_png = bytes.startswith(b"\x89PNG") and bytes.endswith(b"IEND\xaeB`\x82")
        assert bytes == OLD or is_png
        assert len(self.others()) <= 1

    def others(self):
        return [p for p in self.folder.iterdir() if p.name not in ("cache", self.picture.name)]


def signalled(subject, rng, number, status):
    """A signal at a moment of the run; the last moments belong to the end of Python itself."""

    def interrupt(process):
        time.sleep(rng.uniform(0, 1.05 * subject.seconds))
        process.send_signal(number)

    ended = subject.run(interrupt)
    if ended.status == 0:
        assert ended == subject.whole
    else:
        assert ended.status in (status, -number)
        assert ended.err.lstrip("\n") in ("", "rcac: interrupted.\n")  # click ends the line of ^C
        assert number == signal.SIGINT or not ended.err
    if ended.status == -signal.SIGINT:
        assert ended.out == subject.whole.out, "all was done"


def full_disk(subject, rng):
    with open("/dev/full", "wb") as full:
        ended = subject.run(lambda process: None, output=full)
    assert (ended.status, ended.err) == (2, FULL)
    if subject.picture:
        assert subject.picture.read_bytes() == OLD, "no picture of a report that was not given"


def limited_files(subject, rng):
    """No file may grow beyond some size: what is printed goes into one, too."""
    size = rng.choice([0, 1, 4096, rng.randrange(1, 300_000)])
    printed = subject.folder / "cache" / "printed"
    with open(printed, "wb") as output:
        ended = subject.run(lambda process: None, output=output, limits=(size, size))
    assert MESSAGE.fullmatch(ended.err) and ended.status == (2 if ended.err else 0)
    assert printed.read_bytes() == subject.whole.out[:size] or ended.status == 2


def closed_pipe(subject, rng):
    """`rcac ... | head`: who reads goes away after some bytes."""

    def interrupt(process):
        process.stdout.read(rng.choice([0, 0, 1, 100, rng.randrange(1, 10_000)]))
        time.sleep(rng.choice([0, 0.5 * subject.seconds]))
        process.stdout.close()
        process.stdout = None

    ended = subject.run(interrupt)
    assert ended.status in (0, 141) and not ended.err


KINDS = {
    "SIGINT": partial(signalled, number=signal.SIGINT, status=130),
    "SIGTERM": partial(signalled, number=signal.SIGTERM, status=-signal.SIGTERM),
    "SIGKILL": partial(signalled, number=signal.SIGKILL, status=-signal.SIGKILL),
    "full disk": full_disk,
    "file size": limited_files,
    "closed pipe": closed_pipe,
}


@pytest.mark.costly
@pytest.mark.long
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a full device")
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_ends_well_whenever_it_ends(name, tmp_path, in_full, at_a_terminal):
    if not (in_full or name in QUICK):
        pytest.skip("takes a minute; --long runs it")
    (tmp_path / "cache").mkdir()
    subject = Subject(name, tmp_path)
    seed = random.randrange(2**32)
    rng = random.Random(seed)
    kinds = KINDS if in_full else rng.sample(sorted(KINDS), 2)
    counts = {}
    for kind in [*kinds] * (TIMES if in_full else 1):
        subject.renew()
        try:
            KINDS[kind](subject, rng)
            subject.require_whole_files()
        except AssertionError as error:
            error.add_note(f"rcac {name}, {kind}, seed {seed}")
            raise
        counts[kind] = counts.get(kind, 0) + 1
    print(f"rcac {name}: {counts}")
    if subject.picture:
        subject.run(lambda process: None)
        assert not subject.others(), "what a killed run was writing is gone"
