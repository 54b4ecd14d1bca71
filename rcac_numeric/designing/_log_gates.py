"""The gates of a log's model that test its controller: gain, rivals, misfit, halves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rcac_numeric.analysis._peaks import responses_of
from rcac_numeric.analysis._state_space import StateSpace
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.designing._plants import DesignPlant, balanced, slower_plant
from rcac_numeric.designing._reference import MOST, loop_radius
from rcac_numeric.identification._box_jenkins import UNSTABLE, ProcessFit
from rcac_numeric.identification._process_evidence import (
    KNOWN,
    MISFIT,
    OMEGA,
    Gate,
    credible_delays,
    misfit,
    relative_deviation,
    sign_gate,
    with_faster_pole,
)
from rcac_numeric.identification._process_records import ProcessRecord
from rcac_numeric.identification._process_search import ProcessSearch

ROBUST, UNSTABLE_ROBUST = 1.125 * MOST, 4.0  # Ms of the loop with a stable and an unstable model
LOW = 3.0  # times below the crossover S stands in place of T if it is smaller
Part = tuple[ProcessRecord, ProcessFit] | None


@dataclass(frozen=True, eq=False)
class Rival:
    """A credible model beside the one that is handed out."""

    plant: DesignPlant
    order: int
    delay: int
    is_unstable: bool  # and must be held with a margin


@dataclass(frozen=True, eq=False)
class GateLoop:
    """The loop of a controller with a model, for the gates.

    Attributes
    ----------
    compensator : Compensator
        From e to u.
    weight : array, shape (100,)
        abs(T) at `OMEGA`; below a third of the crossover abs(S) if that is smaller, since an error
        of a gain that is large anyway does no harm.
    crossover : float
        Of the gain of the loop, in rad/step of the controller.
    every : int
        Rows of the log in one step of the controller.
    """

    compensator: Compensator
    weight: Array
    crossover: float
    every: int = 1

    @property
    def omega(self) -> Array:
        """The frequencies of `weight` in rad/row."""
        return OMEGA / self.every

    @property
    def parts(self) -> StateSpace:
        """The controller's matrices."""
        return self.compensator.state_space()

    def stabilises(self, plant: DesignPlant) -> bool:
        """Whether the loop with a plant is stable."""
        return bool(loop_radius(plant.servo(), self.parts) < 1)

    def is_robust(self, plant: DesignPlant) -> bool:
        """Whether Ms with an unstable plant is at most that of an unstable model."""
        L = plant.response(OMEGA)[:, 0, 0] * responses_of(self.parts, OMEGA)[:, 0, 0]
        return bool(np.max(1 / np.abs(1 + L)) <= UNSTABLE_ROBUST)

    def holds(self, rival: Rival) -> bool:
        """Whether the loop with a rival is stable, and robust if the rival is unstable."""
        return self.stabilises(rival.plant) and (
            not rival.is_unstable or self.is_robust(rival.plant)
        )


def gate_loop(plant: DesignPlant, compensator: Compensator, every: int = 1) -> GateLoop:
    """The loop of a controller, of e or of [e; r], with a scalar model."""
    of_e = Compensator(compensator.past_u, compensator.past_y[:, :, :1], compensator.sample_time)
    K = responses_of(of_e.state_space(), OMEGA)[:, 0, 0]
    L = plant.response(OMEGA)[:, 0, 0] * K
    T, S = np.abs(L / (1 + L)), np.abs(1 / (1 + L))
    above = np.nonzero(np.abs(L) > 1)[0]
    crossover = float(OMEGA[above[-1]] if len(above) else 0.01)
    weight = np.where(crossover / LOW < OMEGA, T, np.minimum(T, S))
    return GateLoop(of_e, weight, crossover, every)


def design_plant(
    B: Array, A: Array, delay: int, gain_unit: float, sample_time: float | None, every: int = 1
) -> DesignPlant:
    """The plant of a model in units of the record, for a controller in one of `every` rows."""
    n = max(len(A) - 1, len(B))
    a = np.eye(n, k=-1)
    a[0] = -np.pad(A[1:], (0, n - len(A) + 1))
    c = gain_unit * np.pad(B, (0, n - len(B)))[None]
    a, b, c = balanced(a, np.eye(n, 1), c)
    return slower_plant(DesignPlant(a, b, c, delay, sample_time=sample_time), every)


