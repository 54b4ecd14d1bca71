"""The check of a controller as a report."""

from __future__ import annotations

from dataclasses import fields
from math import isnan
from typing import Any

from rcac_numeric.analysis._boundaries import StabilityBoundary
from rcac_numeric.analysis._certified_tail import CertifiedTail
from rcac_numeric.analysis._classical import Margins
from rcac_numeric.analysis._disk import DiskMargin
from rcac_numeric.analysis._exact_comparison import ExactComparison
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.checks._check import NEED_THE_TARGET, ControllerCheck
from rcac_numeric.checks._diagnosis import NO_LOOP, loop_health
from rcac_numeric.checks._hypotheses import Decision
from rcac_numeric.reports._certified import proof_lines, proof_obstacle, tail_record
from rcac_numeric.reports._loop import (
    LOOP,
    health_lines,
    health_record,
    joined,
    match_section,
    missed_poles,
    poles_and_health,
    proof_of_run,
    reached_facts,
    split_section,
    zeros_facts,
)
from rcac_numeric.reports._sheet import (
    Block,
    Fact,
    Section,
    Sheet,
    SheetTable,
    Text,
    cells,
    complex_list,
)

# The loop of stability and margins, where the plant may not be that of the log.
MODEL = "The loop of this plant and this controller"


def check_sheet(check: ControllerCheck) -> Sheet:
    """The report of a controller check: log, controller, loop, and the parts not evaluated."""
    health = loop_health(check)
    sections = [Section(record=health_record(health)), _log(check), _controller(check)]
    is_known = check.loop is not None and check.is_consistent
    proof, record = _proof(check) if is_known else ((), {})
    sections.append(Section(record=record))
    if is_known:
        sections += [_loop(check), *(margins_section(n, m) for n, m in check.margins.items())]
        sections += [_disk(check), _costs(check)]
        if check.target is not None:
            sections.append(_target(check))
    return Sheet(
        title=check.log.source,
        remark=f": {check.log.steps} steps",
        health=(
            *_doubt(check),
            *poles_and_health(
                missed_poles(check.comparison, check.structure) if is_known else (),
                health_lines(health, _subject(check)),
            ),
            *proof,
        ),
        sections=(*sections, _unanswered(check)),
    )


def _subject(check: ControllerCheck) -> str:
    residual = check.plant_residual
    if residual is None or not residual.is_doubtful:
        return LOOP
    return f"{MODEL}, which did not run," if residual.is_contradicted else MODEL


def _doubt(check: ControllerCheck) -> tuple[Text, ...]:
    """The doubts about controller, plant and log, which a reader must see first."""
    residual, decision = check.plant_residual, check.decision
    lines = []
    if not check.is_consistent:
        doubts = check.sample_shift, check.conventions, check.replay
        doubt = next(one for one in doubts if one is not None)
        lines.append(Text(str(doubt), "bad"))
    if residual is not None and residual.is_doubtful:
        lines.append(Text(str(residual), "bad"))
    if decision is not None:
        words = str(decision)
        if check.is_undecided:
            words += " The standard problem is assumed; give --problem."
        lines.append(Text(words, "bad" if check.is_undecided else "plain"))
    return tuple(lines)


def _proof(check: ControllerCheck) -> tuple[tuple[Text, ...], dict[str, Any]]:
    """The first step from which the loop of the logged theta is proved stable: lines and record."""
    if check.run is not None:
        return proof_of_run(LoopAnalysis(check.run))
    if check.structure is None or check.loop is None or not check.loop.is_stable:
        return (), {}
    tail: CertifiedTail | str = proof_obstacle(check.structure.l_theta) or check.certified
    if isinstance(tail, str):
        return proof_lines(tail), {"certified_from": {"k0": None, "reason": tail}}
    return proof_lines(tail), {"certified_from": tail_record(tail)}


def _decided(decision: Decision | str) -> dict[str, Any]:
    if isinstance(decision, str):
        return {"decided": None, "why": decision}
    return {
        "decided": decision.decided and decision.decided.problem,
        "delay": decision.decided and decision.decided.delay,
        "hypotheses": [
            {"problem": h.problem, "delay": h.delay, "rms": h.rms} for h in decision.hypotheses
        ],
        "y_stays": decision.stays,
    }


