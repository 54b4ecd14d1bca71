"""A worker's whole work: runs in, records out. It knows no store and no other worker."""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.judging._cost_measures import h2_cost, high_authority_cost
from rcac_experiments.sweeps._canonical import canonical_json
from rcac_experiments.sweeps._cells import Cell, Cells
from rcac_experiments.sweeps._chunk import (
    FAILED,
    FUNCTION_FAILED,
    MEASURE_FAILED,
    REFUSED,
    ChunkResult,
    ChunkTask,
    RunRecord,
    TimeLimitReached,
    error_text,
    failure,
    storable,
)
from rcac_experiments.sweeps._measures import Metric
from rcac_experiments.sweeps._study import Coordinates, Study
from rcac_numeric.analysis._loop_analysis import LoopAnalysis
from rcac_numeric.compiled._controllers import VARIABLE, instruction_set
from rcac_numeric.engine._batches import SimulationCase, simulate_stream
from rcac_numeric.engine._reference import require_supported, simulate_reference
from rcac_numeric.engine._runs import Run
from rcac_numeric.engine._simulation import simulate


class MeasureFailed(Exception):
    """An exception of a metric that is no property of its run."""

    def __init__(self, name: str, cause: BaseException) -> None:
        super().__init__(name)
        self.name, self.cause = name, cause


class KeyWatch:
    """Notices Ctrl-C while it is entered, to distinguish it from a KeyboardInterrupt of a measure.

    It takes the place of Python's handler of SIGINT in the main thread, and hands on to it.
    """

    def __init__(self) -> None:
        self.pressed = False
        self._previous: Callable[[int, FrameType | None], Any] | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """The signal handler."""
        self.pressed = True
        if self._previous is not None:
            self._previous(number, frame)

    def __enter__(self) -> KeyWatch:
        previous = signal.getsignal(signal.SIGINT)
        if threading.current_thread() is threading.main_thread() and callable(previous):
            self._previous = previous
            signal.signal(signal.SIGINT, self)
        return self

    def __exit__(self, *error: object) -> None:
        handler: object = signal.getsignal(signal.SIGINT)
        if self._previous is not None and handler is self:
            signal.signal(signal.SIGINT, self._previous)


def is_of_a_key(error: BaseException) -> bool:
    """Whether somebody pressed Ctrl-C here; otherwise whoever runs here raised it himself."""
    if not isinstance(error, KeyboardInterrupt):
        return False
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or handler is signal.SIG_IGN:
        return False
    return handler.pressed if isinstance(handler, KeyWatch) else True


def measured(cell: Cell, run: LoopAnalysis) -> tuple[list[float], str]:
    """One number for each measure of the study, NaN where the run has none, and why.

    That a run has none is a property of it: a measure says so by a `CompensatorError`, which after
    a run that did not complete is not even worth a word.
    """
    values, notes = [], []
    for metric in cell.study.keep:
        try:
            values.append(_value(cell, metric, run))
        except CompensatorError as error:
            values.append(math.nan)
            if run.run.outcome == "completed":
                notes.append(f"measure {metric.name}: {type(error).__name__}: {error}")
        except TimeLimitReached:
            raise
        except BaseException as error:  # of the user's own function: SystemExit too
            if is_of_a_key(error):
                raise
            raise MeasureFailed(metric.name, error) from None
    return values, "; ".join(notes)


def _value(cell: Cell, metric: Metric, run: LoopAnalysis) -> float:
    quick = isinstance(metric.measure, str) and ONCE_FOR_A_CELL.get(metric.measure)
    value = (
        quick(cell, run, **metric.arguments) if quick else metric.function(run, **metric.arguments)
    )
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"it returned a {type(value).__name__}, which is no number") from None


def _least_cost(cell: Cell, run: LoopAnalysis, **arguments: Any) -> float:
    """The cost of LQG: one value for all runs that ended with the same plant."""
    key = ("high_authority_cost", run.last_step, canonical_json(arguments))
    if key not in cell.remembered:
        cell.remembered[key] = high_authority_cost(run, **arguments)
    return float(cell.remembered[key])


def _cost_ratio(cell: Cell, run: LoopAnalysis, **arguments: Any) -> float:
    return h2_cost(run, **arguments) / _least_cost(cell, run, **arguments)


ONCE_FOR_A_CELL: dict[str, Callable[..., Any]] = {
    "high_authority_cost": _least_cost,
    "cost_over_high_authority": _cost_ratio,
}


# The study that this process has read last, by its fingerprint.
_KNOWN: dict[str, Cells] = {}


def _no_progress() -> None:
    """Tell nobody that a run has ended."""


def run_chunk(task: ChunkTask, progress: Callable[[], None] = _no_progress) -> ChunkResult:
    """Run some runs of a study; none of them can fail but as a record.

    `progress` is called when it begins, and whenever a run has ended.
    """
    start = time.perf_counter()
    _use(task.instruction_set)
    cells = _cells(task)
    with contextlib.suppress(Exception):  # what it says is recorded below, with the run's number
        cells.cell(task.runs[0][0])  # reads libraries, which is no part of any run's time
    progress()
    with np.errstate(all="ignore"):  # a loop that leaves float64 is an outcome, not a warning
        records = _records(cells, task, progress)
    return ChunkResult(sorted(records, key=lambda record: record.run), time.perf_counter() - start)


