"""Compile the modules of the explorer with `python -m rcac_experiments.explorer._compiling`.

The package holds the results, `modules.json` and the certified sets of the scenes,
`ellipsoids.json`, so that a page needs no compiler.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import shutil
import tempfile
import tomllib
import zlib
from pathlib import Path

import numpy as np

from compensator_theory.errors import InputError
from rcac_experiments.explorer import _ellipsoids
from rcac_experiments.explorer._case import scene_texts
from rcac_experiments.explorer._ellipsoids import ellipsoid_of
from rcac_experiments.explorer._modules import (
    DATA,
    LARGEST_N_C,
    LARGEST_STEPS,
    LARGEST_TARGET,
)
from rcac_experiments.files._builder import build
from rcac_numeric.controllers._bounds import CertifiedBounds
from rcac_numeric.controllers._kinds import iir
from rcac_numeric.controllers._recursive import UD
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.export._building import run_program
from rcac_numeric.export._folder import core_texts
from rcac_numeric.export._header import config_header
from rcac_numeric.export._tables import core_tables
from rcac_numeric.plants._linear import Plant
from rcac_numeric.targets._model import TargetModel

CHANGING = (
    "theta_0", "D_0", "lambda", "numerators", "denominators", "K_W", "K_UPDATE", "center",
    "inverse", "radii",
)  # fmt: skip
FLAGS = (
    "--target=wasm32", "-std=c99", "-nostdlib", "-ffreestanding", "-DRCAC_FREESTANDING", "-Os",
    "-ffp-contract=off", "-Wl,--no-entry,--strip-all,-z,stack-size=16384",
    f"-DEXPLORER_STEPS={LARGEST_STEPS}",
)  # fmt: skip
MODULES = [(n_c, bounded) for bounded in (False, True) for n_c in range(1, LARGEST_N_C + 1)]
SOURCES = {
    "rcac.c": "rcac.c",
    "rcac.h": "rcac.h",
    "rcac_wasm.c": "layouts/wasm/rcac_wasm.c",
    "loop.c": "layouts/explorer/loop.c",
}


def sources(n_c: int, *, in_ellipsoid: bool = False) -> dict[str, str]:
    """The C files of the module of one order, by name."""
    model = np.zeros((2, LARGEST_TARGET + 1))
    model[0, 1] = model[1, 0] = 1.0
    model[1, 1] = 0.5  # the page may write any recursive target model in its place
    ball = CertifiedBounds(np.zeros(2 * n_c), np.eye(2 * n_c))  # and any ellipsoid
    settings = ControllerSettings(
        structure=iir(n_c),
        target=TargetModel(*model),
        update=UD(1.0),
        bounds=ball if in_ellipsoid else None,
    )
    core = core_texts()
    texts = {file: core[source] for file, source in SOURCES.items()}
    return {**texts, "rcac_config.h": config_header(core_tables(settings), changing=CHANGING)}


def digest() -> str:
    """SHA-256 of the sources of all modules and of the compiler's flags."""
    texts = [sources(n_c, in_ellipsoid=bounded) for n_c, bounded in MODULES]
    return hashlib.sha256(json.dumps([FLAGS, texts]).encode()).hexdigest()


def compiler_version() -> str:
    """The first line of `clang --version`; clang is that of the variable CLANG or of PATH."""
    missing = [name for name in (_clang(), "wasm-ld") if shutil.which(name) is None]
    if missing:
        raise InputError(
            f"{' and '.join(missing)} cannot be found. Install clang and lld to compile the "
            "explorer's modules (Debian: apt-get install clang lld)."
        )
    return run_program([_clang(), "--version"]).stdout.partition("\n")[0]


def compiled(n_c: int, *, in_ellipsoid: bool = False) -> bytes:
    """The module of one order, from its sources."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in sources(n_c, in_ellipsoid=in_ellipsoid).items():
            (folder / file).write_text(text, encoding="ascii")
        command = [_clang(), *FLAGS, f"-I{folder}", str(folder / "loop.c")]
        done = run_program([*command, "-o", str(folder / "loop.wasm")])
        if done.returncode:
            raise InputError(f"{_clang()} cannot compile the core: {done.stderr[:2000]}")
        return (folder / "loop.wasm").read_bytes()


def data() -> str:
    """The text of `modules.json`."""
    version = compiler_version()
    codes = [compiled(n_c, in_ellipsoid=bounded) for n_c, bounded in MODULES]
    table = {
        "compiler": version,
        "sources": digest(),
        "lengths": [len(code) for code in codes],
        "deflated": base64.b64encode(zlib.compress(b"".join(codes), 9)).decode(),
    }
    return json.dumps(table, indent=1) + "\n"


def _clang() -> str:
    return os.environ.get("CLANG", "") or "clang"


def scenes_digest() -> str:
    """SHA-256 of the built-in scenes."""
    return hashlib.sha256(json.dumps(scene_texts()).encode()).hexdigest()


def ellipsoids() -> str:
    """The text of `ellipsoids.json`."""
    tables = {}
    for name, text in scene_texts().items():
        run = build(tomllib.loads(text), f"{name}.toml").main_run
        assert isinstance(run.plant, Plant) and isinstance(run.settings, ControllerSettings)
        tables[name] = ellipsoid_of(run.plant, run.settings)
    return json.dumps({"scenes": scenes_digest(), "ellipsoids": tables}, indent=1) + "\n"


if __name__ == "__main__":
    home = Path(__file__).parent
    (home / _ellipsoids.DATA).write_text(ellipsoids(), encoding="ascii")
    (home / DATA).write_text(data(), encoding="ascii")
