"""The report of a design: verdict, assumptions, evidence, reasons."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from rcac_numeric.designing._design import ADAPTED, Design, Recommendation, compared
from rcac_numeric.designing._trials import FIXED, PID, RCAC, Trial
from rcac_numeric.identification._process_matrix import ProcessMatrix
from rcac_numeric.reports._loop import poles_reached
from rcac_numeric.reports._sheet import (
    Block,
    Fact,
    Level,
    Section,
    Sheet,
    SheetTable,
    Text,
    cells,
    counted,
)


def design_sheet(design: Design) -> Sheet:
    """The report of a design, the verdict first."""
    verdict = design.verdict
    rcac = verdict.rcac
    lines = [Text(no_room, "bad")] if (no_room := design.no_room) else []
    lines += [
        Text(str(verdict), _level(verdict)),
        Text(
            f"Test runs: RCAC {rcac}.", "plain" if rcac.stable[0] == rcac.stable[1] else "warning"
        ),
    ]
    lines += _guarantee(design)
    if rcac.fixed_stable[0] < rcac.fixed_stable[1]:
        plants = [
            t.variation.name for t in design.evidence
            if t.controller == FIXED and not all(t.stable)
        ]  # fmt: skip
        words = (
            f"The fixed controller is unstable with {', '.join(plants)}: no controller of the "
            "weight grid stabilises the whole range of plants. Reduce the uncertainty, shorten the "
            "dead time, or change the sample time."
        )
        lines.append(Text(words, "bad"))
    if PID in design.runs:
        comparison = compared(design.evidence, PID)
        better = f" {PID} is the better one for this plant." if comparison.is_better else ""
        lines.append(Text(f"{PID} {comparison}.{better}", "warning" if better else "plain"))
    if not verdict.Ms <= ADAPTED:
        words = f"The adapted controllers have Ms = {verdict.Ms:.3g}: their loops are not robust."
        lines.append(Text(words, "warning"))
    lines += [
        Text(f"Assumed for {q.name}: {q.assumed}; {q.words}.", "warning") for q in design.questions
    ]
    if verdict.use == RCAC:
        lines += poles_reached(design.runs[RCAC], design.health)
        lines += [Text(f"RCAC: {warning}", "quiet") for warning in design.health.warnings]
    return Sheet(
        "Controller design",
        f": e = r - y_0 - v, {design.settings.structure.name} of order "
        f"{design.settings.structure.n_c}",
        health=tuple(lines),
        sections=(_verdict(design), _evidence(design), _reasons(design), _alternatives(design)),
    )


def _level(verdict: Recommendation) -> Level:
    if verdict.is_worse_than_none:
        return "bad"
    return "good" if verdict.use == RCAC else "plain"


def _guarantee(design: Design) -> list[Text]:
    """The certified set, its cost and its exclusions; or the reason why there is none."""
    region, guarantee = design.certified, design.verdict.guarantee
    if region is None:
        return _suggestion(design)
    if isinstance(region, str):
        words = f"No certified set: {region}. The box in `bounds` limits theta, without a proof."
        return [Text(words, "warning")]
    plants = counted(len(region.members), "plant")
    lines = [
        Text(
            f"Proved in exact arithmetic for {plants} (nominal, {', '.join(design.family)}): no "
            "motion of theta in the certified set destabilises the loop.",
            "good",
        ),
        Text(f"Certified set: {guarantee}."),
    ]
    run = design.runs[RCAC]
    if run.saturation is not None:
        limited = int((run.u_applied != run.u).any(axis=1).sum())
        words = (
            "Not covered: u_limits. At a limit the loop is another one; RCAC met them in "
            f"{limited} of {run.steps} steps of the nominal run."
        )
        lines.append(Text(words, "warning"))
    return [*lines, Text(f"Not covered: {'; '.join(region.uncovered)}.")]


def _suggestion(design: Design) -> list[Text]:
    """The certified set that would have kept RCAC stable, where RCAC lost a test run."""
    if (region := design.possible_set) is None:
        return []
    stable, runs = design.verdict.rcac.stable
    words = (
        f"RCAC is unstable in {runs - stable} of {runs} test runs; a certified set exists for all "
        f'{len(region.members)} plants. Try next: kept="certified" (rcac design --kept certified).'
    )
    return [Text(words, "warning")]


def _verdict(design: Design) -> Section:
    record = asdict(design.verdict) | {"questions": [asdict(q) for q in design.questions]}
    record["no_room"] = design.no_room or None
    region = design.certified
    if region is not None:
        reason = region if isinstance(region, str) else None
        members = [] if isinstance(region, str) else [one.name for one in region.members]
        record["certified"] = {"plants": members, "reason": reason}
    if design.logged is not None:
        model = design.logged.model
        record["log"] = {"gates": [asdict(gate) for gate in model.gates]}
        if isinstance(model, ProcessMatrix):
            record["log"] |= {
                "gains": [list(row) for row in model.gain.tolist()],
                "gain_intervals": [
                    [None if one is None else list(one) for one in row]
                    for row in model.gain_intervals
                ],
                "delays": [list(row) for row in model.delays],
                "assumptions": list(model.assumptions),
            }
            return Section(record={"verdict": record})
        record["log"] |= {
            "gain_interval": list(model.gain_interval),
            "delay_interval": list(model.delay_interval),
            "dead_time_interval": list(model.dead_time_interval),
            "poles": [[pole.real, pole.imag] for pole in model.poles],
            "pole_deviations": [float(one) for one in model.pole_deviations],
        }
    return Section(record={"verdict": record})


def _evidence(design: Design) -> Section:
    names = list(dict.fromkeys(trial.controller for trial in design.evidence))
    plants = list(dict.fromkeys(trial.variation.name for trial in design.evidence))
    by_name = {(t.controller, t.variation.name): t for t in design.evidence}
    rows = tuple(
        cells(plant, *(_entry(by_name[name, plant]) for name in names)) for plant in plants
    )
    table = SheetTable(("plant", *(f"{name}: rms, peak, Ms" for name in names)), rows)
    record = [
        {"controller": t.controller, "plant": t.variation.name, "stable": list(t.stable),
         "rms": list(t.rms), "peak": list(t.peak), "Ms": list(t.Ms),
         "radius": [None if np.isnan(r) else r for r in t.radius]}
        for t in design.evidence
    ]  # fmt: skip
    words = Text(
        "Medians over the test seeds: rms of e_0 over the whole run, largest abs(e_0), peak Ms of "
        "the sensitivity with the final controller."
    )
    return Section("Test runs", (table, words), {"evidence": record})


def _entry(trial: Trial) -> Text:
    lost = len(trial.stable) - sum(trial.stable)
    numbers = [float(np.median(values)) for values in (trial.rms, trial.peak, trial.Ms)]
    words = ", ".join(f"{value:.3g}" for value in numbers)
    if not lost:
        return Text(words)
    return Text(f"{words}; {lost} of {len(trial.stable)} unstable", "bad")


def _reasons(design: Design) -> Section:
    facts: tuple[Block, ...] = tuple(
        Fact(one.name, f"{one.value}: {one.words}") for one in design.reasons
    )
    record = {one.name: {"value": one.value, "why": one.words} for one in design.reasons}
    return Section("Settings and their reasons", facts, {"reasons": record})


def _alternatives(design: Design) -> Section:
    blocks: list[Block] = []
    record: dict[str, Any] = {}
    for name, one in design.alternatives.items():
        if isinstance(one, str):
            blocks.append(Fact(name, f"none: {one}"))
            record[name] = one
            continue
        G_c = one.compensator
        record[name] = {"past_u": G_c.past_u, "past_y": G_c.past_y}
        blocks.append(Fact(name, f"a fixed controller of order {G_c.n_c}"))
    blocks.append(Fact("fallback", "the fixed controller, in design.fixed"))
    return Section("Alternatives", tuple(blocks), {"alternatives": record})
