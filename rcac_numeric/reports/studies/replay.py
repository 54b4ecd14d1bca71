"""A run of a study that was run again, as a report."""

from __future__ import annotations

import math

from rcac_numeric.arrays.wording import shortened
from rcac_numeric.health.diagnosis import loop_health
from rcac_numeric.reports.health import health_lines, health_record
from rcac_numeric.reports.sheets.sheet import Block, Fact, Section, Sheet, Table, Text, cells
from rcac_numeric.sweeps.results.replay import ReplayedRun


def replay_sheet(replayed: ReplayedRun) -> Sheet:
    """Whether every bit came out again, and what the run is."""
    run = replayed.analysed.run
    said = [Text("Bit for bit the run that is stored.", "good")]
    if not replayed.is_identical:
        said = [Text(f"Not the run that is stored: {', '.join(replayed.differences)}.", "bad")]
        said += [
            Text(f"{name} was {then} and is {now}.", "warning")
            for name, (then, now) in replayed.differing_versions.items()
        ]
    health = loop_health(replayed.analysed)
    said += health_lines(health)
    facts: list[Block] = [
        *(Fact(name, shortened(str(v), 80)) for name, v in replayed.coordinates.items()),
        Fact("repetition", str(replayed.repetition)),
        Fact("outcome", f"{run.outcome} after {run.steps} steps"),
    ]
    if replayed.stored_error:
        facts.append(Fact("recorded", replayed.stored_error, "bad"))
    rows = [
        cells(name, _number(replayed.stored[name]), _number(replayed.found[name]))
        for name in replayed.stored
    ]
    if rows:
        facts.append(Table(("measure", "stored", "now"), tuple(rows)))
    record = {
        "run": replayed.number,
        "coordinates": replayed.coordinates,
        "repetition": replayed.repetition,
        "outcome": run.outcome,
        "steps": run.steps,
        "is_identical": replayed.is_identical,
        "differences": replayed.differences,
        "stored": replayed.stored,
        "found": replayed.found,
        "theta_final": run.theta_final,
        **health_record(health),
    }
    return Sheet(
        f"Run {replayed.number}",
        health=tuple(said),
        sections=(Section("", tuple(facts), record),),
    )


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.17g}"
