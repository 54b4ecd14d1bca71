"""Test runs of controllers on plants within the uncertainty, with new seeds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from rcac_numeric.analysis._closed_loop import frozen_loop
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._seeds import JUDGING
from rcac_numeric.arrays._values import Value
from rcac_numeric.checks._diagnosis import largest_radius
from rcac_numeric.controllers._bounds import CertifiedBounds
from rcac_numeric.designing._expected import Expected
from rcac_numeric.designing._plants import DesignPlant, Variation
from rcac_numeric.designing._reference import sensitivity_peak
from rcac_numeric.engine._batches import SimulationCase, simulate_many
from rcac_numeric.engine._compatibility import AnyController
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._saturation import Saturation

RCAC, FIXED, PID, FULL = "RCAC", "fixed", "SIMC PID", "LQG"  # the controllers of a design
BOXED = "RCAC, box"  # beside RCAC in a certified set
LAST = 0.25  # of a run: where its tail is measured
LOOKS = 200  # stored thetas of a run whose radius is measured


@dataclass(frozen=True, eq=False)
class Trial(Value):
    """The results of one controller on one plant, over several draws of w.

    Attributes
    ----------
    controller : str
    variation : Variation
    stable : tuple of bool
        Of the controller as it was at the end, frozen, with this plant.
    rms : tuple of float
        Of e_0, the error without the sensor noise, over the whole run, so that a step counts that
        comes and stays, and learning what it costs; infinite where the run ended early or the last
        controller is not stable.
    peak : tuple of float
        The largest abs(e_0).
    Ms : tuple of float
        The peak of the sensitivity with the last controller.
    radius : tuple of float
        The largest share of the radius of `CertifiedBounds` that theta used, 1 where the bounds
        moved theta; NaN without such bounds.
    """

    controller: str
    variation: Variation
    stable: tuple[bool, ...]
    rms: tuple[float, ...]
    peak: tuple[float, ...]
    Ms: tuple[float, ...]
    radius: tuple[float, ...] = ()

    def with_draws(self, more: Trial) -> Trial:
        """Append the results of further draws."""
        return Trial(
            self.controller, self.variation, self.stable + more.stable, self.rms + more.rms,
            self.peak + more.peak, self.Ms + more.Ms,
            self.radius + more.radius,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Trials(Value):
    """The test runs of every controller on every plant with the same draws.

    Attributes
    ----------
    controllers : mapping from names
    plant : DesignPlant
    expected : Expected
    variations : tuple of Variation
    steps : int
        Of each run.
    seeds : int
        Number of the draws.
    first : int
        The first seed: by default of those that judge, and that no setting is chosen by.
    saturation : Saturation or None
    """

    controllers: Mapping[str, AnyController]
    plant: DesignPlant
    expected: Expected
    variations: tuple[Variation, ...]
    steps: int
    seeds: int
    first: int = JUDGING
    saturation: Saturation | None = None

    def __call__(
        self, rng: np.random.Generator, *, controller: str, plant: int, seed: int
    ) -> SimulationCase:
        """Evaluate one run: a controller by name, a plant by index, a draw by seed."""
        changed = self.variations[plant]
        servo = self.plant.servo(changed)
        return self._case(servo, controller, self.expected.w(self.steps, seed, changed.noise))

    @property
    def runs(self) -> int:
        """The number of runs."""
        return len(self.controllers) * len(self.variations) * self.seeds

    def of(self, numbers: Iterable[tuple[float, float, float, float]]) -> tuple[Trial, ...]:
        """The trials from the numbers of every run, in their order."""
        left = iter(numbers)
        trials = []
        for name in self.controllers:
            for one in self.variations:
                rms, peak, Ms, radius = zip(*(next(left) for _ in range(self.seeds)), strict=True)
                stable = tuple(bool(np.isfinite(value)) for value in Ms)
                settled = tuple(a if b else np.inf for a, b in zip(rms, stable, strict=True))
                trials.append(Trial(name, one, stable, settled, peak, Ms, radius))
        return tuple(trials)

    def in_threads(self) -> tuple[Trial, ...]:
        """Evaluate all runs in one batch of this process."""
        servos = [self.plant.servo(one) for one in self.variations]
        draws = [
            [self.expected.w(self.steps, self.first + i, one.noise) for i in range(self.seeds)]
            for one in self.variations
        ]
        runs = simulate_many(
            self._case(servo, name, w)
            for name in self.controllers
            for servo, ws in zip(servos, draws, strict=True)
            for w in ws
        )
        return self.of(
            (whole_rms(run), largest_error(run), sensitivity(run), used_radius(run)) for run in runs
        )

    def nominal_runs(self, controller: AnyController) -> tuple[Run, ...]:
        """Runs of another controller on the first plant, with the same draws."""
        first = self.variations[0]
        servo, options = self.plant.servo(first), {"saturation": self.saturation}
        ws = [self.expected.w(self.steps, self.first + i, first.noise) for i in range(self.seeds)]
        return tuple(simulate_many([SimulationCase(servo, controller, w, options) for w in ws]))

    def _case(self, servo: Plant, controller: str, w: Array) -> SimulationCase:
        settings = self.controllers[controller]
        looks = LOOKS if isinstance(getattr(settings, "bounds", None), CertifiedBounds) else 1
        options = {"stride": -(-self.steps // looks), "saturation": self.saturation}
        return SimulationCase(servo, settings, w, options)


def measured(run: Run) -> tuple[bool, float, float, float]:
    """(stable, rms of the tail, peak, Ms) of one run of the servo problem; of several the norm."""
    Ms = sensitivity(run)
    stable = bool(np.isfinite(Ms))
    return stable, tail_rms(run) if stable else np.inf, largest_error(run), Ms


def whole_rms(run: Run) -> float:
    """Rms of e_0 over the whole run; infinite where that ended early."""
    return _rms(_error(run)) if run.outcome == "completed" else np.inf


def tail_rms(run: Run) -> float:
    """Rms of e_0 over the last quarter; infinite where the run ended early."""
    last = slice(-max(int(LAST * run.steps), 1), None)
    return _rms(_error(run)[last]) if run.outcome == "completed" else np.inf


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2)))


def largest_error(run: Run) -> float:
    """The largest abs(e_0); infinite where the run ended early."""
    return float(_error(run).max(initial=0.0)) if run.outcome == "completed" else np.inf


def sensitivity(run: Run) -> float:
    """The peak of the sensitivity with the last controller; infinite where that is not stable."""
    if run.outcome != "completed":
        return np.inf
    return sensitivity_peak(frozen_loop(run.plant, run.compensator, 0))


def used_radius(run: Run) -> float:
    """The largest share of the radius of CertifiedBounds; 1 where they moved theta, NaN without."""
    radius = largest_radius(run)
    if radius is None:
        return np.nan
    return 1.0 if run.bounded else radius


def _error(run: Run) -> Array:
    """The norm of e_0, the error without the sensor noise, at every step."""
    noise = run.w[: len(run.z), -run.z.shape[1] :]
    return np.asarray(np.linalg.norm(run.z + noise, axis=1))
