"""Experiments: their runs, measures, claims and verdicts."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, Literal

import attrs
import numpy as np

from compensator_theory import figures
from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.experiments._estimation_studies import MEASURES as ESTIMATION_MEASURES
from rcac_experiments.experiments._estimation_studies import EstimationStudy, StudyResult
from rcac_experiments.experiments._figure_requests import STANDARD_FIGURES, FigureRequest
from rcac_experiments.format._places import did_you_mean
from rcac_experiments.format._values import Integer
from rcac_experiments.judging._claim import Check, Claim, Measured, OpenItem, Verdict, judged
from rcac_experiments.judging._measures import MEASURES, OF_PLANT
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._seeds import JUDGING
from rcac_numeric.arrays._showing import notebook_of, report_of
from rcac_numeric.arrays._validation import integer
from rcac_numeric.arrays._values import Result, Value, replaced
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._stepwise import StepwiseController
from rcac_numeric.engine._batches import SimulationCase, simulate_many
from rcac_numeric.engine._compatibility import AnyController, controllers_of
from rcac_numeric.engine._reference import require_supported, simulate_reference
from rcac_numeric.engine._runs import Run
from rcac_numeric.engine._simulation import simulate
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._saturation import Saturation
from rcac_numeric.plants._schedules import PlantSchedule
from rcac_numeric.signals._signal import Signal, exogenous
from rcac_numeric.targets._model import TargetModel

STILL = 1e-12  # of 1, or of an initial coefficient: less is no adaptation
GROUP = 1_000  # seeds of one group


@attrs.frozen(eq=False, kw_only=True)
class RunSpecification(Value):
    """One run of an experiment; with its seed it determines every number of the run.

    Attributes
    ----------
    settings : ControllerSettings, Decentralized, FixedController or PredictiveCost
    target : TargetModel, optional
        The reference of the comparison; by default the target model that the controller has at
        the last step. A fixed controller has none.
    correction : str
        The differences of this run from the source.
    """

    steps: Annotated[int, Integer(1), "Length of the run."]
    seed: Annotated[int, "Of the noise."] = 0
    stride: Annotated[int, Integer(1), "theta is kept at every stride-th step."] = 1
    arithmetic: Annotated[
        Literal["ud", "covariance", "reference"] | None,
        'Of the recursive update: "ud", "covariance" or "reference", which is certified with 250 '
        "digits, see [arithmetic](arithmetic.md). As `update` says where it is left out.",
    ] = None
    repetitions: Annotated[
        int,
        Integer(1),
        "How often it is run; for other than the first time w is changed by `perturbation`.",
    ] = 1
    perturbation: Annotated[
        float,
        "The relative change of w, to see whether the outcome hangs on the last bits.",
    ] = 0.0
    expected: Annotated[
        Literal["completed", "diverged", "mixed"],
        '"diverged" for a run that is there to show a divergence; "mixed" where only some of its '
        "seeds or repetitions diverge.",
    ] = "completed"
    seeds: Annotated[
        int,
        Integer(1),
        "With how many seeds it is run, `seed` and those after it; in place of repetitions.",
    ] = 1
    x_0: Annotated[
        Array | None,
        "The initial state, zero where it is left out; `perturbation` changes it too.",
    ] = attrs.field(default=None, converter=attrs.converters.optional(np.atleast_1d))
    x_0_deviation: Annotated[
        float,
        "The standard deviation of the random initial state of each seed.",
    ] = 0.0
    name: str
    plant: Plant | PlantSchedule
    settings: AnyController
    signals: tuple[Signal, ...]
    saturation: Saturation | None = None
    target: TargetModel | None = None
    correction: str = ""

    @property
    def reference(self) -> bool:
        """Whether the run is made in certified ball arithmetic with 250 digits."""
        return self.arithmetic == "reference"

    @property
    def algorithm(self) -> str:
        """Algorithm of theta: name of the update, "reference", "predictive cost" or "fixed"."""
        if self.reference:
            return "reference"
        if isinstance(self.settings, StepwiseController):
            return "predictive cost"
        first = controllers_of(self.settings)[0]
        return first.update.name if isinstance(first, ControllerSettings) else "fixed"

    def execute(self) -> RunResult:
        """Simulate all repetitions of the run."""
        runs: list[Run]
        if self.reference:
            plant, settings = require_supported(self.plant, self.settings, self.saturation)
            runs = [simulate_reference(plant, settings, np.asarray(c.w)) for c in self.cases()]
        elif isinstance(self.settings, StepwiseController):
            runs = [simulate(c.plant, c.settings, c.w, **c.options) for c in self.cases()]
        else:
            runs = simulate_many(self.cases())
        return RunResult(self, tuple(LoopAnalysis(run, self.target) for run in runs))

    def cases(self) -> list[SimulationCase]:
        """Return one case for each seed or repetition."""
        rng = np.random.default_rng([self.seed, 1])
        cases = []
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
            cases.append(SimulationCase(self.plant, self.settings, w, options))
        return cases

    def _start(self, seed: int) -> dict[str, Array]:
        """Return the initial state, or None for zero."""
        if self.x_0 is None and not self.x_0_deviation:
            return {}
        x_0 = np.zeros(self.plant.n) if self.x_0 is None else self.x_0
        drawn = np.random.default_rng([seed, 2]).standard_normal(self.plant.n)
        return {"x_0": x_0 + self.x_0_deviation * drawn}


@dataclass(frozen=True, eq=False)
class RunResult(Value):
    """The results of a run specification."""

    specification: RunSpecification
    repetitions: tuple[LoopAnalysis, ...]

    @property
    def first(self) -> LoopAnalysis:
        """The unperturbed run."""
        return self.repetitions[0]

    @property
    def diverged(self) -> bool:
        """Whether the run, or one of its repetitions, diverged."""
        return any(r.run.outcome != "completed" for r in self.repetitions)

    @property
    def as_expected(self) -> bool:
        """Whether the run ended as expected."""
        expected = self.specification.expected
        return expected == "mixed" or self.diverged == (expected == "diverged")

    @property
    def over_seeds(self) -> bool:
        """Whether the repetitions use different noise."""
        return self.specification.seeds > 1

    @property
    def may_end(self) -> bool:
        """Whether divergence is expected."""
        return self.specification.expected != "completed"

    def missing_reason(self, measure: str) -> str:
        """The reason why a measure has no value: the coefficients never changed."""
        return "" if measure in OF_PLANT else self._reason

    @cached_property
    def _reason(self) -> str:
        settings = self.specification.settings
        adapts = isinstance(settings, StepwiseController) or any(
            isinstance(one, ControllerSettings) and (0, None) not in one.freeze
            for one in controllers_of(settings)
        )
        moves = any(_moves(repetition.run) for repetition in self.repetitions)
        return "" if moves or not adapts else "no coefficient adapted"

    def values(
        self, measure: str, arguments: Mapping[str, object], until: int | None = None
    ) -> tuple[float, ...]:
        """Return a measure of each repetition; NaN if it ended before the first value."""
        return tuple(_value(one, measure, arguments, until) for one in self.repetitions)


def _moves(run: Run) -> bool:
    """Return whether a coefficient changes by more than rounding."""
    first = run.theta[0] if len(run.theta) else run.theta_final
    moved = np.vstack([run.theta, run.theta_final[None]]) - first
    return bool((~(np.abs(moved) <= STILL * np.maximum(1.0, np.abs(first)))).any())


def _value(
    repetition: LoopAnalysis, measure: str, arguments: Mapping[str, Any], until: int | None
) -> float:
    try:
        measured = repetition if until is None else repetition.until(until)
        return float(MEASURES[measure](measured, **arguments))
    except CompensatorError:
        if repetition.run.outcome != "completed":
            return float("nan")  # nothing to measure at the end; the check fails
        raise


@dataclass(frozen=True, eq=False)
class Experiment(Value):
    """A numbered example or a user's own case: `runs` of controllers, or `studies` of estimators.

    Attributes
    ----------
    open : sequence of OpenItem
        Settings that the source leaves open.
    completions : mapping from names
        Runs or studies with other values of that, over which claims are judged; `completed` has
        them among those that run.
    reduced_runs : frozenset of str
        Those that make fewer repetitions than the verdicts of record have.

    Examples
    --------
    >>> from rcac_experiments.dissertation import load_example
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
    open: Sequence[OpenItem] = ()
    completions: Mapping[str, RunSpecification | EstimationStudy] = field(default_factory=dict)
    reduced_runs: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        object.__setattr__(self, "open", tuple(self.open))
        for name in ("runs", "description", "studies", "completions"):
            object.__setattr__(self, name, dict(getattr(self, name)))
        object.__setattr__(self, "claims", tuple(self.claims))
        object.__setattr__(self, "figures", tuple(self.figures))

    @property
    def main_run(self) -> RunSpecification:
        """The first run, which is plotted and compared in detail."""
        if not self.runs:
            subject = "estimates: no controller of it" if self.studies else "is exact: nothing"
            raise InputError(f"{self.id or self.title!r} {subject} is run.")
        return next(iter(self.runs.values()))

    def reduced(self, seeds: int = 3, *, keep_shares: bool = True) -> Experiment:
        """Return the experiment with at most so many seeds for each run, for a quick look.

        Runs that a claim judges by a share of their seeds keep them all, unless `keep_shares` is
        False: a share of a few says nothing. So do runs in plain arithmetic, in which rounding
        makes an outlier of one seed or another: it is the median of all that is the same on every
        machine.

        Examples
        --------
        >>> from rcac_experiments.dissertation import load_example
        >>> experiment = load_example("5.1")
        >>> experiment.main_run.seeds, experiment.reduced(keep_shares=False).main_run.seeds
        (20, 3)
        """
        checks = [c for claim in self.claims for c in claim.checks if isinstance(c, Check)]
        whole = {check.run for check in checks if check.share < 1}
        for claim in self.claims:  # and so on each run that it is judged over
            if any(isinstance(check, Check) and check.share < 1 for check in claim.checks):
                whole |= {*claim.over, claim.control}
        whole |= {name for name, run in self.runs.items() if run.algorithm == "covariance"}
        whole = whole if keep_shares else set()
        pairs = [{check.run, check.relative_to} for check in checks if check.relative_to]
        while more := [pair for pair in pairs if pair & whole and pair - whole]:
            whole.update(*more)
        runs = {name: _fewer(run, name, whole, seeds) for name, run in self.runs.items()}
        studies = {name: _fewer(study, name, whole, seeds) for name, study in self.studies.items()}
        fewer = {name for name, run in self.runs.items() if run.seeds != runs[name].seeds}
        fewer |= {name for name, one in self.studies.items() if one.seeds != studies[name].seeds}
        reduced = self.reduced_runs | fewer
        return replaced(self, runs=runs, studies=studies, reduced_runs=reduced)

    def held_out(self, group: int = 0) -> Experiment:
        """Return the experiment with test seeds, by which no setting and no bound was chosen.

        Parameters
        ----------
        group : int
            Number of the group of test seeds; the groups are disjoint.

        Examples
        --------
        >>> from rcac_experiments.dissertation import load_example
        >>> experiment = load_example("5.1")
        >>> experiment.main_run.seed, experiment.held_out(2).main_run.seed
        (0, 1002000)
        """
        shift = JUDGING + GROUP * integer(group, "group", at_least=0)

        def moved(these: Mapping[str, Any]) -> dict[str, Any]:
            return {name: replaced(one, seed=one.seed + shift) for name, one in these.items()}

        return replaced(
            self,
            runs=moved(self.runs),
            studies=moved(self.studies),
            completions=moved(self.completions),
        )

    def only(self, claims: Iterable[Claim]) -> Experiment:
        """Return the experiment with these claims only, and the runs that they need."""
        claims_of_result = tuple(claims)
        needed = {run for claim in claims_of_result for check in claim.checks for run in check.runs}
        needed |= {
            name for claim in claims_of_result for name in (*claim.over, claim.run, claim.control)
        }
        needed |= {r for c in claims_of_result for n in c.over for k in c.moved(n) for r in k.runs}
        if any(claim.control for claim in claims_of_result):
            needed |= {
                r for c in claims_of_result if c.control for k in c.moved(c.control) for r in k.runs
            }
        runs = {name: run for name, run in self.runs.items() if name in needed}
        studies = {name: study for name, study in self.studies.items() if name in needed}
        return replaced(self, claims=claims_of_result, runs=runs, studies=studies)

    def completed(self, names: Iterable[str] | None = None) -> Experiment:
        """Return the experiment with all or the named completions among its runs."""
        chosen = self.completions if names is None else {n: self.completions[n] for n in names}
        runs = {n: one for n, one in chosen.items() if isinstance(one, RunSpecification)}
        studies = {n: one for n, one in chosen.items() if isinstance(one, EstimationStudy)}
        return replaced(self, runs={**self.runs, **runs}, studies={**self.studies, **studies})


