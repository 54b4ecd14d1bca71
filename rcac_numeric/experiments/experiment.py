"""An experiment as data: a plant, its signals, the controllers to run and what is claimed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.array_types import Array
from rcac_numeric.arrays.values import Value
from rcac_numeric.controllers.settings import ControllerSettings
from rcac_numeric.engine.batches import SimulationCase, simulate_many
from rcac_numeric.engine.compatibility import AnyController, controllers_of
from rcac_numeric.engine.reference.run import require_supported, simulate_reference
from rcac_numeric.engine.runs import Run
from rcac_numeric.experiments.claims import Check, Claim
from rcac_numeric.experiments.estimation.studies import EstimationStudy
from rcac_numeric.experiments.figure_requests import FigureRequest
from rcac_numeric.experiments.measures.analysed_run import AnalysedRun
from rcac_numeric.plants.linear import Plant
from rcac_numeric.plants.saturation import Saturation
from rcac_numeric.plants.schedules import PlantSchedule
from rcac_numeric.signals.signal import Signal, exogenous
from rcac_numeric.targets.model import TargetModel


@dataclass(frozen=True, eq=False)
class RunSpecification(Value):
    """One run of an experiment; with its seed it determines every number of the run.

    Attributes
    ----------
    settings : ControllerSettings, Decentralized or FixedController
    target : TargetModel, optional
        What the loop is compared with; by default the target model that the controller has at
        the last step. A controller that adapts nothing has none of its own.
    reference : bool
        Whether the run is made in certified ball arithmetic with 250 digits.
    repetitions, perturbation : int, float
        The run is repeated with w and x_0 multiplied by 1 + perturbation * (standard normal), to
        see whether its outcome hangs on the last bits. The first repetition is unperturbed.
    seeds : int
        In place of repetitions: with how many seeds it is run, from `seed` on.
    saturation : Saturation, optional
    expected : {"completed", "diverged"}
        How the run is known to end; a run that shows a divergence says so. With seeds or
        repetitions it is "mixed" where some end in one way and some in the other.
    x_0 : array, shape (n,), optional
        Initial state; zero by default.
    x_0_deviation : float
        Standard deviation of what is added to each entry of x_0, drawn anew for each seed.
    correction : str
        What this run reads differently from the source, or adds to it; its claims that hold are
        reproduced with that correction.
    """

    name: str
    plant: Plant | PlantSchedule
    settings: AnyController
    signals: tuple[Signal, ...]
    steps: int
    seed: int = 0
    stride: int = 1
    reference: bool = False
    repetitions: int = 1
    perturbation: float = 0.0
    saturation: Saturation | None = None
    expected: str = "completed"
    target: TargetModel | None = None
    seeds: int = 1
    x_0: Array | None = None
    x_0_deviation: float = 0.0
    correction: str = ""

    @property
    def arithmetic(self) -> str:
        """How theta is computed, in a word: the update's name, "reference" or "fixed"."""
        if self.reference:
            return "reference"
        first = controllers_of(self.settings)[0]
        return first.update.name if isinstance(first, ControllerSettings) else "fixed"

    def execute(self) -> RunResult:
        """Run it, as often as it asks for."""
        runs: list[Run]
        if self.reference:
            plant, settings = require_supported(self.plant, self.settings, self.saturation)
            runs = [simulate_reference(plant, settings, np.asarray(c.w)) for c in self.cases()]
        else:
            runs = simulate_many(self.cases())
        return RunResult(self, tuple(AnalysedRun(run, self.target) for run in runs))

    def cases(self) -> list[SimulationCase]:
        """What is simulated: one case for each seed, or for each repetition."""
        rng = np.random.default_rng([self.seed, 1])
        made = []
        for number in range(self.seeds * self.repetitions):
            seed = self.seed + number if self.seeds > 1 else self.seed
            w = exogenous(self.signals, self.steps, seed)
            start = self._start(seed)
            if number and self.repetitions > 1:
                w = w * (1 + self.perturbation * rng.standard_normal(w.shape))
                start = {
                    name: value * (1 + self.perturbation * rng.standard_normal(value.shape))
                    for name, value in start.items()
                }
            options = {"stride": self.stride, "saturation": self.saturation, **start}
            made.append(SimulationCase(self.plant, self.settings, w, options))
        return made

    def _start(self, seed: int) -> dict[str, Array]:
        """The initial state, where it is not zero."""
        if self.x_0 is None and not self.x_0_deviation:
            return {}
        given = np.zeros(self.plant.n) if self.x_0 is None else self.x_0
        drawn = np.random.default_rng([seed, 2]).standard_normal(self.plant.n)
        return {"x_0": given + self.x_0_deviation * drawn}


