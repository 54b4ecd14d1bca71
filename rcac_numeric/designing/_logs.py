"""A plant model from a log of u and y, in open or closed loop, and its evidence."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from compensator_theory.errors import InputError, UndecidedError
from rcac_numeric.analysis._closed_loop import frozen_loop
from rcac_numeric.arrays._validation import number
from rcac_numeric.arrays._values import Result
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.designing._log_gates import (
    Part,
    controller_gates,
    design_plant,
    gate_loop,
    lost_plants,
)
from rcac_numeric.designing._plants import LONGEST_DELAY, LOW, DesignPlant, Uncertainty
from rcac_numeric.designing._reference import sensitivity_peak
from rcac_numeric.identification._box_jenkins import ProcessFit
from rcac_numeric.identification._hidden_pairs import has_hidden_pair
from rcac_numeric.identification._prediction_error import PAST_U, STIRRED, excitation
from rcac_numeric.identification._process import (
    ProcessModel,
    gates_without_controller,
    process_model,
    require_effect,
    search_of,
)
from rcac_numeric.identification._process_evidence import (
    KNOWN,
    Gate,
    bandwidth,
    effect_gate,
    part_fits,
    relative_deviation,
)

PARTS = 2  # of the log, in each of which the model is fitted again
# A pole that the log cannot distinguish from 1: abs(1 - pole) times its steps is below SLOW, and
# abs(1 - pole) below CLEAR standard deviations of the pole.
SLOW, CLEAR = 20.0, 4.0
ROBUST = 4.0  # Ms of the reference loop with the model of a part
USUAL_DELAY = 30  # steps of dead time of a controller that skips rows
TRIED = 4  # credible models for which a controller is designed until one passes every gate


class PartsOfALog(Result):
    """Models of parts of a log beside the model of the whole log, for one signal or several."""

    if TYPE_CHECKING:

        @property
        def parts(self) -> tuple[DesignPlant | None, ...]: ...

        @property
        def gains(self) -> tuple[float, ...]: ...

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


@dataclass(frozen=True, eq=False)
class LoggedPlant(PartsOfALog):
    """A plant model from a log, with its evidence.

    Attributes
    ----------
    plant : DesignPlant
    model : ProcessModel
        With its gates, those that need a controller included once it exists.
    parts : tuple of DesignPlant or None
        The model fitted again to each half of the log; None where a half does not determine it.
    noise : float
        Standard deviation of the white part of the residual at most, in units of y.
    disturbance : float
        Size of the remainder, in units of u.
    u : (float, float)
        The least and the largest control of the log.
    is_closed : bool
        Whether the log is from a closed loop: its command moves, or y predicts u.
    every : int
        Rows of the log in one step of the controller: more than 1 where the dead time is longer
        than 60 rows.
    """

    plant: DesignPlant
    model: ProcessModel
    parts: tuple[DesignPlant | None, ...]
    noise: float
    disturbance: float
    u: tuple[float, float]
    is_closed: bool = False
    every: int = 1

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
        model = self.model
        distance = np.abs(1 - model.poles)
        near = distance * len(model.residual) < SLOW
        near &= ~(distance >= CLEAR * model.pole_deviations)  # near where that is unknown
        return bool(near[: model.order - model.integrators].any())

    @property
    def evidence(self) -> str:
        """The gates that were passed, and the intervals of gain, dead time and poles."""
        model = self.model
        poles = ", ".join(
            f"{_complex(pole)} +- {1.96 * deviation:.2g}"
            for pole, deviation in zip(model.poles, model.pole_deviations, strict=True)
        )
        low, high = (one / (model.sample_time or 1.0) for one in model.dead_time_interval)
        gain = ", ".join(f"{one:.4g}" for one in model.gain_interval)
        return (
            f"gates passed: {', '.join(gate.name for gate in model.gates if gate.passed)}; "
            f"95 % interval of the gain [{gain}]; dead time {low:.4g} to {high:.4g} steps; "
            f"poles {poles}"
        )


def _complex(pole: complex) -> str:
    return f"{pole.real:.4g}" if abs(pole.imag) < 1e-9 else f"{pole:.3g}"


class LogSearch:
    """The models of a log in the order in which controllers are designed for them.

    Parameters
    ----------
    log : ControllerLog
        Of one input and output, without gaps.
    sample_time : float, optional
    dead_time : float
        In seconds, or steps; 0 where it is not known.
    """

    def __init__(
        self, log: ControllerLog, sample_time: float | None = None, dead_time: float = 0.0
    ) -> None:
        late, period = number(dead_time, "dead_time"), number(sample_time or 1.0, "sample_time")
        if late < 0 or not period > 0:
            raise InputError(
                f"dead_time = {late:g} with sample_time = {period:g}: give both in seconds, none "
                "of them negative."
            )
        self.log, self.sample_time, self.time_skew = log, sample_time, log.time_skew
        has_command = log.r is not None and bool(np.ptp(log.r) > 0)
        self.search = search_of(
            log.u, log.y, round(late / period) or None, is_commanded=has_command
        )
        if self.search.is_direct:  # the controller reads y of the row before
            self.log = log = _paired_earlier(log)
        self.is_closed = has_command or self.search.is_closed
        if self.search.is_closed:
            self._require_excitation()
        fit = self.search.fits[0]
        require_effect(effect_gate(self.search, fit), self.search)

    def _require_excitation(self) -> None:
        """Raise an error where u follows from y alone."""
        if not np.std(excitation(self.log.u, self.log.y)) > STIRRED * np.std(self.log.u):
            raise InputError(
                f"u is determined by y from step {PAST_U} on: the record shows the controller, not "
                "the plant. Add a dither to u, or move the command, and record again."
            )

    def candidates(self) -> Iterator[ProcessFit]:
        """The credible models, the best first; then the best of each lower order.

        The latter are no worse for a controller that stabilises the credible ones, too. A model
        with a hidden pair on the circle, which has no robust controller, is taken if there is no
        other.
        """
        credible = self.search.distinct
        plain = [one for one in credible if not has_hidden_pair(one)][:TRIED]
        yield from plain
        is_first = not plain
        for order in range(min(one.order for one in credible) - 1, 0, -1):
            fit = self.search.of_order(order)
            if fit is not None and not has_hidden_pair(fit):
                yield fit
                is_first = False
        if is_first:
            yield from credible[:TRIED]

    def first_gates(self, fit: ProcessFit) -> tuple[Gate, ...]:
        """The gates that need no controller."""
        return (effect_gate(self.search, fit), *gates_without_controller(self.search, fit))

    def logged(self, fit: ProcessFit, gates: tuple[Gate, ...] = ()) -> LoggedPlant:
        """The plant of a model, its parts and its disturbances."""
        search, log = self.search, self.log
        model = process_model(search, fit, gates, self.sample_time, self.time_skew)
        plant = self._plant(fit, rows_a_step(fit.delay))
        if not plant.low_gain > 0:
            raise InputError("the model of the log has gain 0: u has no effect on y.")
        parts = tuple(plant for _, plant in self.parts(fit))
        e = model.residual
        noise = min(float(np.std(np.diff(e)) / np.sqrt(2)), float(np.std(e)))
        rest = float(np.sqrt(max(float(np.var(e)) - noise**2, 0.0)))
        size = max(rest, noise) / plant.low_gain
        limits = float(log.u.min()), float(log.u.max())
        return LoggedPlant(
            plant, model, parts, noise, size, limits, self.is_closed, rows_a_step(fit.delay)
        )  # fmt: skip

    def parts(self, fit: ProcessFit) -> list[tuple[Part, DesignPlant | None]]:
        """The model fitted to each half, and its plant where the half knows the gain."""
        parts: list[tuple[Part, DesignPlant | None]] = []
        edge = bandwidth(fit)
        omega = np.geomspace(edge / 3, edge, 15)
        for part in part_fits(self.search, fit, PARTS):
            plant = None
            if part is not None and relative_deviation(*part, omega).max() < KNOWN:
                plant = self._plant(part[1], rows_a_step(fit.delay))
            parts.append((part, plant))
        return parts

    def judged(self, fit: ProcessFit, logged: LoggedPlant, G_c: Compensator, peak: float) -> (
        LoggedPlant
    ):  # fmt: skip
        """The plant with the gates of its controller beside the others."""
        loop = gate_loop(logged.plant, G_c, logged.every)
        gates = controller_gates(
            self.search, fit, loop, peak, self.parts(fit), self.sample_time
        )  # fmt: skip
        model = replace(logged.model, gates=(*logged.model.gates, *gates))
        return replace(logged, model=model)

    def lost(self, fit: ProcessFit, logged: LoggedPlant, G_c: Compensator) -> list[DesignPlant]:
        """The credible plants that a controller does not hold."""
        loop = gate_loop(logged.plant, G_c, logged.every)
        return lost_plants(self.search, fit, loop, self.parts(fit), self.sample_time)

    def _plant(self, fit: ProcessFit, every: int) -> DesignPlant:
        unit_u, unit_y = self.search.record.units
        return design_plant(
            fit.B, fit.denominator, fit.delay, unit_y / unit_u, self.sample_time, every
        )  # fmt: skip

    def undecided(self, gates: tuple[Gate, ...]) -> UndecidedError:
        """The error for a log of which gates failed."""
        failed = [gate for gate in gates if not gate.passed]
        words = "; ".join(f"{gate.name}: {gate.words}" for gate in failed)
        return UndecidedError(
            f"{self.log.source} does not determine the plant well enough for a controller. Failed: "
            f"{words}. {failed[0].advice}"
        )


def _paired_earlier(log: ControllerLog) -> ControllerLog:
    """u(k + 1) with y(k), for a plant with direct feedthrough."""
    r = None if log.r is None else log.r[1:]
    return ControllerLog(log.u[1:], log.y[:-1], r=r, source=log.source, sample_time=log.sample_time)


def rows_a_step(delay: int) -> int:
    """Rows of a log in one step of its controller: more than 1 beyond 60 rows of dead time.

    Each step of dead time has two coefficients of the controller.
    """
    return 1 if delay <= LONGEST_DELAY else -(-delay // USUAL_DELAY)


def plant_from_log(
    log: ControllerLog, sample_time: float | None = None, dead_time: float = 0.0
) -> LoggedPlant:
    """The best model of a log in open or in closed loop, without the gates of a controller."""
    search = LogSearch(log, sample_time, dead_time)
    fit = search.search.fits[0]
    return search.logged(fit, search.first_gates(fit))
