"""The health of a loop as the first lines of a report, and as its entry in the record."""

from __future__ import annotations

from typing import Any

import numpy as np

from rcac_numeric.health.health import LoopHealth
from rcac_numeric.health.signals import SignalHealth, SignalSize
from rcac_numeric.margins.classical import Margins
from rcac_numeric.reports.sheets.sheet import Level, Sheet, Text


def health_lines(health: LoopHealth) -> tuple[Text, ...]:
    """Stability, every warning with its mend, then sizes of signals, margins and excitation."""
    lines = [_stability(health)]
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
            lines.append(Text(f"margins{at}: {margin_words(margins)}"))
    if health.excitation is not None:
        guard = "no update was decided by rounding"
        if health.guard_count:
            guard = f"{health.guard_count} updates were decided by rounding"
        lines.append(Text(f"adaptation: {health.excitation}; {guard}"))
    if health.cost_ratio is not None:
        lines.append(
            Text(f"cost: {health.cost_ratio:.4g} times that of LQG for the noise of the run")
        )
    if health.supervision is not None and health.supervision.troubles:
        lines.append(Text(f"supervision: {health.supervision}"))
    if health.bounded:
        steps = f"{health.bounded} of {health.steps} steps"
        words = f"bounds: theta was moved to its bounds in {steps}"
        if health.is_held and health.missed_by is not None:
            words += (
                f"; they decide where the poles are, up to {health.missed_by:.2g} from those of "
                "the target model"
            )
        lines.append(Text(words))
    return tuple(lines)


def health_sheet(health: LoopHealth) -> Sheet:
    """The lines of the health as a report of their own."""
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
        "margins": {name: _margins(found) for name, found in health.margins.items()},
        "updates_decided_by_rounding": health.guard_count,
        "updates_moved_to_bounds": health.bounded,
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


def _stability(health: LoopHealth) -> Text:
    radius = health.spectral_radius
    if health.is_stable is None:
        return Text(f"Whether the loop is stable is not known: {health.obstacle}.", "warning")
    assert radius is not None, "the loop is known"
    return stability_line(health.is_stable, radius, "good" if health.is_healthy else "warning")


def stability_line(is_stable: bool, radius: float, level: Level = "good") -> Text:
    """Whether a loop is stable, the first line of its report."""
    if not is_stable:
        return Text(f"The closed loop is UNSTABLE, spectral radius {radius:.9g}.", "bad")
    return Text(f"The closed loop is stable, spectral radius {radius:.9g}.", level)


def _signal(signal: SignalHealth) -> dict[str, Any]:
    return {name: _size(getattr(signal, name)) for name in ("before", "after", "late")}


def _size(size: SignalSize | None) -> dict[str, float] | None:
    return None if size is None else {"peak": size.peak, "rms": size.rms}


def _margins(margins: Margins) -> dict[str, Any]:
    found = {
        "gain_up": margins.gain_up, "gain_down": margins.gain_down, "phase": margins.phase,
        "delay": margins.delay,
    }  # fmt: skip
    return {name: None if b is None else b.value for name, b in found.items()}


def margin_words(margins: Margins) -> str:
    """Gain, phase and delay margin in one line.

    Examples
    --------
    >>> from rcac_numeric import ClosedLoop, Compensator, stability_margins, standard_plant
    >>> from rcac_numeric.reports.health import margin_words
    >>> loop = ClosedLoop(
    ...     standard_plant("1/(q - 2)"), Compensator(past_u=[[[-1.0]]], past_y=[[[0.0]], [[-2.5]]]))
    >>> margin_words(stability_margins(loop))
    'gain 0.8 to 1.2 (-1.9 to 1.6 dB), phase 8.43 deg, delay 0.242 steps'
    """
    if not margins.is_stable:
        return "none: the loop is unstable"
    assert margins.gain_up and margins.gain_down and margins.phase and margins.delay
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
