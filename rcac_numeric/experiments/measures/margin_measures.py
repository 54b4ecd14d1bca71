"""The measures of how far a frozen loop is from instability, and of loops after a change."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from rcac_numeric.analysis.closed_loop import frozen_loop
from rcac_numeric.arrays.validation import integer, one_of
from rcac_numeric.experiments.measures.loop_analysis import LoopAnalysis
from rcac_numeric.margins.boundaries import (
    StabilityBoundary,
    delay_boundary,
    gain_boundary,
    nowhere,
    phase_boundary,
)
from rcac_numeric.margins.crossovers import gain_crossovers, phase_crossovers
from rcac_numeric.margins.opened_loop import broken_loop

MarginKind = Literal["gain up", "gain down", "phase lag", "phase lead", "delay"]
MARGINS: tuple[str, ...] = get_args(MarginKind)


def margin(r: LoopAnalysis, kind: MarginKind = "gain up") -> float:
    """A stability margin of the loop with the final controller; not a number if it is unstable.

    Parameters
    ----------
    kind : {"gain up", "gain down", "phase lag", "phase lead", "delay"}
        Factor of the gain, degrees of phase, or steps of delay at which stability is lost.
    """
    return _boundary(r, kind).value


def margin_frequency(r: LoopAnalysis, kind: MarginKind = "gain up") -> float:
    """Frequency in rad/sample at which the loop loses stability at that margin."""
    return _boundary(r, kind).omega


def frozen_spectral_radius(r: LoopAnalysis, at: int) -> float:
    """Largest modulus of a pole of the plant of a step in a loop with the theta of that step.

    Where the plant changes at that step, it is the new plant with what was adapted to the old one.

    Parameters
    ----------
    at : int
        A step at which theta was kept.
    """
    run = r.run
    return frozen_loop(run.plant, run.compensator_at(at), at).spectral_radius


def stable_from(r: LoopAnalysis, start: int = 0) -> float:
    """First kept step from which the loop, frozen at theta(k), is stable to the end of the run.

    Infinity where it is unstable at the last one; steps before `start` do not count.
    """
    run = r.run
    if run.outcome != "completed":
        return float("inf")
    first = -(-integer(start, "start") // run.stride)
    found = float("inf")
    for row in reversed(range(first, len(run.theta))):
        k = row * run.stride
        if not frozen_loop(run.plant, run.settings.compensator_of(run.theta[row]), k).is_stable:
            break
        found = float(k)
    return found


def _boundary(r: LoopAnalysis, kind: str) -> StabilityBoundary:
    one_of(kind, "kind", MARGINS)
    opened = broken_loop(r.loop, at="u", channel=0, feedback=None)
    if not opened.is_stable:
        return nowhere(np.nan)
    if kind.startswith("gain"):
        return gain_boundary(opened, phase_crossovers(opened), up=kind == "gain up")
    crossovers = gain_crossovers(opened)
    if kind == "delay":
        return delay_boundary(opened, crossovers)
    return phase_boundary(opened, crossovers, lead=kind == "phase lead")


MARGIN_MEASURES = (margin, margin_frequency, frozen_spectral_radius, stable_from)