def run_in_full(cells: Cells, coordinates: Coordinates, repetition: int) -> LoopAnalysis:
    """One run of a study by itself, with all that belongs to it."""
    cell = cells.cell(coordinates)
    if cell.is_reference or cell.is_stepwise:
        return LoopAnalysis(_alone(cell, repetition), cell.target)
    case = cell.case(repetition)
    (result,) = simulate_stream([case], lanes=cells.study.lanes)
    if result.value is None:
        raise InputError(result.failure)
    return LoopAnalysis(result.value, cell.target)


def _cells(task: ChunkTask) -> Cells:
    if task.fingerprint not in _KNOWN:
        try:
            study = pickle.loads(task.study)
        except Exception as error:
            raise InputError(
                f"a worker cannot read the study: {type(error).__name__}: {error}. Its functions "
                "must be at the top of modules that every worker can import."
            ) from None
        if not isinstance(study, Study):
            raise InputError(f"a worker was sent a {type(study).__name__} instead of a study.")
        _KNOWN.clear()
        _KNOWN[task.fingerprint] = Cells(study)
    return _KNOWN[task.fingerprint]


def _use(instructions: str) -> None:
    """All runs of a study use the same instructions on whatever machine, unless it is mixed."""
    if instructions and instruction_set() != instructions:
        os.environ[VARIABLE] = instructions
        instruction_set()


def _records(cells: Cells, task: ChunkTask, progress: Callable[[], None]) -> list[RunRecord]:
    """The records of all runs: together, and one by one where that ends in an error."""
    try:
        return _together(cells, task, progress)
    except BaseException as error:  # out of memory, too slow, or whatever a function raises
        if is_of_a_key(error):
            raise
        numbers = task.numbers
        if len(numbers) == 1:
            return [failure(numbers[0], FUNCTION_FAILED, error)]
    records = []
    for number in numbers:
        progress()
        records += _records(cells, task.only([number]), progress)
    return records


def _together(cells: Cells, task: ChunkTask, progress: Callable[[], None]) -> list[RunRecord]:
    study, records = cells.study, []
    under_way: list[tuple[int, Cell]] = []

    def cases() -> Iterator[SimulationCase]:
        for coordinates, pairs in task.runs:
            cell: Cell | None = None
            for run, repetition in pairs:
                try:
                    cell = cells.cell(coordinates) if cell is None else cell
                    if cell.is_reference or cell.is_stepwise:
                        loop_run = _alone(cell, repetition)
                        records.append(_record(run, cell, loop_run, loop_run.failure))
                        progress()
                        continue
                    case = cell.case(repetition)
                except TimeLimitReached:
                    raise
                except BaseException as error:  # of the user's own function too
                    if is_of_a_key(error):
                        raise
                    records.append(_refusal(study, run, error))
                    continue
                under_way.append((run, cell))
                yield case

    def reduced(number: int, loop_run: Run) -> RunRecord:
        run, cell = under_way[number]
        record = _record(run, cell, loop_run, loop_run.failure)
        progress()
        return record

    for result in simulate_stream(
        cases(), reduce=reduced, threads=1, lanes=study.lanes, at_once=task.at_once
    ):
        if result.value is not None:
            records.append(result.value)
            continue
        number = under_way[result.number][0]
        if result.outcome in FAILED:
            records.append(failure(number, result.outcome, result.failure))
        else:
            records.append(_refused(study, number, result.outcome, result.failure))
    return records


def _record(run: int, cell: Cell, loop_run: Run, words: str) -> RunRecord:
    if loop_run.outcome in FAILED:
        if words.startswith(TimeLimitReached.__name__):
            raise TimeLimitReached(words)
        return failure(run, loop_run.outcome, words)
    try:
        values, note = measured(cell, LoopAnalysis(loop_run, cell.target))
    except MeasureFailed as failed:
        text = f"measure {failed.name}: {error_text(failed.cause)}"
        record = failure(run, MEASURE_FAILED, failed.cause)
        return RunRecord(run, record.outcome, storable(text), [], {})
    signals = {name: np.array(getattr(loop_run, name)) for name in cell.study.keep_signals}
    error = storable("; ".join(part for part in (words, note) if part))
    return RunRecord(run, loop_run.outcome, error, values, signals)


def _alone(cell: Cell, repetition: int) -> Run:
    """Run the cases that no batch runs."""
    if cell.is_stepwise:
        case = cell.case(repetition)
        return simulate(case.plant, case.settings, case.w, **case.options)
    specification = cell.specification
    assert specification is not None
    plant, settings = require_supported(
        specification.plant, specification.settings, specification.saturation
    )
    return simulate_reference(plant, settings, cell.w(repetition))


def _refusal(study: Study, run: int, error: BaseException) -> RunRecord:
    if isinstance(error, CompensatorError):
        return _refused(study, run, REFUSED, str(error))
    return failure(run, FUNCTION_FAILED, error)


def _refused(study: Study, run: int, outcome: str, words: str) -> RunRecord:
    """A result without a number: these values make no run."""
    return RunRecord(run, outcome, storable(words), [math.nan] * len(study.keep), {})
