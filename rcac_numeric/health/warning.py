"""A warning: what is wrong, and what to try next."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class HealthWarning:
    """What the reader of a report must not miss.

    Attributes
    ----------
    code : str
        Its name, for programs: "diverged", "unstable", "slow", "small margins", "large transient",
        "large control", "worse than without control", "rounding", "no excitation", "unsettled",
        "saturated", "windup", "missed poles", "costly", "wrong sign", "wrong d_zu",
        "unmodelled zero"; of several inputs and outputs "zero in every channel",
        "zero in one channel", "zero on the input side", "zero in another direction"; of
        `DataDriven` "nothing learnt", "low order", "poor excitation", "unstable start"; of a
        controller that is driven step by step "overflow", "missed samples", "stopped".
    sentence, next_step : str
        What was found, and what to try.
    is_grave : bool
        Whether the loop cannot be used as it is.

    Examples
    --------
    >>> from rcac_numeric import HealthWarning
    >>> print(HealthWarning("slow", "A pole is at 0.9999.", "run more steps"))
    A pole is at 0.9999. Try next: run more steps.
    """

    code: str
    sentence: str
    next_step: str
    is_grave: bool = False

    def __str__(self) -> str:
        return f"{self.sentence} Try next: {self.next_step}."
