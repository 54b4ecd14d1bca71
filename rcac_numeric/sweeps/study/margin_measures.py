"""The measures of how far the final loop is from instability; no number where it is unstable."""

from __future__ import annotations

import math

from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
from rcac_numeric.margins.boundaries import StabilityBoundary
from rcac_numeric.margins.classical import Margins, stability_margins


def gain_margin(r: AnalysedRun) -> float:
    """Least factor above 1 of the loop gain at which the final loop is no longer stable."""
    return _value(_margins(r).gain_up)


def phase_margin(r: AnalysedRun) -> float:
    """Least turn of the loop's phase, in degrees, at which the final loop is no longer stable."""
    return _value(_margins(r).phase)


def delay_margin(r: AnalysedRun) -> float:
    """Least additional delay, in steps, at which the final loop is no longer stable."""
    return _value(_margins(r).delay)


def disk_margin(r: AnalysedRun) -> float:
    """The disk margin alpha of the final loop: gain and phase varied together."""
    disk = _margins(r).disk
    return math.nan if disk is None else disk.alpha


def _margins(r: AnalysedRun) -> Margins:
    return stability_margins(r.loop)


def _value(boundary: StabilityBoundary | None) -> float:
    return math.nan if boundary is None else float(boundary.value)


MARGIN_MEASURES = {
    measure.__name__: measure for measure in (gain_margin, phase_margin, delay_margin, disk_margin)
}
