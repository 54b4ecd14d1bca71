"""From the file of an estimation example to an experiment of studies."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.experiments.budgets import Budget
from rcac_numeric.experiments.estimation.studies import EstimationStudy
from rcac_numeric.experiments.estimation_files.claims import CLAIM, FIGURE, estimation_figure
from rcac_numeric.experiments.estimation_files.tables import ESTIMATOR, TRIAL, Trial
from rcac_numeric.experiments.experiment import Experiment
from rcac_numeric.experiments.format.lists import ListOf
from rcac_numeric.experiments.format.places import Place, brief
from rcac_numeric.experiments.format.tables import Table
from rcac_numeric.experiments.judging.reading import (
    OpenItems,
    check_of,
    claims_of,
    completed_runs,
    completion_name,
    opens,
    require_run,
)

Raw = Mapping[str, Any]
KEPT = 6  # numbers that are kept of each step


def _estimation_run(
    name: str, like: str = "", estimation: Any = None, estimator: Any = None, correction: str = ""
) -> str:
    """One estimator on one true system.

    Parameters
    ----------
    name : str
        What it is called; claims refer to it.
    like : str
        An earlier run whose tables it begins with, in place of those of the file.
    estimation, estimator : tables
        What differs from those.
    correction : str
        What this run reads differently from the source.
    """
    return name


def _estimation_value(name: str, estimation: Any = None, estimator: Any = None) -> str:
    """One of the values that a reader would try.

    Parameters
    ----------
    name : str
        What it is called.
    estimation, estimator : tables
        What it changes.
    """
    return name


def _estimation_file(
    estimation: Any, runs: list[Any], estimator: Any = None, claims: Any = None,
    figures: Any = None, open: Any = None, title: str = "", id: str = "", source: str = "",
    notes: str = "",
) -> str:  # fmt: skip
    """An estimation example.

    Parameters
    ----------
    estimation : table
        The true system and its records.
    runs : tables
        Estimators, or variants, on it; the first is the main one.
    estimator : table
        What the estimators of all runs begin with.
    claims, figures : tables
        What is said and drawn of it.
    open : tables
        What its source leaves open.
    title, id, source, notes : str
        As of any experiment.
    """
    return title


VALUE = Table(_estimation_value, forms={"estimation": TRIAL, "estimator": ESTIMATOR})
RUN = Table(_estimation_run, forms={"estimation": TRIAL, "estimator": ESTIMATOR})
ESTIMATION_FILE = Table(
    _estimation_file,
    forms={
        "estimation": TRIAL,
        "estimator": ESTIMATOR,
        "runs": ListOf(RUN, 1, needed="an array of tables, [[runs]]"),
        "claims": ListOf(CLAIM, needed="an array of tables, [[claims]]"),
        "open": opens(VALUE),
        "figures": ListOf(FIGURE, needed="an array of tables, [[figures]]"),
    },
)


def is_estimation(table: Raw) -> bool:
    """Whether the tables of a file are those of an estimation example."""
    return "estimation" in table


def estimation_experiment(table: Raw, file: str, budget: Budget) -> Experiment:
    """The experiment of an estimation example: studies and claims.

    Raises
    ------
    InputError
        Where a key is unknown or missing, a value is out of range, or it would take more than the
        budget.

    Examples
    --------
    >>> from rcac_numeric import load_example, verify
    >>> verification = verify(load_example("8.3").reduced(1))
    >>> verification.verdicts[0].verdict
    'not reproduced'
    """
    read = ESTIMATION_FILE.read(table, Place(file)).arguments
    raw: dict[str, dict[str, Any]] = {}
    studies: dict[str, EstimationStudy] = {}
    for run in table["runs"]:
        name = str(run["name"])
        if name in studies:
            raise InputError(f"two runs are named {brief(name)}; give each its own name.")
        require_run(run.get("like", ""), dict.fromkeys(raw, ""), f"the run {name!r}")
        base = raw[run["like"]] if run.get("like") else table
        raw[name] = {
            key: form.joined(base.get(key, {}), run.get(key, {}))
            for key, form in (("estimation", TRIAL), ("estimator", ESTIMATOR))
        }
        studies[name] = _study(name, raw[name], file, str(run.get("correction", "")))
    _require_budget(studies, budget)
    items = OpenItems.of(table.get("open", ()))
    claims = [
        claim
        for part in read.get("claims", ())
        for claim in claims_of(part, tuple(studies), items, check_of)
    ]
    completions = {}
    for of_run, values in completed_runs(claims, items):
        tables = raw[of_run]
        for value in values:  # what a value names it replaces as a whole
            tables = {
                key: {**inner, **items.tables[value].get(key, {})} for key, inner in tables.items()
            }
        name = completion_name(of_run, values)
        completions[name] = _study(name, tables, file, studies[of_run].correction)
    text = {key: read.get(key, "") for key in ("title", "id", "source", "notes")}
    return Experiment(
        id=text["id"] or Path(file).stem,
        title=text["title"],
        source=text["source"],
        notes=text["notes"].strip(),
        runs={},
        studies=studies,
        claims=claims,
        open=items.items,
        completions=completions,
        figures=[estimation_figure(part, list(studies)) for part in read.get("figures", ())],
        description={"truth": _words(table["estimation"])},
    )


def _study(name: str, raw: Raw, file: str, correction: str) -> EstimationStudy:
    notes = (f"run {name!r}",)
    trial_part = TRIAL.table.read(raw["estimation"], Place(file, "estimation", notes=notes))
    estimator_part = ESTIMATOR.table.read(raw["estimator"], Place(file, "estimator", notes=notes))
    try:
        trial: Trial = trial_part.build()
        estimator = estimator_part.build()
    except CompensatorError as error:
        raise type(error)(f"run {name!r}: {error}") from None
    return EstimationStudy(
        name, trial.system, estimator, trial.steps, trial.seed, trial.seeds, correction
    )


def _require_budget(studies: Mapping[str, EstimationStudy], budget: Budget) -> None:
    needed = sum(study.steps * study.seeds for study in studies.values())
    if 8.0 * KEPT * needed > budget.memory:
        raise InputError(
            f"the runs would keep {8.0 * KEPT * needed:.3g} bytes; {budget.memory:.3g} are "
            "allowed. Use fewer steps or seeds."
        )
    largest = max(study.system.n for study in studies.values())
    budget.require_operations(float(needed) * (largest + 10) ** 2)


def _words(table: Raw) -> str:
    kept = ("truth", "w", "bias", "deviation", "steps", "seeds")
    return ", ".join(f"{key} = {table[key]}" for key in kept if key in table)
