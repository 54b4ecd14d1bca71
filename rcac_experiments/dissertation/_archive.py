"""One file with all that a reader needs to check a reproduction years later."""

from __future__ import annotations

import json
import platform
import zipfile
from collections.abc import Iterator
from importlib import resources
from importlib.metadata import distributions, version
from importlib.resources.abc import Traversable
from pathlib import Path

from rcac_experiments.dissertation._reproduction import CASES, Reproduction
from rcac_numeric.arrays._files import replacing

PACKAGES = ("compensator_theory", "rcac_numeric", "rcac_experiments")
SOURCES = (".py", ".pyi", ".toml", ".css", ".js", ".html")
DATE = (1980, 1, 1, 0, 0, 0)  # the same content is the same file
README = """This is a reproduction of the examples of a dissertation.

index.html         the page, which needs no network
cases/             each example as it was computed: claims, measures, verdicts, pictures
examples/, errata/ the files that say what was run, quoted and claimed, as they were written
sources/           the three packages in Python, and their data; the compiled kernel is in the
                   source distribution of compensator-theory {version}
environment.json   versions of everything that was installed, and the machine

To compute it again: pip install compensator-theory=={version}, then rcac reproduce -o folder.
Seeds stand in the page's last section and in cases/; the verdicts of record are those of group 0
of the held-out seeds, rcac verify NUMBER --seeds GROUP runs others.
"""


def write_archive(reproduction: Reproduction, path: str | Path) -> None:
    """Write the archive of a reproduction, a ZIP file."""
    package_version = version("compensator-theory")
    with replacing(path) as new, zipfile.ZipFile(new, "w", zipfile.ZIP_DEFLATED) as archive:

        def add(name: str, content: bytes) -> None:
            archive.writestr(zipfile.ZipInfo(name, DATE), content, zipfile.ZIP_DEFLATED)

        add("README.txt", README.format(version=package_version).encode())
        add("environment.json", _environment().encode())
        add("index.html", reproduction.page.read_bytes())
        for file in sorted((reproduction.page.parent / CASES).glob("*.json")):
            add(f"cases/{file.name}", file.read_bytes())
        home = resources.files("rcac_experiments.dissertation")
        for name, content in _files(home.joinpath("example_files"), "examples"):
            add(name, content)
        for name, content in _files(home.joinpath("errata_files"), "errata"):
            add(name, content)
        for package in PACKAGES:
            for name, content in _files(resources.files(package), f"sources/{package}"):
                add(name, content)


def _files(folder: Traversable, prefix: str) -> Iterator[tuple[str, bytes]]:
    """Every source below a folder, in the order of names."""
    for part in sorted(folder.iterdir(), key=lambda entry: entry.name):
        name = f"{prefix}/{part.name}"
        if part.is_dir() and not part.name.startswith(("_", ".")):
            yield from _files(part, name)
        elif part.name.endswith(SOURCES):
            yield name, part.read_bytes()


def _environment() -> str:
    """Versions and machine as JSON."""
    versions = {one.metadata["Name"]: one.version for one in distributions()}
    environment = {
        "python": platform.python_version(),
        "system": platform.system(),
        "machine": platform.machine(),
        "versions": dict(sorted(versions.items())),
    }
    return json.dumps(environment, indent=1)
