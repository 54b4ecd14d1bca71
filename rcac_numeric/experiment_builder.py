"""From the tables of an experiment file to plants, signals, controllers and claims."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.controller import UPDATES, ControllerSettings
from rcac_numeric.experiment import Check, Claim, Experiment, RunSpecification
from rcac_numeric.experiment_files import Section, Table, merged, named, read_example, read_file
from rcac_numeric.plants import MATRICES, Plant, servo_plant, standard_plant
from rcac_numeric.signals import Signal, exogenous, harmonic, sequence, step, white_noise
from rcac_numeric.structures import Structure, fir, iir
from rcac_numeric.target_models import (
    ModellingInformation,
    TargetModel,
    fir_target,
    modelling_information,
    pole_placement_target,
    target_model,
)
from rcac_numeric.validation import Array, integer, number, one_of
from rcac_numeric.verdicts import VERDICTS

CHECK_KEYS = ("measure", "run", "relative_to", "statistic", "at_least", "at_most")


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
    overrides = [Section(t, "runs", file) for t in top.get("runs", [{"name": "main"}])]
    runs = {}
    for override in overrides:
        name = str(override.require("name"))
        if name in runs:
            raise InputError(f"two runs are named {name!r}; give each its own name.")
        runs[name] = _run(name, merged(table, override.table), plant, file)
    claims = [_claim(Section(t, "claims", file), next(iter(runs))) for t in top.get("claims", [])]
    return Experiment(
        id=str(top.get("id", Path(file).stem)),
        title=str(top.get("title", "")),
        source=str(top.get("source", "")),
        notes=str(top.get("notes", "")).strip(),
        runs=runs,
        claims=claims,
        description=_description(table),
    )


def _plant(section: Section) -> Plant:
    problem = one_of(str(section.require("problem")), "problem", ("standard", "servo"))
    if "G" in section.table:
        _require_coprime(section.table["G"])
    if problem == "servo":
        section.given("G") or [section.require(key) for key in ("A", "B", "C", "D_1")]
        return servo_plant(**section.given("G", "performance", "A", "B", "C", "D_0", "D_1"))
    if "G" in section.table:
        return standard_plant(section.table["G"])
    for key in ("A", "B", "D_1", "C"):
        section.require(key)
    return Plant(**section.given(*MATRICES))


def _require_coprime(G: Any) -> None:
    from compensator_theory import NotCoprimeError, transfer_function  # noqa: PLC0415

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
    target = _target(Section(table.get("target", {}), "target", file), plant)
    arithmetic = one_of(str(run.get("arithmetic", "ud")), "arithmetic", (*UPDATES, "reference"))
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
        signals=_signals(Section(table.get("signals", {}), "signals", file), plant),
        steps=integer(run.require("steps"), "steps", at_least=1),
        seed=integer(run.get("seed", 0), "seed"),
        stride=integer(run.get("stride", 1), "stride", at_least=1),
        arithmetic=arithmetic,
        repetitions=integer(run.get("repetitions", 1), "repetitions", at_least=1),
        perturbation=number(run.get("perturbation", 0.0), "perturbation"),
    )
    exogenous(specification.signals, 1)  # a signal that cannot be sampled is refused here
    return specification


def _structure(section: Section, plant: Plant) -> Structure:
    kinds = {"iir": iir, "fir": fir}
    kind = one_of(str(section.get("structure", "iir")), "structure", tuple(kinds))
    order = section.require("n_c")
    return kinds[kind](order, plant.l_u, plant.l_y, **section.given("k_c"))


def _target(section: Section, plant: Plant) -> TargetModel:
    """The target model; what the file does not say of G_zu is taken from the plant."""
    model = one_of(str(section.require("model")), "model", ("fir", "pole placement", "filter"))
    if model == "filter" and "numerator" in section.table:
        return TargetModel(**section.given("numerator", "denominator"))
    if model == "filter":
        target = target_model(section.require("G_f"))
        if target.relative_degree != (wanted := modelling_information(plant).d_zu):
            raise InputError(
                f"the target model G_f has relative degree {target.relative_degree}, the plant's "
                f"G_zu has {wanted}; the intercalated transfer function always has that of G_zu "
                "(4.18). Multiply G_f by a power of q."
            )
        return target
    given = section.given("d_zu", "H", "nmp_zeros")
    known = (
        ModellingInformation(**given)
        if {"d_zu", "H"} <= given.keys()
        else ModellingInformation(**{**vars(modelling_information(plant)), **given})
    )
    if model == "fir":
        return fir_target(known)
    return pole_placement_target(known, section.require("poles"))


def _control_weight(value: Any) -> Any:
    """R_u: a number, a matrix, or {z_squared = c} for R_u(k) = c z(k)'z(k) I."""
    if not isinstance(value, dict):
        return value
    if set(value) != {"z_squared"}:
        raise InputError(f"R_u = {value} is not known; use a number, a matrix or z_squared = c.")
    factor = number(value["z_squared"], "R_u.z_squared")
    if factor < 0:
        raise InputError(f"R_u.z_squared = {factor} must not be negative.")

    def weight(z: Array) -> Array:
        return np.asarray(factor * (z @ z) * np.eye(z.size))

    return weight


