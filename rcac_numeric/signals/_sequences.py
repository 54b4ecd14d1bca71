"""Piecewise signals: levels, and sequences of signals."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import attrs
import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    array_like,
    integer,
    items,
    reads,
    real_array,
    with_checks,
)
from rcac_numeric.signals._signal import Signal


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class Levels(Signal):
    """A sequence of levels, each held for `hold` steps; the last one stays.

    For a record that must not be prolonged see `Recorded`.

    Parameters
    ----------
    levels : array, shape (count,)
        The values, one after another.
    hold : int
        Steps for which each is held.

    Examples
    --------
    >>> from rcac_numeric import Levels
    >>> Levels([1, -1], hold=2).samples(5)
    array([ 1.,  1., -1., -1., -1.])
    """

    levels: Array = attrs.field(converter=array_like, metadata=reads(real_array))
    hold: int = attrs.field(default=1, metadata=reads(integer, at_least=1))

    def __attrs_post_init__(self) -> None:
        if self.levels.ndim != 1 or self.levels.size == 0:
            raise InputError(
                f"levels has shape {self.levels.shape}; a sequence needs at least one number."
            )

    @property
    def description(self) -> str:
        """For instance sequence of 3."""
        return f"sequence of {self.levels.size}"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The level in force at every step."""
        return self.levels[np.minimum(np.arange(steps) // self.hold, self.levels.size - 1)]


@attrs.frozen(eq=False, slots=False)
class Piecewise(Signal):
    """One signal after another: each from its step on, up to the step of the next one.

    The signals do not begin anew: at step k the value is that of the signal in force at k. Before
    the first step the value is zero.

    Parameters
    ----------
    pieces : sequence of (int, Signal)
        Pairs of a first step and a signal, by increasing step.

    Examples
    --------
    >>> from rcac_numeric import Levels, Piecewise, Step
    >>> Piecewise([(1, Step(height=2)), (3, Levels([1, 2, 3, 4, 5]))]).samples(5)
    array([0., 2., 2., 4., 5.])
    """

    pieces: Sequence[tuple[int, Signal]]

    def __attrs_post_init__(self) -> None:
        pieces = items(self.pieces, "pieces")
        for piece in pieces:
            if not (
                isinstance(piece, Sequence) and len(piece) == 2 and isinstance(piece[1], Signal)
            ):
                raise InputError(
                    f"pieces has the entry {piece!r}; pairs (step, Signal) are needed."
                )
        read = tuple((integer(k, "the start of a piece"), signal) for k, signal in pieces)
        object.__setattr__(self, "pieces", read)
        starts = [start for start, _ in read]
        if not starts or any(b <= a for a, b in pairwise(starts)):
            raise InputError(f"the pieces start at {starts}; increasing steps are needed.")
        for (_, signal), (stop, _) in pairwise(read):
            signal.require_length(stop)

    @property
    def description(self) -> str:
        """Each signal with its first step."""
        return ", ".join(f"{signal.description} from {start}" for start, signal in self.pieces)

    @property
    def steps_known(self) -> int | None:
        """Number of known steps of the last signal."""
        return self.pieces[-1][1].steps_known

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The value of the signal in force at every step."""
        result = np.zeros(steps)
        stops = [start for start, _ in self.pieces[1:]]
        for (start, signal), stop in zip(self.pieces, [*stops, steps], strict=True):
            end = min(stop, steps)
            result[start:end] = signal.values(end, rng)[start:]
        return result
