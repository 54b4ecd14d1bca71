"""Controller design: RCAC settings, a fixed controller, and the recommendation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Literal, Protocol, TypeVar

import attrs
import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import binomtest, ttest_1samp

from compensator_theory import figures
from compensator_theory._few_lines import in_few_lines
from compensator_theory.errors import (
    BudgetError,
    CompensatorError,
    InputError,
    NoSolutionError,
    UndecidedError,
)
from rcac_numeric.analysis._certified_set import CertifiedSet, certified_set
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._blas_threads import one_blas_thread
from rcac_numeric.arrays._seeds import JUDGING
from rcac_numeric.arrays._showing import notebook_of, report_of, summary_of
from rcac_numeric.arrays._validation import instance_of, integer, number, one_of
from rcac_numeric.arrays._values import Result
from rcac_numeric.checks._diagnosis import loop_health
from rcac_numeric.checks._health import LoopHealth
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.designing._closed_loop_design import TuningParameters, settings_of
from rcac_numeric.designing._expected import LONGEST, UNKNOWN, Expected, read_expected
from rcac_numeric.designing._logs import TRIED, LoggedPlant, LogSearch
from rcac_numeric.designing._matrix_logs import LoggedMatrix, search_of_logs
from rcac_numeric.designing._plants import (
    DesignPlant,
    Uncertainty,
    Variation,
    read_plant,
    refuse_states,
    variations,
)
from rcac_numeric.designing._reduced import (
    reduced_reference,
    require_reducible,
    with_feedforward,
)
from rcac_numeric.designing._reference import MOST, Reference, WeightGrid, sensitivity_peak
from rcac_numeric.designing._simc import simc
from rcac_numeric.designing._step_tests import plant_of_step, uncertainty_of_step
from rcac_numeric.designing._trials import (
    BOXED,
    FIXED,
    FULL,
    PID,
    RCAC,
    Trial,
    Trials,
    tail_rms,
    whole_rms,
)
from rcac_numeric.designing._truncation import Truncation, truncated
from rcac_numeric.engine._batches import SimulationCase, simulate_many
from rcac_numeric.engine._compatibility import AnyController
from rcac_numeric.engine._runs import Run
from rcac_numeric.engine._simulation import simulate
from rcac_numeric.identification._process_evidence import Gate
from rcac_numeric.identification._step_response import StepResponse
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._saturation import Saturation, limits_of

WORTH = 0.95  # of the fixed controller's rms: RCAC must be below it, with 95 % confidence
PEAK = 1.5  # of the fixed controller's peak: the largest one allowed for RCAC
FAST = 1e-2  # first response of e over the largest: sampled faster than it is good for
INTEGRATES = (
    "its model has a pole that a log of this length cannot distinguish from 1; give design the "
    "model with its integrator instead, such as k/(s*(T*s + 1)) with sample_time, k the slope of y "
    "after a step of u"
)
RESPONSE = 500  # steps of that response
NONE = 1.005  # of the error without control: above it no control is better, to three digits
LEFT = 0.7  # of the error without control: above it the report says so
ADAPTED = 3.0  # Ms of an adapted controller that is warned of
MOST_PROVED = 40  # coefficients; the proof of a family with more takes a minute
KEPT = ("box", "certified")


@dataclass(frozen=True)
class Question:
    """An assumption that the user should confirm.

    Attributes
    ----------
    name : str
        The argument of `design` that answers it.
    assumed : str
    words : str
        What it decides.
    """

    name: str
    assumed: str
    words: str


@dataclass(frozen=True)
class Reason:
    """A setting and its reason."""

    name: str
    value: str
    words: str


@dataclass(frozen=True)
class Comparison:
    """The comparison of a controller with the fixed one, on the same plants and draws.

    Attributes
    ----------
    ratio : float
        Geometric mean over the plants of its rms over that of the fixed controller, where both
        are stable; NaN where there is none.
    interval : (float, float)
        Of that mean, 95 %, the plants being the draws.
    stable, fixed_stable : (int, int)
        Held-out runs that ended in a stable loop, of how many.
    proportion : (float, float)
        Wilson's interval of its proportion, 95 %.
    worst : str
        The plant on which it is lost, or else loses most.
    peak : float
        Median ratio of the peaks.
    wins, losses : int
        Runs that it alone, and that the fixed controller alone keeps stable.
    """

    ratio: float
    interval: tuple[float, float]
    stable: tuple[int, int]
    fixed_stable: tuple[int, int]
    proportion: tuple[float, float]
    worst: str
    peak: float
    wins: int
    losses: int

    @property
    def is_better(self) -> bool:
        """Whether its rms is significantly lower, and it is unstable no more often."""
        return self.interval[1] < WORTH and self.losses <= self.wins

    def __str__(self) -> str:
        (k, n), (low, high) = self.stable, self.proportion
        return (
            f"stable in {k} of {n} runs (95 % interval {100 * low:.0f} to {100 * high:.0f} %), the "
            f"fixed controller in {self.fixed_stable[0]}; rms error {self.ratio:.3g} times the "
            f"fixed controller's (95 % interval {self.interval[0]:.3g} to {self.interval[1]:.3g}), "
            f"peak {self.peak:.3g} times; worst plant: {self.worst}"
        )


@dataclass(frozen=True)
class Guarantee:
    """The benefit and the cost of the certified set, from the test runs.

    Attributes
    ----------
    beside_box : Comparison
        RCAC in the set compared with the same RCAC in the box; its "fixed" fields are the box's.
    radius : float
        Largest share of the radius that theta used.
    met : (int, int)
        Test runs in which the set moved theta, of how many.
    """

    beside_box: Comparison
    radius: float
    met: tuple[int, int]

    def __str__(self) -> str:
        beside, (runs, count) = self.beside_box, self.met
        used = (
            f"met the boundary in {runs} of {count} test runs"
            if runs
            else f"used {100 * self.radius:.2g} % of the radius"
        )
        return (
            f"theta {used}; rms error {beside.ratio:.3g} times that of the same RCAC in a box; "
            f"test runs stable in the set alone: {beside.wins}, in the box alone: {beside.losses}"
        )


@dataclass(frozen=True)
class Recommendation:
    """The recommended controller and its benefit.

    Attributes
    ----------
    use : {"RCAC", "fixed"}
    why : str
    rcac : Comparison
        RCAC beside the fixed controller.
    Ms : float
        Median peak of S with the adapted controllers on the nominal plant.
    over_none : float or None
        Rms of the error with that controller over the one with u = 0, on the nominal plant: over
        the whole run or over its last quarter, whichever is larger, the geometric mean of the
        held-out draws. None where the plant is unstable or integrates, or nothing acts on it.
    guarantee : Guarantee or None
        Where RCAC is kept in a certified set.
    """

    use: str
    why: str
    rcac: Comparison
    Ms: float
    over_none: float | None = None
    guarantee: Guarantee | None = None

    @property
    def is_worse_than_none(self) -> bool:
        """Whether the error is larger with the controller than without any."""
        return self.over_none is not None and self.over_none > NONE

    def __str__(self) -> str:
        kept = " in its certified set" if self.guarantee is not None else ""
        name = f"RCAC{kept}" if self.use == RCAC else "the fixed controller"
        if self.is_worse_than_none:
            return (
                f"Use no controller: with {name}, the better of the two, the rms error is "
                f"{self.over_none:.3g} times that with u = 0. {self.why}"
            )
        return f"Use {name}: {self.why}"


@dataclass(frozen=True, eq=False)
class Design(Result):
    """A controller for a plant, with reasons.

    Attributes
    ----------
    plant : Plant
        The servo problem y = z = e = r - y_0 - v of the plant, dead time as states: what
        `settings` and `fixed` are for, in units of e and u.
    settings : ControllerSettings
        Of RCAC.
    fixed : FixedController
        The reference controller, LQG.
    verdict : Recommendation
    questions : tuple of Question
    reasons : tuple of Reason
    alternatives : mapping from names to FixedController or str
        A PID by SIMC, or why there is none; LQG, where the controller is reduced.
    evidence : tuple of Trial
        Every controller on every plant, on held-out draws.
    reference : Reference
    expected : Expected
    model : DesignPlant
    uncertainty : Uncertainty
    saturation : Saturation or None
    runs : mapping from names to Run
        One of the nominal plant for each controller.
    steps : int
    logged : LoggedPlant, LoggedMatrix or None
        What the log showed, where the plant came from one.
    certified : CertifiedSet, str or None
        The set that keeps theta, or why there is none; None where it was not requested.
    """

    _REST: ClassVar[str] = "report() has all of it"

    plant: Plant
    settings: ControllerSettings
    fixed: FixedController
    verdict: Recommendation
    questions: tuple[Question, ...]
    reasons: tuple[Reason, ...]
    alternatives: Mapping[str, FixedController | str]
    evidence: tuple[Trial, ...]
    reference: Reference
    expected: Expected
    model: DesignPlant
    uncertainty: Uncertainty
    saturation: Saturation | None
    runs: Mapping[str, Run]
    steps: int
    logged: LoggedPlant | LoggedMatrix | None = None
    certified: CertifiedSet | str | None = None

    @cached_property
    def health(self) -> LoopHealth:
        """The health of RCAC's nominal run."""
        return loop_health(self.runs[RCAC])

    @property
    def no_room(self) -> str:
        """Advice if the limits leave u no room on one side of the working point; else empty.

        Limits, like all signals, count from the working point. A command that lasts moves it.
        """
        return _no_room(self.saturation, self.model, self.expected, self.runs[FIXED].w)

    @property
    def family(self) -> dict[str, Plant]:
        """The plants of the uncertainty by name, as `plant` is of the nominal one.

        What `certified_set` takes as its uncertainty.
        """
        return _family(self.model, variations(self.model, self.uncertainty))

    @cached_property
    def possible_set(self) -> CertifiedSet | None:
        """The certified set of the family, where RCAC in the box lost a test run.

        What `kept="certified"` would keep theta in. None where RCAC lost no run, the family has no
        set, or the set is in use.
        """
        stable, runs = self.verdict.rcac.stable
        if self.certified is not None or stable == runs:
            return None
        region = certified_or_reason(self.plant, self.settings, self.family)
        return region if isinstance(region, CertifiedSet) else None

    @property
    def frozen(self) -> ControllerSettings:
        """The fixed controller as RCAC without updates of theta(0), for `Controller` and exports.

        A `FixedController` uses its own u; this one receives the applied u.
        """
        return attrs.evolve(self.settings, freeze=[(0, None)])

    @property
    def controller(self) -> ControllerSettings:
        """The recommended controller, for `Controller`, `simulate` and exports."""
        return self.settings if self.verdict.use == RCAC else self.frozen

    def _sheet(self) -> Any:
        from rcac_numeric.reports._design import design_sheet

        return design_sheet(self)

    def report(self) -> str:
        """The report: verdict, assumptions, and the reason of each setting."""
        return report_of(self._sheet())

    def plot(self) -> figures.Figure:
        """The error of one nominal run, and the rms on every plant."""
        from rcac_numeric.plots._design import plot_design

        return plot_design(self)

    def _repr_html_(self) -> str:
        """The report and the picture as HTML for a notebook."""
        return notebook_of(self._sheet(), self.plot)

    @in_few_lines
    def __str__(self) -> str:
        return summary_of(self._sheet())

    def __repr__(self) -> str:
        k, n = self.verdict.rcac.stable
        return f"Design({self.verdict.use}, ratio={self.verdict.rcac.ratio:.3g}, stable {k}/{n})"


