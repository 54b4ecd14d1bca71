"""The expected exogenous signals of a loop: command, disturbance and sensor noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import lfilter

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, number
from rcac_numeric.arrays._values import Value
from rcac_numeric.signals._recordings import Recorded
from rcac_numeric.signals._signal import Scaled, Signal, Sum, exogenous
from rcac_numeric.signals._waveforms import Harmonic, Ramp, Step, WhiteNoise

UNKNOWN = "unknown"
COLOUR = 0.95  # pole of the noise that stands for a disturbance of which no spectrum is known
KINDS = ("step", "coloured noise", "sinusoid")  # the kinds that stand for an unknown disturbance
OMEGA = (0.02, 0.6)  # rad/sample, of those sinusoids
LITTLE = 0.05  # of the disturbance: its white part
QUIET = 0.01  # default sensor noise, over the disturbance's effect on y
LONGEST = 20_000  # steps of one trial
SHARE = 0.2  # of the actuator's range: the default disturbance


@dataclass(frozen=True, eq=False)
class Expected(Value):
    """The exogenous input w = [r; d; v] of the servo problem, as far as it is known.

    Attributes
    ----------
    disturbance : Signal or None
        d, in units of u; None where only its size is known.
    size : float
        Of d, in units of u; at least the u that the command needs.
    noise : float
        Standard deviation of v, in units of y.
    command : Signal or None
        r, in units of y.
    m : int
        The number of inputs and of outputs, which meet signals of the same kind.
    known_size : float or None
        The known size of d alone, if it is less.
    """

    disturbance: Signal | None
    size: float
    noise: float
    command: Signal | None = None
    m: int = 1
    known_size: float | None = None

    @property
    def disturbance_size(self) -> float:
        """The size of d alone, in units of u."""
        return self.size if self.known_size is None else self.known_size

    @property
    def is_known(self) -> bool:
        """Whether the spectrum of the disturbance is known."""
        return self.disturbance is not None

    @property
    def white(self) -> float:
        """Standard deviation of the white part of d, at least a hundredth of its size."""
        if self.disturbance is None:
            return LITTLE * self.disturbance_size
        white = [
            f * one.std for f, one in parts_of(self.disturbance) if isinstance(one, WhiteNoise)
        ]
        return max(float(np.linalg.norm(white)), 0.01 * self.size)

    @property
    def lasting(self) -> float:
        """Size of the lasting part of d: neither white nor a sinusoid."""
        if self.disturbance is None:
            return self.disturbance_size
        return _size_without(self.disturbance, WhiteNoise, Harmonic)

    @property
    def stays(self) -> tuple[float, float]:
        """Sizes of the lasting parts of d and of r without ramps, in units of u and of y."""
        d, r = self.disturbance, self.command
        of_d = self.lasting if d is None else _size_without(d, WhiteNoise, Harmonic, Ramp)
        return of_d, 0.0 if r is None else _size_without(r, Ramp)

    @property
    def constant_command(self) -> float:
        """Size of the constant part of r, without noise, sinusoids and ramps, in units of y."""
        return (
            0.0 if self.command is None else _size_without(self.command, WhiteNoise, Harmonic, Ramp)
        )

    @property
    def largest_command(self) -> float:
        """The largest abs(r) of the first 2000 steps."""
        return 0.0 if self.command is None else _size(1.0, self.command)

    @property
    def slopes(self) -> tuple[float, float]:
        """Slopes of d and of r per step, in units of u and of y."""
        of_d, of_r = (
            [abs(f * one.slope) for f, one in parts_of(signal) if isinstance(one, Ramp)]
            if signal is not None else [] for signal in (self.disturbance, self.command)
        )  # fmt: skip
        return sum(of_d), sum(of_r)

    @property
    def sinusoids(self) -> tuple[tuple[float, float], ...]:
        """Frequency in rad/sample and amplitude of each sinusoid that is known."""
        if self.disturbance is None:
            return ()
        sinusoids = ((f, one) for f, one in parts_of(self.disturbance))
        return tuple(
            (float(one.omega), abs(f * one.amplitude))
            for f, one in sinusoids if isinstance(one, Harmonic) and one.amplitude
        )  # fmt: skip

    def signals(self, seed: int, noise: float = 1.0) -> tuple[Signal, ...]:
        """r, d and v, of each m; an unknown d is in turn a step, coloured noise and a sinusoid."""
        v = WhiteNoise(noise * self.noise)
        r = Step(0.0) if self.command is None else self.command
        known = self.disturbance
        d = [self._drawn(seed, i) if known is None else known for i in range(self.m)]
        return (*[r] * self.m, *d, *[v] * self.m)

    def w(self, steps: int, seed: int, noise: float = 1.0) -> Array:
        """A draw of w, shape (steps, 3 m)."""
        return exogenous(self.signals(seed, noise), steps, seed)

    def prior_w(self, steps: int, reads_command: bool = False) -> Array:
        """A draw of w for R_theta: coloured and white noise, and the known signals.

        The command is among them where the controller reads it.
        """
        rng = np.random.default_rng(1)
        w = np.zeros((steps, 3 * self.m)) if self.disturbance is None else self.w(steps, 0)
        for i in range(self.m):
            w[:, self.m + i] += self.size * (_coloured(steps, rng) + rng.standard_normal(steps))
            w[:, 2 * self.m + i] = self.noise * rng.standard_normal(steps)
        if reads_command:
            w[:, 0] += self.largest_command * (_coloured(steps, rng) + rng.standard_normal(steps))
        return w

    def _drawn(self, seed: int, i: int) -> Signal:
        rng = np.random.default_rng([seed, 3, *[i] * (i > 0)])
        size = self.disturbance_size
        kind, little = KINDS[seed % len(KINDS)], WhiteNoise(LITTLE * size)
        if kind == "step":
            return Step(size) + little
        if kind == "sinusoid":
            omega = float(np.exp(rng.uniform(*np.log(OMEGA))))
            return Harmonic(omega, size, float(rng.uniform(0, 2 * np.pi))) + little
        return Recorded(size * _coloured(LONGEST, rng)) + little


def _coloured(steps: int, rng: np.random.Generator) -> Array:
    """Noise of unit variance with the spectrum of a lag at `COLOUR`."""
    coloured = lfilter([np.sqrt(1 - COLOUR**2)], [1.0, -COLOUR], rng.standard_normal(steps))
    return np.asarray(coloured, dtype=np.float64)


def parts_of(signal: Signal, factor: float = 1.0) -> list[tuple[float, Signal]]:
    """The summands of a signal, each with its factor."""
    if isinstance(signal, Sum):
        return [summand for part in signal.parts for summand in parts_of(part, factor)]
    if isinstance(signal, Scaled):
        return parts_of(signal.signal, factor * signal.factor)
    return [(factor, signal)]


def _size_without(signal: Signal, *without: type[Signal]) -> float:
    """Size of a signal without its parts of these kinds."""
    return sum(_size(f, one) for f, one in parts_of(signal) if not isinstance(one, without))


def _size(factor: float, signal: Signal) -> float:
    """The largest value of a signal within a trial, or within a shorter record."""
    steps = 2000 if signal.steps_known is None else min(2000, signal.steps_known)
    return float(np.abs(factor * signal.samples(steps)).max(initial=0.0))


def read_expected(
    disturbance: Any, noise: float | None, command: Any, u_range: float, gain: float, m: int = 1
) -> tuple[Expected, tuple[str, ...]]:
    """Return the expected signals, and the names of the assumed ones."""
    assumed = []
    if disturbance is None or (
        not isinstance(disturbance, Signal | str) and not number(disturbance, "disturbance")
    ):
        disturbance = Step(0.0)
    signal = disturbance if isinstance(disturbance, Signal) else None
    if command is not None:
        instance_of(command, "command", Signal)
    if noise is not None and not number(noise, "noise") >= 0:
        raise InputError(f"noise = {noise} is a standard deviation and cannot be negative.")
    if signal is not None:
        size = sum(
            one.std * abs(f) if isinstance(one, WhiteNoise) else _size(f, one)
            for f, one in parts_of(signal)
        )
    elif disturbance == UNKNOWN:
        assumed += ["disturbance", "size"]
        size = _assumed_size(noise, command, u_range, gain)
    elif isinstance(disturbance, str) or number(disturbance, "disturbance") <= 0:
        raise InputError(
            f"disturbance = {disturbance!r}: give a Signal such as Step(0.5), its size as a "
            'positive number, in units of u, "unknown", or 0 where there is none.'
        )
    else:
        assumed.append("disturbance")
        size = float(disturbance)
    known_size = size
    if command is not None:
        size = max(size, _size(1.0, command) / gain)
    if not size:
        raise InputError(
            f"the disturbance is zero and there is no command{' but 0' * (command is not None)}: "
            "nothing to control. Give a command such as Step(1.0), in units of y, or the size of "
            "the disturbance of u."
        )
    if noise is None:
        assumed.append("noise")
        noise = QUIET * gain * size
    return Expected(signal, size, float(noise), command, m, known_size), tuple(assumed)


def _assumed_size(
    noise: float | None, command: Signal | None, u_range: float, gain: float
) -> float:
    if np.isfinite(u_range):
        return SHARE * u_range
    if command is not None and (largest := _size(1.0, command)):
        return SHARE * largest / gain
    return noise / (QUIET * gain) if noise else 1.0
