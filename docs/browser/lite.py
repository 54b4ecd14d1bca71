"""A JupyterLite site with the exact half, whose Python the examples of the pages use, too.

The wheels are in Pyodide's lock file, so that an import loads them: no notebook installs anything.
"""

import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile
from collections.abc import Iterable
from datetime import UTC, datetime
from email.parser import Parser
from hashlib import sha256
from pathlib import Path
from typing import Any

from docs.browser.downloads import PINS, PinsError, cache_folder, downloaded

RUNTIME = ("pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "python_stdlib.zip")
LOCK = "pyodide-lock.json"
BROWSER = {
    "sys_platform": "emscripten",
    "platform_system": "Emscripten",
    "platform_machine": "wasm32",
    "os_name": "posix",
    "python_version": PINS["python"],
    "python_full_version": f"{PINS['python']}.0",
    "implementation_name": "cpython",
    "platform_python_implementation": "CPython",
    "extra": "",
}
"""What markers of requirements ask."""
KERNEL = ["micropip", "piplite", "ipykernel", "comm", "pyodide-kernel", "jedi", "ipython"]
"""Packages that the kernel asks for before the first cell."""
EXTENSION = "share/jupyter/labextensions/@jupyterlite/pyodide-kernel-extension/static/pypi"


def write_site(target: Path, wheel: Path, lectures: Iterable[Path]) -> int:
    """Write the site; its size in bytes.

    Raises
    ------
    UnavailableError
        A pinned package cannot be had.
    PinsError
        The pinned packages do not fit together.
    """
    runtime, temml = downloaded("npm")
    wheels = [*downloaded("exact"), *downloaded("kernel"), wheel]
    tools = _tools()
    kernel = [path for path in (tools / EXTENSION).glob("*.whl") if path.stem[:7] != "widgets"]
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder)
        _write_runtime(source / "static" / "pyodide", runtime, [*wheels, *kernel])
        _write_settings(source)
        shutil.rmtree(target, ignore_errors=True)
        _build(tools, source, target.resolve())
    _unpack(temml, target / "static" / "temml", ["dist/temml.mjs", "LICENSE"])
    _write_lectures(target, lectures)
    return sum(path.stat().st_size for path in target.rglob("*") if path.is_file())


def lock(wheels: Iterable[Path]) -> dict[str, dict[str, Any]]:
    """The packages of a lock file, by normal name, each with all that it needs among them.

    Raises
    ------
    PinsError
        A wheel needs a package that is not there, or another version of it.
    """
    from packaging.utils import canonicalize_name

    packages, needed = {}, []
    for wheel in wheels:
        entry, requirements = _entry(wheel)
        packages[canonicalize_name(entry["name"])] = entry
        needed += [(entry, requirement) for requirement in requirements]
    for entry, requirement in needed:
        name = canonicalize_name(requirement.name)
        version = packages[name]["version"] if name in packages else None
        if version is None or not requirement.specifier.contains(version, prereleases=True):
            raise PinsError(f"{entry['name']} needs {requirement}, and {name} is {version}")
        entry["depends"].append(name)
    return packages


def _entry(wheel: Path) -> tuple[dict[str, Any], list[Any]]:
    """A wheel as Pyodide's lock file lists it, and the requirements that hold in a browser."""
    from packaging.requirements import Requirement

    with zipfile.ZipFile(wheel) as packed:
        names = packed.namelist()
        metadata = next(name for name in names if name.endswith(".dist-info/METADATA"))
        message = Parser().parsestr(packed.read(metadata).decode())
    tops = {name.split("/")[0] for name in names if name.endswith((".py", ".so"))}
    entry = {
        "name": message["Name"],
        "version": message["Version"],
        "file_name": wheel.name,
        "install_dir": "site",
        "sha256": sha256(wheel.read_bytes()).hexdigest(),
        "package_type": "package",
        "imports": sorted(
            top.split(".")[0] for top in tops if not top.endswith((".dist-info", ".libs", ".data"))
        ),
        "depends": [],
        "unvendored_tests": False,
    }
    lines = map(Requirement, message.get_all("Requires-Dist") or [])
    return entry, [line for line in lines if line.marker is None or line.marker.evaluate(BROWSER)]


