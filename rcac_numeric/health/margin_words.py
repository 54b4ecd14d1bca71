"""The margins of a loop in one line, and which of them are small."""

from __future__ import annotations

import numpy as np

from rcac_numeric.margins.classical import Margins

# 3 dB, 20 degrees: half of what textbooks ask for (6 dB, 30 to 60 degrees).
LEAST_GAIN, LEAST_PHASE = 2**0.5, 20.0


def margin_words(margins: Margins) -> str:
    """Gain, phase and delay margin in one line.

    Examples
    --------
    >>> from rcac_numeric import ClosedLoop, Compensator, stability_margins, standard_plant
    >>> from rcac_numeric.health.margin_words import margin_words
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


def small_margins(margins: Margins) -> list[str]:
    """The margins of a stable loop that are below 3 dB or 20 degrees, in words."""
    if not margins.is_stable:
        return []
    assert margins.gain_up and margins.gain_down and margins.phase
    words = []
    if margins.gain_up.value < LEAST_GAIN:
        words.append(f"{margins.gain_up.value:.3g} times the gain is unstable")
    if margins.gain_down.value > 1 / LEAST_GAIN:
        words.append(f"{margins.gain_down.value:.3g} times the gain is unstable")
    if margins.phase.value < LEAST_PHASE:
        words.append(f"{margins.phase.value:.3g} degrees of phase are left")
    return words


def _decibel(gain: float) -> str:
    with np.errstate(divide="ignore"):
        return f"{20 * np.log10(gain):.2g}".replace("inf", "infinity")