@dataclass(frozen=True, eq=False)
class RunResult(Value):
    """What a run specification produced."""

    specification: RunSpecification
    repetitions: tuple[AnalysedRun, ...]

    @property
    def first(self) -> AnalysedRun:
        """The unperturbed run."""
        return self.repetitions[0]

    @property
    def diverged(self) -> bool:
        """Whether the run, or one of its repetitions, diverged."""
        return any(r.run.outcome != "completed" for r in self.repetitions)

    @property
    def as_expected(self) -> bool:
        """Whether the run ended as its specification says."""
        expected = self.specification.expected
        return expected == "mixed" or self.diverged == (expected == "diverged")


@dataclass(frozen=True, eq=False)
class Experiment(Value):
    """A numbered example or a user's own case: `runs` of controllers, or `studies` of estimators.

    Examples
    --------
    >>> from rcac_numeric.dissertation import load_example
    >>> experiment = load_example("4.8")
    >>> list(experiment.runs)[:2], len(experiment.claims)
    (['UD', 'exact'], 6)
    """

    id: str
    title: str
    source: str
    runs: Mapping[str, RunSpecification]
    claims: Sequence[Claim]
    notes: str = ""
    figures: Sequence[FigureRequest] = ()
    description: Mapping[str, str] = field(default_factory=dict)
    studies: Mapping[str, EstimationStudy] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("runs", "description", "studies"):
            object.__setattr__(self, name, dict(getattr(self, name)))
        object.__setattr__(self, "claims", tuple(self.claims))
        object.__setattr__(self, "figures", tuple(self.figures))

    @property
    def main_run(self) -> RunSpecification:
        """The run that is plotted and compared in detail: the first one."""
        if not self.runs:
            what = "estimates: no controller of it" if self.studies else "is exact: nothing"
            raise InputError(f"{self.id or self.title!r} {what} is run.")
        return next(iter(self.runs.values()))

    def reduced(self, seeds: int = 3) -> Experiment:
        """The same experiment with at most so many seeds for each run, for a quick look.

        Runs that a claim judges by a share of their seeds keep them all: a share of a few says
        nothing. So do runs in plain arithmetic, in which rounding makes an outlier of one seed or
        another: it is the median of all that is the same on every machine.

        Examples
        --------
        >>> from rcac_numeric.dissertation import load_example
        >>> experiment = load_example("5.1")
        >>> experiment.main_run.seeds, experiment.reduced().main_run.seeds
        (20, 3)
        """
        checks = [c for claim in self.claims for c in claim.checks if isinstance(c, Check)]
        whole = {check.run for check in checks if check.share < 1}
        whole |= {name for name, run in self.runs.items() if run.arithmetic == "covariance"}
        pairs = [{check.run, check.relative_to} for check in checks if check.relative_to]
        while more := [pair for pair in pairs if pair & whole and pair - whole]:
            whole.update(*more)
        runs = {
            name: run if name in whole else replace(run, seeds=min(run.seeds, seeds))
            for name, run in self.runs.items()
        }
        studies = {
            name: study if name in whole else replace(study, seeds=min(study.seeds, seeds))
            for name, study in self.studies.items()
        }
        return replace(self, runs=runs, studies=studies)
