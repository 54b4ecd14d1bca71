"""Trials that continue or repeat a run of a known plant: a disturbance, another k_w.

The health of a finished run includes two kinds of trials: its controller continues from the final
state, and its settings run again with one change.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import attrs
import numpy as np

from compensator_theory.errors import CompensatorError
from rcac_numeric.analysis._closed_loop import ClosedLoop
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.analysis._loop_costs import loop_costs
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._recursive import RecursiveLeastSquares
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.engine._runs import Run
from rcac_numeric.engine._simulation import simulate
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule, plant_at

KICKS, KICKED = (0.05, 0.2), 300  # of the size of w, white, and for so many steps
ROUNDING = 1e-12  # of its peak: no more than that, a constant w has by the rounding of its mean
DRAWS = 3  # of each: a single one may stay where the data support theta
LONGEST = 20_000  # steps of a run that is repeated
LARGEST = 30  # states of a plant for which LQG is designed in passing
WHITE, SHORTEST = 0.2, 100  # correlation of w from step to step, and its steps, to be a noise


@dataclass(frozen=True)
class NextDisturbance:
    """The peak of z after a further disturbance.

    Attributes
    ----------
    adapting, frozen : float
        The largest abs(z) that a white kick of a fifth of the size of w, or less, adds within 300
        steps: with the controller as it is, and with its coefficients held. Of six drawn kicks, the
        one for which their ratio is largest.
    """

    adapting: float
    frozen: float

    @property
    def ratio(self) -> float:
        """The ratio of `adapting` and `frozen`."""
        return self.adapting / self.frozen if self.frozen > 0 else 1.0


def next_disturbance(run: Run) -> NextDisturbance | None:
    """Simulate a further disturbance after a run; None if that is impossible."""
    if (
        type(run.plant) not in (Plant, PlantSchedule)
        or run.state is None
        or run.outcome != "completed"
        or not isinstance(run.settings, ControllerSettings)
        or run.changes
        or not run.steps
    ):
        return None
    # The kick has the variation of w in every channel that moved; a constant command remains.
    sizes, peaks = run.w.std(axis=0), np.abs(run.w).max(axis=0)
    sizes = np.where(sizes > ROUNDING * peaks, sizes, peaks)
    if not sizes.any():
        return None
    frozen = FixedController(run.compensator)
    plant = plant_at(run.plant, run.first_step + run.steps - 1)
    rest = np.broadcast_to(run.w[-1], (KICKED, len(sizes)))
    rng = np.random.default_rng(0)
    trials = []
    with np.errstate(all="ignore"):
        try:
            plain = simulate(
                run.plant, run.settings, rest, start=run.state, saturation=run.saturation
            )
            for size in KICKS * DRAWS:
                kick = size * sizes * rng.standard_normal(rest.shape)
                kicked = simulate(
                    run.plant, run.settings, rest + kick, start=run.state,
                    saturation=run.saturation,
                )  # fmt: skip
                steps = min(plain.steps, kicked.steps)
                added = _peak(kicked.z[:steps] - plain.z[:steps])
                if kicked.outcome != "completed":
                    added = np.inf
                trials.append(NextDisturbance(added, _peak(simulate(plant, frozen, kick).z)))
        except CompensatorError:
            return None
    trials = [one for one in trials if np.isfinite(one.frozen)]
    return max(trials, key=lambda one: one.ratio, default=None)


def missed_poles(analysis: LoopAnalysis) -> float | None:
    """The largest distance of a pole of G_f from the closed-loop pole assigned to it.

    None for an FIR target, which has no poles except at 0.
    """
    try:
        target = analysis.compared_with
        if not target.denominator[1:].any() or analysis.obstacle:
            return None
        return float(analysis.comparison.worst_distance)
    except (CompensatorError, np.linalg.LinAlgError):
        return None


def pole_remedy(analysis: LoopAnalysis) -> str | None:
    """The tested change of the settings that places the poles; None if none does."""
    run, settings = analysis.run, analysis.run.settings
    if (
        not isinstance(settings, ControllerSettings)
        or not isinstance(settings.update, RecursiveLeastSquares)
        or type(run.plant) not in (Plant, PlantSchedule)
        or run.steps > LONGEST
        or run.first_step
        or run.changes
        or settings.learning is not None
    ):
        return None
    longer = min(max(50, 10 * settings.k_w), run.steps // 2)
    R_theta = np.asarray(settings.update.R_theta)
    lighter = attrs.evolve(
        settings.update, R_theta=R_theta * 1e-6 if R_theta.ndim else R_theta[()] * 1e-6
    )
    later = {"k_w": longer, "k_update": max(longer, settings.k_update)}
    trials: list[tuple[str, dict[str, Any]]] = []
    if longer > settings.k_w:
        trials.append((f"k_w = {longer}, so that more than the start excites theta", dict(later)))
    trials.append((f"R_theta {_times(1e-6)}", {"update": lighter}))
    if longer > settings.k_w:
        trials.append((f"k_w = {longer} and R_theta {_times(1e-6)}", {**later, "update": lighter}))
    for words, change in trials:
        try:
            with np.errstate(all="ignore"):
                other = simulate(
                    run.plant, attrs.evolve(settings, **change), run.w, x_0=run.x_0,
                    saturation=run.saturation, stride=max(run.steps, 1),
                )  # fmt: skip
            if other.outcome != "completed":
                continue
            comparison = LoopAnalysis(other, analysis.target).comparison
        except (CompensatorError, np.linalg.LinAlgError):
            continue
        if comparison.is_reached:
            left = f"{comparison.backward_error:.1g} of the closed-loop polynomial"
            return f"{words} (tested: the poles are then reached, to {left})"
    return None


def cost_over_lqg(analysis: LoopAnalysis) -> float | None:
    """The H2 cost of the final controller over LQG's, for the noise that the run had.

    A channel of w is noise where the second half of the run has neither the same value twice in a
    row nor a correlation above 0.2 from step to step; None where no channel is.
    """
    run = analysis.run
    if type(run.plant) not in (Plant, PlantSchedule) or run.steps < SHORTEST:
        return None
    try:
        plant = analysis.plant
        if plant.n > LARGEST:
            return None
        late = run.w[run.steps // 2 :]
        noise = {
            name: float(np.var(column))
            for name, column in zip(plant.channels, late.T, strict=True)
            if _is_white(column)
        }
        loop: ClosedLoop = analysis.loop
        if not noise or not loop.is_stable:
            return None
        with np.errstate(all="ignore"):
            ratio = loop_costs(loop, noise).ratio
    except (CompensatorError, np.linalg.LinAlgError):
        return None
    return None if ratio is None or not np.isfinite(ratio) else float(ratio)


def _is_white(column: Array) -> bool:
    centred = column - column.mean()
    power = float(centred @ centred)
    if not power > 0:
        return False
    bound = max(WHITE, 3 / np.sqrt(len(column)))
    return bool(abs(float(centred[1:] @ centred[:-1])) < bound * power)


def _peak(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def _times(factor: float) -> str:
    return f"{1 / factor:.0g} times smaller"
