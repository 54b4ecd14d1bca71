"""The measures of what RCAC fits: the intercalated transfer function, and what is left over."""

from __future__ import annotations

import numpy as np

from rcac_numeric.experiments.measures.loop_analysis import LoopAnalysis


def worst_match(r: LoopAnalysis) -> float:
    """Largest relative distance of the intercalated transfer function to G_f over frequency."""
    return r.match.worst


def median_match(r: LoopAnalysis) -> float:
    """Median relative distance of the intercalated transfer function to G_f over frequency."""
    return r.match.median


def match_change(r: LoopAnalysis, since: int) -> float:
    """The median match over the one of theta(since); below 1 where it has come nearer.

    Parameters
    ----------
    since : int
        An earlier step at which theta was kept.
    """
    return r.match.median / r.until(since).match.median


def matching_error_share(r: LoopAnalysis, start: int = 0) -> float:
    """Mean square of (G~zu~ - G_f) u~ over that of the rest of the residual (4.14), G~zw w.

    From an initial state the rest holds the response to it too.

    Parameters
    ----------
    start : int
        First step that counts.
    """
    split = r.split
    error = split.matching_error[start:]
    rest = (split.residual - split.matching_error)[start:]
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        return float(np.divide(np.sum(error**2), np.sum(rest**2)))


MATCH_MEASURES = (worst_match, median_match, match_change, matching_error_share)
