"""Batches of runs over threads: all results, or a stream of results."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any, Generic, TypeVar, overload

import attrs
from numpy.typing import ArrayLike

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays._validation import instance_of, integer, items
from rcac_numeric.arrays._values import Result, Value
from rcac_numeric.controllers._supervision import Supervision
from rcac_numeric.engine._compatibility import AnyController
from rcac_numeric.engine._jobs import PreparedRun, RunInterrupted, in_slices, run_to_end
from rcac_numeric.engine._loops import PreparedLoops
from rcac_numeric.engine._runs import Run
from rcac_numeric.plants._any_plant import AnyPlant
from rcac_numeric.plants._foreign import as_plant
from rcac_numeric.plants._saturation import Saturation


@attrs.frozen(eq=False, slots=False)
class SimulationCase(Value):
    """The arguments of one `simulate`.

    Parameters
    ----------
    plant, settings, w
        As for `simulate`; a system of python-control, SciPy or SymPy is read by `plant_of`, and
        the plant is what is kept.
    options : mapping
        The keyword arguments of `simulate`: x_0, stride, divergence_limit, saturation, start.

    Examples
    --------
    >>> import control
    >>> from rcac_numeric import Compensator, FixedController, SimulationCase
    >>> law = FixedController(Compensator(past_u=[[[0.0]]], past_y=[[[0.0]], [[-0.1]]]))
    >>> case = SimulationCase(control.tf([1], [1, -0.5], 0.01), law, [[1.0]] * 20)
    >>> case.plant.sample_time
    0.01
    """

    plant: AnyPlant = attrs.field(converter=as_plant)
    settings: AnyController
    w: ArrayLike
    options: Mapping[str, Any] = attrs.field(factory=dict)

    def __attrs_post_init__(self) -> None:
        object.__setattr__(self, "options", self.options or {})


def simulate_many(
    cases: Iterable[SimulationCase], *, threads: int | None = None, lanes: bool = False
) -> list[Run]:
    """Run many cases over threads; the results come in the same order.

    Without lanes they are those of `simulate`, bit for bit. A case's result never depends on
    which other cases are there, nor on the number of threads.

    Parameters
    ----------
    cases : iterable of SimulationCase
        Seeds, settings and plants may differ from case to case.
    threads : int, optional
        As many as there are processors by default. Functions of Python plants and weights run one
        at a time.
    lanes : bool
        Let eligible cases with equal structures and sizes go in lock step, eight at a time, one to
        a lane of the processor's vectors: per case about 5 times faster than one after another
        for l_theta = 8, 3.5 times for 20 and 1.8 times for 40 (benchmarks/closed_loop.py). Fewer
        than eight cost what eight do, so lanes pay from 2, 3 and 5 cases on. Plants, signals,
        settings and lengths may differ within the eight. `CertifiedBounds` project each case by
        itself: lanes lose where more than about 50, 30, 20 or 10 % of the steps are projected, for
        l_theta = 20, 30, 40 or 50 (benchmarks/kept_inside.py --lanes).

        Sums are then taken in another order than in `simulate`, and neither order is the more
        accurate. Two runs differ by what the loop makes of relative changes of its data at every
        step by 4 (l_theta + n + l_w + 8) * 2.2e-16 or less. A loop that grows without bound,
        or data that do not determine theta (`Run.guard_count`), amplify these changes; the result
        of `simulate` then has the same uncertainty.

        Eligible is: one controller with ``update = UD(R_theta, lambda_)``, a number each, in the
        predictor form, without process_noise, reset, stop_where_unsupported, freeze,
        target_changes, reflect_poles, R_u_unfiltered, z_normalization, fixed and
        `CoefficientBounds`, k_filter = 0, no derived signals (PID, integrators), l_z <= 3; R_z and
        R_u constant or, for l_z = 1, a `SignalWeight` without nu, their sum for l_z = 1 between
        1e-100 and 1e100; a plant of constant matrices without delay; no saturation. All other
        cases give what `simulate` gives, bit for bit. With `CertifiedBounds` each run makes its
        projections alone: where 30 % of the steps project, lanes are 1.6 times as fast for
        l_theta = 8, 1.2 for 20 and 0.8 for 40 (benchmarks/kept_inside.py).

    Raises
    ------
    InputError
        Where a case is not valid; its number is named, and nothing has run.
    RunInterrupted
        On Ctrl-C, within about 0.1 s; its attribute `runs` holds all runs so far.

    A case whose function failed ends with the outcome "plant failed" or "weight failed" and says
    why in `Run.failure`; the other cases are not touched.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, SimulationCase, WhiteNoise, exogenous, fir_target, iir,
    ...     simulate_many, standard_plant)
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=fir_target(plant), update=UD(R_theta=1))
    >>> noise = [exogenous([WhiteNoise()], 100, seed) for seed in range(8)]
    >>> cases = [SimulationCase(plant, settings, w) for w in noise]
    >>> runs, in_lanes = simulate_many(cases), simulate_many(cases, lanes=True)
    >>> [run.outcome for run in runs] == ["completed"] * 8
    True
    >>> all(abs(a.u - b.u).max() < 1e-12 for a, b in zip(runs, in_lanes))
    True
    """
    workers = integer(os.cpu_count() or 1 if threads is None else threads, "threads", at_least=1)
    instance_of(lanes, "lanes", bool)
    case_list = items(cases, "cases")
    prepared, loops = [], PreparedLoops()
    for number, case in enumerate(case_list):
        if not isinstance(case, SimulationCase):
            raise InputError(
                f"case {number} is {case!r}; SimulationCase(plant, settings, w) is needed."
            )
        try:
            prepared.append(_prepared(case, loops))
        except TypeError as error:
            raise InputError(f"the options of case {number}: {error}.") from None
        except InputError as error:
            raise InputError(f"case {number}: {error}") from None
    return _run_in_groups(prepared, workers, lanes)


# Runs of a batch in memory at the same time: enough to fill the SIMD lanes of many kinds, and few
# enough to reuse memory.
GROUP = 256


def _run_in_groups(prepared: list[PreparedRun], threads: int, lanes: bool) -> list[Run]:
    """Return the runs in order; runs of one kind share SIMD batches."""
    runs: dict[int, Run] = {}
    waiting = dict(sorted(enumerate(prepared), key=lambda pair: pair[1].kind))
    del prepared[:]  # frees the memory of completed runs
    while waiting:
        group = dict(islice(waiting.items(), max(GROUP, 64 * threads)))
        for number in group:
            del waiting[number]
        try:
            run_to_end(list(group.values()), threads, lanes)
        except RunInterrupted as stopped:
            runs.update(zip(group, stopped.runs, strict=True))
            runs.update({n: one.result(interrupted=True) for n, one in waiting.items()})
            raise RunInterrupted([runs[number] for number in sorted(runs)]) from None
        runs.update({number: one.result() for number, one in group.items()})
    return [runs[number] for number in range(len(runs))]


def _prepared(case: SimulationCase, loops: PreparedLoops) -> PreparedRun:
    return _prepared_run(loops, case.plant, case.settings, case.w, **case.options)


def _prepared_run(
    loops: PreparedLoops,
    plant: AnyPlant,
    settings: AnyController,
    w: ArrayLike,
    saturation: Saturation | None = None,
    supervision: Supervision | None = None,
    **options: Any,
) -> PreparedRun:
    return PreparedRun(loops.of(plant, settings, saturation, supervision), w, **options)


T = TypeVar("T")
# Outcomes of a case that could not be prepared, or whose reducer raised.
REFUSED, REDUCER_FAILED = "refused", "reducer failed"


@dataclass(frozen=True, eq=False)
class CaseResult(Result, Generic[T]):
    """The result of one case of a stream.

    Attributes
    ----------
    number : int
        Which case it was, from 0 on.
    outcome : str
        That of the `Run`; "refused" where the case is not valid, and "reducer failed" where
        `reduce` raised.
    value : optional
        The run, or what `reduce` made of it; None where there is none.
    failure : str
        What was wrong with the case, what its function raised, or what `reduce` raised.
    """

    number: int
    outcome: str
    value: T | None
    failure: str = ""


@overload
def simulate_stream(
    cases: Iterable[SimulationCase],
    *,
    threads: int | None = ...,
    lanes: bool = ...,
    at_once: int = ...,
    progress: Callable[[int], None] | None = ...,
) -> Iterator[CaseResult[Run]]: ...
@overload
def simulate_stream(
    cases: Iterable[SimulationCase],
    *,
    reduce: Callable[[int, Run], T],
    threads: int | None = ...,
    lanes: bool = ...,
    at_once: int = ...,
    progress: Callable[[int], None] | None = ...,
) -> Iterator[CaseResult[T]]: ...
def simulate_stream(
    cases: Iterable[SimulationCase],
    *,
    reduce: Callable[[int, Run], Any] | None = None,
    threads: int | None = None,
    lanes: bool = False,
    at_once: int = 256,
    progress: Callable[[int], None] | None = None,
) -> Iterator[CaseResult[Any]]:
    """Run many cases and yield each result when its run has ended.

    A run is that of `simulate_many`, bit for bit, whatever the order. Cases are taken from their
    iterable as they are needed, `at_once` of them at a time, and nothing of a run is kept once
    its result was handed out, so memory does not grow with the number of cases. A case that is
    not valid, or that fails, is a result with that outcome; the others go on.

    Parameters
    ----------
    cases : iterable of SimulationCase
    reduce : callable, optional
        reduce(number, run) takes the place of the run in the result; its runs have no `state`.
    threads, lanes
        As for `simulate_many`.
    at_once : int
        How many runs there are in memory.
    progress : callable, optional
        Called with the number of results so far after each of them.

    Raises
    ------
    RunInterrupted
        On Ctrl-C, within about 0.1 s; its attribute `runs` holds the runs that were under way.
        With `reduce` a plain KeyboardInterrupt.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, SimulationCase, WhiteNoise, exogenous, fir_target, iir,
    ...     simulate_stream, standard_plant)
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = ControllerSettings(
    ...     structure=iir(n_c=2), target=fir_target(plant), update=UD(R_theta=1))
    >>> cases = (
    ...     SimulationCase(plant, settings, exogenous([WhiteNoise()], 100, s)) for s in range(1000))
    >>> peaks = simulate_stream(cases, reduce=lambda number, run: abs(run.z).max(), lanes=True)
    >>> sum(result.outcome == "completed" for result in peaks)
    1000
    """
    workers = integer(os.cpu_count() or 1 if threads is None else threads, "threads", at_least=1)
    instance_of(lanes, "lanes", bool)
    integer(at_once, "at_once", at_least=1)
    return _results(iter(cases), reduce, workers, lanes, at_once, progress)


def _results(
    cases: Iterator[SimulationCase],
    reduce: Callable[[int, Run], Any] | None,
    threads: int,
    lanes: bool,
    at_once: int,
    progress: Callable[[int], None] | None,
) -> Iterator[CaseResult[Any]]:
    first, handed_out, loops = 0, 0, PreparedLoops()
    while batch := list(islice(cases, at_once)):
        for result in _of_batch(batch, first, loops, reduce, threads, lanes):
            handed_out += 1
            yield result
            if progress is not None:
                progress(handed_out)
        first += len(batch)


def _of_batch(
    batch: list[SimulationCase],
    first: int,
    loops: PreparedLoops,
    reduce: Callable[[int, Run], Any] | None,
    threads: int,
    lanes: bool,
) -> Iterator[CaseResult[Any]]:
    prepared: list[PreparedRun] = []
    numbers = []
    loops.begin()
    for number, case in enumerate(batch, first):
        try:
            if not isinstance(case, SimulationCase):
                raise InputError(f"{case!r} is no SimulationCase(plant, settings, w).")
            prepared.append(_prepared(case, loops))
            numbers.append(number)
        except (CompensatorError, TypeError) as error:
            yield CaseResult(number, REFUSED, None, str(error))
    del batch  # a prepared run has its own reference
    waiting = dict(enumerate(prepared))
    for _ in in_slices(prepared, threads, lanes, keep=reduce is None):
        for i in [i for i, one in waiting.items() if one.has_ended]:
            yield _result(numbers[i], waiting.pop(i), reduce)


def _result(
    number: int, one: PreparedRun, reduce: Callable[[int, Run], Any] | None
) -> CaseResult[Any]:
    run = one.result(with_state=reduce is None)
    if reduce is None:
        return CaseResult(number, run.outcome, run, run.failure)
    try:
        return CaseResult(number, run.outcome, reduce(number, run), run.failure)
    except Exception as error:  # the user's reducer may raise any error
        return CaseResult(number, REDUCER_FAILED, None, f"{type(error).__name__}: {error}")
