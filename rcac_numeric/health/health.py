"""The health of a loop as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rcac_numeric.arrays.showing import notebook_of, sheet_of
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.supervision import SupervisionRecord
from rcac_numeric.health.excitation import Excitation
from rcac_numeric.health.signals import SignalHealth, SignalSize
from rcac_numeric.health.trials import NextDisturbance
from rcac_numeric.margins.classical import Margins

HELD = 0.1  # share of the steps in which bounds moved theta


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


@dataclass(frozen=True, eq=False)
class LoopHealth(Value):
    """Whether a loop is healthy, and the evidence.

    Attributes
    ----------
    is_stable : bool or None
        Of the final controller, frozen, with the plant of the last step; None where no linear
        plant is known.
    spectral_radius : float or None
    outcome : str
        How the run ended; empty for a log.
    steps, k_w : int
        Number of steps, and the first one with control.
    signals : mapping from "z", "u" and, behind a saturation, "u_applied" to SignalHealth
    free : SignalSize or None
        z of the same run with u = 0, where that is bounded.
    margins : mapping from components of u to Margins
    guard_count, guard_first_step : int
        Updates decided by rounding, and the first of them (-1: none).
    bounded : int
        Updates after which theta was moved to its bounds.
    excitation : Excitation or None
    warnings : tuple of HealthWarning
        The grave ones first.
    obstacle : str
        Why there is no verdict on stability.
    supervision : SupervisionRecord or None
        What was noted while it ran.
    next_disturbance : NextDisturbance or None
        How far z goes where w moves again, beside the same with theta held.
    missed_by : float or None
        The largest distance of a pole that was asked for from the one that was reached.
    cost_ratio : float or None
        The cost of the final controller over that of LQG, for the noise of the run.

    Examples
    --------
    >>> from rcac_numeric import loop_health, verify
    >>> from rcac_numeric.dissertation import load_example
    >>> health = loop_health(verify(load_example("4.7")))
    >>> health.is_stable, round(health.margins["u"].gain_up.value, 3)
    (True, 1.041)
    >>> [warning.code for warning in health.warnings]
    ['small margins']
    """

    is_stable: bool | None
    spectral_radius: float | None
    outcome: str
    steps: int
    k_w: int
    signals: Mapping[str, SignalHealth]
    free: SignalSize | None = None
    margins: Mapping[str, Margins] = field(default_factory=dict)
    guard_count: int = 0
    guard_first_step: int = -1
    bounded: int = 0
    excitation: Excitation | None = None
    warnings: tuple[HealthWarning, ...] = ()
    obstacle: str = ""
    supervision: SupervisionRecord | None = None
    next_disturbance: NextDisturbance | None = None
    missed_by: float | None = None
    cost_ratio: float | None = None

    @property
    def is_held(self) -> bool:
        """Whether bounds moved theta in a tenth of the steps, and so decide where poles are."""
        return self.bounded > HELD * self.steps

    @property
    def is_healthy(self) -> bool:
        """Whether there is no warning."""
        return not self.warnings

    def report(self) -> str:
        """The health in words and numbers, a line for each."""
        return "\n".join(line.words for line in sheet_of(self).health)

    def _repr_html_(self) -> str:
        """What a notebook shows: the lines of the report, the warnings in colour."""
        return notebook_of(self)

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        codes = ", ".join(warning.code for warning in self.warnings) or "no warning"
        return f"LoopHealth(is_stable={self.is_stable}, steps={self.steps}, {codes})"
