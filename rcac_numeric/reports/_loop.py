"""Reports of a closed loop: health, exact prediction, match with G_f, split residual."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

import compensator_theory as exact
from rcac_numeric.analysis._certified_tail import CertifiedTail
from rcac_numeric.analysis._classical import Margins
from rcac_numeric.analysis._closed_loop import OTHER_SIGN
from rcac_numeric.analysis._exact_comparison import NEAR, REACHED, ExactComparison
from rcac_numeric.analysis._loop_analysis import LoopAnalysis, attempted
from rcac_numeric.analysis._match import IntercalatedMatch, ResidualSplit
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.checks._diagnosis import loop_health
from rcac_numeric.checks._health import LoopHealth, SignalHealth, SignalSize
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._functions import FunctionPlant
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.reports._certified import proof_lines, proof_obstacle, tail_record
from rcac_numeric.reports._sheet import (
    Block,
    Fact,
    Level,
    Section,
    Sheet,
    SheetTable,
    Text,
    cells,
    complex_list,
    complex_text,
    counted,
    exact_text,
    power_text,
    rounded,
)

# Backward errors: below the first the report says "reached" alone, above the second it warns.
EXACTLY, NEARLY = 1e-3, 1e-2


LOOP = "The closed loop"


def health_lines(health: LoopHealth, subject: str = LOOP) -> tuple[Text, ...]:
    """Return the lines on stability, warnings with remedies, signal sizes, margins, excitation.

    `subject` says of which loop stability and margins are.
    """
    lines = [_stability(health, subject)]
    for warning in health.warnings:
        level: Level = "bad" if warning.is_grave else "warning"
        lines.append(Text(f"Warning ({warning.code}): {warning}", level))
    for name, signal in health.signals.items():
        words = f"{name}: {signal}"
        if name == "z" and health.free is not None:
            words += f" ({health.free.rms:.3g} with u = 0)"
        lines.append(Text(words))
    for name, margins in health.margins.items():
        at = "" if len(health.margins) == 1 else f" at {name}"
        if margins.is_stable:
            owner = "" if subject == LOOP else " of that loop"
            lines.append(Text(f"margins{owner}{at}: {margin_words(margins)}"))
    if health.excitation is not None:
        guard = "no numerical problems"
        if health.guard_count:
            guard = f"rounding decided {counted(health.guard_count, 'update')}"
        lines.append(Text(f"excitation: {health.excitation}; {guard}"))
    if health.cost_ratio is not None:
        lines.append(
            Text(f"cost: {health.cost_ratio:.4g} times the LQG cost, for the noise of the run")
        )
    if health.supervision is not None and health.supervision.troubles:
        lines.append(Text(f"supervision: {health.supervision}"))
    if health.bounded:
        steps = f"{health.bounded} of {health.steps} steps"
        words = f"bounds: theta was limited in {steps}"
        if health.is_held and health.missed_by is not None:
            words += (
                f"; the bounds decide the poles, which are up to {health.missed_by:.2g} from those "
                "of the target model"
            )
        lines.append(Text(words))
    if health.radius is not None:
        share = f"{100 * health.radius:.3g} % of the radius of CertifiedBounds"
        words = f"bounds: theta used {share}"
        if "u_applied" in health.signals:
            words += "; the actuator did not apply u everywhere, which no certificate covers"
        lines.append(Text(words))
    return tuple(lines)


def health_sheet(health: LoopHealth) -> Sheet:
    """The report of a loop's health."""
    return Sheet("Health of the loop", health=health_lines(health))


