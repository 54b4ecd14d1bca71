"""The tables [estimation] and [estimator] of an estimation example's file."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

from numpy.typing import ArrayLike

from rcac_numeric.experiments.estimation.filters import JointFilter
from rcac_numeric.experiments.estimation.refinements import controlled, refined
from rcac_numeric.experiments.estimation.runs import Estimation
from rcac_numeric.experiments.estimation.true_systems import TrueSystem
from rcac_numeric.experiments.format.by_key import ByKey
from rcac_numeric.experiments.format.deferred import Deferred
from rcac_numeric.experiments.format.lists import ListOf, Row
from rcac_numeric.experiments.format.tables import Kinds, Table
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


def _trial(
    A: ArrayLike,
    D_1: ArrayLike,
    C: ArrayLike,
    truth: Sequence[tuple[int, float]],
    steps: int,
    seed: int = 0,
    seeds: int = 1,
    A_then: ArrayLike | None = None,
    D_1_then: ArrayLike | None = None,
    w: Signal | None = None,
    bias: float = 0.0,
    deviation: float = 0.0,
    x_0: ArrayLike | None = None,
) -> Trial:
    """The true system x(k+1) = A(k) x + D_1(k) w, y = C x + v, and how often it is recorded.

    Parameters
    ----------
    A, D_1 : matrix
        At the first value of the parameter; D_1 is where the known input acts, or the control.
    C : matrix
        What is measured.
    truth : pairs [step, value]
        What is to be estimated: linear between the steps, constant after the last.
    steps : int
        Length of a record.
    seed, seeds : int
        The first seed, and how many there are from it on.
    A_then, D_1_then : matrix
        At the last value of the parameter, linear in it; as at first where they are left out.
    w : signal
        The known input: `{ white_noise = 10 }` with its standard deviation, `{ ramp = 0.1 }`,
        `{ step = 1 }` or `{ harmonic = 1, omega = 0.1 }`; white noise of deviation 1 by default.
    bias, deviation : number
        Mean and standard deviation of the sensor noise v.
    x_0 : list of numbers
        x(0); zero where it is left out.
    """
    system = TrueSystem(A, D_1, C, truth, A_then, D_1_then, w, bias, deviation, x_0)
    return Trial(system, steps, seed, seeds)


def _estimator(kind: Estimation) -> Estimation:
    """An estimator of the parameter.

    Parameters
    ----------
    kind : str
        Which estimator.
    """
    return kind


MATRICES: dict[str, Form] = dict.fromkeys(
    ("A", "D_1", "C", "A_then", "D_1_then", "A_p", "D_p", "B", "E_1", "C_r", "x_0", "Q", "R",
     "P_0"),
    Numbers(),
)  # fmt: skip
STEPS = {"delays": ListOf(Integer(1), 1), "window": Integer(1, 100_000), "d": Integer(1)}


def _known(*names: str) -> dict[str, Form]:
    return {name: form for name, form in MATRICES.items() if name in names}


TRIAL = Deferred(
    Table(
        _trial,
        forms={
            **_known("A", "D_1", "C", "A_then", "D_1_then", "x_0"),
            "truth": ListOf(Row((Integer(), Real()), "a pair [step, value]"), 1),
            "w": EXCITATION,
            "steps": Integer(1),
            "seeds": Integer(1),
        },
    )
)


def _filter(kind: str) -> Table[JointFilter]:
    make = partial(JointFilter, kind)
    make.__doc__, make.__qualname__ = JointFilter.__doc__, kind  # type: ignore[attr-defined]
    forms = _known("A", "A_p", "D_1", "C", "Q", "R", "x_0", "P_0")
    return Table(make, forms={**forms, "alpha": Real()})


KINDS: dict[str, Table[Any]] = {
    "ekf": _filter("ekf"),
    "ukf": _filter("ukf"),
    "rcmr": Table(refined, forms={**MATRICES, **STEPS, "k_update": Integer()}),
    "indirect": Table(
        controlled,
        forms={**MATRICES, **STEPS, "k_update": Integer(), "V_1": Real(), "V_2": Real()},
    ),
}
ESTIMATOR: Deferred = Deferred(Table(_estimator, forms={"kind": Kinds(KINDS)}))