def design(
    plant: Any,
    *,
    disturbance: Any = UNKNOWN,
    noise: float | None = None,
    command: Any = None,
    u_limits: Any = None,
    sample_time: float | None = None,
    dead_time: ArrayLike = 0.0,
    uncertainty: Uncertainty | None = None,
    structure: Structure | None = None,
    feedforward: bool = False,
    kept: Literal["box", "certified"] = "box",
    seeds: int = 6,
    steps: int = 2000,
) -> Design:
    """From a plant to a controller: RCAC or a fixed one, which was tried out on other plants.

    A robust LQG controller is the reference (Ms <= 2). RCAC begins at it, its target model is the
    intercalated transfer function (4.18) of its loop, and R_theta = N_0 mean(Phi_f' Phi_f) there:
    the prior is worth N_0 samples, whatever the units are.

    Parameters
    ----------
    plant : Plant, PlantSchedule, ContinuousPlant, system of another package, str, log or logs
        Linear, strictly proper, as many inputs as outputs (4 at most, in like units); all that
        `plant_of` reads, and rows of transfer functions. Of more than 40 states, as a measured
        impulse response has, those are kept that its response within 1 % of its peak needs. A
        `Plant` counts as its map from u to y. Of a log u and y count, and r where it is known:
        `identify_process` makes the model, and a controller is handed out if every gate is passed.
        A log of several u and y, or with gaps, and a list of logs, one for each experiment, have
        that of `identify_process_matrix`.
        What the model leaves of y is noise and disturbance unless they are given, and the gain is
        as uncertain as halves of the log disagree. A `StepResponse` brings dead time, noise and
        uncertainty; `sample_time` is its `control_period` by default.
    disturbance : "unknown", number, Signal or None
        d, which adds to u, in units of u: a signal such as ``Step(0.5)`` or ``Harmonic(0.3)``, or
        the size of one that is not known otherwise; 0 or None where there is none, and a command.
        It acts on every input; so do noise and command on every output.
    noise : float, optional
        Standard deviation of the sensor noise, in units of y.
    command : Signal, optional
        r, in units of y. A `Ramp` of it, or of d, has two integrators.
    u_limits : (low, high) or Saturation, optional
    sample_time : float, optional
        In seconds; a plant in continuous time needs it.
    dead_time : float, or rows of them
        Of the plant, in seconds; in steps where no sample time is known. Rows are those of the
        entries of a transfer matrix in s, whole steps each: ``[[1, 3], [7, 3]]``. One plant in s
        may be written with it: ``"2*exp(-3*s)/(10*s + 1)"``.
    uncertainty : Uncertainty, optional
        How far the true plant may be from this one: by default a gain of 0.8 to 1.25, one step,
        time constants of 1/1.2 to 1.2, three times the noise.
    structure : Structure, optional
        One of y alone, such as ``pid("PI")``, ``fir(20)`` or ``fir_integrator(20)``: the
        reference is reduced to it, RCAC adapts its coefficients, and LQG stands beside them.
    feedforward : bool
        Whether the controller reads the command r too, in a part of its own (figure 2.15).
    kept : {"box", "certified"}
        What bounds theta: an interval for each coefficient, or the set around theta_0 in which no
        motion of theta destabilises the loop, proved for the nominal plant and `Design.family`
        (`certified_set`). RCAC in the box is run beside it. Where there is no set,
        `Design.certified` says why, and the box stays. At a limit of u the proof does not hold.
    seeds, steps : int
        Number and length of the held-out runs on each plant.

    Returns
    -------
    Design
        For the error e = r - y_0 - v: ``u = controller.step(y=e, z=e)``, and ``r=r`` with
        feedforward.

    Raises
    ------
    InputError
        Where the plant is not square or cannot be read, or a value is out of range.
    UndecidedError
        Where a log does not determine its plant well enough: the message names the failed gates.
    BudgetError
        Where the plant has more than 40 states and no truncation of it has fewer.
    NoSolutionError
        Where no reference controller exists.

    Examples
    --------
    >>> from rcac_numeric import Step, design
    >>> result = design("1/(10*s + 1)", sample_time=1.0, dead_time=2.0, disturbance=Step(0.5),
    ...                noise=0.01, seeds=1, steps=500)
    >>> result.settings.structure.n_c, result.fixed.compensator.n_c
    (4, 4)
    >>> print(str(result.verdict).partition(":")[0])
    Use the fixed controller
    """
    if uncertainty is not None:
        instance_of(uncertainty, "uncertainty", Uncertainty)
    integer(seeds, "seeds", at_least=1)
    integer(steps, "steps", at_least=100, at_most=LONGEST)
    saturation = limits_of(u_limits)
    if not _range(saturation) > 0:
        raise InputError(f"u_limits = {u_limits!r} must have low < high.")
    if structure is not None:
        require_reducible(structure)
    instance_of(feedforward, "feedforward", bool)
    one_of(kept, "kept", KEPT)
    around = _DesignOptions(
        disturbance, noise, command, saturation, uncertainty, structure, feedforward
    )
    for one in plant if isinstance(plant, list | tuple) else (plant,):
        if hasattr(one, "columns") and hasattr(one, "index"):
            raise InputError(
                "plant is a DataFrame; read_log makes a log of it: "
                'design(read_log(frame, {"u": ["valve"], "y": ["level"]})), with the names of its '
                f"columns, {', '.join(str(name) for name in list(one.columns)[:8])}."
            )
    if _is_log(plant):
        basis = _basis_of_log(plant, sample_time, number(dead_time, "dead_time"), around)
    elif isinstance(plant, StepResponse):
        basis = _basis_of_step(plant, sample_time, dead_time, around)
    else:
        whole = read_plant(plant, sample_time, dead_time)
        shorter = truncated(whole)
        basis = _basis_of(shorter.plant if shorter else whole, Uncertainty(), around)
        if shorter:
            basis = replace(basis, truncation=_truncation_question(shorter, basis.reference))
    model, logged, expected, cases = basis.model, basis.logged, basis.expected, basis.cases
    reference = basis.reference
    settings = settings_of(model, reference, expected)
    fixed, servo = reference.fixed, model.servo()
    controllers: dict[str, AnyController] = {RCAC: settings, FIXED: fixed}
    certified: CertifiedSet | str | None = None
    if kept == "certified":
        certified = certified_or_reason(servo, settings, _family(model, cases))
    if isinstance(certified, CertifiedSet):
        controllers[BOXED] = settings
        controllers[RCAC] = settings = attrs.evolve(settings, bounds=certified.bounds)
    alternatives: dict[str, FixedController | str] = {}
    if reference.full is not None:
        alternatives[FULL] = controllers[FULL] = FixedController(reference.full)
    try:
        alternatives[PID] = controllers[PID] = simc(model)
    except NoSolutionError as error:
        alternatives[PID] = str(error)
    trials = Trials(controllers, model, expected, cases, steps, seeds, saturation=saturation)
    evidence = trials.in_threads()
    w = expected.w(steps, JUDGING)
    options = {"saturation": saturation}
    runs = simulate_many([SimulationCase(servo, one, w, options) for one in controllers.values()])
    by_name = dict(zip(controllers, runs, strict=True))
    verdict = verdict_of(evidence, trials)
    questions = _questions(basis, fixed, saturation)
    questions += _remaining_questions(model, expected, by_name[FIXED], verdict)
    return Design(
        plant=servo, settings=settings, fixed=fixed, verdict=verdict, questions=questions,
        reasons=reasons_of(
            model, reference, expected, settings, TuningParameters(), certified, basis.rivals
        ),
        alternatives=alternatives,
        evidence=evidence, reference=reference, expected=expected, model=model,
        uncertainty=basis.uncertainty, saturation=saturation, logged=logged,
        runs=by_name, steps=steps, certified=certified,
    )  # fmt: skip


