"""What a report says of the studies of an estimation example."""

from __future__ import annotations

import numpy as np

from rcac_numeric.experiments.estimation.studies import StudyResult
from rcac_numeric.experiments.verdicts import Verification
from rcac_numeric.reports.sheets.sheet import Section, Table, Text, cells


def estimation_health(verification: Verification) -> tuple[Text, ...]:
    """Whether every estimate came from data that determine it."""
    results = verification.estimates
    undetermined = [name for name, result in results.items() if _left(result) > 0.5]
    said = [
        Text(f"Run {name!r}: the data do not determine the parameter.", "warning")
        for name in undetermined
    ]
    if not said:
        said = [Text("Estimates of a parameter whose true value is known.")]
    if changed := sum(verdict.has_changed for verdict in verification.verdicts):
        said.append(Text(f"{changed} of the verdicts of record changed.", "bad"))
    return tuple(said)


def estimation_section(verification: Verification) -> Section:
    """Every run side by side: the estimator, its seeds, and the estimate at the end."""
    results = verification.estimates
    heads = ("run", "estimator", "seeds", "truth at the end", "estimate at the end", "outcome")
    rows = tuple(
        cells(
            name,
            result.study.estimator.words,
            str(result.study.seeds),
            f"{result.study.course_end:.5g}",
            _estimates(result),
            _outcome(result),
        )
        for name, result in results.items()
    )
    record = [
        {
            "name": name,
            "estimator": result.study.estimator.words,
            "steps": result.study.steps,
            "seeds": result.study.seeds,
            "truth": result.study.course_end,
            "estimates": list(_last(result)),
            "outcomes": [run.outcome for run in result.repetitions],
        }
        for name, result in results.items()
    ]
    return Section("Runs", (Table(heads, rows),), {"runs": record})


def _last(result: StudyResult) -> tuple[float, ...]:
    return result.values("final_estimate", {})


def _left(result: StudyResult) -> float:
    return max(result.values("initial_estimate_left", {}))


def _estimates(result: StudyResult) -> str:
    values = _last(result)
    if len(values) == 1:
        return f"{values[0]:.5g}"
    return f"{np.median(values):.5g}  ({min(values):.5g} to {max(values):.5g})"


def _outcome(result: StudyResult) -> str:
    lost = sum(run.outcome != "completed" for run in result.repetitions)
    return f"{lost} of {result.study.seeds} diverged" if lost else "completed"
