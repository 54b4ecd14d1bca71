"""A plant model from a log of u and y, in open or closed loop, and its evidence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import Legendre
from scipy.signal import tf2ss
from scipy.stats import ttest_1samp

from compensator_theory.errors import Advice, InputError
from rcac_numeric.analysis._closed_loop import frozen_loop
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import number
from rcac_numeric.arrays._values import Result
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.designing._plants import LOW, DesignPlant, Uncertainty, balanced
from rcac_numeric.designing._reference import sensitivity_peak
from rcac_numeric.identification._output_error import OutputErrorModel, identify_output_error
from rcac_numeric.identification._prediction_error import (
    PredictionErrorModel,
    answers,
    identify_in_closed_loop,
)

PARTS = 3  # of the log, in each of which the model is fitted again
SLOW = 20.0  # abs(1 - pole) times the steps of the log: a pole that the log cannot tell from 1
ROBUST = 4.0  # Ms of the reference loop with the model of a part
HELD_OUT = 3  # the last part of so many, which a pole at 1 is verified on
BLOCKS, SURELY = 10, 0.05  # blocks and level of the test that compares its errors there
DRIFTS = 3  # degree of the polynomial that counts as no error there
ACCIDENT = 4.0  # standard errors: the largest of 20 correlations is above once in 800 records

LogModel = OutputErrorModel | PredictionErrorModel


@dataclass(frozen=True, eq=False)
class LoggedPlant(Result):
    """A plant model from a log, with its evidence.

    Attributes
    ----------
    plant : DesignPlant
    model : OutputErrorModel or PredictionErrorModel
        The latter where u answered to y.
    parts : tuple of DesignPlant or None
        Of the same delay, each fitted to one third of the log, of at most the same order: a third
        may support less. None where it shows nothing.
    noise : float
        Standard deviation of the white part of the residual at most, in units of y.
    disturbance : float
        Size of the remainder, in units of u.
    u : (float, float)
        The least and the largest control of the log.
    held_out : float or None
        Where a pole at 1 was taken: the mean square error on the last third of a model with that
        pole, fitted to the rest, over that of a model with a free one.
    """

    plant: DesignPlant
    model: LogModel
    parts: tuple[DesignPlant | None, ...]
    noise: float
    disturbance: float
    u: tuple[float, float]
    held_out: float | None = None

    @property
    def gains(self) -> tuple[float, ...]:
        """Gain of each part over that of the whole; negative where it has another sign.

        At 0.02 rad/step: at rest a pole and a zero that all but cancel there, which fit the noise,
        may turn the sign of a part.
        """
        whole = self.plant.response(LOW).item()
        ratios = [part.response(LOW).item() / whole for part in self.parts if part is not None]
        return tuple(float(np.copysign(abs(one), one.real)) for one in ratios)

    @property
    def integrates(self) -> bool:
        """Whether a further pole is so near 1 that the log cannot distinguish it from 1."""
        near = np.abs(1 - np.roots(self.model.denominator)) * len(self.model.residual) < SLOW
        return int(near.sum()) > self.model.integrators

    @property
    def is_closed(self) -> bool:
        """Whether the log is from a closed loop."""
        return isinstance(self.model, PredictionErrorModel)

    @property
    def uncertainty(self) -> Uncertainty:
        """The default uncertainty, with the range of gains of the parts."""
        usual = Uncertainty()
        gains = [one for one in self.gains if one > 0] or [1.0]
        low, high = usual.gain
        return Uncertainty(gain=(min(low, *gains), max(high, *gains)))

    def stable_parts(self, compensator: Compensator) -> int:
        """The number of parts whose loop with a controller is stable with Ms < 4."""
        peaks = [
            sensitivity_peak(frozen_loop(part.servo(), compensator, 0))
            for part in self.parts
            if part is not None
        ]
        return sum(peak < ROBUST for peak in peaks)

    def evidence(self, compensator: Compensator) -> str:
        """The evidence in words."""
        gains = self.gains
        same = sum(one > 0 for one in gains)
        spread = f", their gains {min(gains):.3g} to {max(gains):.3g} times" if gains else ""
        evidence = [
            f"{same} of {PARTS} parts of the log have this sign{spread}",
            f"the fixed controller stabilises {self.stable_parts(compensator)} of them with "
            f"Ms < {ROBUST:g}",
        ]
        if self.held_out is not None:
            evidence.append(
                f"with a pole at 1 the error on the last third is {np.sqrt(self.held_out):.3g} "
                "times that with a free pole"
            )
        if isinstance(self.model, PredictionErrorModel):
            evidence.append(
                "its prediction errors are correlated with the excitation of u by "
                f"{self.model.correlation:.2g} standard errors at most"
            )
        return "; ".join(evidence)


def plant_from_log(
    log: ControllerLog, sample_time: float | None = None, dead_time: float = 0.0, most: int = 5
) -> LoggedPlant:
    """Identify a plant from a log in open or in closed loop.

    In an open loop by `identify_output_error`; in a closed one, where the plant may be unstable, by
    `identify_in_closed_loop`. A pole at 1 is taken where the criterion is the better for it and a
    held-out part of the log is predicted as well.
    """
    if log.u.shape[1] != 1 or log.y.shape[1] != 1:
        raise InputError(
            f"{log.source} has {log.u.shape[1]} controls and {log.y.shape[1]} measurements; "
            "design takes a log with one of each. Give design a model: "
            "identification.eigensystem_realisation makes one from Markov parameters."
        )
    late, period = number(dead_time, "dead_time"), number(sample_time or 1.0, "sample_time")
    if late < 0 or not period > 0:
        raise InputError(
            f"dead_time = {late:g} with sample_time = {period:g}: give both in seconds, none of "
            "them negative."
        )
    if log.missing.any():
        raise InputError(
            f"{log.source}: {np.count_nonzero(log.missing)} of {log.steps} rows are missing"
            + (f" ({log.clock})" if log.clock else "")
            + ", and design needs every row. ",
            Advice("read_log", (("resample", f"{log.sample_time or 1.0:g}"),),
                   "Fill them by interpolation with resample={resample}"),
            "; or cut the log to a part without gaps (log.longest_part()).",
        )  # fmt: skip
    steps = round(late / period)
    known: dict[str, Any] = {"orders": range(1, most + 1)}
    known |= {"delays": (steps,)} if steps else {}
    is_closed = (log.r is not None and np.ptp(log.r) > 0) or answers(log.u, log.y)
    identify = identify_in_closed_loop if is_closed else identify_output_error
    model: LogModel = identify(log.u, log.y, integrators=(0, 1), **known)
    verification = None
    if model.integrators:
        verification, is_worse = _verify_integrator(log, model)
        if is_worse:
            model, verification = identify(log.u, log.y, **known), None
    if isinstance(model, PredictionErrorModel) and model.correlation > ACCIDENT:
        raise InputError(
            f"u depends on y in {log.source}, and no model separates plant and controller: the "
            "prediction errors of the best one are correlated with the excitation of u by "
            f"{model.correlation:.2g} standard errors. Give design a model; or record longer, with "
            "a dither on u, while neither plant nor controller changes."
        )
    plant = _plant_of(model, sample_time)
    parts: list[DesignPlant | None] = []
    for u, y in zip(np.array_split(log.u, PARTS), np.array_split(log.y, PARTS), strict=True):
        try:
            parts.append(_plant_of(_again(model, u, y, least=1), sample_time))
        except InputError:
            parts.append(None)
    e = model.residual
    noise = min(float(np.std(np.diff(e)) / np.sqrt(2)), float(np.std(e)))
    rest = float(np.sqrt(max(float(np.var(e)) - noise**2, 0.0)))
    size = max(rest, noise) / plant.low_gain
    limits = float(log.u.min()), float(log.u.max())
    return LoggedPlant(plant, model, tuple(parts), noise, size, limits, verification)


def _again(
    model: LogModel, u: Array, y: Array, integrators: int | None = None, least: int | None = None
) -> LogModel:
    """Identify a model of the same kind and delay, of at most the same order."""
    is_closed = isinstance(model, PredictionErrorModel)
    identify = identify_in_closed_loop if is_closed else identify_output_error
    poles = model.integrators if integrators is None else integrators
    orders = range(model.order if least is None else max(least, poles), model.order + 1)
    return identify(u, y, orders=orders, delays=(model.delay,), integrators=(poles,))


def _verify_integrator(log: ControllerLog, model: LogModel) -> tuple[float, bool]:
    """Compare the mean square errors on the last third with a pole at 1 and with a free pole.

    Returns their ratio, and whether it is significantly larger than 1, by Diebold and Mariano's
    test with the means of blocks.
    """
    cut = len(log.u) - len(log.u) // HELD_OUT
    squares = []
    for poles in (1, 0):
        try:
            refitted = _again(model, log.u[:cut], log.y[:cut], poles)
        except InputError:  # the first two thirds have too little excitation
            return np.inf, True
        try:
            e = refitted.errors(log.u[cut:], log.y[cut:])
        except InputError as error:
            raise InputError(
                f"the last third of {log.source}, {len(log.u) - cut} of its {len(log.u)} steps, is "
                "needed to distinguish a pole at 1 from one near it, and is too short or not "
                f"excited: {error} A third of the log must fulfil this."
            ) from None
        k = np.linspace(-1, 1, len(e))
        # A pole near 1 explains a drift by its state, a pole at 1 by the slope.
        squares.append((e - Legendre.fit(k, e, DRIFTS)(k)) ** 2)
    imposed, free = (np.mean(one) for one in squares)
    means = [one.mean() for one in np.array_split(squares[0] - squares[1], BLOCKS)]
    if not np.ptp(means) or not free:
        return 1.0, False
    is_worse = ttest_1samp(means, 0.0, alternative="greater").pvalue < SURELY
    return float(imposed / free), bool(is_worse)


def _plant_of(model: LogModel, sample_time: float | None) -> DesignPlant:
    size = float(np.abs(model.numerator).max()) or 1.0  # SciPy takes 1e-14 for nothing
    A, B, C, _ = tf2ss(model.numerator / size, model.denominator)
    A, B, C = balanced(A, B, C * size)
    plant = DesignPlant(A, B, C, model.delay, sample_time=sample_time)
    if not plant.low_gain > 0:
        raise InputError("the model of the log has gain 0: u has no effect on y.")
    return plant
