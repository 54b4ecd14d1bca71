"""What a reader of six tasks holds in mind: files, folders, functions, and classes of values.

Run with: python benchmarks/walks.py [NAME OF A TASK]

Counted are the functions of the packages that are called, the files and the folders that hold
them, the deepest stack of them, and the classes of ours that are instantiated. All modules are
imported before, so that what is made at import does not count. With the name of a task its files
are listed, each with the functions called there, and its classes. Then the way of a plant, in each
form that one is written in, through the functions that read it: the files that are entered, and how
often one is entered again that had been left. The last line counts the modules that a controller
needs. The check prints these numbers; nothing enforces them.
"""

from __future__ import annotations

import importlib
import pkgutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import control
import numpy as np
import sympy

import compensator_theory
import rcac_experiments
import rcac_numeric
from compensator_theory import (
    place_poles,
    realisation,
    stability_margins,
    transfer_function,
    transfer_matrix,
)
from rcac_experiments import check_arguments, load_experiment, verify
from rcac_experiments.sweeps import read_table, run_study
from rcac_experiments.sweeps._files import load_study
from rcac_numeric import (
    UD,
    Controller,
    ControllerSettings,
    ModellingInformation,
    check_controller,
    fir_target,
    iir,
    plant_of,
    read_log,
)
from rcac_numeric.estimation import EKF, Estimator, LinearModel

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = tuple(
    str(ROOT / name) for name in ("compensator_theory", "rcac_numeric", "rcac_experiments")
)
EXAMPLES = ROOT / "examples"
CASE = ROOT / "rcac_experiments/dissertation/example_files/4.7.toml"
STUDY = """
title = "one cell"
[plant]
problem = "standard"
G = "(q - 0.5)/(q*(q - 0.9))"
[signals]
w = { white_noise = 1.0 }
[target]
model = "fir"
[controller]
structure = "iir"
n_c = 2
R_theta = 1e-3
[run]
steps = 200
[study]
seed = 1
repetitions = 1
keep = [{ name = "J", measure = "cost_over_high_authority" }]
[study.axes]
R_theta = { sets = "controller.R_theta", values = [1e-3] }
"""


def _settings() -> ControllerSettings:
    target = fir_target(ModellingInformation(d_zu=1, H=1.0))
    return ControllerSettings(structure=iir(n_c=2), target=target, update=UD(R_theta=1e-6))


def _placed() -> object:
    plant = transfer_function("(17/20)/(s**3 + 3*s**2 + 91/20*s)")
    return place_poles(plant, [-1, -2, -3, -4, -5, -6], feedback=-1).residual


def _studied(folder: Path) -> object:
    study, store = folder / "study.toml", folder / "study"
    study.write_text(STUDY)
    run_study(load_study(study), store, workers=0)
    return read_table(store)


def _checked() -> str:
    log = read_log(EXAMPLES / "octave/rcac_loop.mat")
    arguments = check_arguments(EXAMPLES / "octave/example_4_7.toml")
    return str(check_controller(log, **arguments).report())


def tasks(folder: Path) -> dict[str, Callable[[], Any]]:
    """The six tasks; what is made before is no part of them."""
    controller = Controller(_settings())
    estimator = Estimator(EKF(LinearModel(A=0.9, B=1, C=1), Q=0.01, R=0.1))
    return {
        "TOML to verdict": lambda: str(verify(load_experiment(CASE))),
        "Controller.step": lambda: controller.step(y=1.0, z=1.0),
        "text to placement": _placed,
        "sweep cell": lambda: _studied(folder),
        "Estimator.step": lambda: estimator.step(y=1.0, u=0.1),
        "log to report": _checked,
    }


NAMES = tuple(Path(package).name for package in PACKAGES)
MAKING = ("__init__", "__post_init__", "__attrs_post_init__")


def walk(task: Callable[[], Any]) -> tuple[dict[str, set[str]], int, set[str]]:
    """The functions that a task calls, by file, how deep they stand, and the classes it makes."""
    called: dict[str, set[str]] = defaultdict(set)
    classes: set[str] = set()
    depth = deepest = 0

    def note(frame: FrameType, event: str, argument: object) -> None:
        nonlocal depth, deepest
        code = frame.f_code
        if event == "call" and code.co_name in MAKING:
            kind = type(frame.f_locals.get("self"))
            if kind.__module__.startswith(NAMES):
                classes.add(f"{kind.__module__}.{kind.__qualname__}")
        if not code.co_filename.startswith(PACKAGES):
            return
        if event == "call":
            depth += 1
            deepest = max(deepest, depth)
            called[code.co_filename].add(f"{code.co_qualname}:{code.co_firstlineno}")
        elif event == "return":
            depth -= 1

    sys.setprofile(note)
    try:
        task()
    finally:
        sys.setprofile(None)
    return called, deepest, classes


