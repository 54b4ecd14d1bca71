"""Tune settings by simulation: Sobol points, halved on plants of the uncertainty."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from scipy.stats import qmc

from compensator_theory import figures
from compensator_theory.errors import InputError
from compensator_theory.libraries import require_library
from rcac_experiments.files._design_files import design_toml, save_design
from rcac_experiments.sweeps._folder import STUDY
from rcac_experiments.sweeps._pools import InProcess, WorkerPool
from rcac_experiments.sweeps._progress import Progress
from rcac_experiments.tuning._stored_trials import stored
from rcac_numeric.analysis._certified_set import CertifiedSet
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._files import member
from rcac_numeric.arrays._seeds import JUDGING
from rcac_numeric.arrays._showing import notebook_of, report_of
from rcac_numeric.arrays._validation import instance_of, integer
from rcac_numeric.arrays._values import Result
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.designing._closed_loop_design import TuningParameters, settings_of
from rcac_numeric.designing._design import (
    PEAK,
    Comparison,
    Design,
    Recommendation,
    compared,
    reasons_of,
    verdict_of,
)
from rcac_numeric.designing._expected import KINDS
from rcac_numeric.designing._plants import DesignPlant, Uncertainty, Variation, continuous_of
from rcac_numeric.designing._plants import variations as corners
from rcac_numeric.designing._reference import LEARNING
from rcac_numeric.designing._trials import BOXED, FIXED, RCAC, Trial, Trials
from rcac_numeric.engine._compatibility import AnyController
from rcac_numeric.engine._simulation import simulate

RULE = "rule"
BOX_RUNS = "held-out-box"  # the chosen settings in a box instead of the certified set
# The unit cube's edges: the base-10 logarithms of N_0, nu, width and 1 - lambda; the spare order.
SAMPLES, NU, WIDTH, FORGETTING, SPARE = (1.0, 5.5), (-1.5, 1.0), (-1.5, 0.3), (-5.0, -2.5), 3
WEAKEST = 1e-3  # of the default N_0, where a certified set keeps theta
HALF = 0.5  # share of the points with lambda = 1
SURVIVORS = 0.5  # share of candidates for the next round, with twice the draws
ROUNDS = 4

Runner = Callable[[str, Trials], tuple[Trial, ...]]


@dataclass(frozen=True)
class Candidate:
    """Simulated settings, compared with the fixed controller on the same draws.

    Attributes
    ----------
    name : str
        "rule", "fixed", or the number of the point.
    parameters : TuningParameters or None
        None for the fixed controller.
    beside : Comparison
    Ms : float
        Maximum sensitivity: the largest of all plants, each the median over the draws.
    rounds : int
        Number of rounds of the candidate.
    """

    name: str
    parameters: TuningParameters | None
    beside: Comparison
    Ms: float
    rounds: int

    @property
    def order(self) -> tuple[int, float]:
        """The criterion: number of unstable runs, then rms, with a penalty on high peaks."""
        k, n = self.beside.stable
        ratio = self.beside.ratio * max(1.0, self.beside.peak / PEAK)
        return n - k, ratio if np.isfinite(ratio) else np.inf


@dataclass(frozen=True, eq=False)
class Tuned(Result):
    """A design with the best settings, tested on plants and draws that were not used to choose.

    Attributes
    ----------
    design : Design
        With the chosen settings; its evidence is from test plants.
    chosen : Candidate
    candidates : tuple of Candidate
        The rule, the fixed controller and all points, on the plants of the tuning.
    beside_rule : Comparison
        The chosen settings compared with the rule on test plants; its "fixed" fields are the rule.
    """

    design: Design
    chosen: Candidate
    candidates: tuple[Candidate, ...]
    beside_rule: Comparison

    @property
    def settings(self) -> ControllerSettings:
        """The chosen settings of RCAC."""
        return self.design.settings

    @property
    def verdict(self) -> Recommendation:
        """The recommendation from test plants: the chosen RCAC, or the fixed controller."""
        return self.design.verdict

    def to_toml(self) -> str:
        """Return the experiment file of the tuned design."""
        return design_toml(self.design)

    def save(self, path: str | Path) -> None:
        """Write `to_toml()` into a file; an error leaves no partial file."""
        save_design(self.design, path)

    def _sheet(self) -> Any:
        from rcac_experiments.reports._tuned import tuned_sheet

        return tuned_sheet(self)

    def report(self) -> str:
        """Return the report: verdict on test plants, comparison with the rule, best candidates."""
        return report_of(self._sheet())

    def plot(self) -> figures.Figure:
        """Plot the cost of every candidate against its robustness."""
        from rcac_experiments.plots._tuned import plot_tuned

        return plot_tuned(self)

    def _repr_html_(self) -> str:
        """Return report and figure for a notebook."""
        return notebook_of(self._sheet(), self.plot)

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        return (
            f"Tuned({self.chosen.name}, {self.verdict.use}, over the rule "
            f"{self.beside_rule.ratio:.3g})"
        )


def tune(
    design: Design,
    budget: int = 40,
    *,
    held_out: int = 8,
    seeds: int = 3,
    steps: int | None = None,
    seed: int = 0,
    store: str | Path | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Tuned:
    """Tune the settings of a design by simulation, and test the best on other plants.

    The points of a Sobol sequence over (N_0, nu, width of the bounds, spare order, lambda) run on
    the plants at the corners of the uncertainty. In each round the better half continues, with
    twice the draws. The rule's settings and the fixed controller stay candidates in all rounds. The
    best candidate is tested on plants inside the uncertainty, with separate draws. If it loses more
    of these runs than it saves, or saves none and has a higher rms, the rule's settings are
    returned. This last choice uses the test plants, so that their result is slightly optimistic.

    Where a certified set keeps RCAC (`design(..., kept="certified")`), it keeps every candidate,
    with a prior of down to a thousandth of the default one; width and spare order stay. The test
    plants, of which several parameters differ at once, are not of its proof. The chosen settings
    are run in the box of the design, too.

    Parameters
    ----------
    design : Design
    budget : int
        Number of points in addition to the rule.
    held_out : int
        Number of test plants; several parameters differ at once in each.
    seeds : int
        Number of draws on each test plant.
    steps : int, optional
        Steps of each run; default: those of the design.
    seed : int
        Seed of the sequence and of the plants.
    store : path, optional
        A folder for all runs, made if it does not exist: after an interruption the same call
        continues, to the same result. Without a store the runs use threads of this process.
    workers : int, optional
        Number of processes, with a store; default: number of processors; 0: this process.
    executor : concurrent.futures.Executor, optional
        Replaces the processes, with a store: an executor of dask,
        ``Client(...).get_executor(pure=False)``, or of mpi4py. It is not shut down.
    progress : callable, optional
        Called with a `Progress` after runs of each round; `ProgressLine()` prints it.

    Raises
    ------
    InputError
        If `design` is no design, a number is out of range, or processes are given without a store.
    StoreError
        If the store is of another design or other arguments, or cannot be used.

    Notes
    -----
    Tuning improves robustness, not the error: on 30 random plants with 40 points the median ratio
    of the rms on test plants to that of the rule was 1.00. All 810 test runs were stable, 783 with
    the rule's settings. Tune if `design.verdict` reports unstable runs; the fixed controller, which
    loses none, needs no tuning.

    Examples
    --------
    >>> from rcac_numeric import design
    >>> from rcac_experiments import tune
    >>> start = design("1/(q - 0.9)", disturbance=1.0, noise=0.05, seeds=1, steps=300)
    >>> tuned = tune(start, budget=4, held_out=2, seeds=1)
    >>> len(tuned.candidates), tuned.chosen in tuned.candidates
    (6, True)
    """
    instance_of(design, "design", Design)
    integer(budget, "budget", at_least=1, at_most=4096)
    integer(held_out, "held_out", at_least=1)
    integer(seeds, "seeds", at_least=1)
    steps = design.steps if steps is None else integer(steps, "steps", at_least=100)
    is_certified = isinstance(design.certified, CertifiedSet)
    rule = TuningParameters()
    weakest = WEAKEST * rule.worth(design.expected) if is_certified else None
    parameters = {RULE: rule} | {
        str(i + 1): one for i, one in enumerate(_points(budget, seed, weakest))
    }
    if is_certified or design.reference.structure is not None:  # of the set, or of the user
        parameters = {name: replace(one, spare=0) for name, one in parameters.items()}
    if is_certified:
        parameters = {name: replace(one, width=rule.width) for name, one in parameters.items()}
    settings_by_name: dict[str, AnyController] = {FIXED: design.fixed}
    for name, one in parameters.items():
        settings_by_name[name] = _settings(design, one)
    with _runner(store, workers, executor, progress) as runner:
        candidates, chosen = _halved(design, settings_by_name, parameters, steps, runner)
        return _judged(
            design, settings_by_name, chosen, candidates, steps, (held_out, seeds, seed), runner
        )


@contextlib.contextmanager
def _runner(
    store: str | Path | None, workers: int | None, executor: Executor | None,
    progress: Callable[[Progress], None] | None,
) -> Iterator[Runner]:  # fmt: skip
    """Yield a function that runs the trials of a round, in threads or into a store."""
    if progress is not None and not callable(progress):
        raise InputError(f"progress = {progress!r} must be callable; use ProgressLine().")
    if store is None:
        if workers is not None or executor is not None:
            option = "executor" if workers is None else f"workers = {workers}"
            raise InputError(
                f"{option} needs a store, a folder for the runs of processes. Give store=FOLDER, "
                f"or remove {option.partition(' ')[0]}."
            )

        def in_threads(name: str, trials: Trials) -> tuple[Trial, ...]:
            results = trials.in_threads()
            if progress is not None:
                progress(Progress(trials.runs, trials.runs, 0.0))
            return results

        yield in_threads
        return
    folder = Path(instance_of(store, "store", str | Path))
    if folder.exists() and not folder.is_dir():
        raise InputError(f"store = {folder} must be a folder; it is a file.")
    require_library("pyarrow")
    member(folder, f"round-1/{STUDY}")  # an unusable folder is refused before the simulation
    if executor is not None and workers is not None:
        raise InputError("workers and executor exclude each other; remove one of them.")
    local_pool = None
    if executor is None:
        count = integer(os.cpu_count() or 1 if workers is None else workers, "workers")
        executor = local_pool = WorkerPool(count) if count else InProcess()  # once for all rounds

    def into_store(name: str, trials: Trials) -> tuple[Trial, ...]:
        return stored(trials, member(folder, f"{name}/{STUDY}").parent, executor, progress)

    try:
        yield into_store
    except BaseException:
        if isinstance(local_pool, WorkerPool):
            local_pool.leave()
        raise
    if local_pool is not None:
        local_pool.shutdown()


def _settings(design: Design, parameters: TuningParameters) -> ControllerSettings:
    """Return the settings of tuning parameters, kept in the certified set of the design."""
    settings = settings_of(design.model, design.reference, design.expected, parameters)
    if isinstance(design.certified, CertifiedSet):
        return attrs.evolve(settings, bounds=design.certified.bounds)
    return settings


def _points(budget: int, seed: int, weakest: float | None = None) -> list[TuningParameters]:
    """Return Sobol points of the tuning parameters, N_0 from `weakest` on."""
    sobol = qmc.Sobol(5, rng=np.random.default_rng([seed, 5]))
    points = sobol.random_base2(int(np.ceil(np.log2(budget))))[:budget]
    least = SAMPLES[0] if weakest is None else float(np.log10(weakest))
    return [_parameters_of(point, (least, SAMPLES[1])) for point in points]


def _parameters_of(point: Array, samples_range: tuple[float, float]) -> TuningParameters:
    def between(x: float, low: float, high: float) -> float:
        return float(10 ** (low + x * (high - low)))

    samples, nu, width, forgets, spare = point
    rate = between((forgets - HALF) / (1 - HALF), *FORGETTING)
    return TuningParameters(
        samples=between(samples, *samples_range), nu=between(nu, *NU), width=between(width, *WIDTH),
        spare=int(spare * (SPARE + 1)), forgetting=1.0 if forgets < HALF else 1 - rate,
    )  # fmt: skip


def _halved(
    design: Design,
    settings_by_name: dict[str, AnyController],
    parameters: dict[str, TuningParameters],
    steps: int,
    runner: Runner,
) -> tuple[tuple[Candidate, ...], Candidate]:
    """Every candidate, by the last round that it took part in; and the best, the rule in doubt."""
    plants = corners(design.model, design.uncertainty)
    # A disturbance of unknown kind is each of its kinds in turn, and all are needed to compare.
    draws = 1 if design.expected.is_known else len(KINDS)
    trials_by_name: dict[str, list[Trial]] = {}
    candidates_by_name: dict[str, Candidate] = {}
    alive, first = list(settings_by_name), LEARNING
    for i in range(ROUNDS):
        batch = {name: settings_by_name[name] for name in alive}
        trials = runner(f"round-{i + 1}", Trials(
            batch, design.model, design.expected, plants, steps, draws, first, design.saturation
        ))  # fmt: skip
        for name in alive:
            new = [one for one in trials if one.controller == name]
            old = trials_by_name.get(name, [])
            trials_by_name[name] = (
                [a.with_draws(b) for a, b in zip(old, new, strict=True)] if old else new
            )
        for name in alive:
            Ms = max(float(np.median(one.Ms)) for one in trials_by_name[name])
            candidates_by_name[name] = Candidate(
                name, parameters.get(name), _beside(trials_by_name, name, FIXED), Ms, i + 1
            )
        first, draws = first + draws, draws if i == 0 else 2 * draws
        always = [FIXED, RULE]
        points = sorted(
            (n for n in alive if n not in always), key=lambda n: candidates_by_name[n].order
        )
        alive = always + points[: int(np.ceil(SURVIVORS * len(points)))]
    best = min(
        (
            one
            for one in candidates_by_name.values()
            if one.rounds == ROUNDS and one.parameters is not None
        ),
        key=lambda one: one.order,
    )
    over_rule = _beside(trials_by_name, best.name, RULE)
    surely = over_rule.losses < over_rule.wins or over_rule.interval[1] < 1
    return tuple(candidates_by_name.values()), best if surely else candidates_by_name[RULE]


def _beside(trials_by_name: dict[str, list[Trial]], name: str, other: str) -> Comparison:
    """A candidate beside another one, on the draws that it has seen."""
    trials = (
        trials_by_name[name] if name == other else [*trials_by_name[name], *trials_by_name[other]]
    )
    return compared(tuple(trials), name, other)


def _judged(
    design: Design, settings_by_name: dict[str, AnyController], chosen: Candidate,
    candidates: tuple[Candidate, ...], steps: int, held_out: tuple[int, int, int],
    runner: Runner,
) -> Tuned:  # fmt: skip
    """The chosen settings beside the rule's and the fixed controller, on held-out plants.

    The rule's, where the chosen ones lose more runs there than they save, or save none and have
    more error.
    """
    count, seeds, seed = held_out
    settings = settings_by_name[chosen.name]
    controllers: dict[str, AnyController] = {
        RCAC: settings, FIXED: design.fixed, RULE: settings_by_name[RULE]
    }  # fmt: skip
    controllers |= {
        name: one for name, one in design.alternatives.items() if not isinstance(one, str)
    }
    plants = (Variation(), *drawn(design.model, design.uncertainty, count, seed))
    judging = Trials(
        controllers, design.model, design.expected, plants, steps, seeds,
        saturation=design.saturation,
    )  # fmt: skip
    trials = runner("held-out", judging)
    over_rule = compared(trials, RCAC, RULE)
    saved = over_rule.wins - over_rule.losses
    if saved < 0 or (saved == 0 and not over_rule.ratio <= 1):  # it does not carry over
        chosen = next(one for one in candidates if one.name == RULE)
        settings = settings_by_name[RULE]
        rule = [one for one in trials if one.controller == RULE]
        others = [one for one in trials if one.controller != RCAC]
        trials = (*(replace(one, controller=RCAC) for one in rule), *others)
    assert isinstance(settings, ControllerSettings) and chosen.parameters is not None
    if isinstance(design.certified, CertifiedSet):
        boxed = settings_of(design.model, design.reference, design.expected, chosen.parameters)
        trials += runner(BOX_RUNS, replace(judging, controllers={BOXED: boxed}))
    evidence = tuple(one for one in trials if one.controller != RULE)
    nominal = replace(judging, controllers={RCAC: settings, FIXED: design.fixed})
    w = design.expected.w(design.steps, JUDGING)
    run = simulate(design.plant, settings, w, saturation=design.saturation)
    reasons = reasons_of(design.model, design.reference, design.expected, settings,
                         chosen.parameters, design.certified)  # fmt: skip
    tuned = replace(
        design, settings=settings, evidence=evidence,
        verdict=verdict_of(evidence, nominal),
        runs={**design.runs, RCAC: run}, reasons=reasons,
    )  # fmt: skip
    return Tuned(tuned, chosen, candidates, compared(trials, RCAC, RULE))


def drawn(
    plant: DesignPlant, uncertainty: Uncertainty, count: int, seed: int = 0
) -> tuple[Variation, ...]:
    """Plants drawn from inside an uncertainty, everything different at once.

    Examples
    --------
    >>> from rcac_numeric import Uncertainty
    >>> from rcac_numeric.designing._plants import read_plant
    >>> from rcac_experiments.tuning._tuning import drawn
    >>> plants = drawn(read_plant("1/(q - 0.9)", None, 0), Uncertainty(), 3)
    >>> [0.8 <= one.gain <= 1.25 for one in plants]
    [True, True, True]
    """
    rng = np.random.default_rng([seed, JUDGING])
    variations = []
    varies = continuous_of(plant) is not None

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    for i in range(count):
        gain = between(*uncertainty.gain)
        least = -min(uncertainty.delay, plant.delay)
        delay = int(rng.integers(least, uncertainty.delay + 1))
        time = between(1 / uncertainty.time, uncertainty.time) if varies else 1.0
        noise = between(1.0, uncertainty.noise)
        variations.append(Variation(f"drawn {i + 1}", gain, delay, time, noise))
    return tuple(variations)
