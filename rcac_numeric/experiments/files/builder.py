"""From the tables of an experiment file to an experiment: plant, target models, runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.experiments.budgets import Budget
from rcac_numeric.experiments.estimation_files.reading import estimation_experiment, is_estimation
from rcac_numeric.experiments.exact_files.reading import exact_experiment, is_exact
from rcac_numeric.experiments.experiment import Experiment, RunSpecification
from rcac_numeric.experiments.figure_requests import FIGURE, require_drawable
from rcac_numeric.experiments.files.claims import CLAIM, STANDARD_CLAIMS
from rcac_numeric.experiments.files.documents import named, read_file, require_plain
from rcac_numeric.experiments.files.runs import (
    FORMS,
    OVERRIDE,
    TABLES,
    RunTables,
    read_run,
    words_of,
)
from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.places import Place, brief
from rcac_numeric.experiments.format.tables import Raw, Table
from rcac_numeric.experiments.judging.reading import (
    OpenItems,
    check_of,
    claims_of,
    completed_runs,
    completion_name,
    opens,
)
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.schedules import PlantSchedule

# How much of a table's own words a report repeats.
LONGEST_WORDS = 400


def _file(
    plant: Any, title: str = "", id: str = "", source: str = "", notes: str = "",
    signals: Any = None, target: Any = None, controller: Any = None, controllers: Any = None,
    saturation: Any = None, run: Any = None, runs: Any = None, claims: Any = None,
    figures: Any = None, open: Any = None,
) -> str:  # fmt: skip
    """An experiment.

    Parameters
    ----------
    plant : table
        What is controlled.
    title : str
        What it is about, in a line.
    id, source : str
        Its number, the name of the file where it is left out; and where it comes from.
    notes : str
        What a reader of the report should know.
    signals : table
        The exogenous input w.
    target : table
        The target model G_f.
    controller : table
        The controller.
    controllers : tables
        Several controllers whose outputs are added.
    saturation : table
        Bounds of the control.
    run : table
        How long it runs, and how.
    runs : tables
        Several runs, the first being the main one.
    claims : tables
        What is said of it, and what decides whether it holds.
    figures : tables
        What is drawn of it; a sheet on the main run where they are left out.
    open : tables
        What its source leaves open, and what was chosen.
    """
    return title


def _value(
    name: str, plant: Any = None, signals: Any = None, target: Any = None, controller: Any = None,
    controllers: Any = None, saturation: Any = None, run: Any = None,
) -> str:  # fmt: skip
    """One of the values that a reader would try.

    Parameters
    ----------
    name : str
        What it is called.
    plant, signals, target, controller, saturation, run : tables
        What it changes.
    controllers : tables
        In place of [[controllers]].
    """
    return name


VALUE = Table(_value, forms=FORMS)
FILE = Table(
    _file,
    forms={
        **FORMS,
        "runs": ListOf(OVERRIDE, needed="an array of tables, [[runs]]"),
        "claims": ListOf(CLAIM, needed="an array of tables, [[claims]]"),
        "figures": ListOf(FIGURE, needed="an array of tables, [[figures]]"),
        "open": opens(VALUE),
    },
)


def load_experiment(path: str | Path, budget: Budget | None = None) -> Experiment:
    """A user's own case from its TOML file; docs/experiment-files.md describes the format.

    Parameters
    ----------
    path : path
        Of a file of at most 10 MiB.
    budget : Budget, optional
        What the case may take; `Budget()` by default.

    Raises
    ------
    InputError
        Where the file cannot be read, a key is unknown or missing, a value is out of range, or
        the runs would take more than the budget; other errors of the tree where the plant or the
        target model does not allow the case.

    Examples
    --------
    >>> from rcac_numeric import load_experiment, verify
    >>> verify(load_experiment("examples/boost_converter.toml")).exit_status
    0
    """
    return _built(*read_file(path), budget or Budget())


def build(table: Raw, file: str, budget: Budget | None = None) -> Experiment:
    """The experiment that tables describe as a file would; `file` is named in errors.

    Examples
    --------
    >>> from rcac_numeric.experiments.files.builder import build
    >>> build({"plant": {"problem": "standrad"}}, "case.toml")
    Traceback (most recent call last):
        ...
    compensator_theory.errors.InputError: case.toml: [plant] problem = 'standrad' is not known;
    choose one of standard, servo, aircraft, ... Did you mean 'standard'?
    """
    require_plain(dict(table), file)
    return _built(table, file, budget or Budget())


def _built(table: Raw, file: str, budget: Budget) -> Experiment:
    try:
        if is_exact(table):
            return exact_experiment(table, file)
        if is_estimation(table):
            return estimation_experiment(table, file, budget)
        return _experiment(table, file, budget)
    except CompensatorError as error:
        raise named(error, file) from None
    except MemoryError:
        raise InputError(f"{file}: the case needs more memory than there is.") from None


def _experiment(table: Raw, file: str, budget: Budget) -> Experiment:
    read = FILE.read(table, Place(file))
    overrides = table.get("runs") or [{"name": "main"}]
    if "run" not in table and not any("run" in override for override in overrides):
        raise InputError(
            "there is no table [run], which needs the key 'steps'. For a log that ran elsewhere "
            "no run is needed: check_controller(log, **check_arguments(file))."
        )
    runs = [read_run(table, override, file) for override in overrides]
    names = [run.name for run in runs]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise InputError(f"two runs are named {brief(twice)}; give each its own name.")
    items = OpenItems.of(table.get("open", ()))
    claims = [
        claim
        for part in read.arguments.get("claims", ())
        for claim in claims_of(part, names, items, check_of, STANDARD_CLAIMS)
    ]
    figures = [part.build() for part in read.arguments.get("figures", ())]
    common = runs[0].plant.build()
    plants = [
        run.plant.build() if "plant" in override else common
        for run, override in zip(runs, overrides, strict=True)
    ]
    pairs = list(zip(runs, plants, strict=True))
    budget.require_operations(sum(run.cost(plant, budget) for run, plant in pairs))
    made = {run.name: _made(run, plant, len(pairs) > 1) for run, plant in pairs}
    of_run = dict(zip(names, overrides, strict=True))
    completions = {}
    for base, values in completed_runs(claims, items):
        changes = [items.tables[value] for value in values]
        run = read_run(
            table, _override_of(completion_name(base, values), of_run[base], changes), file
        )
        is_other = any("plant" in change for change in changes)
        plant = run.plant.build() if is_other else made[base].plant
        budget.require_operations(run.cost(plant, budget))
        completions[run.name] = _made(run, plant, True)
    text = {key: read.arguments.get(key, "") for key in ("title", "id", "source", "notes")}
    return Experiment(
        id=text["id"] or Path(file).stem,
        title=text["title"],
        source=text["source"],
        notes=text["notes"].strip(),
        runs=made,
        claims=claims,
        open=items.items,
        completions=completions,
        figures=[require_drawable(figure, names) for figure in figures],
        description=_description(table),
    )


def _override_of(name: str, override: Raw, changes: Sequence[Raw]) -> dict[str, Any]:
    """What a completion overrides: what its run does, and then each value."""
    joined = dict(override)
    for change in changes:
        for key, value in change.items():
            old = joined.get(key, {})
            joined[key] = TABLES[key].joined(old, value) if key in TABLES else value
    return {**joined, "name": name}


def _made(
    run: RunTables, plant: Plant | PlantSchedule, is_one_of_several: bool
) -> RunSpecification:
    try:
        return run.build(plant)
    except CompensatorError as error:
        raise type(error)(
            f"run {run.name!r}: {error}" if is_one_of_several else str(error)
        ) from None


def _description(table: Raw) -> dict[str, str]:
    """The file's own words for plant, signals, target and controllers, for the report."""
    words = {}
    for name in ("plant", "signals", "target", "controller", "controllers", "saturation", "run"):
        parts = table.get(name, {})
        text = "; ".join(map(words_of, parts if isinstance(parts, list) else [parts]))
        words[name] = text if len(text) <= LONGEST_WORDS else f"{text[:LONGEST_WORDS]} ..."
    return words