def plants() -> dict[str, Any]:
    """One plant, (s + 2)/(s**2 - 1), as somebody may have it."""
    s = sympy.Symbol("s")
    A, B, C = [[0, 1], [1, 0]], [[0], [1]], [[2, 1]]
    return {
        "text": "(s + 2)/(s**2 - 1)",
        "SymPy": (s + 2) / (s**2 - 1),
        "pair of texts": ("s + 2", "s**2 - 1"),
        "pair of lists": ([1, 2], [1, 0, -1]),
        "pair of arrays": (np.array([1.0, 2.0]), np.array([1.0, 0.0, -1.0])),
        "rows": [["(s + 2)/(s**2 - 1)"]],
        "python-control": control.tf([1, 2], [1, 0, -1]),
        "control.ss": control.ss(A, B, C, 0),
        "matrices": (A, B, C),
        "arrays": tuple(np.array(part, float) for part in (A, B, C)),
        "one of ours": transfer_function("(s + 2)/(s**2 - 1)"),
    }


READERS: dict[str, Callable[[Any], Any]] = {
    "transfer_function": lambda plant: transfer_function(plant, "s"),
    "transfer_matrix": lambda plant: transfer_matrix(plant, "s"),
    "realisation": lambda plant: realisation(plant, "s"),
    "place_poles": lambda plant: place_poles(plant, [-1, -2, -3], feedback=-1, variable="s"),
    "stability_margins": lambda plant: stability_margins(plant, feedback=-1, variable="s"),
    "plant_of": lambda plant: plant_of(plant, sample_time=0.1, variable="s"),
}


def way(reader: Callable[[Any], Any], plant: Any) -> tuple[int, int, int]:
    """Files that are entered, entries into one that had been left, and calls."""
    entered: list[str] = []

    def note(frame: FrameType, event: str, argument: object) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(PACKAGES):
            entered.append(frame.f_code.co_filename)

    sys.setprofile(note)
    try:
        reader(plant)
    finally:
        sys.setprofile(None)
    moves = [file for file, before in zip(entered, ["", *entered], strict=False) if file != before]
    return len(set(moves)), len(moves) - len(set(moves)), len(entered)


def print_ways() -> None:
    """Print files and returns, by reader and by what is read."""
    print("\n" + f"{'files entered + returns':24}" + "".join(f"{n:>18}" for n in READERS))
    for name, plant in plants().items():
        ways = []
        for reader in READERS.values():
            reader(plant)  # what is kept for the next time is no part of the way
            files, returns, _ = way(reader, plant)
            ways.append(f"{files} + {returns}")
        print(f"{name:24}" + "".join(f"{one:>18}" for one in ways))


def modules_of_a_controller() -> str:
    """How many modules `from rcac_numeric import Controller` loads, ours and all."""
    code = (
        "import sys; from rcac_numeric import Controller; "
        f"print(sum(name.startswith({NAMES}) for name in sys.modules), len(sys.modules))"
    )
    return subprocess.check_output([sys.executable, "-c", code], text=True)


def main(chosen: str = "") -> None:
    """Do the tasks and print their walks."""
    for package in (compensator_theory, rcac_numeric, rcac_experiments):
        for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)
    print(f"{'task':18} {'files':>6} {'folders':>8} {'functions':>10} {'depth':>6} {'classes':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for name, task in tasks(Path(folder)).items():
            if chosen not in ("", name):
                continue
            called, depth, classes = walk(task)
            functions = sum(map(len, called.values()))
            folders = {Path(file).parent for file in called}
            counts = f"{len(called):6} {len(folders):8} {functions:10} {depth:6} {len(classes):8}"
            print(f"{name:18} {counts}")
            for file in sorted(called) if chosen else ():
                names = sorted({one.rpartition(":")[0] for one in called[file]})
                print(f"  {Path(file).relative_to(ROOT)}: {', '.join(names)}")
            for one in sorted(classes) if chosen else ():
                print(f"  class {one}")
    if not chosen:
        print_ways()
    ours, every = modules_of_a_controller().split()
    print(f"from rcac_numeric import Controller: {ours} modules of ours, {every} in all")


if __name__ == "__main__":
    main(*sys.argv[1:])