def _basis_of_step(
    step: StepResponse, sample_time: float | None, dead_time: ArrayLike, around: _DesignOptions
) -> _Basis:
    """The plant of a step test, as uncertain as its intervals and at least as usual."""
    period = step.control_period if sample_time is None else number(sample_time, "sample_time")
    model = plant_of_step(step, period, dead_time if np.any(dead_time) else None)
    noise = step.residual if around.noise is None else around.noise
    return _basis_of(model, uncertainty_of_step(step, period), replace(around, noise=noise))


@dataclass(frozen=True)
class _DesignOptions:
    """The arguments of `design` other than the plant."""

    disturbance: Any
    noise: float | None
    command: Any
    saturation: Saturation | None
    uncertainty: Uncertainty | None
    structure: Structure | None
    feedforward: bool


F = TypeVar("F")
SLOWED = 3  # times that a controller is made slower for the credible plants it loses
SLOWER_PASSES = {"gain", "rivals", "draws", "parts", "halves"}  # gates that a slower loop may pass


class _LogSearches(Protocol[F]):
    """The models of a log in the order in which controllers are designed for them."""

    def candidates(self) -> Iterator[F]: ...
    def first_gates(self, fit: F) -> tuple[Gate, ...]: ...
    def logged(self, fit: F, gates: tuple[Gate, ...] = ()) -> LoggedPlant | LoggedMatrix: ...
    def judged(self, fit: F, logged: Any, G_c: Compensator, peak: float) -> (
        LoggedPlant | LoggedMatrix
    ): ...  # fmt: skip
    def lost(self, fit: F, logged: Any, G_c: Compensator) -> list[DesignPlant]: ...
    def undecided(self, gates: tuple[Gate, ...]) -> UndecidedError: ...


