"""Commands, disturbances and noise: the signals of the text, each as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import integer, items, number, real_array
from rcac_numeric.signals.signal import Signal


def _read(signal: Signal, numbers: Sequence[str], steps: Sequence[str] = ()) -> None:
    """Check the fields of a signal and keep them as floats and ints."""
    for name in numbers:
        object.__setattr__(signal, name, number(getattr(signal, name), name))
    for name in steps:
        object.__setattr__(signal, name, integer(getattr(signal, name), name))


@dataclass(frozen=True, eq=False)
class Step(Signal):
    """A step of `height` that begins at step `start`.

    Parameters
    ----------
    height : float
        Its value from `start` on.
    start : int
        First step with that value.

    Examples
    --------
    >>> from rcac_numeric import Step
    >>> Step(height=2, start=1).samples(3)
    array([0., 2., 2.])
    """

    height: float = 1.0
    start: int = 0

    def __post_init__(self) -> None:
        _read(self, ["height"], ["start"])

    @property
    def description(self) -> str:
        """For instance step(2)."""
        return f"step({self.height:g})"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """Zero before `start`, the height from there on."""
        return np.where(np.arange(steps) >= self.start, self.height, 0.0)


@dataclass(frozen=True, eq=False)
class Ramp(Signal):
    """A ramp that is 0 up to step `start` and then grows by `slope` at each step.

    Parameters
    ----------
    slope : float
        Growth in one step.
    start : int
        Last step at which it is zero.

    Examples
    --------
    >>> from rcac_numeric import Ramp
    >>> Ramp(slope=0.5, start=1).samples(4)
    array([0. , 0. , 0.5, 1. ])
    """

    slope: float = 1.0
    start: int = 0

    def __post_init__(self) -> None:
        _read(self, ["slope"], ["start"])

    @property
    def description(self) -> str:
        """For instance ramp(0.5)."""
        return f"ramp({self.slope:g})"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The slope times the steps since `start`."""
        return self.slope * np.maximum(np.arange(steps) - self.start, 0)


@dataclass(frozen=True, eq=False)
class Pulse(Signal):
    """A pulse of `height` over some steps from `start` on; by default an impulse.

    Parameters
    ----------
    height : float
        Its value while it lasts.
    start : int
        First step with that value.
    length : int
        Number of steps with that value.

    Examples
    --------
    >>> from rcac_numeric import Pulse
    >>> Pulse(height=2, start=1, length=2).samples(5)
    array([0., 2., 2., 0., 0.])
    """

    height: float = 1.0
    start: int = 0
    length: int = 1

    def __post_init__(self) -> None:
        _read(self, ["height"], ["start"])
        object.__setattr__(self, "length", integer(self.length, "length", at_least=1))

    @property
    def description(self) -> str:
        """For instance pulse(2, 3 steps)."""
        return f"pulse({self.height:g}, {self.length} steps)"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The height while the pulse lasts, else zero."""
        k = np.arange(steps)
        return np.where((k >= self.start) & (k < self.start + self.length), self.height, 0.0)


@dataclass(frozen=True, eq=False)
class Harmonic(Signal):
    """The harmonic amplitude * cos(omega k + phase).

    Parameters
    ----------
    omega : float
        Frequency in rad/sample.
    amplitude : float
        Largest value.
    phase : float
        In rad.

    Examples
    --------
    >>> from rcac_numeric import Harmonic
    >>> Harmonic(omega=0.5).samples(2).round(4)
    array([1.    , 0.8776])
    """

    omega: float
    amplitude: float = 1.0
    phase: float = 0.0

    def __post_init__(self) -> None:
        _read(self, ["omega", "amplitude", "phase"])

    @property
    def description(self) -> str:
        """For instance 1*cos(0.5 k)."""
        return f"{self.amplitude:g}*cos({self.omega:g} k)"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The cosine at every step."""
        wave: Array = np.cos(self.omega * np.arange(steps) + self.phase)
        return self.amplitude * wave


@dataclass(frozen=True, eq=False)
class WhiteNoise(Signal):
    """Zero-mean Gaussian white noise.

    Parameters
    ----------
    std : float
        Standard deviation.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric import WhiteNoise
    >>> WhiteNoise(std=0.1).samples(10_000, np.random.default_rng(1)).std().round(3)
    np.float64(0.1)
    """

    std: float = 1.0

    def __post_init__(self) -> None:
        _read(self, ["std"])
        if self.std < 0:
            raise InputError(f"std = {self.std} is a standard deviation and cannot be negative.")

    @property
    def description(self) -> str:
        """For instance white noise(0.1)."""
        return f"white noise({self.std:g})"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """Independent normal values."""
        return self.std * rng.standard_normal(steps)


@dataclass(frozen=True, eq=False, init=False)
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

    levels: Array
    hold: int = 1

    def __init__(self, levels: ArrayLike, hold: int = 1) -> None:
        array = real_array(levels, "levels")
        if array.ndim != 1 or array.size == 0:
            raise InputError(
                f"levels has shape {array.shape}; a sequence needs at least one number."
            )
        object.__setattr__(self, "levels", array)
        object.__setattr__(self, "hold", integer(hold, "hold", at_least=1))

    @property
    def description(self) -> str:
        """For instance sequence of 3."""
        return f"sequence of {self.levels.size}"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The level in force at every step."""
        return self.levels[np.minimum(np.arange(steps) // self.hold, self.levels.size - 1)]


@dataclass(frozen=True, eq=False)
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

    def __post_init__(self) -> None:
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
        """That of the last signal."""
        return self.pieces[-1][1].steps_known

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """At every step the value of the signal in force."""
        result = np.zeros(steps)
        stops = [start for start, _ in self.pieces[1:]]
        for (start, signal), stop in zip(self.pieces, [*stops, steps], strict=True):
            end = min(stop, steps)
            result[start:end] = signal.values(end, rng)[start:]
        return result