def health_record(health: LoopHealth) -> dict[str, Any]:
    """The entries "health" and "warnings" of a record."""
    record = {
        "is_stable": health.is_stable,
        "spectral_radius": health.spectral_radius,
        "obstacle": health.obstacle or None,
        "outcome": health.outcome or None,
        "steps": health.steps,
        "k_w": health.k_w,
        "signals": {name: _signal(signal) for name, signal in health.signals.items()},
        "without_control": _size(health.free),
        "margins": {name: _margins(margins) for name, margins in health.margins.items()},
        "updates_decided_by_rounding": health.guard_count,
        "updates_moved_to_bounds": health.bounded,
        "radius_of_bounds": health.radius,
        "missed_by": health.missed_by,
        "cost_over_lqg": health.cost_ratio,
        "next_disturbance": health.next_disturbance and {
            "adapting": health.next_disturbance.adapting,
            "frozen": health.next_disturbance.frozen,
        },
        "supervision": None if health.supervision is None else str(health.supervision),
        "excitation": health.excitation and {
            "l_theta": health.excitation.l_theta,
            "outweighed": health.excitation.outweighed,
            "excited": health.excitation.excited,
        },
    }  # fmt: skip
    warnings = [
        {"code": w.code, "sentence": w.sentence, "next_step": w.next_step, "is_grave": w.is_grave}
        for w in health.warnings
    ]
    return {"health": record, "warnings": warnings}


def _stability(health: LoopHealth, subject: str) -> Text:
    radius = health.spectral_radius
    if health.is_stable is None:
        return Text(f"Stability of the closed loop is unknown: {health.obstacle}.", "warning")
    assert radius is not None, "the loop is known"
    level: Level = "good" if health.is_healthy and subject == LOOP else "warning"
    return stability_line(health.is_stable, radius, level, subject)


def stability_line(
    is_stable: bool, radius: float, level: Level = "good", subject: str = LOOP
) -> Text:
    """The verdict on stability, the first line of a loop's report."""
    if not is_stable:
        return Text(f"{subject} is UNSTABLE, spectral radius {radius_text(radius)}.", "bad")
    return Text(f"{subject} is stable, spectral radius {radius_text(radius)}.", level)


def radius_text(radius: float) -> str:
    """A spectral radius in four significant digits; its distance from 1 where those round to 1."""
    text = f"{radius:.4g}"
    if text != "1" or radius == 1:
        return text
    return f"1 {'-' if radius < 1 else '+'} {abs(1 - radius):.2g}"


def _signal(signal: SignalHealth) -> dict[str, Any]:
    return {name: _size(getattr(signal, name)) for name in ("before", "after", "late")}


def _size(size: SignalSize | None) -> dict[str, float] | None:
    return None if size is None else {"peak": size.peak, "rms": size.rms}


def _margins(margins: Margins) -> dict[str, Any]:
    record = {
        "gain_up": margins.gain_up, "gain_down": margins.gain_down, "phase": margins.phase,
        "delay": margins.delay,
    }  # fmt: skip
    return {name: None if b is None else b.value for name, b in record.items()}


def margin_words(margins: Margins) -> str:
    """The gain, phase and delay margin in one line."""
    if not margins.is_stable:
        return "none: the loop is unstable"
    assert margins.gain_up is not None
    assert margins.gain_down is not None
    assert margins.phase is not None
    assert margins.delay is not None
    low, high = margins.gain_down.value, margins.gain_up.value
    delay = f"{margins.delay.value:.3g} steps" if np.isfinite(margins.delay.value) else "any"
    phase = f"{margins.phase.value:.3g} deg" if np.isfinite(margins.phase.value) else "any"
    if margins.delay_time is not None and np.isfinite(margins.delay_time):
        delay += f" = {margins.delay_time:.3g} s"
    gain = f"{low:.3g} to {high:.3g} ({_decibel(low)} to {_decibel(high)} dB)"
    return f"gain {gain}, phase {phase}, delay {delay}"


def _decibel(gain: float) -> str:
    with np.errstate(divide="ignore"):
        return f"{20 * np.log10(gain):.2g}".replace("inf", "infinity")


def match_section(match: IntercalatedMatch | None, reason: str) -> Section:
    """The match of the intercalated transfer function with G_f."""
    if match is None:
        words = f"Match of the intercalated transfer function with G_f: not evaluated: {reason}."
        return Section(blocks=(Text(words),), record={"match": None})
    words = (
        "intercalated transfer function against G_f: largest relative error "
        f"{match.worst:.3g}, median {match.median:.3g}"
    )
    record = {"match": {"worst": match.worst, "median": match.median}}
    return Section(blocks=(Text(words),), record=record)