@dataclass(frozen=True)
class _Basis:
    """The design model: a plant, its exogenous signals and its reference loop."""

    model: DesignPlant
    uncertainty: Uncertainty
    expected: Expected
    assumed: tuple[str, ...]
    cases: tuple[Variation, ...]
    reference: Reference
    logged: LoggedPlant | LoggedMatrix | None
    obstacle: str = ""  # why the best model of the log is not used
    rivals: int = 0  # credible models of the log that slowed the controller down
    truncation: tuple[str, str] | None = None  # assumption and evidence, for a plant of many states
    blocked: tuple[float, ...] = ()  # frequencies of d that a zero of the plant blocks


def _basis_of(
    model: DesignPlant,
    usual: Uncertainty,
    around: _DesignOptions,
    logged: LoggedPlant | LoggedMatrix | None = None,
    rivals: Sequence[DesignPlant] = (),
) -> _Basis:
    refuse_states(model)
    u_range = _range(around.saturation)
    expected, assumed = _expected(
        logged, around.disturbance, around.noise, around.command, u_range, model
    )
    uncertain = around.uncertainty or usual
    cases = variations(model, uncertain)
    grid = WeightGrid(model, expected, u_range, cases, around.saturation, rivals)
    structure = around.structure
    if structure is not None and model.m > 1:
        raise InputError(f"structure = {structure.name} is for one input and output; leave it out.")
    if (
        structure is not None
        and 0.0 in grid.blocked
        and any(one.pole == 1 for one in structure.derived)
    ):
        raise NoSolutionError(
            f"structure = {structure.name} integrates, and the plant has a zero at rest, z = 1 "
            "(s = 0), that cancels the integrator: an uncontrollable mode. Take a structure "
            "without integrator, such as pid('P') or fir(20)."
        )
    reference = _reference_of(grid, structure)
    if around.feedforward:
        reference = with_feedforward(model, reference, expected)
    return _Basis(
        model, uncertain, expected, assumed, cases, reference, logged, blocked=grid.blocked
    )


def _reference_of(grid: WeightGrid, structure: Structure | None) -> Reference:
    """The reference without limits if its runs do not reach them, else one for the limits."""

    def best(one: WeightGrid) -> Reference:
        return one.best() if structure is None else reduced_reference(one, structure)

    if grid.saturation is None:
        return best(grid)
    try:
        free = best(grid.without_limits())
    except NoSolutionError:
        return best(grid)
    return best(grid) if grid.reaches_limits(free.compensator) else free