def _fewer(one: Any, name: str, whole: set[str], seeds: int) -> Any:
    return one if name in whole else replaced(one, seeds=min(one.seeds, seeds))


@dataclass(frozen=True, eq=False)
class Verification(Result):
    """An experiment after its runs: results, estimates of its studies, and verdicts.

    Examples
    --------
    >>> from rcac_experiments import verify
    >>> from rcac_experiments.dissertation import load_example
    >>> verification = verify(load_example("4.7"))
    >>> [v.verdict for v in verification.verdicts][0]
    'reproduced'
    >>> verification.main.first.comparison.worst_distance < 1e-5
    True
    """

    experiment: Experiment
    results: Mapping[str, RunResult]
    verdicts: tuple[Verdict, ...]
    estimates: Mapping[str, StudyResult] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "results", dict(self.results))
        object.__setattr__(self, "estimates", dict(self.estimates))

    @property
    def main(self) -> RunResult:
        """The result of the experiment's main run."""
        if not self.results:
            subject = "estimates: no controller" if self.estimates else "is exact: nothing"
            raise InputError(f"{self.experiment.id or 'this'} {subject} ran, or is drawn.")
        return next(iter(self.results.values()))

    @property
    def main_loop(self) -> LoopAnalysis:
        """The first repetition of the main run."""
        return self.main.first

    @property
    def diverged(self) -> list[str]:
        """Names of the runs that diverged."""
        return [name for name, result in self.results.items() if result.diverged]

    @property
    def surprising(self) -> list[str]:
        """Names of the runs that did not end as their specification says."""
        return [name for name, result in self.results.items() if not result.as_expected]

    def _sheet(self) -> Any:
        from rcac_experiments.reports._verification import verification_sheet

        return verification_sheet(self)

    def report(self) -> str:
        """The whole verification in words and numbers."""
        return report_of(self._sheet())

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        return self.report().split("\n\n", 1)[0]  # its name and the health of its loop

    def _repr_html_(self) -> str:
        """The notebook view: the report and, where something ran, its sheet of pictures."""
        return notebook_of(self._sheet(), self.plot if self.results else None)

    @property
    def figure_requests(self) -> tuple[FigureRequest, ...]:
        """The requested figures; the default ones without a request."""
        if self.experiment.figures:
            return tuple(self.experiment.figures)
        if self.estimates:
            return (FigureRequest("estimates", "What is estimated."),)
        return STANDARD_FIGURES if self.results else ()

    def plot(self, request: FigureRequest | None = None, *, width: float = 9.0) -> figures.Figure:
        """One sheet on the main run; or the requested figure, so many inches wide.

        `figure_requests` are those that an example requests, or the default ones.
        """
        from rcac_experiments.plots._requested import plot_verification

        return plot_verification(self, request, width=width)

    @property
    def exit_status(self) -> int:
        """0: done; 1: a verdict of record has changed; 3: a loop diverged unexpectedly.

        3 goes before 1. A run that was expected to diverge and did not is a changed verdict, 1.
        """
        if any(self.results[name].diverged for name in self.surprising):
            return 3
        return 1 if self.surprising or any(v.has_changed for v in self.verdicts) else 0