def split_section(split: ResidualSplit | None, reason: str, is_stable: bool) -> Section:
    """The mean squares of the residual and its parts; identity (4.14) if the loop is stable."""
    if split is None:
        words = f"Split of the residual (4.14): not evaluated: {reason}."
        return Section(blocks=(Text(words),), record={"residual": None})
    power = split.power()
    facts = [Text(f"mean squares of the split residual: {power_text(power)}")]
    record: dict[str, float] = dict(power)
    if is_stable:
        record["identity_error"] = split.identity_error
        facts.append(Text(f"identity (4.14) holds to {split.identity_error:.1e}"))
    return Section(blocks=tuple(facts), record={"residual": record})


def fitted_section(D_f: Array | None) -> Section:
    """The target denominator D_f that was fitted together with theta; empty if there is none."""
    if D_f is None:
        return Section()
    terms = [f"{d:+.6g} q^-{i}" for i, d in enumerate(D_f[1:], 1)]
    radius = float(np.abs(np.roots(D_f)).max(initial=0.0))
    words = " ".join(["1", *terms]) + f"; spectral radius {radius:.6g}"
    record = {"D_f": D_f.tolist(), "D_f_spectral_radius": radius}
    return Section(blocks=(Fact("D_f, fitted with theta", words),), record=record)


def joined(title: str, *sections: Section, remark: str = "") -> Section:
    """Join several sections under one title."""
    record: dict[str, object] = {}
    for section in sections:
        record |= section.record
    blocks = tuple(block for section in sections for block in section.blocks)
    return Section(title, blocks, record, remark)


def zeros_facts(zeros: dict[str, str]) -> tuple[Fact, ...]:
    """The zeros from each channel of w to z."""
    return tuple(Fact(f"zeros from {channel} to z", words) for channel, words in zeros.items())


def missed_poles(c: ExactComparison | None, structure: Structure | None = None) -> tuple[Text, ...]:
    """The first line of a report if target poles are missed.

    `ExactComparison.is_reached` decides. Poles that no theta of the structure can place are a
    warning, not a failure of the run. Poles that are reached with a visible error are reported with
    that error.
    """
    if c is None:
        return ()
    if not (missed := c.missed):
        return _nearly_reached(c)
    words = ", ".join(
        f"{complex_list([a])} by {abs(a - b):.2g} (closed loop: {complex_list([b])})"
        for a, b in missed[:4]
    )
    more = f" and {len(missed) - 4} more" if len(missed) > 4 else ""
    count = f"{len(missed)} of {len(c.judged)} target poles"
    if structure is not None and c.can_be_placed_by(structure) is False:
        why = (
            f"The {structure.l_theta} coefficients of structure {structure.name} cannot place the "
            f"{len(c.poles)} target poles: "
        )
        return (Text(f"{why}{count} are missed, {words}{more}.", "warning"),)
    changed = f"Backward error of the closed-loop polynomial: {c.backward_error:.2g}"
    return (Text(f"NOT reached: {count} are missed, {words}{more}. {changed}.", "bad"),)


def poles_and_health(poles: Iterable[Text], health: Iterable[Text]) -> tuple[Text, ...]:
    """Put the verdict on the poles before the health, but after the line of an unstable loop."""
    first, *rest = health
    return (first, *poles, *rest) if first.level == "bad" else (*poles, first, *rest)


def _nearly_reached(c: ExactComparison) -> tuple[Text, ...]:
    """The backward error of poles that are reached, if it is more than rounding."""
    if not c.target_poles.any() or not c.judged or c.backward_error <= EXACTLY:
        return ()
    requested, reached = max(c.judged, key=lambda pair: abs(pair[0] - pair[1]))
    off, change = abs(requested - reached), 100 * c.backward_error
    passes = (
        f"up to {100 * REACHED:g} % counts as reached"
        if c.backward_error <= REACHED
        else f"poles count as reached if their error is at most {NEAR:g}"
    )
    words = (
        f"Target poles reached; the closed-loop polynomial has a backward error of {change:.2g} % "
        f"at the worst frequency ({passes}). Largest pole error "
        f"{off:.2g}, at {complex_list([requested])} (closed loop: {complex_list([reached])})."
    )
    return (Text(words, "warning" if c.backward_error > NEARLY else "plain"),)