def _truncation_question(model: Truncation, reference: Reference) -> tuple[str, str]:
    """The truncation error of a plant, and the fixed controller's loop with the whole plant."""
    order, plant_order = len(model.whole.A), len(model.plant.A)
    gain = model.small_gain(reference.compensator)
    if gain < 1:
        Ms = f"at most {reference.peak / (1 - gain):.3g}"
    else:  # enough, not necessary
        loop = reference.loop(model.whole)
        if not loop.is_stable:
            raise NoSolutionError(
                f"the controller for the plant's truncation to {plant_order} of its {order} "
                "states does not stabilise the whole plant: give a model of lower order that is "
                "accurate around the bandwidth of the loop."
            )
        Ms = f"{sensitivity_peak(loop):.3g}"
    return (
        f"{plant_order} of its {order} states, and {model.plant.delay} steps of dead time",
        f"balanced truncation, with an error of at most {100 * model.error:.2g} % of the peak of "
        f"the response; with the whole plant the fixed controller's loop is stable, Ms {Ms}",
    )


def _is_log(plant: Any) -> bool:
    """Whether a plant is a log, or logs of several experiments."""
    if isinstance(plant, ControllerLog):
        return True
    is_sequence = isinstance(plant, list | tuple) and len(plant) > 0
    return is_sequence and all(isinstance(one, ControllerLog) for one in plant)


@one_blas_thread()
def _basis_of_log(
    log: ControllerLog | Sequence[ControllerLog], sample_time: float | None, dead_time: float,
    around: _DesignOptions,
) -> _Basis:  # fmt: skip
    """The first model of a log, the best one first, whose controller passes every gate.

    Where no credible model has a controller, one of lower order may: its controller must stabilise
    the credible ones.
    """
    search = search_of_logs(log, sample_time, dead_time)
    if isinstance(search, LogSearch):
        return _basis_of_search(search, around)
    return _basis_of_search(search, around)


def _basis_of_search(search: _LogSearches[F], around: _DesignOptions) -> _Basis:
    first: tuple[Gate, ...] = ()
    obstacle: NoSolutionError | InputError | None = None
    rejected: tuple[F, LoggedPlant | LoggedMatrix, _Basis] | None = None
    is_first = False  # the obstacle is that of the best model
    for count, fit in enumerate(search.candidates()):
        if first and count >= TRIED:
            break  # lower orders are tried where there was no controller
        gates = search.first_gates(fit)
        if not all(gate.passed for gate in gates):
            first = first or gates
            continue
        logged = search.logged(fit, gates)
        try:
            basis = _basis_of(logged.plant, logged.uncertainty, around, logged)
        except (NoSolutionError, BudgetError) as error:
            is_first = is_first or not count
            why = f"the plant of the log integrates: {INTEGRATES}. " * logged.integrates
            obstacle = obstacle or type(error)(f"{why}{error}")
            continue
        judged = search.judged(fit, logged, basis.reference.compensator, basis.reference.peak)
        if _passes(judged):
            reason = "" if obstacle is None else str(obstacle)
            return replace(basis, logged=judged, obstacle=reason)
        first = first or judged.model.gates
        rejected = rejected or (fit, logged, replace(basis, logged=judged))
    if obstacle is not None and (is_first or not first):
        raise obstacle
    slower = rejected and _slower_basis(search, *rejected, around)
    if slower:
        return slower
    raise search.undecided(first)


def _passes(logged: LoggedPlant | LoggedMatrix) -> bool:
    return all(gate.passed for gate in logged.model.gates)


def _slower_basis(
    search: _LogSearches[F], fit: F, logged: LoggedPlant | LoggedMatrix, basis: _Basis,
    around: _DesignOptions,
) -> _Basis | None:  # fmt: skip
    """The basis whose controller holds the credible plants that the first one lost, too.

    The plants that each controller loses are added, until one passes every gate. None where a gate
    fails that no controller passes, such as that of the sign.
    """
    rivals: list[DesignPlant] = []
    for _ in range(SLOWED):
        assert basis.logged is not None
        failed = {gate.name for gate in basis.logged.model.gates if not gate.passed}
        lost = search.lost(fit, logged, basis.reference.compensator)
        if not failed <= SLOWER_PASSES or not lost:
            return None
        rivals += lost
        try:
            basis = _basis_of(logged.plant, logged.uncertainty, around, logged, rivals)
        except (NoSolutionError, BudgetError):
            return None
        judged = search.judged(fit, logged, basis.reference.compensator, basis.reference.peak)
        basis = replace(basis, logged=judged, rivals=len(rivals))
        if _passes(judged):
            return basis
    return None


def _expected(
    logged: LoggedPlant | LoggedMatrix | None, disturbance: Any, noise: float | None, command: Any,
    u_range: float, model: DesignPlant,
) -> tuple[Expected, tuple[str, ...]]:  # fmt: skip
    """As `read_expected`, with defaults from the log if there is one."""
    if logged is None:
        return read_expected(disturbance, noise, command, u_range, model.low_gain, model.m)
    is_unspecified = isinstance(disturbance, str) and disturbance == UNKNOWN
    size = logged.disturbance if is_unspecified else disturbance
    sensor = logged.noise if noise is None else noise
    expected, assumed = read_expected(size, sensor, command, u_range, model.low_gain, model.m)
    return expected, (
        *assumed,
        *(["size"] if is_unspecified else []),
        *(["noise"] * (noise is None)),
    )


def _family(model: DesignPlant, cases: tuple[Variation, ...]) -> dict[str, Plant]:
    """The plants beside the nominal one; those that differ in the noise alone are no other ones."""
    return {one.name: model.servo(one) for one in cases[1:] if one.noise == 1}


def certified_or_reason(
    servo: Plant, settings: ControllerSettings, family: Mapping[str, Plant]
) -> CertifiedSet | str:
    """The certified set of a design, or why there is none."""
    if settings.l_theta > MOST_PROVED:
        return (
            f"theta has {settings.l_theta} coefficients, and beyond {MOST_PROVED} the proof for "
            f"{len(family) + 1} plants takes minutes; certified_set(design.plant, design.settings, "
            "uncertainty=design.family) makes it on demand"
        )
    try:
        return certified_set(servo, settings, uncertainty=family)
    except CompensatorError as error:
        return str(error).rstrip(".")


