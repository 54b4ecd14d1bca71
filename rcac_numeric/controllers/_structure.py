"""Controller structures: the regressor as a table of taps on scalar signals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer, items, number, one_of, real_array
from rcac_numeric.controllers._compensator import Compensator

SIGNALS = ("u", "y", "r", "derived")
LONGEST_DELAY = 100_000


@dataclass(frozen=True)
class Tap:
    """One entry of the regressor: one component of a signal, `delay` steps back.

    Attributes
    ----------
    signal : {"u", "y", "r", "derived"}
        The control input, the measurement, the command, or a signal that the controller derives
        from y and r itself.
    component, delay : int
        Which component of that signal, from 0 on, and how many steps back.
    """

    signal: str
    component: int
    delay: int


@dataclass(frozen=True)
class DerivedSignal:
    """A first-order filter of the measurements that the controller runs itself.

    s(k) = pole s(k-1) + now [y; r](k) + before [y; r](k-1), held within +-limit

    Pole 1 and before = 0 integrate, (6.5); pole 0 and before = -now take the difference, (2.61);
    pole p in (0, 1), now = 1 - p and before = 0 are a low-pass filter of gain 1.
    A limit on an integrator is the anti-windup that published RCAC runs: its state is clamped at
    every step.

    Attributes
    ----------
    now, before : tuples of l_y + l_r numbers
    pole : float
        In [-1, 1]; 0 where s is a moving average.
    limit : float
        Positive; infinite by default.
    """

    now: tuple[float, ...]
    before: tuple[float, ...]
    pole: float = 0.0
    limit: float = math.inf

    def __post_init__(self) -> None:
        for name in ("now", "before"):
            row = real_array(getattr(self, name), name)
            if row.ndim != 1:
                raise InputError(f"{name} = {getattr(self, name)!r} must be a list of numbers.")
            object.__setattr__(self, name, tuple(map(float, row)))
        if len(self.now) != len(self.before):
            raise InputError(
                f"a derived signal has {len(self.now)} weights now and {len(self.before)} before; "
                "one for each component of [y; r] is needed in both."
            )
        object.__setattr__(self, "pole", number(self.pole, "pole"))
        if abs(self.pole) > 1:
            raise InputError(f"the pole {self.pole} of a derived signal is outside [-1, 1].")
        if self.limit != math.inf:
            object.__setattr__(self, "limit", number(self.limit, "limit"))
        if self.limit <= 0:
            raise InputError(f"limit = {self.limit:g} of a derived signal must be positive.")

    def __repr__(self) -> str:
        limit = "" if self.limit == math.inf else f", limit={self.limit}"
        return f"DerivedSignal(now={self.now}, before={self.before}, pole={self.pole}{limit})"


def integral(weights: Sequence[float], limit: float = math.inf) -> DerivedSignal:
    """The running sum gamma(k) = gamma(k-1) + F [y; r](k) of (6.5), F a row, within +-limit.

    Examples
    --------
    >>> from rcac_numeric import integral
    >>> integral([1, 0])
    DerivedSignal(now=(1.0, 0.0), before=(0.0, 0.0), pole=1.0)
    """
    row = items(weights, "weights")
    return DerivedSignal(row, (0.0,) * len(row), 1.0, limit)


def difference(weights: Sequence[float]) -> DerivedSignal:
    """The difference F [y; r](k) - F [y; r](k-1), F a row.

    Examples
    --------
    >>> from rcac_numeric import difference
    >>> difference([1])
    DerivedSignal(now=(1.0,), before=(-1.0,), pole=0.0)
    """
    signal = integral(weights)
    return DerivedSignal(signal.now, tuple(-w for w in signal.now))


@dataclass(frozen=True)
class Structure:
    """A controller structure: u(k) = Phi(k) theta(k) with Phi(k) = phi(k)' (x) I, (2.29)-(2.30).

    phi(k) is read off the taps in their order, and theta = vec(Theta) stacks the columns of the
    l_u x len(taps) coefficient matrix Theta. (The transpose behind the bracket in (2.31) would
    not fit Phi theta; without it, it does.)

    Parameters
    ----------
    taps : sequence of Tap
        A user's own table, or what `iir`, `fir`, `pid`, `quasi_fir`, `fir_integrator` and
        `feedforward` return.
    l_u, l_y, l_r : int
        Numbers of control inputs, measurements and commands that the controller reads.
    n_c : int, optional
        The order; the longest delay by default.
    derived : sequence of DerivedSignal

    Raises
    ------
    InputError
        Where a tap names a component that does not exist, reads u(k) itself, or appears twice.

    Examples
    --------
    >>> from rcac_numeric import Structure, Tap, iir
    >>> structure = iir(n_c=2)
    >>> structure.l_theta
    4
    >>> structure.compensator([1.5, -0.5, 0.2, 0.1]).denominator
    array([ 1. , -1.5,  0.5])
    >>> notch = Structure([Tap("u", 0, 2), Tap("y", 0, 1), Tap("y", 0, 3)])
    >>> notch.l_theta, notch.n_c
    (3, 3)
    """

    taps: Sequence[Tap]
    l_u: int = 1
    l_y: int = 1
    n_c: int = -1
    name: str = "tap table"
    l_r: int = 0
    derived: Sequence[DerivedSignal] = ()

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "taps", items(self.taps, "taps", Tap))
        set_(self, "derived", items(self.derived, "derived", DerivedSignal))
        for name, least in (("l_u", 1), ("l_y", 0), ("l_r", 0)):
            integer(getattr(self, name), name, at_least=least)
        widths = dict(zip(SIGNALS, (self.l_u, self.l_y, self.l_r, len(self.derived)), strict=True))
        for tap in self.taps:
            one_of(tap.signal, "the signal of a tap", SIGNALS)
            integer(tap.component, "the component of a tap")
            integer(tap.delay, "the delay of a tap", at_most=LONGEST_DELAY)
            if tap.component >= widths[tap.signal]:
                raise InputError(
                    f"{tap} reads component {tap.component} of {tap.signal}, which has "
                    f"{widths[tap.signal]} components."
                )
            if tap.signal == "u" and tap.delay == 0:
                raise InputError(f"{tap} reads u(k) to compute u(k); use a delay of at least 1.")
        if len(set(self.taps)) < len(self.taps):
            raise InputError(
                "the taps hold the same entry twice; their coefficients would not be identifiable."
            )
        if not self.taps:
            raise InputError("the structure has no taps, so it has no coefficients.")
        for signal in self.derived:
            if len(signal.now) != self.l_y + self.l_r:
                raise InputError(
                    f"{signal} weighs {len(signal.now)} components; [y; r] has l_y + l_r = "
                    f"{self.l_y + self.l_r}."
                )
        longest = max(tap.delay for tap in self.taps)
        set_(self, "n_c", max(longest, 1) if self.n_c == -1 else integer(self.n_c, "n_c"))
        if self.n_c < longest:
            raise InputError(f"n_c = {self.n_c} is less than the longest delay {longest}.")

    @property
    def l_theta(self) -> int:
        """Number of controller coefficients."""
        return self.l_u * len(self.taps)

    @property
    def measures_first(self) -> bool:
        """Whether u(k) uses y(k): an exactly proper controller, k_c = 0."""
        return any(tap.delay == 0 for tap in self.taps)

    def index(self, tap: Tap) -> int:
        """Return the kernel's index of the scalar signal of a tap: u, y, r, then derived ones."""
        before = {
            "u": 0,
            "y": self.l_u,
            "r": self.l_u + self.l_y,
            "derived": self.l_u + self.l_y + self.l_r,
        }
        return before[tap.signal] + tap.component

    def compensator(self, theta: ArrayLike) -> Compensator:
        """Return the fixed compensator (2.32) from [y; r] to u of the coefficients `theta`.

        Derived signals are multiplied out, so that an integrator is a pole at 1; their limits are
        ignored.
        """
        values = real_array(theta, "theta").reshape(-1)
        if values.size != self.l_theta:
            raise InputError(
                f"theta has {values.size} entries; this {self.name} structure with n_c = "
                f"{self.n_c}, l_u = {self.l_u}, l_y = {self.l_y} has {self.l_theta}."
            )
        used = {tap.component for tap in self.taps if tap.signal == "derived"}
        poles = sorted({self.derived[i].pole for i in used} - {0.0})
        common = polynomial_with(poles)  # in powers of q^{-1}
        inputs = self.l_y + self.l_r
        longest = max(self.n_c, *(tap.delay + 1 for tap in self.taps if tap.signal == "derived"), 0)
        order = longest + len(poles)
        P = np.zeros((order + 1, self.l_u, self.l_u))
        Q = np.zeros((order + 1, self.l_u, inputs))
        P[: len(common)] -= np.multiply.outer(common, np.eye(self.l_u))
        for tap, column in zip(self.taps, values.reshape(-1, self.l_u), strict=True):
            rows = slice(tap.delay, tap.delay + len(common))
            if tap.signal == "u":
                P[rows, :, tap.component] += np.outer(common, column)
            elif tap.signal == "derived":
                signal = self.derived[tap.component]
                rest = polynomial_with([pole for pole in poles if pole != signal.pole])
                for lag, row in enumerate((signal.now, signal.before)):
                    if any(row):
                        start = tap.delay + lag
                        Q[start : start + len(rest)] += np.multiply.outer(
                            rest, np.outer(column, row)
                        )
            else:
                Q[rows, :, tap.component + (self.l_y if tap.signal == "r" else 0)] += np.outer(
                    common, column
                )
        used_lags = np.flatnonzero(P[1:].any(axis=(1, 2)) | Q[1:].any(axis=(1, 2)))
        # Never below n_c: the unused lags of a table are poles at zero of (2.32).
        order = max(self.n_c + len(poles), int(used_lags[-1]) + 1 if used_lags.size else 0)
        return Compensator(P[1 : order + 1], Q[: order + 1])


def polynomial_with(poles: Sequence[float]) -> Array:
    """Return the coefficients of prod (1 - pole q^{-1}) in powers of q^{-1}."""
    return np.atleast_1d(np.poly(poles)).astype(np.float64)
