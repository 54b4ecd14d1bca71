"""The commands `rcac design` and `rcac tune`: design a controller for a plant or a log."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from compensator_theory.errors import InputError
from rcac_experiments.cli._check import (
    is_transfer_function,
    parse_names,
    read_case,
    written_rows,
    written_system,
)
from rcac_experiments.cli._exits import DONE, NO
from rcac_experiments.cli._output import (
    as_json_option,
    log_arguments,
    log_options,
    picture_option,
    show,
    with_log,
)
from rcac_experiments.files._design_files import design_arguments, save_design
from rcac_experiments.reports._tuned import tuned_sheet
from rcac_experiments.sweeps._progress import ProgressLine
from rcac_experiments.tuning._tuning import Tuned, tune
from rcac_numeric.checks._logs import ControllerLog, read_log
from rcac_numeric.controllers._kinds import fir, fir_integrator, pid
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.designing._design import KEPT, Design
from rcac_numeric.designing._design import design as designed
from rcac_numeric.designing._plants import Uncertainty, read_plant
from rcac_numeric.reports._design import design_sheet
from rcac_numeric.signals._data_files import ARRAYS, read_variables
from rcac_numeric.signals._waveforms import Step

# Options that only the owner of the plant knows: the question and the default of --assume.
QUESTIONS = {
    "disturbance": ("Size of the disturbance, in units of u, or none", "unknown"),
    "noise": ("Standard deviation of the sensor noise, in units of y", "unknown"),
    "u_limits": ("Limits of u, as LOW,HIGH", "none"),
}


# Options of both commands: the plant, and the disturbances and limits that its owner knows.
PLANT = (
    click.argument("plant", metavar="FILE"),
    click.option(
        "-o", "--output", type=click.Path(dir_okay=False, path_type=Path),
        help="Write the experiment file here; rcac verify runs it.",
    ),
    click.option("--disturbance", help='Size in units of u, "unknown", or "none".'),
    click.option(
        "--noise", help='Standard deviation of the sensor noise, in units of y, or "unknown".'
    ),
    click.option("--command", "height", type=float, help="Height of a step command, in units of "
                                                         "y."),
    click.option("--u-limits", help='Actuator limits LOW,HIGH, or "none".'),
    click.option("--sample-time", type=float, help="In seconds; required for a plant in s."),
    click.option(
        "--dead-time", default="0", metavar="SECONDS",
        help='Dead time, in steps if there is no sample time; one per entry of rows: "1, 3; 7, 3".',
    ),
    click.option("--uncertain-gain", metavar="LOW,HIGH",
                 help="Range of the gain, relative to the nominal one.  [default: 0.8,1.25]"),
    click.option("--uncertain-delay", type=click.IntRange(min=0),
                 help="Largest error of the dead time, in steps.  [default: 1]"),
    click.option("--uncertain-time", type=float,
                 help="Largest factor between true and nominal time constants.  [default: 1.2]"),
    click.option("--structure", metavar="KIND",
                 help='"PI", "PID" or other PID terms; "fir:20"; "fir+i:20" (FIR with integrator). '
                 "Default: IIR, of the order that the plant requires."),
    click.option("--feedforward", is_flag=True,
                 help="Feed the command to the controller."),
    click.option("--kept", type=click.Choice(KEPT), default="box", show_default=True,
                 help="Keep the coefficients in a box, or in a set with a stability proof."),
    click.option("--assume", is_flag=True,
                 help="Assume defaults for missing options, without a question; the report names "
                      "them."),
)  # fmt: skip


def plant_options(command: Callable[..., int]) -> Callable[..., int]:
    """Add the options of a plant, its disturbances and limits to a command."""
    command = log_options(command)
    for option in reversed(PLANT):
        command = option(command)
    return command


@click.command("design")
@plant_options
@click.option("--seeds", type=click.IntRange(min=1), default=6, show_default=True,
              help="Number of test runs on each plant.")  # fmt: skip
@picture_option("Draw a nominal run and the rms on every plant into this file.")
@as_json_option
def design(
    *, seeds: int, output: Path | None, picture: Path | None, as_json: bool, **options: Any
) -> int:
    """Design a controller, adaptive or fixed, explain the choices, and test it on other plants.

    FILE is a .toml file with [plant] (its [signals] and [saturation] are read too), a .mat or .npz
    file with A, B and C, a transfer function such as "1/(10*s + 1)", the rows of several such as
    "1/(s + 1), 0; 0.2/(s + 1), 2/(s + 3)", or a log: a file (rcac log --help) with u and y of an
    open loop, or of a closed loop excited by a command r or a dither. A column of times in the log
    gives the sample time.
    A terminal is asked for missing options; without a terminal the command names them and stops,
    or assumes defaults with --assume. The status is 1 if u = 0 gives a smaller error than the
    controller, or a log does not determine its plant well enough.
    """
    known = _known(**options)
    result = designed(**known, seeds=seeds)
    sheet = with_log(design_sheet(result), known["plant"])
    show(sheet, as_json, picture, result.plot, lambda: _written(result, output))
    return _status(result)


@click.command("tune")
@plant_options
@click.option("--budget", type=click.IntRange(min=1, max=4096), default=40, show_default=True,
              help="Number of settings to simulate, in addition to those of rcac "
                   "design.")  # fmt: skip
@click.option("--held-out", type=click.IntRange(min=1), default=8, show_default=True,
              help="Number of test plants for the best settings.")  # fmt: skip
@click.option(
    "--seed", type=int, default=0, show_default=True, help="Seed of the settings and plants."
)
@click.option("--store", type=click.Path(file_okay=False, path_type=Path),
              help="Store every run in this folder; after an interruption the same command "
                   "continues.")  # fmt: skip
@click.option("--workers", type=click.IntRange(min=0),
              help="Number of processes, with --store; default: number of processors.")  # fmt: skip
@picture_option("Draw cost against robustness of all settings into this file.")
@as_json_option
def tune_command(
    *, budget: int, held_out: int, seed: int, store: Path | None, workers: int | None,
    output: Path | None, picture: Path | None, as_json: bool, **options: Any,
) -> int:  # fmt: skip
    """Design a controller as rcac design does, and tune its settings by simulation.

    The best settings are tested on plants and noise that were not used to choose them, together
    with the settings of rcac design and the fixed controller.
    """
    known = _known(**options)
    begun = designed(**known, seeds=1)
    line = ProgressLine() if sys.stderr.isatty() else None
    try:
        tuned = tune(begun, budget, held_out=held_out, seed=seed, store=store, workers=workers,
                     progress=line)  # fmt: skip
    finally:
        if line is not None:
            line.end()
    sheet = with_log(tuned_sheet(tuned), known["plant"])
    show(sheet, as_json, picture, tuned.plot, lambda: _written(tuned, output))
    return _status(tuned.design)


def _status(result: Design) -> int:
    """Return 1 if u = 0 is better than the controller."""
    return NO if result.verdict.is_worse_than_none else DONE


def _known(
    *, plant: str, disturbance: str | None, noise: str | None, height: float | None,
    u_limits: str | None, sample_time: float | None, dead_time: str, structure: str | None,
    feedforward: bool, kept: str, assume: bool, names: str, columns: str, time: str | None,
    resample: float | None, transpose: bool, **uncertain: Any,
) -> dict[str, Any]:  # fmt: skip
    """Return the arguments of `design`; ask for the missing ones."""
    known: dict[str, Any] = {"sample_time": sample_time, "feedforward": feedforward, "kept": kept}
    known["structure"] = None if structure is None else _structure(structure)
    known["uncertainty"] = _uncertainty(**uncertain)
    if is_transfer_function(plant):
        known["plant"] = written_system(plant)
    elif Path(plant).suffix.lower() == ".toml":
        read = design_arguments(plant)
        known |= {name: value for name, value in read.items() if value is not None}
    elif Path(plant).suffix.lower() in ARRAYS and set(read_variables(plant)) >= {"A", "B", "C"}:
        known["plant"] = read_case(plant, "standard")[0]
    else:
        known["plant"] = read_log(
            plant, parse_names(names), transpose=transpose, sample_time=sample_time,
            **log_arguments(columns, time, resample),
        )  # fmt: skip
    late = _dead_time(dead_time)
    if not isinstance(known["plant"], ControllerLog):  # errors come before the questions
        read_plant(known["plant"], known["sample_time"], late)
    options = {"disturbance": disturbance, "noise": noise, "u_limits": u_limits}
    missing = [name for name, value in options.items() if value is None and name not in known]
    if missing and not assume:
        if not at_a_terminal():
            names = ", ".join(f"--{name.replace('_', '-')}" for name in missing)
            raise InputError(
                f"{names} {'is' if len(missing) == 1 else 'are'} missing, and there is no "
                f"terminal to ask. Give {'it' if len(missing) == 1 else 'them'}, or --assume to "
                f"use {', '.join(f'{name} = {QUESTIONS[name][1]}' for name in missing)}."
            )
        for name in missing:
            words, default = QUESTIONS[name]
            options[name] = click.prompt(words, default=default)
    for name, value in options.items():
        if value is not None and value != QUESTIONS[name][1]:
            known[name] = _numbers(name, value)
    if height is not None:
        known["command"] = Step(height)
    return known | {"dead_time": late}


def _dead_time(text: str) -> float | list[list[float]]:
    """Return the dead time of the plant, or of each entry."""
    try:
        rows = [[float(one) for one in row] for row in written_rows(text)]
    except ValueError:
        raise InputError(
            f'--dead-time {text}: write seconds, or rows of them, "1, 3; 7, 3".'
        ) from None
    return rows if len(rows) > 1 or len(rows[0]) > 1 else rows[0][0]


def _structure(text: str) -> Structure:
    """Return the structure of a text: PID terms, fir:N or fir+i:N."""
    kind, _, order = text.strip().partition(":")
    if kind.lower() in ("fir", "fir+i") and order.isdecimal():
        return (fir if kind.lower() == "fir" else fir_integrator)(int(order))
    if order or not kind or set(kind.upper()) - set("PID"):
        raise InputError(f'--structure {text}: write "PI", "PID", "fir:20" or "fir+i:20".')
    return pid(kind.upper())


def _uncertainty(
    uncertain_gain: str | None, uncertain_delay: int | None, uncertain_time: float | None
) -> Uncertainty | None:
    """Return the uncertainty of the options, or None."""
    uncertainty: dict[str, Any] = {"delay": uncertain_delay, "time": uncertain_time}
    if uncertain_gain is not None:
        uncertainty["gain"] = _numbers("uncertain_gain", uncertain_gain)
    options = {name: value for name, value in uncertainty.items() if value is not None}
    return Uncertainty(**options) if options else None


def at_a_terminal() -> bool:
    """Return whether input and output are a terminal."""
    return sys.stdin.isatty() and sys.stderr.isatty()


def _numbers(name: str, text: str) -> float | tuple[float, ...]:
    """Return a number, or a pair separated by a comma."""
    option = f"--{name.replace('_', '-')}"
    if name == "disturbance" and text.strip() == "none":
        return 0.0
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) != (1 if name in ("disturbance", "noise") else 2):
        form = "a number" if name in ("disturbance", "noise") else "LOW,HIGH"
        instead = f", or {QUESTIONS[name][1]!r}" if name in QUESTIONS else ""
        instead += ', or "none"' * (name == "disturbance")
        raise InputError(f"{option} {text}: write {form}{instead}.")
    return values if len(values) > 1 else values[0]


def _written(result: Design | Tuned, output: Path | None) -> list[str]:
    if output is None:
        return []
    save_design(result.design if isinstance(result, Tuned) else result, output)
    return [f"Experiment file: {output} (rcac verify {output})"]
