"""The tables [estimation] and [estimator] of an estimation example's file."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, NamedTuple

import attrs

from rcac_numeric.arrays.array_types import Array
from rcac_numeric.experiments.estimation.filters import JointFilter
from rcac_numeric.experiments.estimation.refinements import controlled, refined
from rcac_numeric.experiments.estimation.runs import Estimation
from rcac_numeric.experiments.estimation.true_systems import TrueSystem
from rcac_numeric.experiments.format.lists import ListOf, Row
from rcac_numeric.experiments.format.parts import Shorthand, resolved
from rcac_numeric.experiments.format.tables import ByKey, Deferred, Kinds, Table
from rcac_numeric.experiments.format.values import Form, Integer, Numbers, Real
from rcac_numeric.signals.signal import Signal
from rcac_numeric.signals.waveforms import Harmonic, Ramp, Step, WhiteNoise

EXCITATION: ByKey[Signal] = ByKey("an excitation", number=Step)
EXCITATION.register("step", Step)
EXCITATION.register("ramp", Ramp)
EXCITATION.register("harmonic", Harmonic)
EXCITATION.register("white_noise", WhiteNoise)


class Trial(NamedTuple):
    """The true system and how long and how often it is recorded."""

    system: TrueSystem
    steps: int
    seed: int
    seeds: int


AT_FIRST = "At the first value of the parameter; D_1 is where the known input acts, or the control."
AT_LAST = "At the last value of the parameter, linear in it; as at first where they are left out."
SEEDS = "The first seed, and how many there are from it on."
NOISE = "Mean and standard deviation of the sensor noise v."
COURSE = ListOf(Row((Integer(), Real()), "a pair [step, value]"), 1)


@attrs.frozen(eq=False)
class TrialTable(Shorthand):
    """The true system x(k+1) = A(k) x + D_1(k) w, y = C x + v, and how often it is recorded."""

    A: Annotated[Array, AT_FIRST]
    D_1: Annotated[Array, AT_FIRST]
    C: Annotated[Array, "What is measured."]
    truth: Annotated[
        list[tuple[int, float]],
        COURSE,
        "What is to be estimated: linear between the steps, constant after the last.",
    ]
    steps: Annotated[int, Integer(1), "Length of a record."]
    seed: Annotated[int, SEEDS] = 0
    seeds: Annotated[int, Integer(1), SEEDS] = 1
    A_then: Annotated[Array | None, AT_LAST] = None
    D_1_then: Annotated[Array | None, AT_LAST] = None
    w: Annotated[
        Signal | None,
        EXCITATION,
        "The known input: `{ white_noise = 10 }` with its standard deviation, `{ ramp = 0.1 }`, "
        "`{ step = 1 }` or `{ harmonic = 1, omega = 0.1 }`; white noise of deviation 1 by "
        "default.",
    ] = None
    bias: Annotated[float, NOISE] = 0.0
    deviation: Annotated[float, NOISE] = 0.0
    x_0: Annotated[Array | None, "x(0); zero where it is left out."] = None

    def made(self) -> Trial:
        """The true system, and how it is recorded."""
        system = TrueSystem(
            self.A, self.D_1, self.C, self.truth, self.A_then, self.D_1_then, self.w, self.bias,
            self.deviation, self.x_0,
        )  # fmt: skip
        return Trial(system, self.steps, self.seed, self.seeds)


OF_MODEL = "Of the model."


@attrs.frozen(eq=False)
class Filter(Shorthand):
    """A filter of [x; p] with x(k+1) = (A + p A_p) x + D_1 w and y = C x, p taken as constant."""

    kind: ClassVar[str]

    A: Annotated[Array, "Of the model, without the parameter."]
    A_p: Annotated[Array, "The derivative of A with respect to the parameter."]
    D_1: Annotated[Array, OF_MODEL]
    C: Annotated[Array, OF_MODEL]
    Q: Annotated[
        Array,
        "Covariance of the noise of [x; p]: a matrix, its diagonal, or a number for a multiple of"
        " I.",
    ]
    R: Annotated[Array, "Covariance of the noise of y."]
    x_0: Annotated[Array | None, "What is believed of [x; p] at first."] = None
    P_0: Annotated[float | Array, Numbers(), "Its covariance."] = 1.0
    alpha: Annotated[float | None, "Of the UKF, see {py:class}`rcac_numeric.estimation.UKF`."] = (
        None
    )

    def made(self) -> JointFilter:
        """The filter."""
        return JointFilter(
            self.kind, self.A, self.A_p, self.D_1, self.C, self.Q, self.R, self.x_0, self.P_0,
            self.alpha,
        )  # fmt: skip


@attrs.frozen(eq=False)
class ExtendedFilter(Filter):
    """A filter of [x; p] with x(k+1) = (A + p A_p) x + D_1 w and y = C x, p taken as constant."""

    kind = "ekf"


@attrs.frozen(eq=False)
class UnscentedFilter(Filter):
    """A filter of [x; p] with x(k+1) = (A + p A_p) x + D_1 w and y = C x, p taken as constant."""

    kind = "ukf"


MATRICES: dict[str, Form] = dict.fromkeys(
    ("A", "D_1", "C", "A_then", "D_1_then", "A_p", "D_p", "B", "E_1", "C_r", "x_0", "Q", "R",
     "P_0"),
    Numbers(),
)  # fmt: skip
STEPS = {"delays": ListOf(Integer(1), 1), "window": Integer(1, 100_000), "d": Integer(1)}


KINDS: dict[str, Table[Any]] = {
    "ekf": Table(ExtendedFilter),
    "ukf": Table(UnscentedFilter),
    "rcmr": Table(refined, forms={**MATRICES, **STEPS, "k_update": Integer()}),
    "indirect": Table(
        controlled,
        forms={**MATRICES, **STEPS, "k_update": Integer(), "V_1": Real(), "V_2": Real()},
    ),
}
ESTIMATORS: Kinds[Any] = Kinds(KINDS)


@attrs.frozen(eq=False)
class Estimator(Shorthand):
    """An estimator of the parameter."""

    kind: Annotated[Any, ESTIMATORS, "Which estimator."]

    def made(self) -> Estimation:
        """The estimator."""
        estimation: Estimation = resolved(self.kind, None)
        return estimation


TRIAL = Deferred(Table(TrialTable))
ESTIMATOR = Deferred(Table(Estimator))