def poles_reached(run: Run, health: LoopHealth) -> tuple[Text, ...]:
    """The pole error of a run's final controller, if the target poles are reached."""
    analysis = LoopAnalysis(run)
    comparison = None if health.is_held or analysis.obstacle else _or_none(analysis)
    return () if comparison is None or comparison.missed else missed_poles(comparison)


def reached_facts(c: ExactComparison) -> tuple[Fact, ...]:
    """The backward error of the poles, and the sensitivity of a multiple pole."""
    if not c.target_poles.any():
        return ()
    words = (
        f"{c.backward_error:.3g} of the closed-loop polynomial at the worst frequency (up to "
        f"{REACHED:g} counts as reached)"
    )
    facts = [Fact("backward error", words)]
    if (sensitive := c.sensitivity()) is not None and sensitive[2] > NEAR:
        pole, m, moved = sensitive
        words = (
            f"a {m}-fold pole at {complex_text(pole)} moves by {moved:.2g} if the coefficients "
            "change by 1e-9 of their size; its distance is no evidence"
        )
        facts.append(Fact("sensitivity", words))
    return tuple(facts)


def comparison_section(c: ExactComparison) -> Section:
    """The coefficients, poles and zeros of the closed loop, and their targets."""
    blocks: list[Block] = [
        Text("Characteristic polynomial D D_c - N_yu N_c:"),
        _polynomial(c),
    ]
    if c.requested is None:
        blocks.append(Text(f"Exact prediction not evaluated: {c.obstacle}", "warning"))
    pairs = tuple(
        cells(complex_text(requested), complex_text(pole), f"{abs(requested - pole):.2e}")
        for requested, pole in c.assigned
    )
    blocks.append(SheetTable(("pole of G_f", "closed-loop pole", "distance"), pairs))
    blocks.append(Fact("other closed-loop poles", complex_list(c.unassigned)))
    blocks += zeros_facts({channel: complex_list(zeros) for channel, zeros in c.zeros.items()})
    blocks.append(Fact("largest pole distance", f"{c.worst_distance:.3g}"))
    blocks += reached_facts(c)
    if c.compensators is not None:
        free = len(c.compensators.homogeneous)
        family = "the only compensator" if not free else f"the {free}-parameter family"
        far = f"{c.controller_distance:.3g}"
        words = f"distance of (D_c, N_c) to {family} with this polynomial: {far}"
        blocks.append(Text(words))
    record = {
        "poles": c.poles,
        "requested_poles": c.requested_poles,
        "zeros": c.zeros,
        "characteristic_polynomial": {
            "requested": None
            if c.requested is None
            else [str(v) for v in c.requested.all_coeffs()],
            "reached": [rounded(v) for v in c.reached.all_coeffs()],
            "obstacle": c.obstacle or None,
        },
        "worst_pole_distance": c.worst_distance,
        "backward_error": c.backward_error,
        "is_reached": c.is_reached,
        "controller_distance": c.controller_distance,
    }
    return Section(blocks=tuple(blocks), record=record)


def comparison_sheet(c: ExactComparison) -> Sheet:
    """The report of a closed loop and its exact prediction."""
    radius = float(np.abs(c.poles).max(initial=0.0))
    is_stable = bool(exact.decide_stability(c.reached, time="discrete").is_stable)
    health = poles_and_health(missed_poles(c), [stability_line(is_stable, radius)])
    return Sheet(
        "Closed loop and exact prediction", health=health, sections=(comparison_section(c),)
    )


def analysis_sheet(analysis: LoopAnalysis) -> Sheet:
    """The report of a run's final loop, or of a plant and a compensator."""
    if isinstance(analysis.of, Run):
        remark = f": {analysis.of.outcome} after {analysis.of.steps} steps"
        missed = () if analysis.obstacle else missed_poles(_or_none(analysis), analysis.structure)
        health = poles_and_health(missed, health_lines(loop_health(analysis)))
        health += proof_of_run(analysis)[0]
    else:
        remark = ""
        loop = analysis.loop
        health = (stability_line(loop.is_stable, loop.spectral_radius),)
        if not loop.is_stable and loop.has_stable_opposite:
            health += (Text(OTHER_SIGN.strip(), "warning"),)
    return Sheet("Closed loop", remark, health, (loop_section(analysis),))


