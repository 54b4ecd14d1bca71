"""Commands, disturbances and noise: scalar signals that can be added and scaled."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.validation import integer, items, number, real_array

Sampler = Callable[[int, np.random.Generator], Array]


@dataclass(frozen=True)
class Signal:
    """A scalar discrete-time signal, defined for k = 0, 1, ....

    Signals add and scale; random ones draw from the generator passed to `samples`.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric import harmonic, step
    >>> command = 2 * step() + harmonic(omega=np.pi)
    >>> command.samples(4)
    array([3., 1., 3., 1.])
    """

    description: str
    sampler: Sampler
    length: int | None = None  # how many steps are known; all of them by default

    def samples(self, steps: int, rng: np.random.Generator | None = None) -> Array:
        """The values at k = 0, ..., steps-1; shape (steps,)."""
        self.require_length(integer(steps, "steps"))
        return self.sampler(steps, np.random.default_rng(0) if rng is None else rng)

    def require_length(self, steps: int) -> None:
        """Refuse a run of more steps than are known."""
        if self.length is not None and steps > self.length:
            raise InputError(
                f"the signal {self.description} is known for {self.length} steps, but {steps} are "
                "asked for. Shorten the run; `sequence` would hold the last value."
            )

    def __add__(self, other: Signal) -> Signal:
        if not isinstance(other, Signal):
            raise InputError(f"{other!r} is not a Signal; add step({other!r}) for a constant.")
        return Signal(
            f"{self.description} + {other.description}",
            lambda steps, rng: self.sampler(steps, rng) + other.sampler(steps, rng),
            min((n for n in (self.length, other.length) if n is not None), default=None),
        )

    def __mul__(self, factor: float) -> Signal:
        value = number(factor, "factor")
        return Signal(
            f"{value:g}*({self.description})",
            lambda steps, rng: value * self.sampler(steps, rng),
            self.length,
        )

    __rmul__ = __mul__


def step(height: float = 1.0, start: int = 0) -> Signal:
    """A step of `height` that begins at step `start`.

    Examples
    --------
    >>> from rcac_numeric import step
    >>> step(height=2, start=1).samples(3)
    array([0., 2., 2.])
    """
    value, first = number(height, "height"), integer(start, "start")
    return Signal(
        f"step({value:g})", lambda steps, _: np.where(np.arange(steps) >= first, value, 0.0)
    )


def ramp(slope: float = 1.0, start: int = 0) -> Signal:
    """A ramp that is 0 up to step `start` and then grows by `slope` at each step.

    Examples
    --------
    >>> from rcac_numeric import ramp
    >>> ramp(slope=0.5, start=1).samples(4)
    array([0. , 0. , 0.5, 1. ])
    """
    value, first = number(slope, "slope"), integer(start, "start")
    return Signal(
        f"ramp({value:g})", lambda steps, _: value * np.maximum(np.arange(steps) - first, 0)
    )


def pulse(height: float = 1.0, start: int = 0, length: int = 1) -> Signal:
    """A pulse of `height` during `length` steps from step `start` on; by default an impulse.

    Examples
    --------
    >>> from rcac_numeric import pulse
    >>> pulse(height=2, start=1, length=2).samples(5)
    array([0., 2., 2., 0., 0.])
    """
    value, first = number(height, "height"), integer(start, "start")
    end = first + integer(length, "length", at_least=1)
    return Signal(
        f"pulse({value:g}, {end - first} steps)",
        lambda steps, _: np.where(
            (np.arange(steps) >= first) & (np.arange(steps) < end), value, 0.0
        ),
    )


def harmonic(omega: float, amplitude: float = 1.0, phase: float = 0.0) -> Signal:
    """The harmonic amplitude * cos(omega k + phase), with omega in rad/sample and phase in rad.

    Examples
    --------
    >>> from rcac_numeric import harmonic
    >>> harmonic(omega=0.5).samples(2).round(4)
    array([1.    , 0.8776])
    """
    w, a, p = number(omega, "omega"), number(amplitude, "amplitude"), number(phase, "phase")
    return Signal(f"{a:g}*cos({w:g} k)", lambda steps, _: a * np.cos(w * np.arange(steps) + p))


def piecewise(pieces: Sequence[tuple[int, Signal]]) -> Signal:
    """One signal after another: each from its step on, up to the step of the next one.

    The signals do not begin anew: at step k the value is that of the signal in force at k. Before
    the first step the value is zero.

    Examples
    --------
    >>> from rcac_numeric import piecewise, sequence, step
    >>> piecewise([(1, step(height=2)), (3, sequence([1, 2, 3, 4, 5]))]).samples(5)
    array([0., 2., 2., 4., 5.])
    """
    pieces = items(pieces, "pieces")
    for piece in pieces:
        if not (isinstance(piece, Sequence) and len(piece) == 2 and isinstance(piece[1], Signal)):
            raise InputError(f"pieces has the entry {piece!r}; pairs (step, Signal) are needed.")
    starts = [integer(start, "the start of a piece") for start, _ in pieces]
    if not starts or any(b <= a for a, b in pairwise(starts)):
        raise InputError(f"the pieces start at {starts}; increasing steps are needed.")

    stops = [*starts[1:], None]
    for (_, signal), stop in zip(pieces, stops, strict=True):
        if stop is not None:
            signal.require_length(stop)

    def samples(steps: int, rng: np.random.Generator) -> Array:
        values = np.zeros(steps)
        for (start, signal), stop in zip(pieces, stops, strict=True):
            end = steps if stop is None else min(stop, steps)
            values[start:end] = signal.samples(end, rng)[start:]
        return values

    words = ", ".join(f"{signal.description} from {start}" for start, signal in pieces)
    return Signal(words, samples, pieces[-1][1].length)


def white_noise(std: float = 1.0) -> Signal:
    """Zero-mean Gaussian white noise with standard deviation `std`.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric import white_noise
    >>> white_noise(std=0.1).samples(10_000, np.random.default_rng(1)).std().round(3)
    np.float64(0.1)
    """
    deviation = number(std, "std")
    if deviation < 0:
        raise InputError(f"std = {deviation} is a standard deviation and cannot be negative.")
    return Signal(
        f"white noise({deviation:g})", lambda steps, rng: deviation * rng.standard_normal(steps)
    )


def sequence(values: Sequence[float], hold: int = 1) -> Signal:
    """The levels `values`, each held for `hold` steps; the last one stays.

    For a record that must not be prolonged see `recorded`.

    Examples
    --------
    >>> from rcac_numeric import sequence
    >>> sequence([1, -1], hold=2).samples(5)
    array([ 1.,  1., -1., -1., -1.])
    """
    levels, length = real_array(values, "values"), integer(hold, "hold", at_least=1)
    if levels.ndim != 1 or levels.size == 0:
        raise InputError(f"values has shape {levels.shape}; a sequence needs at least one number.")
    return Signal(
        f"sequence of {levels.size}",
        lambda steps, _: levels[np.minimum(np.arange(steps) // length, levels.size - 1)],
    )


def exogenous(signals: Sequence[Signal], steps: int, seed: int | None = 0) -> Array:
    """The exogenous input w of shape (steps, len(signals)), one signal for each channel.

    Each channel has its own random stream, spawned from `seed`, so adding a channel does not
    change the others.

    Examples
    --------
    >>> from rcac_numeric import exogenous, step
    >>> exogenous([step(), step(2)], steps=2)
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
