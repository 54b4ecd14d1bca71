"""Rules that change the update while it runs: forgetting, covariance resets, signal weights."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import integer, items, number


@dataclass(frozen=True)
class ScheduledForgetting:
    """A forgetting factor that changes at given steps.

    Attributes
    ----------
    changes : mapping from steps to numbers
        lambda from that step on, in (0, 1].
    initial : float
        lambda before the first change.

    Examples
    --------
    >>> from rcac_numeric import ScheduledForgetting
    >>> ScheduledForgetting({1000: 0.98, 1200: 1})
    ScheduledForgetting(changes={1000: 0.98, 1200: 1.0}, initial=1.0)
    """

    changes: Mapping[int, float] = field(hash=False)
    initial: float = 1.0

    def __post_init__(self) -> None:
        read = changes_by_step(self.changes, "changes")
        factors = {k: forgetting_factor(value) for k, value in read.items()}
        object.__setattr__(self, "changes", factors)
        object.__setattr__(self, "initial", forgetting_factor(self.initial))


@dataclass(frozen=True)
class VariableRateForgetting:
    """A forgetting factor that falls while z is larger than it was of late.

    lambda(k) = 1 / (1 + gain * max(0, rms_short(k) / rms_long(k) - 1))

    where the root mean squares of z run over the last `short` and `long` steps (fewer at the
    beginning). At rest lambda = 1, so nothing is forgotten without a reason and P does not wind up
    (Bruce, Goel, Bernstein, "Convergence and consistency of recursive least squares with
    variable-rate forgetting", Automatica 119, 2020).

    Attributes
    ----------
    short, long : int
        Numbers of steps, short < long.
    gain : float
        Positive.
    smallest : float
        lambda(k) is never below it.

    Examples
    --------
    >>> from rcac_numeric import VariableRateForgetting
    >>> VariableRateForgetting(short=10, long=100, gain=0.1)
    VariableRateForgetting(short=10, long=100, gain=0.1, smallest=0.5)
    """

    short: int
    long: int
    gain: float
    smallest: float = 0.5

    def __post_init__(self) -> None:
        integer(self.short, "short", at_least=1)
        integer(self.long, "long", at_least=2, at_most=1_000_000)
        if self.short >= self.long:
            raise InputError(f"short = {self.short} must be less than long = {self.long}.")
        if number(self.gain, "gain") <= 0:
            raise InputError(f"gain = {self.gain} must be positive.")
        if not 0 < number(self.smallest, "smallest") <= 1:
            raise InputError(f"smallest = {self.smallest} is not in (0, 1].")


@dataclass(frozen=True)
class CovarianceReset:
    """When P(k) is set back to P(0); theta stays.

    Any of the rules may be given; each that holds resets before the update of that step.

    Attributes
    ----------
    at : sequence of int
        Steps.
    every : int
        Period in steps, counted from the first update; 0: never.
    trace_below : float
        Reset where trace P(k) < trace_below * trace P(0); 0: never.
    growth : float
        Reset where the root mean square of z over the last `short` steps exceeds `growth` times
        that over the last `long` steps, but not within `long` steps of the first update or of
        the last reset by `every`, `trace_below` or `growth`; 0: never.
    short, long : int

    Examples
    --------
    >>> from rcac_numeric import CovarianceReset
    >>> CovarianceReset(at=[2000]).at
    (2000,)
    """

    at: Sequence[int] = ()
    every: int = 0
    trace_below: float = 0.0
    growth: float = 0.0
    short: int = 10
    long: int = 100

    def __post_init__(self) -> None:
        steps = tuple(
            sorted({integer(k, "the step of a covariance reset") for k in items(self.at, "at")})
        )
        object.__setattr__(self, "at", steps)
        integer(self.every, "every")
        integer(self.short, "short", at_least=1)
        integer(self.long, "long", at_least=2, at_most=1_000_000)
        if self.short >= self.long:
            raise InputError(f"short = {self.short} must be less than long = {self.long}.")
        for name in ("trace_below", "growth"):
            if number(getattr(self, name), name) < 0:
                raise InputError(f"{name} = {getattr(self, name)} must not be negative.")
        if self.trace_below >= 1:
            raise InputError(f"trace_below = {self.trace_below} would reset at every step.")
        if self.growth and self.growth <= 1:
            raise InputError(f"growth = {self.growth} must exceed 1.")


@dataclass(frozen=True)
class SignalWeight:
    """A weight that follows z: R(k) = (constant + z_squared z(k)'z(k)) I, evaluated in the kernel.

    The text uses R_u = e_0(k)^2 so that a large error slows the adaptation down (section 2.3.4).

    Examples
    --------
    >>> from rcac_numeric import SignalWeight
    >>> SignalWeight(z_squared=0.1)
    SignalWeight(z_squared=0.1, constant=0.0)
    """

    z_squared: float
    constant: float = 0.0

    def __post_init__(self) -> None:
        for name in ("z_squared", "constant"):
            object.__setattr__(self, name, number(getattr(self, name), name))
            if getattr(self, name) < 0:
                raise InputError(f"{name} = {getattr(self, name)} must not be negative.")


# A forgetting factor that is not constant.
Forgetting = ScheduledForgetting | VariableRateForgetting


def forgetting_factor(value: object) -> float:
    """`value` as a number in (0, 1]."""
    factor = number(value, "lambda_")
    if not 0 < factor <= 1:
        raise InputError(f"lambda_ = {factor} is not in (0, 1].")
    return factor


def changes_by_step(changes: object, name: str) -> dict[int, Any]:
    """A mapping from steps to values, sorted by step."""
    if changes is None:
        return {}
    if not isinstance(changes, Mapping):
        raise InputError(f"{name} = {changes!r} must map steps to values, such as {{1000: ...}}.")
    read = {integer(k, f"a step of {name}", at_least=1): v for k, v in changes.items()}
    return dict(sorted(read.items()))
