"""Through how many files and folders six tasks go, from what is given to what is shown.

Run with: python benchmarks/walks.py [NAME OF A TASK]

Counted are the functions of the two packages that are called, the files and the folders that hold
them, and the deepest stack of them. All modules are imported before, so that what is made at import
does not count. With the name of a task its files are listed, each with the functions called there.
"""

from __future__ import annotations

import importlib
import pkgutil
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import compensator_theory
import rcac_numeric
from compensator_theory import place_poles, transfer_function
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
    study, store = folder / "study.toml", folder / "study.sqlite"
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


def walk(task: Callable[[], Any]) -> tuple[dict[str, set[str]], int]:
    """The functions that a task calls, by file, and how deep they stand in each other."""
    called: dict[str, set[str]] = defaultdict(set)
    depth = deepest = 0

    def note(frame: FrameType, event: str, argument: object) -> None:
        nonlocal depth, deepest
        code = frame.f_code
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
    return called, deepest


def main(chosen: str = "") -> None:
    """Do the tasks and print their walks."""
    for package in (compensator_theory, rcac_numeric):
        for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)
    print(f"{'task':18} {'files':>6} {'folders':>8} {'functions':>10} {'depth':>6}")
    with tempfile.TemporaryDirectory() as folder:
        for name, task in tasks(Path(folder)).items():
            if chosen not in ("", name):
                continue
            called, depth = walk(task)
            functions = sum(map(len, called.values()))
            folders = {Path(file).parent for file in called}
            print(f"{name:18} {len(called):6} {len(folders):8} {functions:10} {depth:6}")
            for file in sorted(called) if chosen else ():
                names = sorted({one.rpartition(":")[0] for one in called[file]})
                print(f"  {Path(file).relative_to(ROOT)}: {', '.join(names)}")


if __name__ == "__main__":
    main(*sys.argv[1:])
