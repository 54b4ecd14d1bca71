"""The numbers that are kept of one run; what is the same for a whole cell is found once."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
from rcac_numeric.experiments.measures.cost_measures import h2_cost, high_authority_cost
from rcac_numeric.sweeps.study.canonical import canonical_json
from rcac_numeric.sweeps.study.cells import Cell
from rcac_numeric.sweeps.study.measures import Kept


def measured(cell: Cell, run: AnalysedRun) -> tuple[list[float], str]:
    """One number for each measure of the study, NaN where there is none, and what failed.

    A measure that raises leaves the others alone. After a run that did not complete there may be
    nothing to measure; that is no failure.
    """
    values, failures = [], []
    for kept in cell.study.keep:
        try:
            values.append(_value(cell, kept, run))
        except Exception as error:  # of the user's own function too
            values.append(math.nan)
            if run.run.outcome == "completed" or not isinstance(error, CompensatorError):
                failures.append(f"measure {kept.name}: {type(error).__name__}: {error}")
    return values, "; ".join(failures)


def _value(cell: Cell, kept: Kept, run: AnalysedRun) -> float:
    quick = isinstance(kept.measure, str) and ONCE_FOR_A_CELL.get(kept.measure)
    value = quick(cell, run, **kept.arguments) if quick else kept.function(run, **kept.arguments)
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(f"it returned {value!r}, which is no number.") from None


def _least_cost(cell: Cell, run: AnalysedRun, **arguments: Any) -> float:
    """That of LQG: the same for all runs that ended with the same plant."""
    key = ("high_authority_cost", run.last_step, canonical_json(arguments))
    if key not in cell.remembered:
        cell.remembered[key] = high_authority_cost(run, **arguments)
    return float(cell.remembered[key])


def _cost_ratio(cell: Cell, run: AnalysedRun, **arguments: Any) -> float:
    return h2_cost(run, **arguments) / _least_cost(cell, run, **arguments)


ONCE_FOR_A_CELL: dict[str, Callable[..., Any]] = {
    "high_authority_cost": _least_cost,
    "cost_over_high_authority": _cost_ratio,
}