def controller_gates(
    search: ProcessSearch, fit: ProcessFit, loop: GateLoop, peak: float,
    parts: Sequence[tuple[Part, DesignPlant | None]], sample_time: float | None,
) -> tuple[Gate, ...]:  # fmt: skip
    """All gates of a model that need its controller; `peak` is Ms of their loop."""
    worst = float(np.max(loop.weight * relative_deviation(search.record, fit, loop.omega)))
    gain = Gate(
        "gain", worst < KNOWN, worst, KNOWN,
        f"largest abs(T) times the relative standard deviation of G: {worst:.2g}, at most "
        f"{KNOWN:.2g} is allowed",
        "The gain around the crossover is not known well enough: excite u more, or record longer.",
    )  # fmt: skip
    probability, left = misfit(search, fit, loop.omega)
    size = float(np.max(loop.weight * left))
    fits = probability > MISFIT or size < KNOWN
    remainder = Gate(
        "misfit", fits, size, KNOWN,
        f"past u explains {size:.2g} of G in the prediction errors, with probability "
        f"{probability:.2g} by chance",
        "The model misses a part of the plant: several inputs, a nonlinear plant, or a plant of "
        "higher order. Give design a model.",
    )  # fmt: skip
    limit = UNSTABLE_ROBUST if fit.is_unstable else ROBUST
    robust = Gate(
        "robustness", peak <= limit, peak, limit,
        f"Ms = {peak:.3g} of the fixed controller with the model, at most {limit:.3g} is allowed",
        "No controller of the weight grid is robust for this model: sample more slowly, or shorten "
        "the dead time.",
    )  # fmt: skip
    sign = sign_gate(search, fit, loop.crossover / LOW / loop.every)
    return (
        gain, sign, rivals_gate(loop, rivals_of(search, fit, sample_time, loop.every)), remainder,
        _halves(loop, parts), robust,
    )  # fmt: skip


def lost_plants(
    search: ProcessSearch, fit: ProcessFit, loop: GateLoop,
    parts: Sequence[tuple[Part, DesignPlant | None]], sample_time: float | None,
) -> list[DesignPlant]:  # fmt: skip
    """The credible plants, and those of the parts, that the controller does not hold."""
    rivals = rivals_of(search, fit, sample_time, loop.every)
    lost = [one.plant for one in rivals if not loop.holds(one)]
    return lost + [plant for plant in _known_parts(loop, parts) if not loop.stabilises(plant)]


def rivals_of(
    search: ProcessSearch, fit: ProcessFit, sample_time: float | None, every: int
) -> list[Rival]:
    """The other credible models, and the model with its other credible delays.

    Of each unstable one, the model itself included, also the plant with its unstable pole at the
    end of its interval.
    """
    unit_u, unit_y = search.record.units
    models: dict[tuple[object, ...], tuple[Array, Array, int]] = {}
    for one in [*search.fits, *search.jumped]:
        if not search.credible(one):
            continue
        if one is not fit:
            models.setdefault(one.key, (one.B, one.denominator, one.delay))
        if one.is_unstable and ("fastest", one.key) not in models:
            moved = with_faster_pole(search.record, one)
            models["fastest", one.key] = (moved.B, moved.denominator, one.delay)
    for B, delay in credible_delays(search, fit):
        models.setdefault(("delay", delay), (B, fit.denominator, delay))
    return [
        Rival(
            design_plant(B, A, delay, unit_y / unit_u, sample_time, every), len(A) - 1, delay,
            key[0] != "fastest" and bool((np.abs(np.roots(A)) > UNSTABLE).any()),
        )
        for key, (B, A, delay) in models.items()
    ]  # fmt: skip


def rivals_gate(loop: GateLoop, rivals: Sequence[Rival]) -> Gate:
    """Whether the controller stabilises every credible model and delay.

    Unstable ones robustly: with a narrow margin the controller loses a plant beside the model, and
    the pole of an unstable model is known less well than the response of a stable one.
    """
    lost = [one for one in rivals if not loop.holds(one)]
    example = f", and not order {lost[0].order} with delay {lost[0].delay}" if lost else ""
    return Gate(
        "rivals", not lost, float(len(lost)), 0.0,
        f"the fixed controller stabilises {len(rivals) - len(lost)} of {len(rivals)} credible "
        f"models, unstable ones with Ms of at most {UNSTABLE_ROBUST:g}{example}",
        "Several plants fit the record and need different controllers: excite u more, record "
        "longer, or give the dead time.",
    )  # fmt: skip


def _known_parts(
    loop: GateLoop, parts: Sequence[tuple[Part, DesignPlant | None]]
) -> list[DesignPlant]:
    """The plants of the parts that know their gain about the crossover."""
    plants = []
    for part, plant in parts:
        if part is None or plant is None:
            continue
        record, fit = part
        if not np.max(loop.weight * relative_deviation(record, fit, loop.omega)) > KNOWN:
            plants.append(plant)
    return plants


def _halves(loop: GateLoop, parts: Sequence[tuple[Part, DesignPlant | None]]) -> Gate:
    """Whether the controller stabilises the models of the parts that know their gain."""
    plants = _known_parts(loop, parts)
    judged, lost = len(plants), sum(not loop.stabilises(plant) for plant in plants)
    return Gate(
        "halves", not lost, float(lost), 0.0,
        f"the fixed controller stabilises the models of {judged - lost} of the {judged} halves of "
        "the log that determine one",
        "The plant changes during the log, or is not linear: design for each part of it.",
    )  # fmt: skip
