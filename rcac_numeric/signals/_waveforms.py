"""Commands, disturbances and noise: the signals of the text, each as data."""

from __future__ import annotations

import attrs
import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer, number, reads, with_checks
from rcac_numeric.signals._signal import Signal

NUMBER, STEPS = reads(number), reads(integer)


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
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

    height: float = attrs.field(default=1.0, metadata=NUMBER)
    start: int = attrs.field(default=0, metadata=STEPS)

    @property
    def description(self) -> str:
        """For instance step(2)."""
        return f"step({self.height:g})"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """Zero before `start`, the height from there on."""
        return np.where(np.arange(steps) >= self.start, self.height, 0.0)


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
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

    slope: float = attrs.field(default=1.0, metadata=NUMBER)
    start: int = attrs.field(default=0, metadata=STEPS)

    @property
    def description(self) -> str:
        """For instance ramp(0.5)."""
        return f"ramp({self.slope:g})"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The slope times the steps since `start`."""
        return self.slope * np.maximum(np.arange(steps) - self.start, 0)


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
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

    height: float = attrs.field(default=1.0, metadata=NUMBER)
    start: int = attrs.field(default=0, metadata=STEPS)
    length: int = attrs.field(default=1, metadata=reads(integer, at_least=1))

    @property
    def description(self) -> str:
        """For instance pulse(2, 3 steps)."""
        return f"pulse({self.height:g}, {self.length} steps)"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The height while the pulse lasts, else zero."""
        k = np.arange(steps)
        return np.where((k >= self.start) & (k < self.start + self.length), self.height, 0.0)


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
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

    omega: float = attrs.field(metadata=NUMBER)
    amplitude: float = attrs.field(default=1.0, metadata=NUMBER)
    phase: float = attrs.field(default=0.0, metadata=NUMBER)

    @property
    def description(self) -> str:
        """For instance 1*cos(0.5 k)."""
        return f"{self.amplitude:g}*cos({self.omega:g} k)"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The cosine at every step."""
        wave: Array = np.cos(self.omega * np.arange(steps) + self.phase)
        return self.amplitude * wave


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
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
    >>> float(WhiteNoise(std=0.1).samples(10_000, np.random.default_rng(1)).std().round(3))
    0.1
    """

    std: float = attrs.field(default=1.0, metadata=NUMBER)

    def __attrs_post_init__(self) -> None:
        if self.std < 0:
            raise InputError(f"std = {self.std} is a standard deviation and cannot be negative.")

    @property
    def description(self) -> str:
        """For instance white noise(0.1)."""
        return f"white noise({self.std:g})"

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """Independent normal values."""
        return self.std * rng.standard_normal(steps)