def _write_runtime(target: Path, runtime: Path, wheels: Iterable[Path]) -> None:
    """Write Pyodide, the wheels, and the lock file that names them."""
    wheels = list(wheels)
    _unpack(runtime, target, [*RUNTIME, LOCK])
    for wheel in wheels:
        shutil.copy(wheel, target)
    locked = json.loads((target / LOCK).read_text())
    (target / LOCK).write_text(json.dumps({**locked, "packages": lock(wheels)}))


def _unpack(archive: Path, target: Path, names: Iterable[str]) -> None:
    """Write some files of a packed npm package into a folder."""
    target.mkdir(parents=True)
    with tarfile.open(archive) as packed:
        for name in names:
            content = packed.extractfile(f"package/{name}")
            assert content is not None, f"{archive.name} has no {name}"
            (target / Path(name).name).write_bytes(content.read())


def _write_settings(source: Path) -> None:
    """Write the settings of the app: nothing is asked of another server."""
    kernel = {"disablePyPIFallback": True, "loadPyodideOptions": {"packages": KERNEL}}
    app = {
        "appName": "compensator-theory",
        "appUrl": "./tree",
        "disabledExtensions": ["@jupyter-notebook/notebook-extension:tab-icon"],  # of a server
        "contentsAllJsonFile": "all.json",  # see _write_lectures
        "faviconUrl": "./notebooks/favicon.ico",
        "litePluginSettings": {"@jupyterlite/pyodide-kernel-extension:kernel": kernel},
    }
    settings = {"jupyter-lite-schema-version": 0, "jupyter-config-data": app}
    (source / "jupyter-lite.json").write_text(json.dumps(settings))
    whole = {"@jupyterlab/notebook-extension:tracker": {"windowingMode": "none"}}
    (source / "overrides.json").write_text(json.dumps(whole))  # so that a page can be searched


def _tools() -> Path:
    """An environment with JupyterLite's builder, kept in the cache for its pins."""
    files = downloaded("build")
    digest = sha256(json.dumps([PINS["build"], sys.version]).encode()).hexdigest()[:12]
    folder = cache_folder() / f"build-{digest}"
    if not (folder / "finished").exists():
        venv.create(folder, clear=True)
        pip = [sys.executable, "-m", "pip", "--python", folder, "install", "--quiet"]
        subprocess.run([*pip, "--no-index", "--no-deps", *files], check=True)
        (folder / "finished").touch()
    return folder


def _build(tools: Path, source: Path, target: Path) -> None:
    """Build the app for notebooks with its list of files."""
    scripts = tools / ("Scripts" if sys.platform == "win32" else "bin")
    command = [
        scripts / "python", "-W", "ignore", "-m", "jupyterlite_core", "build",
        "--lite-dir", source, "--output-dir", target, "--apps", "notebooks", "--apps", "tree",
        "--no-sourcemaps", "--no-unused-shared-packages",
    ]  # fmt: skip
    ended = subprocess.run(command, cwd=source, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise RuntimeError(f"JupyterLite is not built:\n{ended.stdout}\n{ended.stderr}")


def _write_lectures(target: Path, lectures: Iterable[Path]) -> None:
    """Write the notebooks and their list, in the form of Jupyter's contents API.

    JupyterLite's own step for it needs a Jupyter server with thirty packages.
    """
    (target / "files").mkdir()
    today = datetime.now(UTC).isoformat()
    common = {"created": today, "last_modified": today, "mimetype": None, "writable": True}
    files = []
    for path in lectures:
        shutil.copy(path, target / "files")
        file = {"name": path.name, "path": path.name, "type": "notebook", "format": None}
        files.append({**common, **file, "content": None, "size": path.stat().st_size})
    folder = {"name": "", "path": "", "type": "directory", "format": "json", "size": None}
    contents = target / "api" / "contents"
    contents.mkdir(parents=True, exist_ok=True)
    (contents / "all.json").write_text(json.dumps({**common, **folder, "content": files}))
