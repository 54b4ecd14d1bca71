"""The command `rcac check`: analyse the final controller of a log."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.cli._exits import DONE, MISSED, NO, UNDECIDED, UNSTABLE
from rcac_experiments.cli._output import (
    as_json_option,
    budget_option,
    log_arguments,
    log_options,
    picture_option,
    show,
)
from rcac_experiments.files._case_files import k_w_of, plant_and_tables, read_structure, read_target
from rcac_experiments.files._documents import Raw, named
from rcac_numeric.arrays._record_files import is_record
from rcac_numeric.arrays._values import replaced
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.checks._check import ControllerCheck, check_controller
from rcac_numeric.checks._convention_search import is_same
from rcac_numeric.checks._conventions import convention_of
from rcac_numeric.checks._hypotheses import Decision, decide_problem
from rcac_numeric.checks._logs import ControllerLog, read_log
from rcac_numeric.controllers._compensator import compensator_of
from rcac_numeric.engine._runs import Run, load_run
from rcac_numeric.plants._foreign import linear_plant, plant_of
from rcac_numeric.plants._linear import MATRICES, Plant
from rcac_numeric.plants._problems import servo_plant, standard_plant
from rcac_numeric.reports._check import check_sheet
from rcac_numeric.signals._clock import TIMES
from rcac_numeric.signals._data_files import ARRAYS, READ, read_variables
from rcac_numeric.signals._log_signals import ROLES
from rcac_numeric.signals._text_tables import as_number
from rcac_numeric.targets._filters import target_model

KINDS = ("iir", "fir", "quasi-fir", "pid", "fir + integrator")


@click.command("check")
@click.argument("log", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--plant",
    help="A .toml file with [plant] (its [controller] and [target] are read too), a .mat or .npz "
    'file with A, B, C, ..., or a transfer function such as "1/(q - 2)". Default: A, B, C of LOG.',
)
@click.option(
    "--problem", type=click.Choice(["standard", "servo"], case_sensitive=False),
    help="Convention of a transfer function or of A, B, C: y = z = G (u + w), or with a command "
    "the error y = z = r - G (u + d) - v. Default: identified from the log.",
)  # fmt: skip
@log_options
@click.option(
    "--structure",
    type=click.Choice(KINDS, case_sensitive=False),
    help="Structure of the coefficients theta; default with --n-c: iir.",
)
@click.option(
    "--controller",
    help='Transfer function of a fixed controller, u = G_c y: "-(0.5*q - 0.4)/(q - 1)".',
)
@click.option("--n-c", type=int, help="Order of the controller.")
@click.option(
    "--k-c", type=int, help="First lag of y: 1 by default, 0 for an exactly proper controller."
)
@click.option("--k-w", type=int, help="First step at which theta determines u.")
@click.option("--target", help='Target model G_f, for instance "1/q".')
@click.option(
    "--noise", default="", help="Variances for the H2 cost: d=1,v=0.25. Default: 1 for all of w."
)
@click.option("--sample-time", type=float, help="In seconds, for the delay margin.")
@click.option(
    "--tolerance", type=float,
    help="Largest relative difference between u and Phi theta. Default: the rounding of the "
    "digits of LOG.",
)  # fmt: skip
@click.option(
    "--convention",
    help='How the program of LOG differs from u = Phi theta, joined by commas: "-y, y first". '
    "Default: as here; the check names the one that replays.",
)
@click.option("--u-limits", help="Actuator limits LOW,HIGH, if u is limited.")
@picture_option("Draw signals, coefficients, poles, match and Nyquist curve into this file.")
@budget_option()
@as_json_option
def check(
    *,
    log: Path,
    plant: str | None,
    problem: str | None,
    names: str,
    columns: str,
    time: str | None,
    resample: float | None,
    transpose: bool,
    structure: str | None,
    controller: str | None,
    n_c: int | None,
    k_c: int | None,
    k_w: int | None,
    target: str | None,
    noise: str,
    sample_time: float | None,
    tolerance: float | None,
    convention: str | None,
    u_limits: str | None,
    picture: Path | None,
    as_json: bool,
) -> int:
    """Check the final controller of a LOG (.csv, .mat, .npz and others: rcac log --help).

    A LOG written by `rcac verify CASE --save RUN.npz` or Run.save contains its plant, structure,
    target model and k_w. Any other LOG needs u and y, optionally z, w and r, with one row per step;
    and theta (over time, or its final row), or the polynomials D_c and N_c. The status is 1 if the
    logged u is not the output of the logged theta or compensator, or if the log contradicts the
    plant: the error of y is larger than that of a fitted model, and no disturbance that was not
    logged explains it; 7 if the log does not decide the --problem of a transfer function; 5 for an
    unstable loop; 6 for a loop that misses the poles of its target model. The report names a theta
    that still changes; this is no error. If u is not the output of theta, it names the --convention
    of another program by which u is.
    """
    with np.errstate(all="ignore"):  # an overflow is reported, without a warning of NumPy
        model, table = read_case(plant, problem, sample_time)
        described = names or structure is not None or controller is not None
        structure_of_log = _saved_run(log) if plant is None and not described else None
        if structure_of_log is not None:
            if problem is not None:
                raise InputError(
                    f"{log} is a saved run, which contains its plant; remove --problem."
                )
            result = check_controller(
                structure_of_log, target=None if target is None else target_model(target),
                noise=parse_noise(noise), k_w=k_w, sample_time=sample_time, tolerance=tolerance,
            )  # fmt: skip
            result = replace(result, log=replaced(result.log, source=str(log)))
            show(check_sheet(result), as_json, picture, result.plot)
            return _status(result)
        if controller is not None and (structure is not None or n_c is not None):
            raise InputError(
                "--controller is the complete controller; remove --structure and --n-c."
            )
        recorded = read_log(
            log, parse_names(names), transpose=transpose, sample_time=sample_time,
            **log_arguments(columns, time, resample),
        ).longest_part()  # fmt: skip
        limits = parse_limits(u_limits)
        holds_arrays = plant is None and log.suffix.lower() in ARRAYS
        inside = read_variables(log) if holds_arrays else None
        if inside is not None and plant_in(inside, str(log)) is None:
            inside = None
        if inside is not None:
            model = _of_matrices(inside, str(log), problem)
        elif plant is None and problem is not None:
            raise InputError("--problem is the convention of a plant; give --plant too.")
        decision: Decision | str | None = None
        if problem is None and (plants := _plants(plant, inside, str(log), sample_time)):
            converted = recorded.reading(convention_of(convention))
            if limits is not None:
                converted = replaced(converted, u=np.clip(converted.u, *limits))
            decision, model = _decided(converted, plants)
        if k_w is None:
            k_w = k_w_of(table) if controller is None else 0
        widths = (recorded.u.shape[1], recorded.y.shape[1])
        structure_of_case = read_structure(
            table, model, kind=structure, n_c=n_c, k_c=k_c, widths=widths
        )
        if controller is None:
            _require_coefficients(recorded, log, parse_names(names))
            if structure_of_case is None:
                _require_structure(recorded, widths)
        result = check_controller(
            recorded,
            structure=structure_of_case,
            compensator=None if controller is None else compensator_of(controller, "controller"),
            plant=model,
            target=read_target(table, model, target),
            noise=parse_noise(noise),
            k_w=k_w,
            sample_time=sample_time,
            tolerance=tolerance,
            convention=convention,
            u_limits=limits,
        )
        result = replace(result, decision=decision)
        show(check_sheet(result), as_json, picture, result.plot)
    return _status(result)


def _status(result: ControllerCheck) -> int:
    """Return the exit status for the check of a log."""
    residual = result.plant_residual
    if not result.is_consistent or (residual is not None and residual.is_contradicted):
        return NO
    if result.is_undecided:
        return UNDECIDED
    if result.loop is not None and not result.loop.is_stable:
        return UNSTABLE
    if result.comparison is None or result.comparison.is_reached:
        return DONE
    return MISSED


def _plants(
    plant: str | None, inside: Mapping[str, Any] | None, log: str, sample_time: float | None
) -> dict[str, Plant]:
    """Return the plants of both problems, for a plant that does not say its problem."""
    known: dict[str, Plant | None] = {}
    for name in ("standard", "servo"):
        if inside is not None:
            known[name] = None if _is_complete(inside) else _of_matrices(inside, log, name)
        elif plant is not None and Path(plant).suffix.lower() in READ:
            variables = read_variables(plant)
            known[name] = None if _is_complete(variables) else _of_matrices(variables, plant, name)
        elif is_transfer_function(plant):
            known[name] = read_case(plant, name, sample_time)[0]
    return {name: one for name, one in known.items() if one is not None}


def _decided(log: ControllerLog, plants: dict[str, Plant]) -> tuple[Decision | str, Plant]:
    """Return the problem of the log and its plant; the standard one if the log is undecided."""
    if log.r is None and log.z is not None and is_same(log.z, -log.y):
        # z is no error of a command: the controller reads -z.
        plants = {"standard": plants["standard"], "negated": _negated(plants["standard"])}
    decision: Decision | str
    try:
        decision = decide_problem(log, plants)
    except CompensatorError as error:
        decision = f"UNDECIDED: standard or servo problem: {error}"
    if isinstance(decision, str) or decision.decided is None:
        _require_problem(log)
        return decision, plants["standard"]
    return decision, plants[decision.decided.problem]


def _negated(plant: Plant) -> Plant:
    """Return the plant with the output y = -z."""
    return replaced(plant, C=-plant.C, D_0=-plant.D_0, D_2=-plant.D_2)


def _saved_run(log: Path) -> Run | None:
    """Return the run in a file; None for another file, or for a run with Python functions."""
    if log.suffix.lower() != ".npz" or not is_record(log):
        return None
    try:
        return load_run(log)
    except InputError as error:
        # A command cannot pass the Python functions that such a run needs.
        if any(advice.function == "load_run" for advice in error.advice):
            return None
        raise


def _require_structure(log: ControllerLog, widths: tuple[int, int]) -> None:
    if log.theta is None or log.D_c is not None:
        return
    size = log.theta.shape[-1]
    raise InputError(
        f"{log.source}: theta has {size} coefficient{'s' * (size != 1)}; give their structure: "
        f"{_structures(size, *widths)}."
    )


def _require_problem(log: ControllerLog) -> None:
    """Refuse to guess the problem of a log with a command."""
    if log.r is not None:
        raise InputError(
            f"{log.source} has a command r; give the convention of --plant: --problem servo for "
            "the "
            "error y = r - G (u + d) - v, or --problem standard for y = G (u + w)."
        )


def _require_coefficients(log: ControllerLog, file: Path, names: dict[str, str]) -> None:
    """Refuse a log without theta and polynomials; propose an unused column."""
    if log.theta is not None or (log.D_c is not None and log.N_c is not None):
        return
    known = {*ROLES, *names.values()}
    columns = [v for v in read_variables(file) if v not in known and v.lower() not in TIMES]
    proposal = (
        f"name its column and its structure, --names theta={shortened(columns[0], 40)} "
        "with --structure and --n-c"
        if columns
        else "log it, one column theta[i] for each coefficient"
    )
    raise InputError(
        f"{log.source} has no theta, the coefficients of the controller: {proposal}; or log D_c "
        "and N_c, over time or final, in a .mat or .npz file. For a fixed controller give its "
        "transfer function with --controller."
    )


def _structures(size: int, l_u: int, l_y: int) -> str:
    """Return the options of structures with this number of coefficients."""
    fits = []
    if size % (l_u * (l_u + l_y)) == 0:
        fits.append(f"--structure iir --n-c {size // (l_u * (l_u + l_y))}")
    if size % (l_u * l_y) == 0:
        fits.append(f"--structure fir --n-c {size // (l_u * l_y)}")
    if size == 3 * l_u * l_y:
        fits.append("--structure pid")
    return " or ".join(fits) or "write any other structure as [controller] in the file of --plant"


# Plant, names and intensities of a check from command-line options.

Names = dict[str, str]
ENTRIES = re.compile(r",(?=\s*(?:\w+\s*=|$))")  # the commas before NAME= and at the end


def parse_names(text: str, option: str = "names", example: str = "u=input,y=output") -> Names:
    """Return the option --names u=input,y=output as a mapping.

    A comma that no NAME= follows is part of the name before it.

    Examples
    --------
    >>> from rcac_experiments.cli._check import parse_names
    >>> parse_names("u=input, y=output")
    {'u': 'input', 'y': 'output'}
    >>> parse_names("u=Valve, zone 1, y=TIC203.PV, degC")
    {'u': 'Valve, zone 1', 'y': 'TIC203.PV, degC'}
    """
    names: dict[str, str] = {}
    for part in filter(None, (part.strip(", ") for part in ENTRIES.split(text))):
        role, equals, name = (piece.strip() for piece in part.partition("="))
        if not (role and equals and name):
            raise InputError(
                f"--{option}: the entry {part!r} must be NAME=VALUE, for instance {example}."
            )
        if role in names:
            raise InputError(f"--{option} gives {role} twice: {names[role]!r} and {name!r}.")
        names[role] = name
    return names


def parse_noise(text: str) -> dict[str, float] | None:
    """Return the option --noise d=1,v=0.25 as intensities of blocks or channels of w.

    Examples
    --------
    >>> from rcac_experiments.cli._check import parse_noise
    >>> parse_noise("d=1, v=0.25")
    {'d': 1.0, 'v': 0.25}
    """
    noise: dict[str, float] = {}
    for name, intensity in parse_names(text, "noise", "d=1,v=0.25").items():
        value = as_number(intensity)
        if value is None:
            raise InputError(
                f"--noise {name}={intensity}: {intensity!r} must be a number, for instance "
                "d=1,v=0.25."
            )
        noise[name] = value
    return noise or None


def parse_limits(text: str | None) -> tuple[float, float] | None:
    """Return the option --u-limits LOW,HIGH.

    Examples
    --------
    >>> from rcac_experiments.cli._check import parse_limits
    >>> parse_limits("-0.2, inf")
    (-0.2, inf)
    """
    if text is None:
        return None
    numbers = [as_number(part.strip()) for part in text.split(",")]
    if len(numbers) != 2 or numbers[0] is None or numbers[1] is None:
        raise InputError(f"--u-limits {text!r} must be LOW,HIGH, for instance -0.2,0.2.")
    return numbers[0], numbers[1]


def read_case(
    plant: str | None, problem: str | None, sample_time: float | None = None
) -> tuple[Plant | None, Raw]:
    """Return the plant of --plant by a problem, and the tables of its experiment file, if any.

    Raises
    ------
    InputError
        Where the plant says its problem, and it is another one.
    """
    if plant is None:
        return None, {}
    suffix = Path(plant).suffix.lower()
    if suffix == ".toml":
        model, table = plant_and_tables(plant)
        stated = table.get("plant", {}).get("problem")
        if problem is not None and problem != stated:
            raise InputError(
                f"--problem {problem}: {plant} states its plant, problem = {stated!r}; change "
                "it there."
            )
        return model, table
    if suffix in READ:
        return _of_matrices(read_variables(plant), plant, problem), {}
    G: Any = _sampled(written_system(plant), sample_time)
    if problem == "servo":
        return servo_plant(G), {}
    return standard_plant(G) if isinstance(G, str) else linear_plant(G), {}


def _of_matrices(variables: Mapping[str, Any], file: str, problem: str | None) -> Plant:
    """Return the plant of a file's matrices by a problem."""
    plant = plant_in(variables, file)
    if plant is None:
        raise InputError(
            f"{file} has no plant: it needs A, B and C, and contains "
            f"{shortened(', '.join(variables))}."
        )
    if problem is not None and (complete := _is_complete(variables)):
        raise InputError(
            f"--problem {problem}: {file} contains {', '.join(complete)} beside A, B, C, and so "
            "states w and z itself; remove --problem, or these matrices."
        )
    return servo_plant(plant) if problem == "servo" else plant


