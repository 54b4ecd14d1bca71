"""Controllers on plants within the uncertainty, on noise that no setting was chosen by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rcac_numeric.analysis.closed_loop import frozen_loop
from rcac_numeric.arrays.values import Value
from rcac_numeric.engine.batches import SimulationCase, simulate_many
from rcac_numeric.engine.compatibility import AnyController
from rcac_numeric.engine.runs import Run
from rcac_numeric.experiments.experiment import JUDGING
from rcac_numeric.plants.saturation import Saturation
from rcac_numeric.synthesis.expected import Expected
from rcac_numeric.synthesis.plants import DesignPlant, Variation
from rcac_numeric.synthesis.reference import sensitivity_peak

RCAC, FIXED, PID = "RCAC", "fixed", "SIMC PID"  # the controllers of a design
LAST = 0.25  # of a run: where its tail is measured


@dataclass(frozen=True, eq=False)
class Trial(Value):
    """What one controller came to on one plant, over several draws of what acts on it.

    Attributes
    ----------
    controller : str
    variation : Variation
    stable : tuple of bool
        Of the controller as it was at the end, frozen, with this plant.
    rms : tuple of float
        Of e_0, the error without the sensor noise, over the last quarter; infinite where the run
        ended early or the last controller is not stable.
    peak : tuple of float
        The largest abs(e_0).
    Ms : tuple of float
        The peak of the sensitivity with the last controller.
    """

    controller: str
    variation: Variation
    stable: tuple[bool, ...]
    rms: tuple[float, ...]
    peak: tuple[float, ...]
    Ms: tuple[float, ...]

    def with_draws(self, more: Trial) -> Trial:
        """The same controller on the same plant, with further draws."""
        return Trial(
            self.controller, self.variation, self.stable + more.stable, self.rms + more.rms,
            self.peak + more.peak, self.Ms + more.Ms,
        )  # fmt: skip


def run_trials(
    controllers: Mapping[str, AnyController], plant: DesignPlant, expected: Expected,
    variations: Sequence[Variation], *, steps: int, seeds: int,
    saturation: Saturation | None = None, first: int = JUDGING,
) -> tuple[Trial, ...]:  # fmt: skip
    """Every controller on every plant with the same draws, in one batch.

    Parameters
    ----------
    controllers : mapping from names
    plant : DesignPlant
    expected : Expected
    variations : sequence of Variation
    steps, seeds : int
        Length and number of the draws.
    saturation : Saturation, optional
    first : int
        The first seed: by default of those that judge, and that no setting is chosen by.
    """
    servos = [plant.servo(one) for one in variations]
    draws = [
        [expected.w(steps, seed, one.noise) for seed in range(first, first + seeds)]
        for one in variations
    ]
    options = {"stride": steps, "saturation": saturation}
    cases = [
        SimulationCase(servo, controller, w, options)
        for controller in controllers.values()
        for servo, ws in zip(servos, draws, strict=True) for w in ws
    ]  # fmt: skip
    runs = iter(simulate_many(cases))
    return tuple(
        _trial(name, one, [next(runs) for _ in range(seeds)], steps)
        for name in controllers for one in variations
    )  # fmt: skip


def _trial(name: str, variation: Variation, runs: list[Run], steps: int) -> Trial:
    found = [measured(run, steps) for run in runs]
    stable, rms, peak, Ms = zip(*found, strict=True)
    return Trial(name, variation, stable, rms, peak, Ms)


def measured(run: Run, steps: int) -> tuple[bool, float, float, float]:
    """(stable, rms, peak, Ms) of one run of the servo problem; of several errors the norm."""
    error = np.linalg.norm(run.z + run.w[: len(run.z), -run.z.shape[1] :], axis=1)
    peak = float(np.abs(error).max(initial=0.0))
    if run.outcome != "completed":
        return False, np.inf, np.inf, np.inf
    Ms = sensitivity_peak(frozen_loop(run.plant, run.compensator, 0))
    if not np.isfinite(Ms):
        return False, np.inf, peak, np.inf
    tail = error[-max(int(LAST * steps), 1) :]
    return True, float(np.sqrt(np.mean(tail**2))), peak, Ms
