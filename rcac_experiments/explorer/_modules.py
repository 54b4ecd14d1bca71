"""The stand-alone core around a plant as WebAssembly, a module for each order n_c."""

from __future__ import annotations

import base64
import os
import shutil
import tempfile
import zlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.controllers._kinds import iir
from rcac_numeric.controllers._recursive import UD
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.export._building import run_program
from rcac_numeric.export._folder import core_texts
from rcac_numeric.export._header import config_header
from rcac_numeric.export._tables import core_tables
from rcac_numeric.targets._model import TargetModel

LARGEST_STEPS = 5000
LARGEST_TARGET = 24  # order of the target model
CHANGING = ("D_0", "lambda", "numerators", "denominators", "K_W", "K_UPDATE")
FLAGS = (
    "--target=wasm32", "-std=c99", "-nostdlib", "-ffreestanding", "-DRCAC_FREESTANDING", "-Os",
    "-ffp-contract=off", "-Wl,--no-entry,--strip-all,-z,stack-size=16384",
)  # fmt: skip
SOURCES = {
    "rcac.c": "rcac.c",
    "rcac.h": "rcac.h",
    "rcac_wasm.c": "layouts/wasm/rcac_wasm.c",
    "loop.c": "layouts/explorer/loop.c",
}


def modules(orders: Iterable[int]) -> dict[str, Any]:
    """The modules of these orders n_c: deflated behind one another, in base64, with their lengths.

    The same compiler gives the same bytes.
    """
    modules_by_order = {n_c: module(n_c) for n_c in sorted(set(orders))}
    packed = zlib.compress(b"".join(modules_by_order.values()), 9)
    return {
        "orders": list(modules_by_order),
        "lengths": [len(code) for code in modules_by_order.values()],
        "deflated": base64.b64encode(packed).decode(),
    }


@cache
def module(n_c: int) -> bytes:
    """The module of one order, whose target model, R_theta, lambda and k_w a page writes."""
    clang = os.environ.get("CLANG", "") or "clang"
    missing = [name for name in (clang, "wasm-ld") if shutil.which(name) is None]
    if missing:
        raise InputError(
            f"the page runs the core as WebAssembly, and {' and '.join(missing)} cannot be found "
            "here to build it. Install clang and lld (Debian: apt-get install clang lld)."
        )
    model = np.zeros((2, LARGEST_TARGET + 1))
    model[0, 1] = model[1, 0] = 1.0
    model[1, 1] = 0.5  # it is recursive, as every one that a page writes may be
    settings = ControllerSettings(structure=iir(n_c), target=TargetModel(*model), update=UD(1.0))
    core = core_texts()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, source in SOURCES.items():
            (folder / file).write_text(core[source], encoding="ascii")
        header = config_header(core_tables(settings), changing=CHANGING)
        (folder / "rcac_config.h").write_text(header, encoding="ascii")
        command = [clang, *FLAGS, f"-DEXPLORER_STEPS={LARGEST_STEPS}", f"-I{folder}"]
        done = run_program([*command, str(folder / "loop.c"), "-o", str(folder / "loop.wasm")])
        if done.returncode:
            raise InputError(f"{clang} does not build the page's core: {done.stderr[:2000]}")
        return (folder / "loop.wasm").read_bytes()
