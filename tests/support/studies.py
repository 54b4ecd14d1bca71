"""Small studies, and functions of them that misbehave; workers import them from here."""

import multiprocessing
import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import numpy as np

import rcac_numeric as rcac
from rcac_experiments import sweeps
from rcac_experiments.sweeps import _sweep

BASE = {
    "plant": {"problem": "standard", "G": "(q - 0.5)/((q - 0.9)*(q - 1.1))"},
    "signals": {"w": {"white_noise": 1.0}},
    "target": {"model": "fir"},
    "controller": {"structure": "iir", "n_c": 3, "R_theta": 1.0},
    "run": {"steps": 120},
}
# The same as a file.
FILE = """
title = "a study"
signals.w = { white_noise = 1.0 }
target.model = "fir"
controller = { structure = "iir", n_c = 3, R_theta = 1.0 }
run.steps = %(steps)d
[plant]
problem = "standard"
G = "(q - 0.5)/((q - 0.9)*(q - 1.1))"
[study]
repetitions = %(repetitions)d
seed = 5
keep = [{ measure = "rms" }, { measure = "spectral_radius", name = "radius" }]
axes.R_theta = { sets = "controller.R_theta", decades = [-2, 2], points = 3 }
axes.n_c = { sets = "controller.n_c", values = [3, 6] }
"""
DEADLY, RAISING, HANGING = 13.0, 7.0, 5.0


def study(repetitions=20, **changes):
    """Two axes, one of them of the plant."""
    axes = [
        sweeps.Axis("R_theta", [0.01, 1.0, 100.0], sets="controller.R_theta"),
        sweeps.Axis("noise", [0.5, 2], sets="signals.w.white_noise"),
    ]
    keep = [
        sweeps.Metric("rms"),
        sweeps.Metric("peak", "late", {"start": 100}),
        sweeps.Metric("steps"),
    ]
    arguments = {"repetitions": repetitions, "seed": 3, **changes}
    return sweeps.Study(
        arguments.pop("base", BASE), arguments.pop("axes", axes), arguments.pop("keep", keep),
        **arguments,
    )  # fmt: skip


def stored(study, path, chunk_size):
    """A finished store whose chunks have a size that no clock chooses."""
    with mock.patch.object(_sweep, "_chunk_size", lambda *of: chunk_size):
        sweeps.run_study(study, path, workers=0)
    return path


def contents(folder):
    """Every file in a folder and below it, its bytes by its path there."""
    result = (path for path in sorted(Path(folder).rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in result}


def over_R_theta(values, measure, repetitions=1):
    """One axis that a measure can tell runs by."""
    axis = sweeps.Axis("R_theta", values, sets="controller.R_theta")
    return study(repetitions, axes=[axis], keep=[sweeps.Metric("rms"), sweeps.Metric(measure)])


def deadly(r):
    """Ends the worker that measures a certain run."""
    if r.run.settings.update.R_theta == DEADLY and multiprocessing.parent_process() is not None:
        os.kill(os.getpid(), signal.SIGKILL)
    return 1.0


def raising(r):
    """Cannot measure a certain run."""
    if r.run.settings.update.R_theta == RAISING:
        raise ZeroDivisionError("there is no seventh root")
    return 1.0


def no_number(r):
    """Measures nothing."""
    return "much"


def case_of_functions(rng, gain, x_0=0.0):
    """A plant that is Python, with an initial state and noise of its own."""
    plant = rcac.FunctionPlant(
        advance=lambda k, x, u, w: 0.9 * x + gain * u + w, output=lambda k, x, w: (x, x),
        n=1, l_u=1, l_w=1, l_y=1, l_z=1,
    )  # fmt: skip
    settings = rcac.ControllerSettings(
        structure=rcac.iir(2), target=rcac.TargetModel([0, 1.0]), update=rcac.UD(R_theta=1.0)
    )
    w = rng.standard_normal((40, 1))
    start = np.array([x_0 * rng.standard_normal()])
    return rcac.SimulationCase(plant, settings, w, {"x_0": start})


@dataclass(frozen=True)
class CaseWithData:
    """The same, the initial state being data that it holds."""

    x_0: float

    def __call__(self, rng, gain):
        return case_of_functions(rng, gain, self.x_0)


def case_that_raises(rng, gain):
    """A function of a study that has a fault where gain is 3 and the noise is large."""
    if gain == 3 and rng.standard_normal() > 0:
        raise RuntimeError("no such gain")
    return case_of_functions(rng, gain)


def hanging(r):
    """Never ends where a certain run is measured."""
    while r.run.settings.update.R_theta == HANGING:
        time.sleep(0.01)
    return 1.0


def short_of_memory(r):
    """Has none as long as a file says so."""
    if os.environ.get("SHORT_OF_MEMORY") and Path(os.environ["SHORT_OF_MEMORY"]).exists():
        raise MemoryError
    return 1.0


class OddError(BaseException):
    """Derived from what `except Exception` does not catch."""


ODD = {
    1.0: lambda: SystemExit(3),
    2.0: lambda: KeyboardInterrupt("my own"),
    3.0: lambda: OddError("odd"),
    4.0: lambda: ValueError("\udcff\0\x1b[31m red"),
    5.0: lambda: ValueError("x" * 10**7),
    6.0: MemoryError,
    7.0: lambda: RecursionError("deep"),
}


def odd(r):
    """Raises what few functions raise; R_theta says which."""
    error = ODD.get(r.run.settings.update.R_theta)
    if error is not None:
        raise error()
    return 1.0


def pressing(r):
    """Somebody presses Ctrl-C while this is measured."""
    signal.raise_signal(signal.SIGINT)
    return 1.0


COUNT = {"calls": 0}


def failing_once(r):
    """Fails when it is called first."""
    COUNT["calls"] += 1
    if COUNT["calls"] == 1:
        raise OSError("try again")
    return 1.0
