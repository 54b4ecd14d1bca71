"""Packages that pages need to run Python in the reader's browser, from npm and PyPI.

``python -m docs.browser.downloads SECTION...`` prints the files of those sections of ``pins.toml``,
one a line. Versions and digests are those of ``pins.toml``; the files are in a cache folder,
``compensator-theory/browser`` under ``XDG_CACHE_HOME`` or ``~/.cache``. Status 69: a package cannot
be had.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path

PINS = tomllib.loads((Path(__file__).parent / "pins.toml").read_text("utf-8"))
TARGET = [
    "--python-version", PINS["python"],
    "--implementation", "cp",
    "--abi", f"cp{PINS['python'].replace('.', '')}",
    "--platform", PINS["platform"],
]  # fmt: skip
UNAVAILABLE = 69


class UnavailableError(Exception):
    """A package that cannot be had on this machine, with the reason in one line."""


class PinsError(Exception):
    """An entry of pins.toml that does not fit the package that is served, or another entry."""


def main(sections: Sequence[str]) -> int:
    """Print the files of some sections; the exit status."""
    try:
        paths = [path for section in sections for path in downloaded(section)]
    except UnavailableError as error:
        print(error, file=sys.stderr)
        return UNAVAILABLE
    print(*paths, sep="\n")
    return 0


def cache_folder() -> Path:
    """The folder in which downloads are kept from one build to the next."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(base) / "compensator-theory" / "browser"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def downloaded(section: str) -> list[Path]:
    """The files of a section of the pins, each with the pinned digest.

    Raises
    ------
    UnavailableError
        npm or PyPI do not answer.
    PinsError
        A file is not the pinned one.
    """
    digests: dict[str, str] = PINS[section]
    folder = cache_folder()
    absent = [name for name, digest in digests.items() if not _is(folder / name, digest)]
    if absent:
        with tempfile.TemporaryDirectory(dir=folder) as place:
            if section == "npm":
                _npm(absent, place)
            else:
                _pip(absent, place, [] if section == "build" else TARGET)
            for name in absent:
                if not _is(Path(place, name), digests[name]):
                    raise PinsError(f"{name}: the file that is served is not the pinned one")
                Path(place, name).replace(folder / name)
    return [folder / name for name in digests]


def distribution(wheel: str) -> tuple[str, str]:
    """The name and the version that a wheel's file name says.

    Examples
    --------
    >>> from docs.browser.downloads import distribution
    >>> distribution("lazy_loader-0.6-py3-none-any.whl")
    ('lazy-loader', '0.6')
    """
    name, version, *_ = wheel.split("-")
    return name.replace("_", "-").lower(), version


def _is(path: Path, digest: str) -> bool:
    """Whether a file is there and has the digest."""
    return path.exists() and sha256(path.read_bytes()).hexdigest() == digest


def _npm(names: Sequence[str], place: str) -> None:
    """Fetch packed npm packages."""
    npm = shutil.which("npm")
    if npm is None:
        raise UnavailableError("npm is not installed")
    packages = ["@".join(name.removesuffix(".tgz").rsplit("-", 1)) for name in names]
    _run([npm, "pack", "--silent", *packages], "npm", place)


def _pip(names: Sequence[str], place: str, target: Sequence[str]) -> None:
    """Fetch wheels, for Pyodide or, to build the site, for this machine."""
    options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--only-binary", ":all:"]
    packages = ["==".join(distribution(name)) for name in names]
    _run([sys.executable, "-m", "pip", "download", *options, *target, *packages], "PyPI", place)


def _run(command: Sequence[str | Path], source: str, place: str) -> None:
    """Run a command in a folder; its last line is the reason if it fails."""
    ended = subprocess.run(command, cwd=place, capture_output=True, text=True, check=False)
    if ended.returncode:
        lines = (ended.stderr or ended.stdout).strip().splitlines() or ["no reason given"]
        raise UnavailableError(f"{source} does not serve the pinned packages: {lines[-1]}")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
