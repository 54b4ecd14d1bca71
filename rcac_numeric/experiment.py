"""An experiment as data: a plant, its signals, the controllers to run and what is claimed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.actuators import Saturation
from rcac_numeric.closed_loop import ClosedLoop, Match, intercalated_match
from rcac_numeric.comparison import Comparison, compare
from rcac_numeric.controller_settings import ControllerSettings
from rcac_numeric.decentralized import Decentralized
from rcac_numeric.frozen_plants import frozen_loop, measuring_command, plant_at
from rcac_numeric.plant_schedules import PlantSchedule
from rcac_numeric.plants import Plant
from rcac_numeric.residual_split import ResidualSplit, split_residual
from rcac_numeric.runs import Run, controllers_of
from rcac_numeric.signals import Signal, exogenous
from rcac_numeric.simulation import simulate
from rcac_numeric.target_models import TargetModel


@dataclass(frozen=True, eq=False)
class RunSpecification:
    """One run of an experiment; with its seed it determines every number of the run.

    Attributes
    ----------
    arithmetic : str
        "reference" is ball arithmetic with 250 digits; else the update of the settings.
    repetitions, perturbation : int, float
        The run is repeated with w multiplied by 1 + perturbation * (standard normal), to see
        whether its outcome hangs on the last bits. The first repetition is unperturbed.
    saturation : Saturation, optional
    expected : {"completed", "diverged"}
        How the run is known to end; a run that shows a divergence says so.
    """

    name: str
    plant: Plant | PlantSchedule
    settings: ControllerSettings | Decentralized
    signals: tuple[Signal, ...]
    steps: int
    seed: int = 0
    stride: int = 1
    arithmetic: str = "ud"
    repetitions: int = 1
    perturbation: float = 0.0
    saturation: Saturation | None = None
    expected: str = "completed"

    def execute(self) -> RunResult:
        """Run it, as often as it asks for."""
        w = exogenous(self.signals, self.steps, self.seed)
        rng = np.random.default_rng([self.seed, 1])
        runs = []
        for repetition in range(self.repetitions):
            factor = 1 + self.perturbation * rng.standard_normal(w.shape) if repetition else 1.0
            runs.append(self._run(w * factor))
        return RunResult(self, tuple(Repetition(run) for run in runs))

    def _run(self, w: np.ndarray) -> Run:
        if self.arithmetic == "reference":
            from rcac_numeric.reference import require_supported, simulate_reference

            plant, settings = require_supported(self.plant, self.settings, self.saturation)
            return simulate_reference(plant, settings, w)
        return simulate(
            self.plant, self.settings, w, stride=self.stride, saturation=self.saturation
        )


@dataclass(frozen=True, eq=False)
class Repetition:
    """A run with the analyses that claims ask of it, each made once and when it is needed."""

    run: Run

    @property
    def is_scalar(self) -> bool:
        """Whether the exact comparison applies."""
        return not self.obstacle

    @cached_property
    def obstacle(self) -> str:
        """Why the exact comparison does not apply; empty where it does."""
        run, compensator = self.run, self.run.compensator
        sizes = {"l_u": compensator.l_u, "l_y": run.plant.l_y, "l_z": run.plant.l_z}
        if set(sizes.values()) != {1}:
            words = ", ".join(f"{name} = {size}" for name, size in sizes.items())
            return f"it is for scalar signals, and the plant has {words}"
        if compensator.l_y > 1:
            return "it is for a controller that reads y alone, and this one reads the command too"
        return ""

    @cached_property
    def plant(self) -> Plant:
        """The plant of the last completed step, without its delay line."""
        return plant_at(self.run.plant, self.last_step)

    @property
    def last_step(self) -> int:
        """The last completed step."""
        return self.run.first_step + max(self.run.steps - 1, 0)

    @cached_property
    def target(self) -> TargetModel:
        """The target model in force at the last step; the same for all controllers."""
        targets = []
        for settings in controllers_of(self.run.settings):
            later = [m for k, m in settings.later_targets.items() if k <= self.last_step]
            targets.append([settings.target, *later][-1])
        first = targets[0]
        if any(
            not np.array_equal(getattr(first, name), getattr(other, name))
            for other in targets[1:]
            for name in ("numerator", "denominator")
        ):
            raise InputError("the controllers have different target models")
        return first

    @cached_property
    def loop(self) -> ClosedLoop:
        """The plant of the last step in a loop with the final controller."""
        return frozen_loop(self.run.plant, self.run.compensator, self.last_step)

    @cached_property
    def zeros(self) -> dict[str, np.ndarray]:
        """Closed-loop zeros from each channel of w to z with the final controller."""
        return dict(self.comparison.zeros) if self.is_scalar else dict(self.loop.zeros())

    @cached_property
    def comparison(self) -> Comparison:
        """The final controller beside the exact prediction."""
        if self.obstacle:
            raise InputError(f"there is no exact comparison here: {self.obstacle}.")
        return compare(self.plant, self.run.compensator, self.target)

    @cached_property
    def match(self) -> Match:
        """The intercalated transfer function of the final controller beside G_f."""
        return intercalated_match(self.loop, self.target)

    @cached_property
    def split(self) -> ResidualSplit:
        """The retrospective residual of the whole run for the final controller.

        Behind a saturation it is that of the applied input, which the controller's own past holds.
        """
        run, y = self.run, self.run.y
        if isinstance(run.plant, PlantSchedule) and len(run.plant.changes) > 1:
            raise InputError("the plant changes during the run")
        plant = self.plant
        if run.compensator.l_y > plant.l_y:
            plant = measuring_command(plant)
            y = np.hstack([y, run.w @ plant.D_2[run.plant.l_y :].T])
        return split_residual(
            plant, run.compensator, self.target, u=run.u_applied, y=y, z=run.z, w=run.w
        )


@dataclass(frozen=True, eq=False)
class RunResult:
    """What a run specification produced."""

    specification: RunSpecification
    repetitions: tuple[Repetition, ...]

    @property
    def first(self) -> Repetition:
        """The unperturbed run."""
        return self.repetitions[0]

    @property
    def diverged(self) -> bool:
        """Whether the run, or one of its repetitions, diverged."""
        return any(r.run.outcome != "completed" for r in self.repetitions)

    @property
    def as_expected(self) -> bool:
        """Whether the run ended as its specification says."""
        return self.diverged == (self.specification.expected == "diverged")


@dataclass(frozen=True, eq=False)
class Check:
    """A measure of one run and the interval in which it must lie.

    Attributes
    ----------
    measure, arguments
        A name of `measures.MEASURES` and its keyword arguments.
    run, relative_to : names of runs
        With `relative_to` the measure is divided by that of the other run, repetition by
        repetition.
    statistic : {"each", "median"}
        Whether every repetition must lie in the interval, or the median.
    """

    measure: str
    run: str
    at_least: float = -np.inf
    at_most: float = np.inf
    relative_to: str = ""
    statistic: str = "each"
    arguments: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Claim:
    """Something said of an experiment, with the checks that decide whether it holds.

    Attributes
    ----------
    text, claimed : str
        What is said, and the number or behaviour that is claimed.
    correction : str
        What had to be read differently from the source for the checks to be the right ones.
    recorded : str
        The verdict of record; a run that computes another one has changed.
    """

    text: str
    claimed: str
    checks: tuple[Check, ...]
    correction: str = ""
    recorded: str = ""


@dataclass(frozen=True, eq=False)
class Experiment:
    """A numbered example or a user's own case.

    Examples
    --------
    >>> from rcac_numeric import load_example
    >>> experiment = load_example("4.8")
    >>> list(experiment.runs)[:2], len(experiment.claims)
    (['UD', 'exact'], 4)
    """

    id: str
    title: str
    source: str
    runs: Mapping[str, RunSpecification]
    claims: Sequence[Claim]
    notes: str = ""
    description: Mapping[str, str] = field(default_factory=dict)

    @property
    def main_run(self) -> RunSpecification:
        """The run that is plotted and compared in detail: the first one."""
        return next(iter(self.runs.values()))
