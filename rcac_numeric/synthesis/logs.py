"""A plant from a log of u and y: an output-error model, and what parts of the log say of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import tf2ss

from compensator_theory.errors import InputError
from rcac_numeric.analysis.closed_loop import ClosedLoop
from rcac_numeric.arrays.values import Value
from rcac_numeric.checks.logs import ControllerLog
from rcac_numeric.controllers.compensator import Compensator
from rcac_numeric.identification.output_error import OutputErrorModel, identify_output_error
from rcac_numeric.synthesis.plants import DesignPlant, Uncertainty, balanced
from rcac_numeric.synthesis.reference import sensitivity_peak

PARTS = 3  # of the log, in each of which the model is fitted again
SLOW = 20.0  # abs(1 - pole) times the steps of the log: a pole that the log cannot tell from 1
ROBUST = 4.0  # Ms of the reference loop with the model of a part


@dataclass(frozen=True, eq=False)
class LoggedPlant(Value):
    """What a log shows of a plant.

    Attributes
    ----------
    plant : DesignPlant
    model : OutputErrorModel
    parts : tuple of DesignPlant or None
        Of the same order and delay, each fitted to one third of the log; None where that third
        shows nothing.
    noise : float
        Standard deviation of what of the residual is white at most, in units of y.
    disturbance : float
        Size of what is left of it, in units of u.
    u : (float, float)
        The least and the largest control of the log.
    """

    plant: DesignPlant
    model: OutputErrorModel
    parts: tuple[DesignPlant | None, ...]
    noise: float
    disturbance: float
    u: tuple[float, float]

    @property
    def gains(self) -> tuple[float, ...]:
        """Gain of each part over that of the whole; negative where it has another sign."""
        return tuple(
            (1 if part.sign == self.plant.sign else -1) * part.low_gain / self.plant.low_gain
            for part in self.parts
            if part is not None
        )

    @property
    def integrates(self) -> bool:
        """Whether the model has a pole so near 1 that the log cannot tell it from an integrator."""
        poles = np.roots(self.model.denominator)
        return bool((np.abs(1 - poles) * len(self.model.residual) < SLOW).any())

    @property
    def uncertainty(self) -> Uncertainty:
        """The usual one, with a gain as uncertain as the parts disagree."""
        usual = Uncertainty()
        found = [one for one in self.gains if one > 0] or [1.0]
        low, high = usual.gain
        return Uncertainty(gain=(min(low, *found), max(high, *found)))

    def held(self, compensator: Compensator) -> int:
        """On how many parts the loop with a controller is stable with Ms < 4."""
        peaks = [
            sensitivity_peak(ClosedLoop(part.servo(), compensator))
            for part in self.parts
            if part is not None
        ]
        return sum(peak < ROBUST for peak in peaks)

    def evidence(self, compensator: Compensator) -> str:
        """In words, for the one who is to confirm it."""
        gains = self.gains
        same = sum(one > 0 for one in gains)
        spread = f", their gains {min(gains):.3g} to {max(gains):.3g} times" if gains else ""
        return (
            f"{same} of {PARTS} parts of the log have this sign{spread}; the fixed controller "
            f"holds {self.held(compensator)} of them with Ms < {ROBUST:g}"
        )


def plant_from_log(
    log: ControllerLog, sample_time: float | None = None, dead_time: float = 0.0
) -> LoggedPlant:
    """The plant that a log shows, by `identify_output_error`.

    Parameters
    ----------
    log : ControllerLog
        Of u and y of an open loop, each scalar.
    sample_time : float, optional
        In seconds.
    dead_time : float
        Where it is known: in seconds, in steps without a sample time; 0 looks for it.

    Raises
    ------
    InputError
        Where the log does not show that y answers to u.

    Examples
    --------
    >>> import numpy as np
    >>> from scipy.signal import lfilter
    >>> from rcac_numeric import ControllerLog
    >>> from rcac_numeric.synthesis.logs import plant_from_log
    >>> rng = np.random.default_rng(1)
    >>> u = rng.standard_normal(1000)
    >>> y = lfilter([0, 0, 0, -0.1], [1, -0.9], u) + 0.01 * rng.standard_normal(1000)
    >>> found = plant_from_log(ControllerLog(u, y))
    >>> found.plant.delay, found.plant.sign, round(found.noise, 3)
    (2, '-', 0.01)
    """
    if log.u.shape[1] != 1 or log.y.shape[1] != 1:
        raise InputError(
            f"{log.source} has {log.u.shape[1]} controls and {log.y.shape[1]} measurements; "
            "a log takes one of each. Give design a model: identification.eigensystem_realisation "
            "makes one of Markov parameters."
        )
    late = round(dead_time / (sample_time or 1.0))
    known = {"delays": (late,)} if late else {}
    model = identify_output_error(log.u, log.y, **known)
    plant = _plant_of(model, sample_time)
    parts: list[DesignPlant | None] = []
    for u, y in zip(np.array_split(log.u, PARTS), np.array_split(log.y, PARTS), strict=True):
        try:
            part = identify_output_error(u, y, orders=(model.order,), delays=(model.delay,))
            parts.append(_plant_of(part, sample_time))
        except InputError:
            parts.append(None)
    e = model.residual
    noise = min(float(np.std(np.diff(e)) / np.sqrt(2)), float(np.std(e)))
    rest = float(np.sqrt(max(float(np.var(e)) - noise**2, 0.0)))
    size = max(rest, noise) / plant.low_gain
    limits = float(log.u.min()), float(log.u.max())
    return LoggedPlant(plant, model, tuple(parts), noise, size, limits)


def _plant_of(model: OutputErrorModel, sample_time: float | None) -> DesignPlant:
    A, B, C, _ = tf2ss(model.numerator, model.denominator)
    A, B, C = balanced(A, B, C)
    made = DesignPlant(A, B, C, model.delay, sample_time=sample_time)
    if not made.low_gain > 0:
        raise InputError("the model of the log has no gain: y does not answer to u.")
    return made
