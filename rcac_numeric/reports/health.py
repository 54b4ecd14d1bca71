"""The health of a loop as the first lines of a report, and as its entry in the record."""

from __future__ import annotations

from typing import Any

from rcac_numeric.health.health import LoopHealth
from rcac_numeric.health.margin_words import margin_words
from rcac_numeric.health.signals import SignalHealth, SignalSize
from rcac_numeric.margins.classical import Margins
from rcac_numeric.reports.sheets.sheet import Level, Sheet, Text


def health_lines(health: LoopHealth) -> tuple[Text, ...]:
    """Stability, every warning with its mend, then sizes of signals, margins and excitation.

    Examples
    --------
    >>> from rcac_numeric import loop_health, verify
    >>> from rcac_numeric.dissertation import load_example
    >>> from rcac_numeric.reports.health import health_lines
    >>> for line in health_lines(loop_health(verify(load_example("4.7")))):
    ...     print(line.words[:46])
    The closed loop is stable, spectral radius 0.8
    Warning (small margins): The margins are small
    z: peak 19.2, rms 16.2 before control; peak 63
    u: peak 107, rms 25.9 under control; rms 1 at
    margins: gain 0.967 to 1.04 (-0.29 to 0.35 dB)
    adaptation: the data outweigh R_theta in 8 of
    """
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
    if health.bounded:
        steps = f"{health.bounded} of {health.steps} steps"
        lines.append(Text(f"bounds: theta was moved to its bounds in {steps}"))
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
    if not health.is_stable:
        return Text(f"The closed loop is UNSTABLE, spectral radius {radius:.9g}.", "bad")
    words = f"The closed loop is stable, spectral radius {radius:.9g}."
    return Text(words, "good" if health.is_healthy else "warning")


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