def _signals(section: Section, plant: Plant) -> tuple[Signal, ...]:
    """One signal for each channel of w; a block that the file does not name is zero."""
    for key in section.table:
        if key not in plant.blocks:
            raise InputError(
                f"[signals] sets {key!r}; this plant's exogenous input has "
                f"{', '.join(plant.blocks)}."
            )
    channels: list[Signal] = []
    for name, width in plant.blocks.items():
        value = section.get(name, 0.0)
        parts = value if isinstance(value, list) else [value]
        if len(parts) == 1 and not isinstance(value, list):
            parts = parts * width if value == 0.0 else parts
        if len(parts) != width:
            raise InputError(f"[signals] {name} has {len(parts)} components; {width} are needed.")
        channels += [_signal(part, name) for part in parts]
    return tuple(channels)


def _signal(value: Any, name: str) -> Signal:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return step(value)
    kinds: dict[str, Any] = {
        "step": step,
        "harmonic": harmonic,
        "white_noise": white_noise,
        "sequence": sequence,
    }
    if isinstance(value, dict):
        if set(value) == {"sum"}:
            parts = [_signal(part, name) for part in value["sum"]]
            return sum(parts[1:], parts[0])
        for kind, make in kinds.items():
            if kind in value:
                first = {"step": "height", "harmonic": "omega", "white_noise": "std"}
                rest = {key: v for key, v in value.items() if key != kind}
                try:
                    signal: Signal = make(**{first.get(kind, "values"): _real(value[kind]), **rest})
                    return signal
                except TypeError as error:
                    raise InputError(f"[signals] {name}: {error}.") from None
    raise InputError(
        f"[signals] {name} = {value!r} is not a signal; use a number, or a table with one of "
        f"{', '.join(kinds)} or sum."
    )


def _real(value: Any) -> Any:
    """A number; a string such as "pi/8" is evaluated exactly and rounded once."""
    if not isinstance(value, str):
        return value
    from compensator_theory import parse_expression  # noqa: PLC0415

    expression = parse_expression(value)
    if not expression.is_real:
        raise InputError(f"{value!r} is not a real number.")
    return float(expression)


def _claim(section: Section, main_run: str) -> Claim:
    recorded = str(section.get("verdict", ""))
    if recorded:
        one_of(recorded, "verdict", VERDICTS)
    checks = section.require("checks")
    if not isinstance(checks, list) or not checks:
        raise InputError("a claim needs a list of at least one check.")
    return Claim(
        text=str(section.require("text")),
        claimed=str(section.get("claimed", "")),
        checks=tuple(_check(entry, main_run) for entry in checks),
        correction=str(section.get("correction", "")),
        recorded=recorded,
    )


def _check(entry: Any, main_run: str) -> Check:
    if not isinstance(entry, dict) or "measure" not in entry:
        raise InputError(f"the check {entry!r} of a claim must be a table with the key 'measure'.")
    if not {"at_least", "at_most"} & entry.keys():
        raise InputError(
            f"the check of {entry['measure']!r} needs at_least, at_most or both: a check without "
            "a bound cannot fail."
        )
    own = {key: value for key, value in entry.items() if key in CHECK_KEYS}
    one_of(str(own.get("statistic", "each")), "statistic", ("each", "median"))
    arguments = {
        key: _real(value) if key == "omega" else value
        for key, value in entry.items()
        if key not in CHECK_KEYS
    }
    return Check(**{"run": main_run, **own}, arguments=arguments)


def _description(table: Table) -> dict[str, str]:
    """The file's own words for plant, signals, target and controller, for the report."""
    return {
        name: ", ".join(f"{key} = {value}" for key, value in table.get(name, {}).items())
        for name in ("plant", "signals", "target", "controller", "run")
    }
