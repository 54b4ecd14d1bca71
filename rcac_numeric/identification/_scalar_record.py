"""A scaled record of scalar u and y, and its candidate models."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer, items, real_array, squarable
from rcac_numeric.arrays._values import Value

STEPS_EACH = 10  # steps that a record must have for each of the longest model's lags
LOW, SHARE = 0.02, 0.3  # rad/step, and of the gain there: what an integrator must make of it
FASTEST = 1.0  # modulus: a root of a filter outside the circle is reflected into it

Shape = tuple[int, int, int]  # order, delay and number of integrators of a model


@dataclass(frozen=True, eq=False)
class ScalarModel(Value):
    """The map q^-delay B/A from u to y: B = b_1 q^-1 + ..., and b_0 + b_1 q^-1 + ... if direct."""

    numerator: Array
    denominator: Array
    delay: int
    is_direct: bool = field(default=False, kw_only=True)

    @property
    def order(self) -> int:
        """n, without the delay."""
        return len(self.denominator) - 1

    @property
    def transfer_function(self) -> tuple[Array, Array]:
        """Coefficients of B and A in descending powers of q, without the delay."""
        order = max(self.order, len(self.numerator) - self.is_direct)
        B = np.pad(self.numerator, (0, order + self.is_direct - len(self.numerator)))
        return B, np.pad(self.denominator, (0, order - self.order))


@dataclass(frozen=True)
class ScalarRecord:
    """u and y less their means in units of their standard deviations.

    Attributes
    ----------
    u, y : arrays, shape (steps,)
    units : (float, float)
        Those of u and y.
    first : int
        The first step before which no u and no y is missing, whatever model is tried.
    drifts : bool
        Whether y may have a slope that is none of the plant's: what an offset of u makes of y where
        a pole is 1, and what an integrator must not be mistaken for.
    """

    u: Array
    y: Array
    units: tuple[float, float]
    first: int
    drifts: bool = False

    @property
    def last_y(self) -> Array:
        """The output y from `first` on."""
        return self.y[self.first :]


def scalar_record(
    u: ArrayLike, y: ArrayLike, longest: int, *, drifts: bool = False
) -> ScalarRecord:
    """The record of one u and one y, for models of orders and delays of `longest` together."""
    control, output = scalar_signal(u, "u"), scalar_signal(y, "y")
    if len(control) != len(output):
        raise InputError(
            f"u has {len(control)} steps and y {len(output)}; they must be equally long."
        )
    if len(control) < STEPS_EACH * (longest + 2):
        raise InputError(
            f"there are {len(control)} steps, and for orders and delays of {longest} together at "
            f"least {STEPS_EACH * (longest + 2)} are needed. Record more, or reduce orders or "
            "delays."
        )
    units = float(np.std(control)), float(np.std(output))
    for name, one in zip("uy", units, strict=True):
        if not one > 0:
            raise InputError(f"{name} is constant: the record does not show the plant.")
    return ScalarRecord(
        (control - control.mean()) / units[0], (output - output.mean()) / units[1], units, longest,
        drifts,
    )  # fmt: skip


def shapes(orders: Iterable[int], delays: Iterable[int], integrators: Iterable[int]) -> list[Shape]:
    """The candidate models: every order, delay and number of integrators that are compatible."""
    ns = [integer(n, "order", at_least=1) for n in items(orders, "orders")]
    ds = [integer(d, "delay") for d in items(delays, "delays")]
    poles = [integer(i, "integrators", at_most=1) for i in items(integrators, "integrators")]
    candidates = [(n, d, i) for i in poles for n in ns for d in ds]
    if not candidates:
        raise InputError(
            "there is no candidate model: give an order, a delay, and integrators (0,)."
        )
    return candidates


def scalar_signal(values: ArrayLike, name: str) -> Array:
    """A signal of one component, as an array of shape (steps,)."""
    signal = squarable(real_array(values, name), name)
    if signal.ndim == 2 and signal.shape[1] != 1:
        raise InputError(f"{name} has {signal.shape[1]} columns; one signal is needed.")
    return signal.ravel()


def late(signal: Array, steps: int) -> Array:
    """Delay a signal by some steps, with zeros before."""
    return signal if not steps else np.r_[np.zeros(steps), signal[:-steps]]


def inside(A: Array) -> Array:
    """Reflect the roots of A outside the unit circle into it; powers of q^-1 from 1 on."""
    A = np.asarray(A, dtype=np.float64)
    roots = np.roots(A)
    size = np.abs(roots)
    if not (size > FASTEST).any():
        return A
    reflected = np.where(size > FASTEST, 1 / np.conj(np.where(size > 0, roots, 1.0)), roots)
    return np.asarray(np.poly(reflected).real)


def information_criterion(e: Array, parameters: int, penalty: float) -> float:
    """N log(mean e^2) + penalty x parameters x log N."""
    size = max(float(np.mean(e**2)), np.finfo(float).tiny)
    return float(len(e) * np.log(size) + penalty * parameters * np.log(len(e)))


def integrated_share(A: Array, B: Array) -> float:
    """The share of the pole at 1 of B/((1 - q^-1) A) in the gain at 0.02 rad/step.

    Its residue over 0.02 abs(G): 1 for an integrator alone, 0 where a zero cancels it.
    """
    there = np.exp(-1j * LOW)
    gain = np.polyval(B[::-1], there) / (np.polyval(A[::-1], there) * (1 - there))
    return float(abs(B.sum() / A.sum() / LOW) / abs(gain)) if A.sum() and gain else 0.0
