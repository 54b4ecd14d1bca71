"""The file of an estimation example: its tables, and the experiment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import attrs

from compensator_theory.errors import InputError
from rcac_experiments.experiments._budgets import ExperimentBudget
from rcac_experiments.experiments._estimation_studies import MEASURES, Estimation, EstimationStudy
from rcac_experiments.experiments._estimators import (
    ExtendedFilter,
    UnscentedFilter,
    controlled,
    refined,
)
from rcac_experiments.experiments._experiment import Experiment
from rcac_experiments.experiments._figure_requests import FigureRequest
from rcac_experiments.experiments._true_systems import TrueSystem
from rcac_experiments.files._documents import Heading
from rcac_experiments.format._places import Errors, Location, quoted
from rcac_experiments.format._signatures import Composed
from rcac_experiments.format._tables import Kinds, PartialTable, Raw, Table
from rcac_experiments.format._values import Choice, Integer, ListOf, String
from rcac_experiments.judging._claim import Claim, OpenItem
from rcac_experiments.judging._reading import (
    check_table,
    claim_table,
    claims_of,
    completed_runs,
    completion_name,
    opens,
    require_run,
    tables_of,
)
from rcac_numeric.arrays._values import Value

SEEDS = "The first seed, and how many there are from it on."


STEPS = {"delays": ListOf(Integer(1), 1), "window": Integer(1, 100_000), "d": Integer(1)}
ESTIMATORS: Kinds[Estimation] = Kinds(
    {
        "ekf": Table(ExtendedFilter),
        "ukf": Table(UnscentedFilter),
        "rcmr": Table(refined, forms=STEPS),
        "indirect": Table(controlled, forms=STEPS),
    }
)


def _trial(
    system: TrueSystem,
    steps: Annotated[int, Integer(1), "Length of a record."],
    seed: Annotated[int, SEEDS] = 0,
    seeds: Annotated[int, Integer(1), SEEDS] = 1,
) -> dict[str, Any]:
    """The true system x(k+1) = A(k) x + D_1(k) w, y = C x + v, and how often it is recorded."""
    return {"system": system, "steps": steps, "seed": seed, "seeds": seeds}


def _estimator(kind: Annotated[Any, ESTIMATORS, "Which estimator."]) -> Any:
    """An estimator of the parameter."""
    return kind


TRIAL = PartialTable(Table(Composed(_trial, system=TrueSystem)))
ESTIMATOR = PartialTable(Table(_estimator))


WINDOW = {"start": Integer(), "stop": Integer(1)}
CHECK: Table[Any] = check_table(
    {n: Table(f, supplied=["r"], forms=WINDOW) for n, f in MEASURES.items()}, supplied=["until"]
)
CLAIM: Table[Any] = claim_table(CHECK)
FIGURE = Table(
    FigureRequest,
    supplied=["channel", "noise", "direct", "designs"],
    forms={
        "kind": Choice(("estimates", "responses", "distribution")),
        "runs": ListOf(String()),
        "signal": Choice(("z",)),
        "first": Integer(0),
        "last": Integer(1),
        "measure": Choice(tuple(MEASURES)),
    },
)


def estimation_figure(request: FigureRequest, runs: Sequence[str]) -> FigureRequest:
    """The figure of a table, if its runs exist."""
    for name in request.runs:
        require_run(name, runs, "a figure")
    return request


STORED = 6  # stored numbers of each step


BEGINNING = "What differs from those."


@attrs.frozen(eq=False)
class EstimationValue(Value):
    """One of the values that a reader would try: its name, and what it changes."""

    name: Annotated[str, "What it is called; claims refer to it."]
    estimation: Annotated[Raw | None, TRIAL, BEGINNING] = None
    estimator: Annotated[Raw | None, ESTIMATOR, BEGINNING] = None


@attrs.frozen(eq=False)
class EstimationRun(EstimationValue):
    """One estimator on one true system."""

    like: Annotated[
        str,
        "An earlier run whose tables it begins with, in place of those of the file.",
    ] = ""
    correction: Annotated[
        str,
        "The differences of this run from the source.",
    ] = ""


RUN = Table(EstimationRun)


@attrs.frozen(eq=False, kw_only=True)
class EstimationFile(Heading):
    """An estimation example."""

    estimation: Annotated[Raw, TRIAL, "The true system and its records."]
    runs: Annotated[
        list[EstimationRun],
        ListOf(RUN, 1, needed="an array of tables, [[runs]]", named="run"),
        "Estimators, or variants, on it; the first is the main one.",
    ]
    estimator: Annotated[
        Raw | None,
        ESTIMATOR,
        "The common keys of the estimators of all runs.",
    ] = None
    claims: Annotated[
        list[Claim],
        ListOf(CLAIM, needed="an array of tables, [[claims]]"),
        "Claims, with the checks that decide them.",
    ] = attrs.field(factory=list)
    figures: Annotated[
        list[FigureRequest],
        ListOf(FIGURE, needed="an array of tables, [[figures]]"),
        "Figures.",
    ] = attrs.field(factory=list)
    open: Annotated[
        list[OpenItem],
        opens(Table(EstimationValue)),
        "Settings that the source leaves open, with the choice.",
    ] = attrs.field(factory=list)


ESTIMATION_FILE = Table(EstimationFile)


def estimation_experiment(table: Raw, file: str, budget: ExperimentBudget) -> Experiment:
    """The experiment of an estimation example: studies and claims."""
    read: EstimationFile = ESTIMATION_FILE.read(table, Location(file))
    raw: dict[str, dict[str, Any]] = {}
    studies: dict[str, EstimationStudy] = {}
    errors = Errors()
    for run in table["runs"]:
        name = str(run["name"])
        if name in studies:
            raise InputError(
                f"two runs have the name {quoted(name)}; give each run a different name."
            )
        require_run(run.get("like", ""), dict.fromkeys(raw, ""), f"the run {name!r}")
        base = raw[run["like"]] if run.get("like") else table
        raw[name] = {
            key: form.joined(base.get(key, {}), run.get(key, {}))
            for key, form in (("estimation", TRIAL), ("estimator", ESTIMATOR))
        }
        with errors:
            studies[name] = _study(name, raw[name], file, str(run.get("correction", "")))
    errors.raise_any()
    _require_budget(studies, budget)
    items, of_value = tuple(read.open), tables_of(read.open)
    claims = [claim for one in read.claims for claim in claims_of(one, tuple(studies), items)]
    completions = {}
    for of_run, values in completed_runs(claims, items):
        tables = raw[of_run]
        for value in values:  # what a value names it replaces as a whole
            tables = {
                key: {**inner, **of_value[value].get(key, {})} for key, inner in tables.items()
            }
        name = completion_name(of_run, values)
        completions[name] = _study(name, tables, file, studies[of_run].correction)
    return Experiment(
        **read.words(file),
        runs={},
        studies=studies,
        claims=claims,
        open=items,
        completions=completions,
        figures=[estimation_figure(figure, list(studies)) for figure in read.figures],
        description={"truth": _words(table["estimation"])},
    )


def _study(name: str, raw: Raw, file: str, correction: str) -> EstimationStudy:
    notes, errors = (f"run {name!r}",), Errors()
    read: dict[str, Any] = {}
    with errors:
        read |= TRIAL.table.read(raw["estimation"], Location(file, "estimation", notes=notes))
    with errors:
        location = Location(file, "estimator", notes=notes)
        read["estimator"] = ESTIMATOR.table.read(raw["estimator"], location)
    errors.raise_any()
    return EstimationStudy(name=name, correction=correction, **read)


def _require_budget(studies: Mapping[str, EstimationStudy], budget: ExperimentBudget) -> None:
    needed = sum(study.steps * study.seeds for study in studies.values())
    if 8.0 * STORED * needed > budget.memory:
        raise InputError(
            f"the runs need {8.0 * STORED * needed:.3g} bytes; the limit is {budget.memory:.3g}. "
            "Use fewer steps or seeds."
        )
    largest = max(study.system.n for study in studies.values())
    budget.require_operations(float(needed) * (largest + 10) ** 2)


def _words(table: Raw) -> str:
    fields = ("truth", "w", "bias", "deviation", "steps", "seeds")
    return ", ".join(f"{key} = {table[key]}" for key in fields if key in table)