def guarantee_of(evidence: tuple[Trial, ...]) -> Guarantee:
    """The benefit and the cost of a certified set, beside RCAC in the box."""
    used = [r for t in evidence if t.controller == RCAC for r in t.radius]
    met = sum(r >= 1 for r in used), len(used)
    return Guarantee(compared(evidence, RCAC, BOXED), max(used), met)


def _range(saturation: Saturation | None) -> float:
    """Half the range of u; infinite if it is not bounded on both sides."""
    if saturation is None or saturation.low is None or saturation.high is None:
        return np.inf
    return float((saturation.high - saturation.low).min()) / 2


def verdict_of(evidence: tuple[Trial, ...], trials: Trials | None = None) -> Recommendation:
    """Recommend RCAC if it is significantly better than the fixed controller, with no drawback.

    At no price: stable on the nominal plant and not less often on the others, and peaks of at most
    1.5 times those of the fixed controller. The plants are the draws of the interval: runs on one
    plant are alike. Of `trials` the controllers are run on the nominal plant beside u = 0.
    """
    comparison = compared(evidence, RCAC)
    nominal = next(t for t in evidence if t.controller == RCAC)
    use, why = _choice(nominal, comparison)
    over = None if trials is None else _over_none(trials, use)
    is_boxed = any(t.controller == BOXED for t in evidence)
    return Recommendation(
        use, why, comparison, float(np.median(nominal.Ms)), over,
        guarantee_of(evidence) if is_boxed else None,
    )  # fmt: skip


def _over_none(trials: Trials, name: str) -> float | None:
    """The error with a controller over that with u = 0, if the latter is bounded."""
    m = trials.plant.m
    if not trials.plant.is_stable:
        return None
    still = FixedController(Compensator(np.zeros((1, m, m)), np.zeros((2, m, m))))
    runs, free = (trials.nominal_runs(one) for one in (trials.controllers[name], still))
    ratios = []
    for size in (whole_rms, tail_rms):
        sizes = np.array([[size(a), size(b)] for a, b in zip(runs, free, strict=True)])
        if not sizes[:, 1].all():
            return None
        with np.errstate(divide="ignore"):
            ratios.append(float(np.exp(np.mean(np.log(sizes[:, 0] / sizes[:, 1])))))
    return max(ratios)


def compared(evidence: tuple[Trial, ...], name: str, other: str = FIXED) -> Comparison:
    """Compare a controller with the fixed one, or another, over all plants and draws."""
    ours = [t for t in evidence if t.controller == name]
    theirs = [t for t in evidence if t.controller == other]
    logs: dict[str, float] = {}
    peaks, wins, losses = [], 0, 0
    for a, b in zip(ours, theirs, strict=True):
        both = [
            np.log(x / y) for x, y in zip(a.rms, b.rms, strict=True)
            if np.isfinite(x) and np.isfinite(y) and x > 0 and y > 0
        ]  # fmt: skip
        if both:
            logs[a.variation.name] = float(np.mean(both))
        peaks += [x / y for x, y in zip(a.peak, b.peak, strict=True) if np.isfinite(y) and y > 0]
        wins += sum(x > y for x, y in zip(a.stable, b.stable, strict=True))
        losses += sum(x < y for x, y in zip(a.stable, b.stable, strict=True))
    stable = sum(sum(t.stable) for t in ours), sum(len(t.stable) for t in ours)
    fixed_stable = sum(sum(t.stable) for t in theirs), sum(len(t.stable) for t in theirs)
    proportion = binomtest(*stable).proportion_ci(method="wilson")
    broken = [t.variation.name for t in ours if not all(t.stable)]
    return Comparison(
        *_mean(list(logs.values())), stable, fixed_stable, (proportion.low, proportion.high),
        worst=broken[0] if broken else max(logs, key=lambda one: logs[one], default="none"),
        peak=float(np.median(peaks)) if peaks else np.inf, wins=wins, losses=losses,
    )  # fmt: skip


def _choice(nominal: Trial, comparison: Comparison) -> tuple[str, str]:
    """The recommended controller and the reason."""
    change = 100 * abs(comparison.ratio - 1)
    verb = "lowers" if comparison.ratio < 1 else "raises"
    brings = f"RCAC {verb} the rms error by {change:.0f} %"
    if change < 0.5:
        brings = "RCAC changes the rms error by less than 0.5 %"
    if not all(nominal.stable):
        return FIXED, "RCAC ends in an unstable loop with the nominal plant."
    if comparison.losses > comparison.wins:
        return FIXED, (
            f"of {comparison.stable[1]} test runs {comparison.losses} are unstable with RCAC alone "
            f"and {comparison.wins} with the fixed controller alone; where both are stable "
            f"{brings}."
        )
    if comparison.peak > PEAK:
        return FIXED, f"{brings}, but its peaks are {comparison.peak:.2g} times as large."
    if comparison.interval[1] < WORTH:
        return RCAC, f"{brings} over the uncertainty."
    saved = (
        f"RCAC stabilises {comparison.wins} of {comparison.stable[1]} test runs that are unstable "
        "with the fixed controller"
    )
    if comparison.wins > comparison.losses and comparison.interval[1] < 1 / WORTH:
        return RCAC, f"{saved}, and {brings}."
    if comparison.wins > comparison.losses:
        return FIXED, f"{saved}, but {brings}, which is not significant."
    if comparison.interval[0] > 1 / WORTH:
        return FIXED, f"{brings} over the uncertainty."
    low, high = comparison.interval
    if low > 1:
        return FIXED, f"{brings}, which is significant."
    if high < 1:
        worth = f"the {100 * (1 - WORTH):.0f} % that justify adaptation"
        return FIXED, f"{brings}: significant, but not significantly more than {worth}."
    return FIXED, f"{brings}: not significant."


