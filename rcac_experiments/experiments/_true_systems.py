"""The true system of an estimation example, and the records computed from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Annotated, NamedTuple

import attrs
import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import InputError
from rcac_experiments.format._tables import ByKey
from rcac_experiments.format._values import Integer, ListOf, Real, Row
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import (
    instance_of,
    integer,
    matrix,
    number,
    optional_array_like,
    vector,
)
from rcac_numeric.arrays._values import Value
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.engine._simulation import simulate
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantChange, PlantSchedule
from rcac_numeric.signals._signal import Signal, exogenous
from rcac_numeric.signals._waveforms import Harmonic, Ramp, Step, WhiteNoise


class Record(NamedTuple):
    """The data of an estimator, w and y, and the true values."""

    w: Array
    y: Array
    truth: Array


AT_FIRST = "At the first value of the parameter; D_1 is where the known input acts, or the control."
AT_LAST = "At the last value of the parameter, linear in it; as at first where they are left out."
NOISE = "Mean and standard deviation of the sensor noise v."
TRAJECTORY = ListOf(Row((Integer(), Real()), "a pair [step, value]"), 1)
EXCITATION: ByKey[Signal] = ByKey("an excitation", number=Step)
EXCITATION.register("step", Step)
EXCITATION.register("ramp", Ramp)
EXCITATION.register("harmonic", Harmonic)
EXCITATION.register("white_noise", WhiteNoise)


def _excitation(signal: Signal | None) -> Signal:
    return WhiteNoise() if signal is None else signal


@attrs.frozen(eq=False, slots=False)
class TrueSystem(Value):
    """x(k+1) = A(k) x(k) + D_1(k) w(k), y = C x + v, with a parameter that moves along a course.

    A(k) and D_1(k) are linear in the parameter: at its first value A and D_1, at its last value
    A_then and D_1_then.

    Examples
    --------
    >>> from rcac_experiments.experiments._true_systems import TrueSystem
    >>> system = TrueSystem(A=[[0.5]], D_1=[1], C=[1], truth=[(0, 2), (10, 3)], A_then=[[0.6]])
    >>> record = system.record(steps=12, seed=0)
    >>> record.y.shape, record.truth[[0, 5, 11]]
    ((12, 1), array([2. , 2.5, 3. ]))
    """

    A: Annotated[Array, AT_FIRST]
    D_1: Annotated[Array, AT_FIRST]
    C: Annotated[Array, "What is measured."]
    truth: Annotated[
        Sequence[tuple[int, float]],
        TRAJECTORY,
        "The true values: linear between the steps, constant after the last.",
    ]
    A_then: Annotated[Array, AT_LAST] = attrs.field(default=None, converter=optional_array_like)
    D_1_then: Annotated[Array, AT_LAST] = attrs.field(default=None, converter=optional_array_like)
    w: Annotated[
        Signal,
        EXCITATION,
        "The known input: `{ white_noise = 10 }` with its standard deviation, `{ ramp = 0.1 }`, "
        "`{ step = 1 }` or `{ harmonic = 1, omega = 0.1 }`; white noise of deviation 1 by "
        "default.",
    ] = attrs.field(default=None, converter=_excitation)
    bias: Annotated[float, NOISE] = 0.0
    deviation: Annotated[float, NOISE] = 0.0
    x_0: Annotated[Array, "x(0); zero where it is left out."] = attrs.field(
        default=None, converter=optional_array_like
    )

    def __attrs_post_init__(self) -> None:
        set_ = partial(object.__setattr__, self)
        n = matrix(self.A, "A", (None, None)).shape[0]
        set_("A", matrix(self.A, "A", (n, n)))
        set_("D_1", columns_of(self.D_1, "D_1", n))
        set_("C", rows_of(self.C, "C", n))
        pairs = [
            (integer(k, "a step of truth"), number(v, "a value of truth")) for k, v in self.truth
        ]
        steps = [k for k, _ in pairs]
        if not pairs or steps[0] != 0 or sorted(set(steps)) != steps:
            raise InputError(f"truth = {pairs} must begin at step 0, with steps in order.")
        set_("truth", tuple(pairs))
        A_then: Array | None = self.A_then
        D_1_then: Array | None = self.D_1_then
        if (A_then is not None or D_1_then is not None) and pairs[0][1] == pairs[-1][1]:
            raise InputError("the last value of truth is its first: A_then has no meaning.")
        set_("A_then", self.A if A_then is None else matrix(A_then, "A_then", (n, n)))
        then = self.D_1 if D_1_then is None else columns_of(D_1_then, "D_1_then", n)
        if then.shape != self.D_1.shape:
            raise InputError(f"D_1_then has shape {then.shape} and D_1 {self.D_1.shape}.")
        set_("D_1_then", then)
        instance_of(self.w, "w", Signal)
        set_("bias", number(self.bias, "bias"))
        set_("deviation", number(self.deviation, "deviation"))
        if self.deviation < 0:
            raise InputError(f"deviation = {self.deviation} cannot be negative.")
        set_("x_0", vector(np.zeros(n) if self.x_0 is None else self.x_0, "x_0", n))

    @property
    def n(self) -> int:
        """Number of states."""
        return int(self.A.shape[0])

    def parameter_trajectory(self, steps: int) -> Array:
        """The true parameter at each step."""
        k, values = zip(*self.truth, strict=True)
        return np.asarray(np.interp(np.arange(steps), k, values), dtype=float)

    def schedule(self, plant_of: Callable[[Array, Array, Array], Plant]) -> PlantSchedule:
        """The system as a plant that changes, made of A, D_1 and C."""
        first, last = self.truth[0][1], self.truth[-1][1]
        changes = []
        for i, (k, value) in enumerate(self.truth):
            part = (value - first) / (last - first) if last != first else 0.0
            A = (1 - part) * self.A + part * self.A_then
            D_1 = (1 - part) * self.D_1 + part * self.D_1_then
            moves = i + 1 < len(self.truth) and self.truth[i + 1][1] != value
            changes.append(PlantChange(start=k, plant=plant_of(A, D_1, self.C), ramp=moves))
        return PlantSchedule(changes)

    def record(self, steps: int, seed: int) -> Record:
        """w, y with its noise, and the truth, for one seed."""
        l_w, l_y = self.D_1.shape[1], self.C.shape[0]
        w = exogenous([self.w] * l_w, steps, seed)
        nothing = FixedController(Compensator([[[0.0]]], np.zeros((2, 1, l_y))))
        y = simulate(self.schedule(_observed), nothing, w, x_0=self.x_0).y
        if len(y) < steps:
            raise InputError("the true system diverges within the record; see A and A_then.")
        v = np.random.default_rng([seed, 1]).standard_normal(y.shape)
        return Record(w, y + self.bias + self.deviation * v, self.parameter_trajectory(steps))


def _observed(A: Array, D_1: Array, C: Array) -> Plant:
    """Without a control: w acts, y is measured, and an input u does nothing."""
    l_y, l_w, none = len(C), D_1.shape[1], np.zeros((len(A), 1))
    feed, still = np.zeros((l_y, l_w)), np.zeros((l_y, 1))
    return Plant(A=A, B=none, D_1=D_1, C=C, D_0=still, D_2=feed, E_1=C, E_2=still, E_0=feed)


def columns_of(value: ArrayLike, name: str, n: int) -> Array:
    """An n x l matrix; a list of n numbers is one column."""
    array = np.asarray(value)
    return matrix(array.reshape(-1, 1) if array.ndim == 1 else value, name, (n, None))


def rows_of(value: ArrayLike, name: str, n: int) -> Array:
    """An l x n matrix; a list of n numbers is one row."""
    array = np.asarray(value)
    return matrix(array.reshape(1, -1) if array.ndim == 1 else value, name, (None, n))
