"""Scalar signals with addition and scaling, and the exogenous input w."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import attrs
import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, integer, items, number
from rcac_numeric.arrays._values import Value


class Signal(Value, ABC):
    """A scalar discrete-time signal, defined for k = 0, 1, ....

    Signals are data: they add, scale, compare, print and pickle. Random ones draw from the
    generator passed to `samples`. A signal of your own derives from this class as a frozen
    dataclass and says what its values and its name are.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric import Harmonic, Step
    >>> command = 2 * Step() + Harmonic(omega=np.pi)
    >>> command.samples(4)
    array([3., 1., 3., 1.])
    """

    @property
    @abstractmethod
    def description(self) -> str:
        """Short description of the signal, for reports and errors."""

    @abstractmethod
    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """Return the values at k = 0, ..., steps-1, at most `steps_known`; shape (steps,)."""

    @property
    def steps_known(self) -> int | None:
        """Number of known steps; None for all."""
        return None

    def samples(self, steps: int, rng: np.random.Generator | None = None) -> Array:
        """The values at k = 0, ..., steps-1; shape (steps,)."""
        self.require_length(integer(steps, "steps"))
        return self.values(steps, np.random.default_rng(0) if rng is None else rng)

    def require_length(self, steps: int) -> None:
        """Raise if a run has more steps than are known."""
        if self.steps_known is not None and steps > self.steps_known:
            raise InputError(
                f"the signal {self.description} is known for {self.steps_known} steps, but "
                f"{steps} are requested. Shorten the run; `Levels` would hold the last value."
            )

    def __add__(self, other: Signal) -> Signal:
        if not isinstance(other, Signal):
            raise InputError(f"{other!r} is not a Signal; add Step({other!r}) for a constant.")
        return Sum((*self.parts, other)) if isinstance(self, Sum) else Sum((self, other))

    def __mul__(self, factor: float) -> Signal:
        return Scaled(factor, self)

    __rmul__ = __mul__


@attrs.frozen(eq=False, slots=False)
class Sum(Signal):
    """A sum of signals, the result of `+`.

    Parameters
    ----------
    parts : sequence of Signal
        The signals that are added.

    Examples
    --------
    >>> from rcac_numeric import Step
    >>> (Step(2) + Step(1, start=1)).samples(3)
    array([2., 3., 3.])
    """

    parts: tuple[Signal, ...]

    def __attrs_post_init__(self) -> None:
        object.__setattr__(self, "parts", items(self.parts, "parts", Signal))
        if not self.parts:
            raise InputError("a sum of signals needs at least one.")

    @property
    def description(self) -> str:
        """The parts, joined by plus signs."""
        return " + ".join(part.description for part in self.parts)

    @property
    def steps_known(self) -> int | None:
        """Number of known steps of the shortest part."""
        return min((n for part in self.parts if (n := part.steps_known) is not None), default=None)

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The sum of the parts' values."""
        total = self.parts[0].values(steps, rng)
        for part in self.parts[1:]:
            total = total + part.values(steps, rng)
        return total


@attrs.frozen(eq=False, slots=False)
class Scaled(Signal):
    """A signal times a number, the result of `*`."""

    factor: float
    signal: Signal

    def __attrs_post_init__(self) -> None:
        object.__setattr__(self, "factor", number(self.factor, "factor"))
        instance_of(self.signal, "signal", Signal)

    @property
    def description(self) -> str:
        """The factor and the signal."""
        return f"{self.factor:g}*({self.signal.description})"

    @property
    def steps_known(self) -> int | None:
        """Number of known steps of the signal."""
        return self.signal.steps_known

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The signal's values times the factor."""
        return self.factor * self.signal.values(steps, rng)


def exogenous(signals: Sequence[Signal], steps: int, seed: int | None = 0) -> Array:
    """The exogenous input w of shape (steps, len(signals)), one signal for each channel.

    Each channel has its own random stream, spawned from `seed`, so adding a channel does not
    change the others.

    Examples
    --------
    >>> from rcac_numeric import Step, exogenous
    >>> exogenous([Step(), Step(2)], steps=2)
    array([[1., 2.],
           [1., 2.]])
    """
    signals = items(signals, "signals", Signal)
    integer(steps, "steps")
    if seed is not None:
        integer(seed, "seed")
    streams = np.random.default_rng(seed).spawn(len(signals))
    columns = [
        signal.samples(steps, stream) for signal, stream in zip(signals, streams, strict=True)
    ]
    return np.ascontiguousarray(np.column_stack(columns)) if columns else np.zeros((steps, 0))