def _mean(logs: list[float]) -> tuple[float, tuple[float, float]]:
    """The geometric mean and its 95 % interval by Student's t."""
    if not logs:
        return np.nan, (np.nan, np.nan)
    mean = float(np.exp(np.mean(logs)))
    if len(logs) == 1:
        return mean, (0.0, np.inf)
    if np.ptp(logs) == 0:
        return mean, (mean, mean)
    interval = ttest_1samp(logs, 0.0).confidence_interval()
    return mean, (float(np.exp(interval.low)), float(np.exp(interval.high)))


def _first_response(model: DesignPlant, fixed: FixedController) -> float:
    """The first response of e to an impulse of d over the largest one, in the reference loop."""
    w = np.zeros((RESPONSE, 3 * model.m))
    w[0, model.m : 2 * model.m] = 1.0
    e = np.linalg.norm(simulate(model.servo(), fixed, w).z, axis=1)
    significant = e[e > np.finfo(float).eps * e.max()]
    return float(significant[0] / e.max()) if len(significant) else 1.0


def _meaning_of_sign(model: DesignPlant) -> str:
    """The response that the assumed sign is of."""
    words = "the sign of y at rest for a constant u > 0"
    if not model.is_stable:
        words = "the sign of y in the end after a step of u > 0 from rest"
        gain = model.gain_at_rest
        if np.isfinite(gain) and gain != 0:
            words += f" (y leaves; G(1) = {gain:.4g} is the equilibrium, which is unstable)"
    return f"{words}; with the other sign every loop diverges"


def _questions(
    basis: _Basis, fixed: FixedController, saturation: Saturation | None
) -> tuple[Question, ...]:
    """The assumptions that only the user can confirm."""
    model, expected, assumed = basis.model, basis.expected, basis.assumed
    uncertainty, logged = basis.uncertainty, basis.logged
    late = model.delay + model.fraction
    by_entry = "" if model.longest == model.delay else f" to {model.longest} by entry"
    least = max(late - uncertainty.delay, 0)
    most = model.longest + model.fraction + uncertainty.delay
    questions = []
    if logged is not None:
        questions.append((
            "plant", f"the model of the log, {logged.model}", logged.evidence
        ))  # fmt: skip
        if logged.model.is_direct:
            questions.append((
                "plant", "y responds to u of the same row: y is logged after u is applied",
                "the model has one step of delay more, since a controller computes u from the y "
                "before it",
            ))  # fmt: skip
        if logged.every > 1:
            every, h = logged.every, model.sample_time
            questions.append((
                "sample_time", f"{every} rows of the log" + (f", {h:.4g} s" if h else ""),
                "the dead time is longer than 60 rows, and each step of it has two "
                "coefficients: the controller runs in one of these rows and holds u between them",
            ))  # fmt: skip
    if basis.truncation:
        questions.append(("plant", *basis.truncation))
    questions += [
        ("plant", "gain 0 at rest", "a constant u has no lasting effect on y")
        if 0.0 in basis.blocked else
        ("plant", f"sign {model.sign}", _meaning_of_sign(model))
        if model.m == 1 else
        ("plant", "at rest the weakest direction of u has "
         f"1/{model.condition:.3g} of the strongest's gain",
         "sign and size of this gain decide whether a loop with integrators is stable"),
        ("dead_time", f"{late:.4g}{by_entry} steps, {least:.4g} to {most:.4g}",
         "the dead time limits the bandwidth"),
    ]  # fmt: skip
    if "disturbance" in assumed:
        size = " and of size" if "size" in assumed else ", of size"
        origin = ""
        if "size" in assumed and basis.logged is not None:
            origin = (
                "as large as what the model leaves of y in the log; the size of a larger one in "
                "place of unknown makes the controller faster; "
            )
        questions.append((
            "disturbance", f"of unknown kind{size} {expected.disturbance_size:.3g}, in units of u",
            origin + "a known step, sinusoid or spectrum improves the design more than any tuning",
        ))  # fmt: skip
    for omega in basis.blocked:
        at, signal = "at rest, z = 1 (s = 0)", "a constant"
        model_of = "an integrator"
        if omega:
            at, signal = f"at {omega:.4g} rad/step", "this sinusoid"
            model_of = "an oscillator"
        questions.append((
            "disturbance", f"blocked by the plant's zero {at}",
            f"{signal} in u does not reach y: the controller is designed without {model_of}, "
            "which the zero would cancel, and no controller holds a command there",
        ))  # fmt: skip
    if "noise" in assumed:
        words = "standard deviation of the sensor noise"
        questions.append(("noise", f"{expected.noise:.3g}, in units of y", words))
    if saturation is None:
        range_of_u = (
            "" if logged is None else f"; in the log u is {logged.u[0]:.3g} to {logged.u[1]:.3g}"
        )
        questions.append(
            ("u_limits", "none", f"with limits the saturation is simulated{range_of_u}")
        )
    if (first := _first_response(model, fixed)) < FAST:
        questions.append((
            "sample_time", "as given",
            f"the first response of e to d is {first:.1e} of the largest: sample more slowly",
        ))  # fmt: skip
    if basis.obstacle:
        questions.append((
            "plant", "a model of lower order than the log supports",
            f"the best model has no controller: {basis.obstacle}",
        ))  # fmt: skip
    if logged is not None and logged.integrates:
        questions.append(
            ("plant", "the model of the log, though the plant seems to integrate", INTEGRATES)
        )
    if not model.is_stable and (logged is None or not logged.is_closed):
        questions.append((
            "plant", "unstable or integrating, with the stated uncertainty",
            "confirm it on a log of a stabilised loop before RCAC runs alone",
        ))  # fmt: skip
    return tuple(Question(*one) for one in questions)


