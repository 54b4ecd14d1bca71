"""Compile an exported folder and run its test on this machine."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from compensator_theory.errors import InputError

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off")
SECONDS = 300  # for a compiler that never ends


def compiler() -> str | None:
    """The C compiler: that of the environment variable CC, or the first of cc, gcc and clang."""
    names = [os.environ.get("CC", ""), "cc", "gcc", "clang"]
    return next((path for name in names if name and (path := shutil.which(name))), None)


def compiled(sources: Sequence[Path], program: Path, *flags: str, includes: Sequence[Path]) -> Path:
    """A program, or with the flag -shared a library, of C sources."""
    cc = compiler()
    if cc is None:
        raise InputError("no C compiler found: there is no cc, gcc or clang, and CC is empty.")
    command = [cc, *FLAGS, *flags, *(f"-I{path}" for path in includes)]
    done = run_program([*command, *map(str, sources), "-o", str(program)])
    if done.returncode:
        raise InputError(f"{cc} does not compile the export: {done.stderr.strip()[:2000]}")
    return program


def run_program(command: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run a program of this machine and return its answer."""
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(f"{command[0]} did not end within {SECONDS} s.") from None
    except OSError as error:
        raise InputError(f"{command[0]} cannot be run: {error.strerror}.") from None


def replayed(source: Path, test: Path, name: str) -> tuple[bool, str]:
    """Whether the recorded vector of a folder is replayed, and the message of the test."""
    with tempfile.TemporaryDirectory() as folder:
        program = compiled(
            [source / f"{name}.c", test / "replay.c"],
            Path(folder) / "replay",
            includes=[source, test],
        )
        done = run_program([str(program)])
    return done.returncode == 0, done.stdout.strip() or f"it ended with {done.returncode}"
