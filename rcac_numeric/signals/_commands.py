"""Reference filters: lags of first and second order with limits."""

from __future__ import annotations

from math import exp, expm1, sin, sqrt

import attrs
import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import instance_of, number, reads, with_checks
from rcac_numeric.signals._signal import Signal

NUMBER = reads(number)
LIMIT = reads(number, optional=True)


@attrs.frozen(eq=False, slots=False, field_transformer=with_checks)
class FilteredCommand(Signal):
    r"""A command behind a filter of first or second order that limits its size and its rate.

    With S_M the limits of size and S_R those of the rate, x the filtered command and v its rate,

        first order:   v(k+1) = S_R(a (S_M(r(k)) - x(k))),
        second order:  v(k+1) = v(k) + b (S_R(c (S_M(r(k)) - x(k))) - v(k)),

    and x(k+1) = x(k) + v(k+1), held within S_M. Between the limits the poles are those of the
    continuous filter sampled, e^-omega, or e^s with s^2 + 2 zeta omega s + omega^2 = 0, and a
    constant command is reached without error. x never leaves its limits and no step of it is larger
    than `rate`, whatever the command does.

    Parameters
    ----------
    signal : Signal
        The requested command, before limits.
    omega : float
        Bandwidth in rad/sample.
    zeta : float, optional
        Damping ratio of a filter of second order; of first order without it.
    low, high : float, optional
        Limits of the command.
    rate : float, optional
        Largest change in one step, up or down.
    initial : float
        x(0), at rest.

    Raises
    ------
    InputError
        Where omega, zeta or rate is not positive, low exceeds high, or `initial` lies outside.

    Notes
    -----
    J. A. Farrell, M. Polycarpou, M. Sharma and W. Dong, Command filtered backstepping, IEEE
    Transactions on Automatic Control 54(6), 2009, for the filter in continuous time.

    Examples
    --------
    >>> from rcac_numeric import FilteredCommand, Step
    >>> FilteredCommand(Step(), omega=0.7, rate=0.3).samples(6).round(3)
    array([0.   , 0.3  , 0.6  , 0.801, 0.901, 0.951])
    >>> FilteredCommand(Step(5.0), omega=0.7, zeta=0.9, high=1.0).samples(40)[[2, 39]].round(3)
    array([0.54, 1.  ])
    """

    signal: Signal
    omega: float = attrs.field(metadata=NUMBER)
    zeta: float | None = attrs.field(default=None, metadata=LIMIT)
    low: float | None = attrs.field(default=None, metadata=LIMIT)
    high: float | None = attrs.field(default=None, metadata=LIMIT)
    rate: float | None = attrs.field(default=None, metadata=LIMIT)
    initial: float = attrs.field(default=0.0, metadata=NUMBER)

    def __attrs_post_init__(self) -> None:
        instance_of(self.signal, "signal", Signal)
        for name, value in (("omega", self.omega), ("zeta", self.zeta), ("rate", self.rate)):
            if value is not None and not value > 0:
                raise InputError(f"{name} = {value:.6g} must be positive.")
        low, high = self._limits
        if low > high:
            raise InputError(f"low = {low:.6g} exceeds high = {high:.6g}.")
        if not low <= self.initial <= high:
            raise InputError(
                f"initial = {self.initial:.6g} lies outside the limits {low:.6g} and {high:.6g}."
            )

    @property
    def description(self) -> str:
        """For instance step(1) filtered at 0.5 rad/sample."""
        return f"{self.signal.description} filtered at {self.omega:g} rad/sample"

    @property
    def steps_known(self) -> int | None:
        """Number of known steps of the signal plus one: x(k) depends on r(k-1)."""
        known = self.signal.steps_known
        return None if known is None else known + 1

    @property
    def start(self) -> tuple[float, float]:
        """(x, v) at k = 0."""
        return self.initial, 0.0

    def advance(self, state: tuple[float, float], r: float) -> tuple[float, float]:
        """(x, v) at k + 1 from that at k and the command r(k): the filter beside a device.

        Parameters
        ----------
        state : (float, float)
            `start` at first.
        r : float

        Raises
        ------
        InputError
            Where r is not finite.

        Examples
        --------
        >>> from rcac_numeric import FilteredCommand, Step
        >>> filter = FilteredCommand(Step(), omega=0.7, rate=0.3)
        >>> state = filter.start
        >>> for r in (1.0, 1.0, -1.0):
        ...     state = filter.advance(state, r)
        >>> round(state[0], 3)
        0.3
        """
        return self._advanced(state, number(r, "r"), *self._gains)

    def values(self, steps: int, rng: np.random.Generator) -> Array:
        """The filtered command at every step."""
        command = self.signal.values(max(steps - 1, 0), rng)
        state, gains, values = self.start, self._gains, np.full(steps, self.initial)
        for k, r in enumerate(command.tolist()):
            state = self._advanced(state, r, *gains)
            values[k + 1] = state[0]
        return values

    @property
    def _limits(self) -> tuple[float, float]:
        low = -np.inf if self.low is None else self.low
        return low, np.inf if self.high is None else self.high

    @property
    def _gains(self) -> tuple[float, float]:
        """Return the gains from the distance to the rate, and from the rate to the next rate."""
        if self.zeta is None:
            return -expm1(-self.omega), 1.0
        share, bend = -expm1(-2 * self.zeta * self.omega), 1 - self.zeta**2
        if bend > 0:  # (1 - p)(1 - q) of the poles p and q of the sampled filter
            lag, turn = self.zeta * self.omega, self.omega * sqrt(bend)
            product = expm1(-lag) ** 2 + 4 * exp(-lag) * sin(turn / 2) ** 2
        else:
            fast = self.zeta + sqrt(-bend)
            product = expm1(-self.omega * fast) * expm1(-self.omega / fast)
        return product / share, share

    def _advanced(
        self, state: tuple[float, float], r: float, gain: float, share: float
    ) -> tuple[float, float]:
        (x, v), (low, high) = state, self._limits
        change = gain * (min(max(r, low), high) - x)
        if self.rate is not None:
            change = min(max(change, -self.rate), self.rate)
        v += share * (change - v)
        reached = min(max(x + v, low), high)
        return reached, reached - x