def _no_room(limits: Saturation | None, model: DesignPlant, expected: Expected, w: Array) -> str:
    sides = {} if limits is None else {"low": limits.low, "high": limits.high}
    low, high = (
        np.array(default) if sides.get(name) is None else np.ravel(np.asarray(sides[name]))
        for name, default in (("low", [-np.inf]), ("high", [np.inf]))
    )
    if (low < 0).all() and (high > 0).all():
        return ""
    if model.m == 1 and expected.constant_command:
        at_rest = _control_at_rest(model, w[-max(len(w) // 4, 1) :], expected.is_known)
        if low[0] < at_rest < high[0]:
            return ""
    side, beyond = ("below", low >= 0) if (low >= 0).any() else ("above", high <= 0)
    which = "" if len(beyond) == 1 else f" of input {int(np.argmax(beyond)) + 1}"
    return (
        f"u_limits = {low[beyond.argmax() % len(low)]:g} to {high[beyond.argmax() % len(high)]:g}"
        f"{which} leave u no room {side} 0, and u = 0 is the working point from which limits and "
        "signals count: the controller can push one way only. Give the limits as deviations, such "
        "as (-30, 70) for an actuator of 0 to 100 that is at 30 there; or the command that moves "
        "the loop away from u = 0, such as command=Step(20.0)."
    )


def _control_at_rest(model: DesignPlant, last: Array, is_known: bool) -> float:
    """The u at rest for the means of r and of a known d, both scalar."""
    r, d = last[:, :2].mean(axis=0)
    with np.errstate(divide="ignore"):
        u_at_rest = float(np.divide(r, model.gain_at_rest)) if r else 0.0
    return u_at_rest - float(d) * is_known


def _remaining_questions(
    model: DesignPlant, expected: Expected, run: Run, verdict: Recommendation
) -> tuple[Question, ...]:
    """The limits of control: by the actuator, or in general."""
    remainders, m, last = [], model.m, slice(-max(run.steps // 4, 1), None)
    limits = run.saturation
    if (
        limits is not None
        and expected.is_known
        and m == 1
        and None not in (limits.low, limits.high)
    ):
        at_rest = _control_at_rest(model, run.w[last], is_known=True)
        low, high = (float(np.ravel(np.asarray(one))[0]) for one in (limits.low, limits.high))
        if not low < at_rest < high:
            remainders.append(Question(
                "u_limits", f"{low:g} to {high:g}, with u = 0 at the working point",
                f"the constant parts of r and d need u = {at_rest:.3g} at rest, beyond the "
                "actuator: the error stays. Count u from the working point",
            ))  # fmt: skip
    if model.is_stable and not verdict.is_worse_than_none:
        still = Compensator(np.zeros((1, m, m)), np.zeros((2, m, m)))
        free = simulate(run.plant, FixedController(still), run.w)
        left = tail_rms(run) / (tail_rms(free) or 1.0)
        if left > LEFT:
            words = f"with the fixed controller the error is {left:.2g} times that without control"
            remainders.append(Question(
                "disturbance", "as given", f"{words}: control can do little here",
            ))  # fmt: skip
    return tuple(remainders)


def reasons_of(
    model: DesignPlant, reference: Reference, expected: Expected, settings: ControllerSettings,
    parameters: TuningParameters, certified: CertifiedSet | str | None = None, rivals: int = 0,
) -> tuple[Reason, ...]:  # fmt: skip
    """The reasons of the settings."""
    n_c, structure = reference.compensator.n_c, settings.structure
    models = [f"an oscillator at {omega:.3g} rad/step" for omega, _ in expected.sinusoids]
    model_order = model.servo().n + 2 * model.m * len(models)
    models += {0: [], 1: ["an integrator"]}.get(
        (reference.problem.n - model_order) // model.m, ["two integrators"]
    )
    parts = " and ".join(models)
    robust = (
        ""
        if reference.peak <= MOST
        else "; no controller of the weight grid is robust with Ms <= 2"
    )
    weights = f"R_2 = {reference.R_2:g}, V_2 x {reference.V_2:g}"
    modelled = f"; with {parts} for the disturbance" if parts else ""
    held = f" of the loops that hold {rivals} more models credible by the log" if rivals else ""
    chosen = f"{weights}: the smallest u among errors within 10 % of the least{held}"
    fixed = f"LQG of order {n_c}", f"{chosen}{robust}{modelled}"
    more = (
        f" and {parameters.spare} more" if parameters.spare else "; a higher order costs robustness"
    )
    order = f"iir(n_c={n_c + parameters.spare})", f"the order of the fixed controller{more}"
    if reference.commands:
        words = "past u, e and r under one denominator; the part from r does not change the loop"
        order = f"feedforward(n_c={structure.n_c})", words
    if reference.full is not None:
        words = f"fitted to LQG loops, weighted by the effect on the error{robust}"
        fixed = f"{structure.name} of {structure.l_theta} coefficients", words
        order = structure.name, "as requested"
    bounds = (
        f"theta_0 +- {parameters.width:.3g} of its rms",
        "a limit on theta if actuator or delay are not as expected",
    )
    if isinstance(certified, CertifiedSet):
        bounds = (
            f"certified set for {len(certified.members)} plants",
            "no motion of theta in it destabilises the loop on any of them, by an exact proof",
        )
    forgets = "" if parameters.forgetting == 1 else f"; lambda = {parameters.forgetting:.6g}"
    return (
        Reason("fixed", f"{fixed[0]}, Ms = {reference.peak:.3g}", fixed[1]),
        Reason("structure", *order),
        Reason("target", f"order {settings.target.n_f}",
               "the closed loop of the fixed controller, by (4.18), so that it can be reached"),
        Reason("theta_0", "the fixed controller", "from theta_0 = 0 a weak prior gives a large "
               "transient"),
        Reason("R_theta", f"{parameters.worth(expected):.3g} samples",
               "N_0 mean(Phi_f' Phi_f) in the fixed controller's loop: a prior weight of N_0 "
               f"samples{forgets}"),
        Reason("k_w", "0", "theta_0 is already a working controller, so control starts at once"),
        Reason("k_update", f"{settings.k_update} steps",
               "max(n_c, n_f): the step from which regressor and filter are filled"),
        Reason("R_z", f"1/(1 + nu abs(z))^2, nu = {parameters.nu:.3g} over the size of z",
               "steps with a large z have less weight"),
        Reason("bounds", *bounds),
    )  # fmt: skip
