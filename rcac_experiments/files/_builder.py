"""Build an experiment from the tables of its file: plant, target models, runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import attrs

from compensator_theory.errors import Advice, CompensatorError, InputError
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_experiments.experiments._experiment import Experiment, RunSpecification
from rcac_experiments.experiments._figure_requests import FIGURE, FigureRequest, require_drawable
from rcac_experiments.files._claims import CLAIM, STANDARD_CLAIMS
from rcac_experiments.files._documents import Heading, named, read_file, require_plain
from rcac_experiments.files._estimation import estimation_experiment
from rcac_experiments.files._exact import exact_experiment
from rcac_experiments.files._runs import (
    CONTROLLERS,
    OPEN_VALUE,
    OVERRIDE,
    TABLES,
    Override,
    RunTables,
    read_run,
    words_of,
    wrong_tables,
)
from rcac_experiments.format._places import Errors, Location, quoted
from rcac_experiments.format._tables import Raw, Table
from rcac_experiments.format._values import ListOf
from rcac_experiments.judging._claim import Claim, OpenItem
from rcac_experiments.judging._reading import (
    claims_of,
    completed_runs,
    completion_name,
    opens,
    tables_of,
)
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule

# How much of a table's own words a report repeats.
LONGEST_WORDS = 400


@attrs.frozen(eq=False, kw_only=True)
class File(Heading):
    """An experiment."""

    plant: Annotated[Raw, TABLES["plant"], "What is controlled."]
    signals: Annotated[Raw | None, TABLES["signals"], "The exogenous input w."] = None
    target: Annotated[Raw | None, TABLES["target"], "The target model G_f."] = None
    controller: Annotated[Raw | None, TABLES["controller"], "The controller."] = None
    controllers: Annotated[
        list[Raw] | None,
        CONTROLLERS,
        "Several controllers whose outputs are added.",
    ] = None
    saturation: Annotated[Raw | None, TABLES["saturation"], "Bounds of the control."] = None
    run: Annotated[Raw | None, TABLES["run"], "How long it runs, and how."] = None
    runs: Annotated[
        list[Override] | None,
        ListOf(OVERRIDE, needed="an array of tables, [[runs]]", named="run"),
        "Several runs, the first being the main one.",
    ] = None
    claims: Annotated[
        list[Claim],
        ListOf(CLAIM, needed="an array of tables, [[claims]]"),
        "Claims, with the checks that decide them.",
    ] = attrs.field(factory=list)
    figures: Annotated[
        list[FigureRequest],
        ListOf(FIGURE, needed="an array of tables, [[figures]]"),
        "Figures; by default a sheet on the main run.",
    ] = attrs.field(factory=list)
    open: Annotated[
        list[OpenItem],
        opens(OPEN_VALUE),
        "Settings that the source leaves open, with the choice.",
    ] = attrs.field(factory=list)


FILE = Table(File)
NO_RUN = (
    "the table [run] with the key 'steps' is missing. For a log of another program no run is "
    "needed: ",
    Advice("check_controller", (), "{function}(log, **check_arguments(file))"),
    ".",
)


def load_experiment(path: str | Path, budget: ExperimentBudget | None = None) -> Experiment:
    """A user's own case from its TOML file; docs/experiment-files.md describes the format.

    Parameters
    ----------
    path : path
        Of a file of at most 10 MiB.
    budget : ExperimentBudget, optional
        The budget of the case; `ExperimentBudget()` by default.

    Raises
    ------
    InputError
        Where the file cannot be read, a key is unknown or missing, a value is out of range, or
        the runs would take more than the budget; other errors of the tree where the plant or the
        target model does not allow the case.

    Examples
    --------
    >>> from rcac_experiments import load_experiment, verify
    >>> verify(load_experiment("examples/boost_converter.toml")).exit_status
    0
    """
    return _built(*read_file(path), budget or ExperimentBudget())


def build(table: Raw, file: str, budget: ExperimentBudget | None = None) -> Experiment:
    """Build an experiment from the tables of a file; errors name `file`."""
    require_plain(dict(table), file)
    return _built(table, file, budget or ExperimentBudget())


def _built(table: Raw, file: str, budget: ExperimentBudget) -> Experiment:
    try:
        if "exact" in table:
            return exact_experiment(table, file)
        if "estimation" in table:
            return estimation_experiment(table, file, budget)
        return _experiment(table, file, budget)
    except CompensatorError as error:
        raise named(error, file) from None
    except MemoryError:
        raise InputError(f"{file}: not enough memory for the case.") from None


def _experiment(table: Raw, file: str, budget: ExperimentBudget) -> Experiment:
    read, runs = _read(table, file)
    overrides = _overrides(table)
    names = [run.name for run in runs]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise InputError(f"two runs have the name {quoted(twice)}; give each run a different name.")
    items, tables = tuple(read.open), tables_of(read.open)
    claims = [c for one in read.claims for c in claims_of(one, names, items, STANDARD_CLAIMS)]
    errors, plants = Errors(), []
    common: Plant | PlantSchedule | None = None  # made once for all that take it as it is
    for run, override in zip(runs, overrides, strict=True):
        with errors:
            if "plant" in override:
                plants.append(run.plant.build())
            else:
                common = run.plant.build() if common is None else common
                plants.append(common)
    errors.raise_any()
    pairs = list(zip(runs, plants, strict=True))
    budget.require_operations(sum(run.cost(plant, budget) for run, plant in pairs))
    specifications = {}
    for run, plant in pairs:
        with errors:
            specifications[run.name] = _run_of(run, plant, len(pairs) > 1)
    for figure in read.figures:
        with errors:
            require_drawable(figure, names)
    errors.raise_any()
    of_run = dict(zip(names, overrides, strict=True))
    completions = {}
    for base, values in completed_runs(claims, items):
        changes = [tables[value] for value in values]
        name = completion_name(base, values)
        completed = read_run(table, _override_of(name, of_run[base], changes), file)
        assert completed is not None, "no table of it is wrong"
        is_other = any("plant" in change for change in changes)
        plant = completed.plant.build() if is_other else specifications[base].plant
        budget.require_operations(completed.cost(plant, budget))
        completions[name] = _run_of(completed, plant, True)
    return Experiment(
        **read.words(file),
        runs=specifications,
        claims=claims,
        open=items,
        completions=completions,
        figures=read.figures,
        description=_description(table),
    )


def _read(table: Raw, file: str) -> tuple[File, list[RunTables]]:
    """Read the file and its runs; report the errors of all tables together."""
    errors, runs, wrong = Errors(), [], frozenset[str]()
    try:
        read = FILE.read(table, Location(file))
    except CompensatorError as error:
        errors.add(error)
        wrong = wrong_tables(table, file)
        if "runs" in wrong or not FILE.all_keys().keys() >= table.keys():
            raise  # a table that seems to be missing may be the one whose name is misspelt
    if "run" not in table and not any("run" in override for override in _overrides(table)):
        errors.add(InputError(*NO_RUN))
        errors.raise_any()
    for override in _overrides(table):
        with errors:
            if (run := read_run(table, override, file, wrong)) is not None:
                runs.append(run)
    errors.raise_any()
    return read, runs


def _overrides(table: Raw) -> list[Raw]:
    return table.get("runs") or [{"name": "main"}]


def _override_of(name: str, override: Raw, changes: Sequence[Raw]) -> dict[str, Any]:
    """Return the overrides of a completion: those of its run, then those of each value."""
    joined = dict(override)
    for change in changes:
        for key, value in change.items():
            old = joined.get(key, {})
            joined[key] = TABLES[key].joined(old, value) if key in TABLES else value
    return {**joined, "name": name}


def _run_of(
    run: RunTables, plant: Plant | PlantSchedule, is_one_of_several: bool
) -> RunSpecification:
    try:
        return run.build(plant)
    except CompensatorError as error:
        before = (f"run {run.name!r}: ",) if is_one_of_several else ()
        raise type(error)(*before, *error.args) from None


def _description(table: Raw) -> dict[str, str]:
    """Return plant, signals, target and controllers as the file writes them, for the report."""
    words = {}
    for name in ("plant", "signals", "target", "controller", "controllers", "saturation", "run"):
        parts = table.get(name, {})
        text = "; ".join(map(words_of, parts if isinstance(parts, list) else [parts]))
        words[name] = text if len(text) <= LONGEST_WORDS else f"{text[:LONGEST_WORDS]} ..."
    return words
