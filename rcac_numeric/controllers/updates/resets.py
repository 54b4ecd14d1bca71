"""When the covariance is set back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import integer, items, number


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
