"""Covariance resets."""

from __future__ import annotations

from collections.abc import Sequence

import attrs

from compensator_theory.errors import InputError
from rcac_numeric.arrays._validation import integer, items, number, reads, with_checks


def _steps(value: object, name: str) -> tuple[int, ...]:
    return tuple(sorted({integer(k, "the step of a covariance reset") for k in items(value, name)}))


@attrs.frozen(slots=False, field_transformer=with_checks)
class CovarianceReset:
    """Rules that reset P(k) to P(0); theta stays.

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

    at: Sequence[int] = attrs.field(default=(), metadata=reads(_steps))
    every: int = attrs.field(default=0, metadata=reads(integer))
    trace_below: float = 0.0
    growth: float = 0.0
    short: int = attrs.field(default=10, metadata=reads(integer, at_least=1))
    long: int = attrs.field(default=100, metadata=reads(integer, at_least=2, at_most=1_000_000))

    def __attrs_post_init__(self) -> None:
        if self.short >= self.long:
            raise InputError(f"short = {self.short} must be less than long = {self.long}.")
        for name in ("trace_below", "growth"):
            if number(getattr(self, name), name) < 0:
                raise InputError(f"{name} = {getattr(self, name)} must not be negative.")
        if self.trace_below >= 1:
            raise InputError(
                f"trace_below = {self.trace_below} must be below 1: P would be reset at every step."
            )
        if self.growth and self.growth <= 1:
            raise InputError(f"growth = {self.growth} must exceed 1.")