def verify(
    experiment: Experiment, progress: Callable[[str], None] = lambda name: None
) -> Verification:
    """Run every run of an experiment and judge every claim.

    Parameters
    ----------
    experiment : Experiment
        From `load_example` or `load_experiment`.
    progress : callable
        Called with the name of each run before it starts.

    Raises
    ------
    InputError
        Where a claim names a measure or a run that does not exist.

    Examples
    --------
    >>> from rcac_experiments import verify
    >>> from rcac_experiments.dissertation import load_example
    >>> verify(load_example("2.2")).exit_status
    0
    """
    for claim in experiment.claims:
        for check in claim.checks:
            if isinstance(check, Check):
                _known(check, experiment)
    results = {}
    for name, specification in experiment.runs.items():
        progress(name)
        results[name] = specification.execute()
    estimates = {}
    for name, study in experiment.studies.items():
        progress(name)
        estimates[name] = study.execute()
    measured: dict[str, Measured] = {**results, **estimates}
    verdicts = tuple(
        judged(claim, measured, experiment.reduced_runs) for claim in experiment.claims
    )
    return Verification(experiment, results, verdicts, estimates)


def _known(check: Check, experiment: Experiment) -> None:
    """Refuse an invalid check before the simulation."""
    known: Mapping[str, Callable[..., float]] = MEASURES
    if experiment.studies:
        known = ESTIMATION_MEASURES
    if check.measure not in known:
        raise InputError(
            f"the measure {check.measure!r} of a claim is not known; known are {', '.join(known)}."
            f"{did_you_mean(check.measure, known)}"
        )
    try:
        inspect.signature(known[check.measure]).bind(None, **check.arguments)
    except TypeError as error:
        raise InputError(f"the check {check.measure!r} of a claim: {error}.") from None
    repeated = {name: run.seeds * run.repetitions for name, run in experiment.runs.items()}
    repeated |= {name: study.seeds for name, study in experiment.studies.items()}
    for name in (check.run, check.relative_to):
        if name and name not in repeated:
            raise InputError(
                f"a claim refers to the run {name!r}; the runs are {', '.join(repeated)}."
                f"{did_you_mean(name, repeated)}"
            )
    if len({repeated[name] for name in (check.run, check.relative_to) if name}) > 1:
        raise InputError(
            f"a claim divides a measure of {check.run!r} by that of {check.relative_to!r}, "
            "pair by pair; give both runs the same number of seeds and repetitions."
        )