def _log(check: ControllerCheck) -> Section:
    replay, drift, residual = check.replay, check.drift, check.plant_residual
    blocks: list[Block] = []
    record: dict[str, Any] = {
        "source": check.log.source, "steps": check.log.steps, "replay": None, "drift": None,
        "sample_time": check.log.sample_time, "clock": check.log.clock or None,
        "notes": list(check.log.notes),
        "problem": None if check.decision is None else _decided(check.decision),
        "plant_residual": None if residual is None else {
            name: getattr(residual, name)
            for name in (
                "rms", "change", "best", "relative", "whitened", "is_doubtful", "is_contradicted",
            )
        },
    }  # fmt: skip
    blocks += [Text(f"Clock: {check.log.clock}")] if check.log.clock else []
    blocks += [Text(f"Log: {note}", "warning") for note in check.log.notes]
    if residual is not None and not residual.is_doubtful:
        blocks.append(Text(str(residual)))
    if check.conventions is not None:
        record["conventions"] = {
            "tried": check.conventions.tried,
            "matches": [
                {"convention": str(one.convention), "u_limits": one.u_limits,
                 "shift": one.replay.shift, "worst": one.replay.worst}
                for one in check.conventions.matches
            ],
        }  # fmt: skip
    if replay is not None:
        if replay.agrees or check.conventions is not None:
            blocks.append(Text(str(replay), "plain" if replay.agrees else "bad"))
        record["replay"] = {
            name: getattr(replay, name)
            for name in ("of", "agrees", "worst", "worst_step", "start", "shift", "tolerance")
        }
    if drift is not None:
        blocks.append(Text(str(drift), "plain" if drift.is_converged else "bad"))
        record["drift"] = {n: getattr(drift, n) for n in ("is_converged", "relative", "start")}
    if not check.is_consistent:
        subject = "theta" if replay is None or check.structure is not None else replay.of
        words = f"The results below are for {subject}, which did not produce the logged u."
        blocks.append(Text(words))
    return Section(blocks=tuple(blocks), record=record)


def _controller(check: ControllerCheck) -> Section:
    poles = check.compensator.poles()
    blocks: list[Block] = [Fact("poles", complex_list(poles))]
    if (largest := float(abs(poles).max(initial=0.0))) > 1 + 1e-9:
        words = f"the controller itself is unstable: spectral radius {largest:.6g}"
        blocks.append(Text(words, "warning"))
    for model in check.internal_models:
        known = model.gains if check.is_consistent else {}
        gains = ", ".join(f"{gain:.2g} from {name}" for name, gain in known.items())
        gains = f"; gain to z there: {gains}" if gains else ""
        pole = complex_list([model.pole])
        blocks.append(
            Text(f"internal model: the controller pole at {pole} rejects {model.rejects}{gains}")
        )
    record = {
        "P": check.compensator.past_u,
        "Q": check.compensator.past_y,
        "poles": poles,
        "internal_models": [
            {name: getattr(model, name) for name in ("pole", "omega", "rejects", "gains")}
            for model in check.internal_models
        ],
    }
    return Section(
        "The controller", tuple(blocks), {"controller": record}, remark=" at the end of the log"
    )


def _loop(check: ControllerCheck) -> Section:
    loop, poles = check.loop, check.poles
    assert loop is not None and poles is not None
    record = {
        "is_stable": loop.is_stable,
        "spectral_radius": loop.spectral_radius,
        "poles": poles,
        "zeros": check.zeros,
    }
    zeros = {channel: complex_list(values) for channel, values in check.zeros.items()}
    facts = (Fact("poles", complex_list(poles)), *zeros_facts(zeros))
    remark = "" if (subject := _subject(check)) == LOOP else f": {subject.rstrip(',').lower()}"
    return Section("The closed loop", facts, {"loop": record, "margins": {}}, remark)


def _disk(check: ControllerCheck) -> Section:
    blocks = (
        ()
        if check.disk is None
        else (Text(f"disk margin, all components of u together: {check.disk}"),)
    )
    return Section(blocks=blocks, record={"disk_margin": disk_record(check.disk)})


def _costs(check: ControllerCheck) -> Section:
    costs = check.costs
    assert costs is not None
    blocks: list[Block] = []
    if costs.reached is None:
        blocks.append(Text(f"not evaluated: {costs.obstacle}.", "warning"))
    else:
        shares = ", ".join(f"{name} {value:.6g}" for name, value in costs.reached.shares.items())
        blocks.append(Text(f"this controller: {costs.reached.value:.6g} ({shares})"))
    if costs.least is None:
        blocks.append(Text(f"LQG cost not evaluated: {costs.obstacle}.", "warning"))
    else:
        ratio = "" if costs.ratio is None else f"; ratio {costs.ratio:.6g}"
        blocks.append(Text(f"LQG optimum: {costs.least.value:.6g}{ratio}"))
    record = {
        "cost": None if costs.reached is None else costs.reached.value,
        "by_noise": {} if costs.reached is None else costs.reached.shares,
        "lqg": None if costs.least is None else costs.least.value,
        "obstacle": costs.obstacle or None,
    }
    remark = " for white noise, with the share of each channel"
    return Section("H2 cost", tuple(blocks), {"h2": record}, remark)


def _target(check: ControllerCheck) -> Section:
    parts = []
    if check.comparison is not None:
        parts.append(_comparison(check.comparison))
    if check.match is not None:
        parts.append(match_section(check.match, ""))
    if check.split is not None:
        stable = check.loop is not None and check.loop.is_stable
        parts.append(split_section(check.split, "", stable))
    return joined("Comparison with the target model", *parts)


