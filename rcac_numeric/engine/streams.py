"""Many runs, one result after another: what is not kept takes no memory."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any, Generic, TypeVar, overload

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.arrays.validation import instance_of, integer
from rcac_numeric.arrays.values import Value
from rcac_numeric.engine.batches import SimulationCase
from rcac_numeric.engine.interruption import in_slices
from rcac_numeric.engine.jobs import PreparedRun
from rcac_numeric.engine.runs import Run

T = TypeVar("T")
# What a case that could not be prepared, or whose reducer raised, ends with.
REFUSED, REDUCER_FAILED = "refused", "reducer failed"


@dataclass(frozen=True, eq=False)
class CaseResult(Value, Generic[T]):
    """How one case of a stream ended.

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
    """Run many cases and hand out each result when its run has ended.

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
    return _results(iter(cases), reduce, workers, lanes, at_once, progress or _silence)


def _results(
    cases: Iterator[SimulationCase],
    reduce: Callable[[int, Run], Any] | None,
    threads: int,
    lanes: bool,
    at_once: int,
    progress: Callable[[int], None],
) -> Iterator[CaseResult[Any]]:
    first = handed_out = 0
    while batch := list(islice(cases, at_once)):
        for result in _of_batch(batch, first, reduce, threads, lanes):
            handed_out += 1
            yield result
            progress(handed_out)
        first += len(batch)


def _of_batch(
    batch: list[SimulationCase],
    first: int,
    reduce: Callable[[int, Run], Any] | None,
    threads: int,
    lanes: bool,
) -> Iterator[CaseResult[Any]]:
    prepared: list[PreparedRun] = []
    numbers = []
    for number, case in enumerate(batch, first):
        try:
            if not isinstance(case, SimulationCase):
                raise InputError(f"{case!r} is no SimulationCase(plant, settings, w).")
            prepared.append(PreparedRun(case.plant, case.settings, case.w, **case.options))
            numbers.append(number)
        except (CompensatorError, TypeError) as error:
            yield CaseResult(number, REFUSED, None, str(error))
    del batch  # what is prepared holds its own
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
    except Exception as error:  # of the user's own function
        return CaseResult(number, REDUCER_FAILED, None, f"{type(error).__name__}: {error}")


def _silence(count: int) -> None:
    """Say nothing of how far it is."""
