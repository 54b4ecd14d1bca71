"""A study as a report: what was run, how it ended, and the statistics group by group."""

from __future__ import annotations

from typing import Any

import numpy as np

from rcac_numeric.arrays.wording import shortened
from rcac_numeric.reports.sheets.sheet import Block, Fact, Level, Section, Sheet, Table, Text, cells
from rcac_numeric.sweeps.results.overview import SweepOverview
from rcac_numeric.sweeps.results.statistics import SweepSummary, wilson_interval

# Groups that a reader looks through, and errors.
LONGEST_TABLE, MOST_ERRORS = 40, 5


def sweep_sheet(overview: SweepOverview) -> Sheet:
    """What a store holds."""
    return Sheet(
        title=overview.title or overview.path,
        health=_health(overview),
        sections=(_study(overview), _outcomes(overview), _groups(overview), _errors(overview)),
    )


def _health(overview: SweepOverview) -> tuple[Text, ...]:
    said: list[Text] = []
    results = len(overview.table)
    if overview.failed:
        words = f"{overview.failed} of {overview.total} runs failed"
        how = "and are in no number below; --retry-failed (retry_failed=True) runs them again."
        said.append(Text(f"{words} {how}", "bad"))
    if overview.done < overview.total:
        said.append(
            Text(
                f"{overview.done} of {overview.total} runs have been run; the numbers below are "
                "of those.",
                "warning",
            )
        )
    others = results - overview.outcomes.get("completed", 0)
    if others:
        said.append(Text(f"{others} of {results} runs did not complete.", "warning"))
    elif results and not overview.failed:
        said.append(Text(f"All {results} runs completed.", "good"))
    if noted := sum(overview.errors.values()):
        said.append(Text(f"{noted} runs have an error recorded.", "bad"))
    if overview.mixed:
        words = f"Not all runs were made with the same: {'; '.join(overview.mixed)}."
        said.append(Text(words, "warning"))
    return tuple(said)


def _study(overview: SweepOverview) -> Section:
    axes = [
        Fact(name, f"{count} value{'s' * (count > 1)} of {path}")
        for name, (path, count) in overview.axes.items()
    ]
    versions = ", ".join(f"{name} {number}" for name, number in overview.versions.items())
    facts = [
        *axes,
        Fact("repetitions", str(overview.repetitions)),
        Fact("seed", str(overview.seed)),
        Fact("fingerprint", overview.fingerprint),
        Fact("made with", f"{versions}; {overview.instruction_set}; {overview.created}"),
    ]
    record = {
        "study": {
            "path": overview.path,
            "title": overview.title,
            "axes": {n: {"sets": p, "values": c} for n, (p, c) in overview.axes.items()},
            "repetitions": overview.repetitions,
            "seed": overview.seed,
            "fingerprint": overview.fingerprint,
            "versions": overview.versions,
            "mixed": list(overview.mixed),
            "instruction_set": overview.instruction_set,
            "created": overview.created,
            "runs": overview.total,
            "stored": overview.done,
            "failed": overview.failed,
        }
    }
    return Section("The study", tuple(facts), record)


def _outcomes(overview: SweepOverview) -> Section:
    rows = []
    for outcome, count in overview.outcomes.items():
        low, high = wilson_interval(count, len(overview.table))
        level: Level = "plain" if outcome == "completed" else "warning"
        interval = f"{_percent(low)} to {_percent(high)}"
        share = _percent(count / len(overview.table))
        rows.append(cells(Text(outcome, level), str(count), share, interval))
    table = Table(("outcome", "runs", "share", "95 % interval"), tuple(rows))
    return Section("How the runs ended", (table,) if rows else (), {"outcomes": overview.outcomes})


def _groups(overview: SweepOverview) -> Section:
    summary = overview.summary
    columns = {name: values.tolist() for name, values in summary.columns.items()}
    record = {"groups": {"by": list(summary.axes), "measure": summary.measure, **columns}}
    if not len(summary):
        return Section("", (), record)
    measured: list[str] = []
    if summary.measure:
        measured = ["median", *(f"q{q:g}" for q in summary.quantiles)]
        if (summary["measured"] != summary["runs"] - summary["not_completed"]).any():
            measured.insert(0, "measured")
    if summary["failed"].any():
        measured.insert(0, "failed")
    heads = [*summary.axes, "runs", "not completed", "share", *measured]
    rows = [_row(summary, i, measured) for i in range(min(len(summary), LONGEST_TABLE))]
    blocks: list[Block] = [Table(tuple(heads), tuple(rows))]
    if len(summary) > LONGEST_TABLE:
        words = f"{len(summary) - LONGEST_TABLE} more groups: --by fewer axes, --json or --export."
        blocks.append(Text(words, "quiet"))
    of = ", with the 95 % interval of the share that did not complete"
    if summary.measure:
        of += f", and {summary.measure} of the completed runs"
    return Section("Group by group", tuple(blocks), record, of)


def _row(summary: SweepSummary, i: int, measured: list[str]) -> Any:
    def entry(name: str) -> Any:
        return summary.columns[name][i]

    interval = f"{100 * entry('share_low'):.2g}-{_percent(entry('share_high'))}"
    failed = int(entry("not_completed"))
    row: list[str | Text] = [_value(entry(name)) for name in summary.axes]
    row += [str(entry("runs")), Text(str(failed), "warning" if failed else "plain"), interval]
    row += [_value(entry(name)) for name in measured]
    return cells(*row)


def _errors(overview: SweepOverview) -> Section:
    blocks: list[Block] = []
    for errors, column in ((overview.failures, "failed"), (overview.errors, "failure")):
        blocks += [
            Text(f"{count} times: {shortened(words, 300)}", "bad")
            for words, count in list(errors.items())[:MOST_ERRORS]
        ]
        if (more := len(errors) - MOST_ERRORS) > 0:
            blocks.append(Text(f"and {more} others; `{column}` of the table has them all."))
    record = {
        "failures": [{"error": e, "runs": n} for e, n in overview.failures.items()],
        "errors": [{"error": e, "runs": n} for e, n in overview.errors.items()],
    }
    return Section("Errors" if blocks else "", tuple(blocks), record)


def _percent(share: Any) -> str:
    return f"{100 * float(share):.3g}%"


def _value(value: Any) -> str:
    if isinstance(value, float | np.floating):
        return "-" if np.isnan(value) else f"{value:.3g}"
    return shortened(str(value), 40)