def _comparison(comparison: ExactComparison) -> Section:
    rows = tuple(
        cells(complex_list([requested]), complex_list([pole]), f"{abs(requested - pole):.2e}")
        for requested, pole in comparison.assigned
    )
    blocks: list[Block] = [SheetTable(("pole of G_f", "closed-loop pole", "distance"), rows)]
    if comparison.requested is None:
        blocks.append(Text(f"exact prediction not evaluated: {comparison.obstacle}", "warning"))
    else:
        far = f"{comparison.spectrum_distance:.3g}"
        words = f"distance of the closed-loop poles from the target poles: {far}"
        blocks.append(Text(words))
    blocks += reached_facts(comparison)
    record = {
        "poles": comparison.target_poles,
        "backward_error": comparison.backward_error,
        "is_reached": comparison.is_reached,
        "worst_pole_distance": comparison.worst_distance,
        "spectrum_distance": comparison.spectrum_distance,
        "obstacle": comparison.obstacle or None,
    }
    return Section(blocks=tuple(blocks), record={"target": record})


def _unanswered(check: ControllerCheck) -> Section:
    reasons = check.unanswered
    if check.loop is not None and not check.is_consistent:
        names = "poles", "costs", "margins", *(NEED_THE_TARGET if check.target is not None else ())
        reasons = {**dict.fromkeys(names, NO_LOOP), **reasons}
    lines = tuple(Text(f"{name}: {why}.", "warning") for name, why in reasons.items())
    return Section("Not evaluated" if lines else "", lines, {"unanswered": reasons})


# The margins of a loop as a section of a report.

HEADS = ("", "margin", "at rad/sample", "pole radius there")


def margins_section(name: str, margins: Margins) -> Section:
    """The margins of the loop opened at the signal `name`, each with the pole radius there."""
    record: dict[str, Any] = {
        "is_stable": margins.is_stable,
        "gain_crossovers": margins.gain_crossovers,
        "phase_crossovers": margins.phase_crossovers,
    }
    whole = {"margins": {name: record}}
    remark = f", the loop opened at {name}"
    if not margins.is_stable:
        return Section("Margins", (Text(str(margins), "bad"),), whole, remark)
    rows = []
    for label, margin, unit in _boundaries(margins):
        omega = f"{margin.frequency:.6g}" if margin.is_reached else ""
        there = f"{margin.radius_at:.12f}" if margin.is_reached else ""
        rows.append(cells(label, f"{margin.value:.6g}{unit}", omega, there))
        record[label.replace(" ", "_")] = {
            "value": margin.value,
            "omega": margin.frequency,
            "is_reached": margin.is_reached,
            "radius_before": margin.radius_before,
            "radius_at": margin.radius_at,
            "radius_after": margin.radius_after,
        }
    record["delay_time"] = margins.delay_time
    disk = margins.disk
    record["disk"] = disk_record(disk)
    if disk is None:
        return Section("Margins", (SheetTable(HEADS, tuple(rows)),), whole, remark)
    low, high = disk.gain
    rows.append(
        cells(
            "disk, S - T",
            f"{disk.alpha:.6g}: {low:.4g} to {high:.4g}, {disk.phase:.4g} deg",
            f"{disk.frequency:.6g}",
            "" if isnan(disk.radius_at) else f"{disk.radius_at:.12f}",
        )
    )
    peaks = (
        f"peaks: |S| {disk.S_peak:.4g} at {disk.S_frequency:.4g}, |T| {disk.T_peak:.4g} at "
        f"{disk.T_frequency:.4g} rad/sample"
    )
    return Section("Margins", (SheetTable(HEADS, tuple(rows)), Text(peaks)), whole, remark)


def margins_sheet(margins: Margins) -> Sheet:
    """The report of the margins of one loop."""
    return Sheet("", sections=(margins_section("u", margins),))


def disk_record(disk: DiskMargin | None) -> dict[str, Any] | None:
    """A disk margin as a record."""
    if disk is None:
        return None
    return {
        part.name.replace("frequency", "omega"): getattr(disk, part.name) for part in fields(disk)
    }


def _boundaries(margins: Margins) -> list[tuple[str, StabilityBoundary, str]]:
    """Name, boundary and unit of each margin of a stable loop."""
    assert margins.gain_up is not None
    assert margins.gain_down is not None
    assert margins.phase_lag is not None
    assert margins.phase_lead is not None
    assert margins.delay is not None
    seconds = "" if margins.delay_time is None else f" = {margins.delay_time:.6g} s"
    return [
        ("gain up", margins.gain_up, ""),
        ("gain down", margins.gain_down, ""),
        ("phase lag", margins.phase_lag, " deg"),
        ("phase lead", margins.phase_lead, " deg"),
        ("delay", margins.delay, f" steps{seconds}"),
    ]
