"""A worker's whole work: runs in, records out. It knows no store and no other worker."""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import time
from collections.abc import Callable, Iterator

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.analysis.loop_analysis import LoopAnalysis
from rcac_numeric.engine.batches import SimulationCase
from rcac_numeric.engine.compiled.instruction_sets import VARIABLE, instruction_set
from rcac_numeric.engine.reference.run import require_supported, simulate_reference
from rcac_numeric.engine.runs import Run
from rcac_numeric.engine.streams import simulate_stream
from rcac_numeric.sweeps.chunks.chunk import (
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
from rcac_numeric.sweeps.chunks.measuring import MeasureFailed, is_of_a_key, measured
from rcac_numeric.sweeps.study.cells import Cell, Cells
from rcac_numeric.sweeps.study.study import Coordinates, Study

# The study that this process has read last, by its fingerprint.
_KNOWN: dict[str, Cells] = {}


def _silence() -> None:
    """Tell nobody that a run has ended."""


def run_chunk(task: ChunkTask, progress: Callable[[], None] = _silence) -> ChunkResult:
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
    if cell.is_reference:
        return LoopAnalysis(_reference(cell, repetition), cell.target)
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
            for run, repetition in pairs:
                try:
                    cell = cells.cell(coordinates)
                    if cell.is_reference:
                        records.append(_record(run, cell, _reference(cell, repetition), ""))
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

    def reduced(number: int, found: Run) -> RunRecord:
        run, cell = under_way[number]
        record = _record(run, cell, found, found.failure)
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


def _record(run: int, cell: Cell, found: Run, words: str) -> RunRecord:
    if found.outcome in FAILED:
        if words.startswith(TimeLimitReached.__name__):
            raise TimeLimitReached(words)
        return failure(run, found.outcome, words)
    try:
        values, note = measured(cell, LoopAnalysis(found, cell.target))
    except MeasureFailed as failed:
        text = f"measure {failed.name}: {error_text(failed.cause)}"
        record = failure(run, MEASURE_FAILED, failed.cause)
        return RunRecord(run, record.outcome, storable(text), [], {})
    signals = {name: np.array(getattr(found, name)) for name in cell.study.keep_signals}
    error = storable("; ".join(part for part in (words, note) if part))
    return RunRecord(run, found.outcome, error, values, signals)


def _reference(cell: Cell, repetition: int) -> Run:
    made = cell.specification
    assert made is not None
    plant, settings = require_supported(made.plant, made.settings, made.saturation)
    return simulate_reference(plant, settings, cell.w(repetition))


def _refusal(study: Study, run: int, error: BaseException) -> RunRecord:
    if isinstance(error, CompensatorError):
        return _refused(study, run, REFUSED, str(error))
    return failure(run, FUNCTION_FAILED, error)


def _refused(study: Study, run: int, outcome: str, words: str) -> RunRecord:
    """A result without a number: these values make no run."""
    return RunRecord(run, outcome, storable(words), [math.nan] * len(study.keep), {})
