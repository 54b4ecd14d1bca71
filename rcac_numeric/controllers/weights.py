"""Weights of the retrospective cost (2.41) that follow the signals."""

from __future__ import annotations

from dataclasses import dataclass

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import number


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