def _is_complete(variables: Mapping[str, Any]) -> list[str]:
    """The matrices of w and z in a file: with them it states its problem itself."""
    return [name for name in ("D_1", "D_2", "E_1", "E_2", "E_0") if name in variables]


def _sampled(G: str | list[list[str]], sample_time: float | None) -> Any:
    """Return a transfer function in s by a zero-order hold, as `rcac design` reads it."""
    entries = [G] if isinstance(G, str) else [entry for row in G for entry in row]
    if not any(re.search(r"(?<![A-Za-z_])s(?![A-Za-z_(])", entry) for entry in entries):
        return G
    if sample_time is None:
        raise InputError(
            "--plant is in s, and RCAC runs in discrete time; give --sample-time, in seconds, to "
            "sample it with a zero-order hold."
        )
    return plant_of(G, sample_time=sample_time)


def written_system(text: str) -> str | list[list[str]]:
    """Return a transfer function as text, or the rows of a matrix of them.

    Examples
    --------
    >>> from rcac_experiments.cli._check import written_system
    >>> written_system("1/q"), written_system("1/q, 0; 0, 2/q")
    ('1/q', [['1/q', '0'], ['0', '2/q']])
    """
    return written_rows(text) if set(text) & set(",;[") else text


def written_rows(text: str) -> list[list[str]]:
    """Split entries at commas, and rows at semicolons or brackets."""
    inside = text.strip()
    if inside.startswith("["):
        inside = inside[1:-1] if inside.replace(" ", "").startswith("[[") else inside
        inside = inside.replace("],", ";").replace("[", "").replace("]", "")
    return [[one.strip() for one in row.split(",")] for row in inside.split(";")]


def is_transfer_function(plant: str | None) -> bool:
    """Return whether --plant is a transfer function, and neither missing nor a file.

    Examples
    --------
    >>> from rcac_experiments.cli._check import is_transfer_function
    >>> is_transfer_function("1/(q - 0.5)"), is_transfer_function("plant.toml")
    (True, False)
    """
    return plant is not None and Path(plant).suffix.lower() not in (".toml", *READ)


def plant_in(variables: Mapping[str, Any], file: str) -> Plant | None:
    """Return the plant of a file's matrices; D_1 = B by default."""
    if not {"A", "B", "C"} <= variables.keys():
        return None
    matrices = {name: variables[name] for name in MATRICES if name in variables}
    try:
        return Plant(**{"D_1": variables["B"], **matrices})
    except CompensatorError as error:
        raise named(error, file) from None