def proof_of_run(analysis: LoopAnalysis) -> tuple[tuple[Text, ...], dict[str, Any]]:
    """The first step from which a run of one adaptive controller is proved stable: lines, record.

    Nothing where the last loop is unstable, as the first line says.
    """
    run = analysis.of
    if not isinstance(run, Run) or not isinstance(run.settings, ControllerSettings):
        return (), {}
    if isinstance(run.plant, FunctionPlant) or not analysis.loop.is_stable:
        return (), {}
    plants = len(run.plant.changes) if isinstance(run.plant, PlantSchedule) else 1
    tail: CertifiedTail | None = None
    if not (reason := proof_obstacle(run.settings.l_theta, plants)):
        tail, reason = attempted(lambda: analysis.certified)
    if tail is None:
        return proof_lines(reason), {"certified_from": {"k0": None, "reason": reason}}
    return proof_lines(tail), {"certified_from": tail_record(tail)}


def _or_none(analysis: LoopAnalysis) -> ExactComparison | None:
    return attempted(lambda: analysis.comparison)[0]


def loop_section(analysis: LoopAnalysis, title: str = "", remark: str = "") -> Section:
    """The exact prediction, the match with G_f and the split residual, or the obstacle of each."""
    parts = []
    run = analysis.of if isinstance(analysis.of, Run) else None
    if run is not None and run.saturation is not None:
        words = "The results below are for the linear loop, without the saturation."
        parts.append(Section(blocks=(Text(words, "warning"),)))
    comparison, obstacle = attempted(lambda: analysis.comparison)
    if comparison is not None:
        parts.append(comparison_section(comparison))
    else:
        parts.append(poles_section(analysis, analysis.obstacle or obstacle))
    match, reason = attempted(lambda: analysis.match)
    parts.append(match_section(match, reason))
    if run is not None:
        split, reason = attempted(lambda: analysis.split)
        parts += [split_section(split, reason, analysis.loop.is_stable), _guard(run)]
        parts.append(Section(record=proof_of_run(analysis)[1]))
        parts.append(fitted_section(run.D_f))
    return joined(title, *parts, remark=remark)


def _guard(run: Run) -> Section:
    if not run.guard_count:
        return Section()
    words = (
        f"Rounding decided {counted(run.guard_count, 'update')}, the first at step "
        f"{run.guard_first_step}: R_theta is too small for these data. Use a larger R_theta."
    )
    return Section(blocks=(Text(words, "warning"),))


def _polynomial(c: ExactComparison) -> SheetTable:
    rows = []
    for power in range(c.reached.degree(), -1, -1):
        reached = c.reached.nth(power)
        row = [str(power), "", f"{rounded(reached):.12g}", ""]
        if c.requested is not None:
            requested = c.requested.nth(power)
            row[1], row[3] = exact_text(requested), f"{rounded(reached - requested):.1e}"
        rows.append(cells(*row))
    return SheetTable(("power of q", "target, exact", "closed loop", "difference"), tuple(rows))


def poles_section(analysis: LoopAnalysis, obstacle: str) -> Section:
    """The poles and zeros in float64, if the exact comparison does not apply."""
    poles = analysis.loop.poles()
    blocks: list[Block] = [
        Text(f"Exact comparison not evaluated: {obstacle}.", "warning"),
        Fact("closed-loop poles", complex_list(poles)),
        Fact("controller poles", complex_list(analysis.compensator.poles())),
    ]
    if analysis.plant.l_z == 1:
        zeros = {channel: complex_list(values) for channel, values in analysis.zeros.items()}
        blocks += zeros_facts(zeros)
    return Section(blocks=tuple(blocks), record={"obstacle": obstacle, "poles": poles})


def run_sheet(run: Run) -> Sheet:
    """The report of a run: its outcome and the health of its loop."""
    remark = f": {run.outcome} after {run.steps} steps"
    return Sheet("Run", remark, health_lines(loop_health(run)))
