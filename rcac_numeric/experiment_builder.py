"""From the tables of an experiment file to an experiment: plant, target models, runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.adaptation_rules import SignalWeight
from rcac_numeric.controller_settings import UPDATES, ControllerSettings
from rcac_numeric.experiment import Experiment, RunSpecification
from rcac_numeric.experiment_claims import claim
from rcac_numeric.experiment_files import Section, Table, merged, named, read_example, read_file
from rcac_numeric.experiment_signals import signals
from rcac_numeric.experiment_targets import target_of
from rcac_numeric.plants import MATRICES, Plant, from_problem, servo_plant, standard_plant
from rcac_numeric.structure_kinds import fir, iir
from rcac_numeric.structures import Structure
from rcac_numeric.validation import integer, number, one_of

# What a run may keep in memory before it is refused.
MAX_BYTES = 8 * 2**30


def load_example(number: str) -> Experiment:
    """A numbered example of the dissertation.

    Examples
    --------
    >>> from rcac_numeric import load_example
    >>> load_example("4.7").main_run.settings.k_w
    50
    """
    return build(*read_example(number))


def load_experiment(path: str | Path) -> Experiment:
    """A user's own case from its TOML file; docs/experiment-files.md describes the format.

    Raises
    ------
    InputError
        Where the file cannot be read, a key is unknown or missing, or a value is out of range;
        other errors of the tree where the plant or the target model does not allow the case.

    Examples
    --------
    >>> from rcac_numeric import load_experiment, verify
    >>> verify(load_experiment("examples/boost_converter.toml")).exit_status
    0
    """
    return build(*read_file(path))


def build(table: Table, file: str) -> Experiment:
    """The experiment that a parsed file describes; `file` is named in errors."""
    try:
        return _experiment(table, file)
    except CompensatorError as error:
        raise named(error, file) from None


def _experiment(table: Table, file: str) -> Experiment:
    top = Section(table, "", file)
    plant = _plant(Section(top.require("plant"), "plant", file))
    overrides = [Section(t, "runs", file) for t in top.tables("runs") or [{"name": "main"}]]
    runs = {}
    for override in overrides:
        name = override.text("name")
        if name in runs:
            raise InputError(f"two runs are named {name!r}; give each its own name.")
        runs[name] = _run(name, merged(table, override.table), plant, file)
    return Experiment(
        id=top.text("id", Path(file).stem),
        title=top.text("title", ""),
        source=top.text("source", ""),
        notes=top.text("notes", "").strip(),
        runs=runs,
        claims=[claim(Section(t, "claims", file), next(iter(runs))) for t in top.tables("claims")],
        description=_description(table),
    )


def _plant(section: Section) -> Plant:
    problem = one_of(section.text("problem"), "problem", ("standard", "servo"))
    if problem == "servo":
        one_of(section.text("performance", "measured"), "performance", ("measured", "true"))
    performance = ("performance",) if problem == "servo" else ()
    if "G" in section.table:
        section.only(f'problem = "{problem}" with G', "problem", "G", *performance)
        _require_coprime(section.table["G"])
        make = servo_plant if problem == "servo" else standard_plant
        return make(**section.given("G", *performance))
    allowed = ("A", "B", "D_1", "C", "D_0") if problem == "servo" else MATRICES
    section.only(f'problem = "{problem}"', "problem", *allowed, *performance)
    for key in ("A", "B", "C") if problem == "servo" else ("A", "B", "D_1", "C"):
        section.require(key)
    matrices = section.given(*allowed)
    if problem == "servo":
        return servo_plant(**matrices, **section.given(*performance))
    from compensator_theory import StandardProblem

    left_out = {"D_0": None, "D_2": None, "E_1": matrices["C"], "E_2": None, "E_0": None}
    return from_problem(StandardProblem(**{**left_out, **matrices}))


def _require_coprime(G: Any) -> None:
    from compensator_theory import NotCoprimeError, transfer_function

    plant = transfer_function(G)
    if plant.is_coprime is False:
        factor = plant.common_factor().as_expr()
        raise NotCoprimeError(
            f"numerator and denominator of the plant G share the factor {factor}: no controller "
            "moves that pole. Cancel the factor, or give the matrices A, B, D_1 and C if the "
            "hidden mode is meant."
        )


def _run(name: str, table: Table, plant: Plant, file: str) -> RunSpecification:
    run = Section(table.get("run", {}), "run", file)
    settings = Section(table.get("controller", {}), "controller", file)
    structure = _structure(settings, plant)
    target = target_of(Section(table.get("target", {}), "target", file), plant)
    arithmetic = one_of(run.text("arithmetic", "ud"), "arithmetic", (*UPDATES, "reference"))
    options = settings.given("R_z", "k_w", "k_update", "k_filter", "theta_0")
    if "lambda" in settings.table:
        options["lambda_"] = settings.table["lambda"]
    specification = RunSpecification(
        name=name,
        plant=plant,
        settings=ControllerSettings(
            structure=structure,
            target=target,
            R_theta=settings.require("R_theta"),
            R_u=_control_weight(settings.get("R_u", 0.0)),
            update=arithmetic if arithmetic in UPDATES else "ud",
            **options,
        ),
        signals=signals(Section(table.get("signals", {}), "signals", file), plant),
        steps=integer(run.require("steps"), "steps", at_least=1),
        seed=integer(run.get("seed", 0), "seed"),
        stride=integer(run.get("stride", 1), "stride", at_least=1),
        arithmetic=arithmetic,
        repetitions=integer(run.get("repetitions", 1), "repetitions", at_least=1),
        perturbation=number(run.get("perturbation", 0.0), "perturbation"),
    )
    _require_sense(specification)
    return specification


def _require_sense(run: RunSpecification) -> None:
    """Refuse a run that could not adapt or would not fit into memory."""
    for name in ("k_w", "k_update"):
        if (start := getattr(run.settings, name)) >= run.steps:
            raise InputError(
                f"{name} = {start} is not before the end of the run of {run.steps} steps, so "
                "nothing would be adapted. Use more steps."
            )
    for signal in run.signals:
        signal.require_length(run.steps)
    plant, kept = run.plant, run.settings.structure.l_theta / run.stride
    size = 8 * run.steps * (2 * plant.l_w + plant.l_u + plant.l_y + plant.l_z + kept)
    if size > MAX_BYTES:
        raise InputError(
            f"the run of {run.steps} steps would keep {size / 2**30:.3g} GiB; at most "
            f"{MAX_BYTES / 2**30:.0f} are allowed. Use fewer steps or a larger stride."
        )


def _structure(section: Section, plant: Plant) -> Structure:
    kinds = {"iir": iir, "fir": fir}
    kind = one_of(section.text("structure", "iir"), "structure", tuple(kinds))
    order = section.require("n_c")
    return kinds[kind](order, plant.l_u, plant.l_y, **section.given("k_c"))


def _control_weight(value: Any) -> Any:
    """R_u: a number, a matrix, or {z_squared = c} for R_u(k) = c z(k)'z(k) I."""
    if not isinstance(value, dict):
        return value
    if set(value) != {"z_squared"}:
        raise InputError(f"R_u = {value} is not known; use a number, a matrix or z_squared = c.")
    return SignalWeight(z_squared=number(value["z_squared"], "R_u.z_squared"))


def _description(table: Table) -> dict[str, str]:
    """The file's own words for plant, signals, target and controller, for the report."""
    return {
        name: ", ".join(f"{key} = {value}" for key, value in table.get(name, {}).items())
        for name in ("plant", "signals", "target", "controller", "run")
    }
