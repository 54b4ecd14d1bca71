"""What the regressor of a controller is made of: tables of taps on the signals u and y."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.compensators import Compensator
from rcac_numeric.validation import integer, real_array


@dataclass(frozen=True)
class Tap:
    """One entry of the regressor: component `component` of u or y, `delay` steps back."""

    signal: str
    component: int
    delay: int


@dataclass(frozen=True)
class Structure:
    """A controller structure: u(k) = Phi(k) theta(k) with Phi(k) = phi(k)' (x) I, (2.29)-(2.30).

    phi(k) is read off the taps in their order, and theta = vec(Theta) stacks the columns of the
    l_u x len(taps) coefficient matrix Theta. (The transpose behind the bracket in (2.31) would
    not fit Phi theta; without it, it does.)

    Examples
    --------
    >>> from rcac_numeric import iir
    >>> structure = iir(n_c=2)
    >>> structure.l_theta
    4
    >>> structure.compensator([1.5, -0.5, 0.2, 0.1]).denominator
    array([ 1. , -1.5,  0.5])
    """

    taps: tuple[Tap, ...]
    l_u: int
    l_y: int
    n_c: int
    name: str

    @property
    def l_theta(self) -> int:
        """Number of controller coefficients."""
        return self.l_u * len(self.taps)

    @property
    def measures_first(self) -> bool:
        """Whether u(k) uses y(k): an exactly proper controller, k_c = 0."""
        return any(tap.delay == 0 for tap in self.taps)

    def index(self, tap: Tap) -> int:
        """The kernel's number of a tap's scalar signal: u first, then y."""
        return tap.component if tap.signal == "u" else self.l_u + tap.component

    def compensator(self, theta: ArrayLike) -> Compensator:
        """The fixed compensator (2.32) that the coefficients `theta` describe."""
        values = real_array(theta, "theta").reshape(-1)
        if values.size != self.l_theta:
            raise InputError(
                f"theta has {values.size} entries; this {self.name} structure with n_c = "
                f"{self.n_c}, l_u = {self.l_u}, l_y = {self.l_y} has {self.l_theta}."
            )
        P = np.zeros((self.n_c, self.l_u, self.l_u))
        Q = np.zeros((self.n_c + 1, self.l_u, self.l_y))
        for tap, column in zip(self.taps, values.reshape(-1, self.l_u), strict=True):
            if tap.signal == "u":
                P[tap.delay - 1, :, tap.component] = column
            else:
                Q[tap.delay, :, tap.component] = column
        return Compensator(P, Q)


def iir(n_c: int, l_u: int = 1, l_y: int = 1, k_c: int = 1) -> Structure:
    """The IIR structure (2.28)-(2.33) of order `n_c`.

    Parameters
    ----------
    n_c : int
        Order, at least 1.
    l_u, l_y : int
        Number of control inputs and of measurements.
    k_c : int
        First lag of y: 0 for an exactly proper controller, up to n_c.

    Examples
    --------
    >>> from rcac_numeric import iir
    >>> iir(n_c=3, l_u=2, l_y=1).l_theta  # l_u^2 n_c + l_u l_y (n_c + 1 - k_c)
    18
    """
    order, inputs, outputs, first = _sizes(n_c, l_u, l_y, k_c)
    past_u = [Tap("u", i, lag) for lag in range(1, order + 1) for i in range(inputs)]
    return Structure((*past_u, *_past_y(order, outputs, first)), inputs, outputs, order, "IIR")


def fir(n_c: int, l_u: int = 1, l_y: int = 1, k_c: int = 1) -> Structure:
    """The FIR structure (2.34)-(2.35): every pole of the controller is at zero.

    Examples
    --------
    >>> from rcac_numeric import fir
    >>> fir(n_c=5).l_theta
    5
    """
    order, inputs, outputs, first = _sizes(n_c, l_u, l_y, k_c)
    return Structure(tuple(_past_y(order, outputs, first)), inputs, outputs, order, "FIR")


def _past_y(n_c: int, l_y: int, k_c: int) -> list[Tap]:
    return [Tap("y", i, lag) for lag in range(k_c, n_c + 1) for i in range(l_y)]


def _sizes(n_c: int, l_u: int, l_y: int, k_c: int) -> tuple[int, int, int, int]:
    order = integer(n_c, "n_c", at_least=1)
    first = integer(k_c, "k_c")
    if first > order:
        raise InputError(f"k_c = {first} exceeds n_c = {order}: the controller would not read y.")
    return order, integer(l_u, "l_u", at_least=1), integer(l_y, "l_y", at_least=1), first
