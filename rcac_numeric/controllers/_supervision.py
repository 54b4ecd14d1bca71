"""Supervision of a running controller: detection, policies, records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import attrs
import numpy as np

from compensator_theory._truth import Truth
from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import instance_of, integer, number, one_of, reads, with_checks
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator

# In the order of the kernel's indices.
POLICIES = ("off", "warn", "freeze", "bound", "reset", "fallback")
TROUBLES = ("windup", "large z", "saturated", "missed sample", "jump", "overflow")
ACTIONS = ("frozen", "bounded", "restored", "reset", "to fallback", "to adaptive")
WHERE_MISSED = ("hold", "fallback")


class SupervisionWarning(UserWarning):
    """The supervision of a `Controller` detected a trouble for the first time."""


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class Supervision(Value):
    """The supervision of a running controller, and its policy in case of trouble.

    P is looked at after every 16 steps: it is wound up where a variance is more than `growth` times
    what it was in P(0), with U and D of P = U D U' where d_j > growth d_j(0). Then, where abs(z)
    exceeds `limit`, and where the update leaves float64 the policy acts:

    - "warn": nothing is done but noted, the default.
    - "freeze": theta is held until `Controller.resume`.
    - "bound": P is reduced until no variance exceeds `growth` times that of P(0).
    - "reset": P becomes P(0); theta stays.
    - "fallback": the fixed compensator takes over, without a bump, until `Controller.resume`.
    - "off": nothing is noted, and an overflow or a missed sample is an error.

    In `Controller.step` a y, z or r with an entry that is not finite is a missed sample: k moves
    on, u is held (or the fallback makes it), theta waits, and the last known entries stand in the
    regressor. An update that leaves float64 there gives theta back that was held at the last look
    without trouble, with P = P(0), and the controller goes on. `simulate` reports that as the
    outcome "overflow", unless a policy was chosen that acts.

    Parameters
    ----------
    policy : {"warn", "freeze", "bound", "reset", "fallback", "off"}
    growth : float
        Of a variance over that of P(0) that counts as wound up; at least 1.
    limit : float
        Of abs(z); none by default.
    jump : float, optional
        In `Controller.step` a z that is more than so many times its running rms (over 64 steps) is
        a missed sample, five times in a row at most; none by default, since a command that steps
        does the same.
    patience : int
        Steps without a break in which the actuator did not apply u that count as saturated.
    fallback : Compensator, optional
        From [y; r] to u. Where there is one it runs along on the u that was applied.
    fade : float
        In [0, 1): what is left of a bump in u from step to step after a change of controllers.
    missed : {"hold", "fallback"}
        What makes u where y or r is not known.

    Raises
    ------
    InputError
        Where one is out of range, or the policy is a fallback without one.

    Examples
    --------
    >>> from rcac_numeric import Supervision
    >>> Supervision(policy="bound", growth=1.0)
    Supervision(policy='bound', growth=1.0, limit=inf, jump=None, patience=100, fallback=None, \
fade=0.9, missed='hold')
    """

    policy: str = attrs.field(default="warn", metadata=reads(one_of, choices=POLICIES))
    growth: float = attrs.field(default=1e6, kw_only=True, metadata=reads(number))
    limit: float = attrs.field(default=np.inf, kw_only=True)
    jump: float | None = attrs.field(
        default=None, kw_only=True, metadata=reads(number, optional=True)
    )
    patience: int = attrs.field(default=100, kw_only=True, metadata=reads(integer, at_least=1))
    fallback: Compensator | None = attrs.field(
        default=None, kw_only=True, metadata=reads(instance_of, kind=Compensator, optional=True)
    )
    fade: float = attrs.field(default=0.9, kw_only=True, metadata=reads(number))
    missed: str = attrs.field(
        default="hold", kw_only=True, metadata=reads(one_of, choices=WHERE_MISSED)
    )

    def __attrs_post_init__(self) -> None:
        if self.growth < 1:
            raise InputError(
                f"growth = {self.growth} is below 1: P would be wound up before the first step."
            )
        if self.limit != np.inf:
            object.__setattr__(self, "limit", number(self.limit, "limit"))
        for name, value in (("limit", self.limit), ("jump", self.jump)):
            if value is not None and not value > 0:
                raise InputError(f"{name} = {value} must be positive.")
        if not 0 <= self.fade < 1:
            raise InputError(f"fade = {self.fade} is not in [0, 1).")
        if self.fallback is None and "fallback" in (self.policy, self.missed):
            raise InputError(
                'the policy "fallback" needs a compensator; give fallback = Compensator(...).'
            )

    @property
    def is_on(self) -> bool:
        """Whether the supervision records troubles."""
        return self.policy != "off"

    def require_widths(self, l_u: int, l_e: int) -> None:
        """Raise unless the fallback maps [y; r] of l_e entries to u of l_u entries."""
        if self.fallback is None:
            return
        widths = self.fallback.l_y, self.fallback.l_u
        if widths != (l_e, l_u):
            raise InputError(
                f"the fallback has {widths[0]} inputs and {widths[1]} outputs; here it reads "
                f"[y; r] with {l_e} entries and makes u with {l_u}."
            )


@dataclass(frozen=True)
class TroubleCount(Truth):
    """Number and extent of the occurrences of a trouble.

    Attributes
    ----------
    steps, episodes : int
        Steps at which it was noted, and how often it began.
    first, last : int
        The first and the last of these steps.
    worst : float
        The largest value noted: of the growth of P, of abs(z), of the steps in saturation.

    Examples
    --------
    >>> from rcac_numeric.results import TroubleCount
    >>> TroubleCount(steps=12, episodes=2, first=100, last=240, worst=1.0).episodes
    2
    """

    steps: int
    episodes: int
    first: int
    last: int
    worst: float


@dataclass(frozen=True)
class SupervisionEvent(Truth):
    """The start of a trouble, or an action, with its step and value.

    Examples
    --------
    >>> from rcac_numeric.results import SupervisionEvent
    >>> print(SupervisionEvent(step=2063, kind="windup", value=1.2e6))
    step 2063: windup (1.2e+06)
    """

    step: int
    kind: str
    value: float

    def __str__(self) -> str:
        value = f" ({self.value:.3g})" if self.value else ""
        return f"step {self.step}: {self.kind}{value}"


@dataclass(frozen=True)
class SupervisionRecord(Truth):
    """The record of the supervision: troubles and actions.

    Attributes
    ----------
    troubles : mapping from names to TroubleCount
        "windup", "large z", "saturated", "missed sample", "jump", "overflow" and what was done:
        "frozen", "bounded", "restored", "reset", "to fallback", "to adaptive"; those that occurred.
    events : tuple of SupervisionEvent
        How they began, the last 64.
    growth : float
        The largest growth of a variance over P(0), at any look; 0 before the first.
    is_frozen, in_fallback : bool
        Whether theta is held by the policy, and whether the fallback makes u.
    radius : float
        With `CertifiedBounds` the largest share of the radius that theta used, at any look.

    Examples
    --------
    >>> from rcac_numeric import UD, Controller, ControllerSettings, TargetModel, iir
    >>> controller = Controller(ControllerSettings(
    ...     structure=iir(n_c=1), target=TargetModel([0, 1]), update=UD(R_theta=1)))
    >>> for y in (0.0, 1.0, float("nan"), float("nan"), 0.5):
    ...     _ = controller.step(y, y)
    >>> print(controller.record)
    missed sample once in 2 steps from 2 on
    """

    troubles: Mapping[str, TroubleCount] = field(hash=False)
    events: tuple[SupervisionEvent, ...]
    growth: float
    is_frozen: bool = False
    in_fallback: bool = False
    radius: float = 0.0

    @classmethod
    def of(cls, noted: Sequence[Any]) -> SupervisionRecord:
        """Return the record of a compiled controller."""
        counts, entries, growth, frozen, fallback, radius = noted
        if not counts:
            return cls({}, (), growth, frozen, fallback, radius)
        names = (*TROUBLES, *ACTIONS)
        counts_of = {
            name: TroubleCount(*count)
            for name, count in zip(names, counts, strict=True)
            if count[0]
        }
        events = tuple(SupervisionEvent(k, names[kind], value) for k, kind, value in entries)
        return cls(counts_of, events, growth, frozen, fallback, radius)

    def __str__(self) -> str:
        if not self.troubles:
            return "no trouble recorded"
        lines = []
        for name, count in self.troubles.items():
            times = "once" if count.episodes == 1 else f"{count.episodes} times"
            worst = f", at worst {count.worst:.3g}" if count.worst not in (0.0, 1.0) else ""
            lines.append(f"{name} {times} in {count.steps} steps from {count.first} on{worst}")
        return "; ".join(lines)
