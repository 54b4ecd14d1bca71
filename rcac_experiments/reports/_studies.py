"""Reports of a study: outcomes of its runs, a repeated run, the check of a store."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rcac_experiments.sweeps._check import StoreCheck
from rcac_experiments.sweeps._overview import SweepOverview
from rcac_experiments.sweeps._replay import ReplayedRun
from rcac_experiments.sweeps._statistics import SweepSummary, wilson_interval
from rcac_numeric.arrays._wording import shortened
from rcac_numeric.checks._diagnosis import loop_health
from rcac_numeric.reports._loop import health_lines, health_record
from rcac_numeric.reports._sheet import Block, Fact, Level, Section, Sheet, SheetTable, Text, cells

# Rows of the tables of groups and errors.
LONGEST_TABLE, MOST_ERRORS = 40, 5


def sweep_sheet(overview: SweepOverview) -> Sheet:
    """Return the report of the runs in a store."""
    return Sheet(
        title=overview.title or overview.path,
        health=_health(overview),
        sections=(_study(overview), _outcomes(overview), _groups(overview), _errors(overview)),
    )


def _health(overview: SweepOverview) -> tuple[Text, ...]:
    sentences: list[Text] = []
    results = len(overview.table)
    if overview.failed:
        words = f"{overview.failed} of {overview.total} runs failed"
        how = "the numbers below exclude them. Repeat them with --retry-failed (retry_failed=True)."
        sentences.append(Text(f"{words}; {how}", "bad"))
    if overview.done < overview.total:
        sentences.append(
            Text(
                f"{overview.done} of {overview.total} runs are finished; the numbers below use "
                "these "
                "runs.",
                "warning",
            )
        )
    others = results - overview.outcomes.get("completed", 0)
    if others:
        sentences.append(Text(f"{others} of {results} runs did not complete.", "warning"))
    elif results and not overview.failed:
        sentences.append(Text(f"All {results} runs completed.", "good"))
    if noted := sum(overview.errors.values()):
        sentences.append(Text(f"{noted} runs have a recorded error.", "bad"))
    if overview.mixed:
        words = f"The runs used different versions: {'; '.join(overview.mixed)}."
        sentences.append(Text(words, "warning"))
    return tuple(sentences)


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
        Fact("versions", f"{versions}; {overview.instruction_set}; {overview.created}"),
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
    table = SheetTable(("outcome", "runs", "share", "95 % interval"), tuple(rows))
    return Section("Outcomes", (table,) if rows else (), {"outcomes": overview.outcomes})


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
    blocks: list[Block] = [SheetTable(tuple(heads), tuple(rows))]
    if len(summary) > LONGEST_TABLE:
        words = f"{len(summary) - LONGEST_TABLE} more groups; use fewer axes in --by, or --json."
        blocks.append(Text(words, "quiet"))
    of = ", with the 95 % interval of the share that did not complete"
    if summary.measure:
        of += f", and {summary.measure} of the completed runs"
    return Section("Groups", tuple(blocks), record, of)


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
            blocks.append(Text(f"and {more} more; the column `{column}` of the table lists all."))
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


def replay_sheet(replayed: ReplayedRun) -> Sheet:
    """Return the report of a repeated run: comparison with the stored run, and its results."""
    run = replayed.analysed.run
    sentences = [Text("The repeated run is bit-identical to the stored run.", "good")]
    if not replayed.is_identical:
        sentences = [
            Text(
                f"The repeated run differs from the stored run: {', '.join(replayed.differences)}.",
                "bad",
            )
        ]
        sentences += [
            Text(f"{name} was {then} and is {now}.", "warning")
            for name, (then, now) in replayed.differing_versions.items()
        ]
    health = loop_health(replayed.analysed)
    sentences += health_lines(health)
    facts: list[Block] = [
        *(Fact(name, shortened(str(v), 80)) for name, v in replayed.coordinates.items()),
        Fact("repetition", str(replayed.repetition)),
        Fact("outcome", f"{run.outcome} after {run.steps} steps"),
    ]
    if replayed.stored_error:
        facts.append(Fact("recorded error", replayed.stored_error, "bad"))
    rows = [
        cells(name, _number(replayed.stored[name]), _number(replayed.repeated[name]))
        for name in replayed.stored
    ]
    if rows:
        facts.append(SheetTable(("measure", "stored", "now"), tuple(rows)))
    record = {
        "run": replayed.number,
        "coordinates": replayed.coordinates,
        "repetition": replayed.repetition,
        "outcome": run.outcome,
        "steps": run.steps,
        "is_identical": replayed.is_identical,
        "differences": replayed.differences,
        "stored": replayed.stored,
        "repeated": replayed.repeated,
        "theta_final": run.theta_final,
        **health_record(health),
    }
    return Sheet(
        f"Run {replayed.number}",
        health=tuple(sentences),
        sections=(Section("", tuple(facts), record),),
    )


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.17g}"


MOST_FAULTS = 20  # rows of the report


def store_sheet(check: StoreCheck) -> Sheet:
    """Return the report of the check of a store."""
    lost = sum(last - first + 1 for first, last in check.damaged)
    sentences = [Text("The store is intact: all files match their digests.", "good")]
    if not check.total:
        sentences = [Text("The store contains no study yet; nothing is damaged. If `rcac sweep` "
                          "was interrupted at its start, run the same command again.",
                     "warning")]  # fmt: skip
    if not check.is_whole:
        sentences = [Text(f"The store is damaged: {lost} runs do not match their digests.", "bad")]
        sentences.append(Text("Repeat the damaged runs with the same `rcac sweep`.", "warning"))
    blocks: list[Block] = [
        Fact("intact runs", f"{check.done} of {check.total}"),
        Fact("failed runs", str(check.failed)),
        *(Text(shortened(words, 300), "bad") for words in check.faults[:MOST_FAULTS]),
    ]
    if (more := len(check.faults) - MOST_FAULTS) > 0:
        blocks.append(Text(f"and {more} more; --json lists all."))
    record = {
        "path": check.path,
        "is_whole": check.is_whole,
        "done": check.done,
        "total": check.total,
        "failed": check.failed,
        "damaged": [list(runs) for runs in check.damaged],
        "faults": list(check.faults),
    }
    return Sheet(
        check.path, health=tuple(sentences), sections=(Section("", tuple(blocks), record),)
    )
