"""The measures of how signals went: what settled, how large they were, how often u saturated."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import integer, one_of
from rcac_numeric.experiments.measures.loop_analysis import LoopAnalysis

SignalName = Literal["z", "y", "u", "u_applied", "w"]
SIGNALS: tuple[str, ...] = get_args(SignalName)


def settling_step(r: LoopAnalysis, band: float = 0.02) -> float:
    """First step from which the size of z stays within the band to the end of the run.

    Parameters
    ----------
    band : float
        Largest size of z.
    """
    if r.run.outcome != "completed":
        return float("inf")
    outside = np.flatnonzero(np.abs(r.run.z).max(axis=1) > band)
    return float(outside[-1] + 1) if outside.size else 0.0


def peak(
    r: LoopAnalysis,
    start: int = 0,
    stop: int | None = None,
    signal: SignalName = "z",
    channel: int | None = None,
) -> float:
    """Largest size of a signal over start <= k < stop; of one channel or of all of them.

    Parameters
    ----------
    start, stop : int
        First step that counts, and the first that does not count any more; to the end where
        `stop` is left out.
    signal : {"z", "y", "u", "u_applied", "w"}
        Which signal; u_applied is what the actuator made of u.
    channel : int or str
        A component from 0 on; for zeros the name of a channel of w.
    """
    return float(np.abs(_window(r, start, stop, signal, channel)).max())


def rms(
    r: LoopAnalysis,
    start: int = 0,
    stop: int | None = None,
    signal: SignalName = "z",
    channel: int | None = None,
) -> float:
    """Root mean square of a signal over start <= k < stop."""
    return float(np.sqrt(np.mean(np.sum(_window(r, start, stop, signal, channel) ** 2, axis=1))))


def mean(
    r: LoopAnalysis,
    start: int = 0,
    stop: int | None = None,
    signal: SignalName = "z",
    channel: int = 0,
) -> float:
    """Mean of one channel of a signal over start <= k < stop."""
    return float(np.mean(_window(r, start, stop, signal, channel)))


def saturated_fraction(r: LoopAnalysis, start: int = 0, stop: int | None = None) -> float:
    """Fraction of the steps start <= k < stop at which the actuator did not apply u as it was."""
    u, applied = (_window(r, start, stop, name, None) for name in ("u", "u_applied"))
    return float(np.mean((u != applied).any(axis=1)))


def _window(
    r: LoopAnalysis, start: int, stop: int | None, signal: str, channel: int | None
) -> np.ndarray:
    values: np.ndarray = getattr(r.run, one_of(signal, "signal", SIGNALS))
    window = values[start:stop]
    if not len(window):
        raise InputError(f"the run of {r.run.steps} steps has no step in [{start}, {stop}).")
    if channel is None:
        return window
    last = integer(channel, "channel", at_most=window.shape[1] - 1)
    return window[:, last : last + 1]


SIGNAL_MEASURES = (settling_step, peak, rms, mean, saturated_fraction)
