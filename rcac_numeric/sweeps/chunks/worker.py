"""A worker's whole work: runs in, records out. It knows no store and no other worker."""

from __future__ import annotations

import math
import os
import pickle
import time
from collections.abc import Iterator

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from rcac_numeric.engine.batches import SimulationCase
from rcac_numeric.engine.compiled.instruction_sets import VARIABLE, instruction_set
from rcac_numeric.engine.reference.run import require_supported, simulate_reference
from rcac_numeric.engine.runs import Run
from rcac_numeric.engine.streams import simulate_stream
from rcac_numeric.experiments.analysed_run import AnalysedRun
from rcac_numeric.sweeps.chunks.chunk import (
    FUNCTION_FAILED,
    REFUSED,
    ChunkResult,
    ChunkTask,
    RunRecord,
)
from rcac_numeric.sweeps.chunks.measuring import measured
from rcac_numeric.sweeps.study.cells import Cell, Cells
from rcac_numeric.sweeps.study.study import Coordinates, Study

# The study that this process has read last, by its fingerprint.
_KNOWN: dict[str, Cells] = {}
# Runs in memory at a time.
AT_ONCE = 256


def run_chunk(task: ChunkTask) -> ChunkResult:
    """Run some runs of a study; none of them can fail but as a record.

    Raises
    ------
    InputError
        Where this process cannot read the study, or lacks the instructions that it is run with.
    """
    start = time.perf_counter()
    _use(task.instruction_set)
    with np.errstate(all="ignore"):  # a loop that leaves float64 is an outcome, not a warning
        records = _records(_cells(task), task)
    return ChunkResult(sorted(records, key=lambda record: record.run), time.perf_counter() - start)


def run_in_full(cells: Cells, coordinates: Coordinates, repetition: int) -> AnalysedRun:
    """One run of a study by itself, with all that belongs to it.

    Raises
    ------
    CompensatorError
        Where these values make no run.
    """
    cell = cells.cell(coordinates)
    if cell.is_reference:
        return AnalysedRun(_reference(cell, repetition), cell.target)
    case = cell.case(repetition)
    (result,) = simulate_stream([case], lanes=cells.study.lanes)
    if result.value is None:
        raise InputError(result.failure)
    return AnalysedRun(result.value, cell.target)


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
    """All runs of a study use the same instructions, on whatever machine."""
    if instruction_set() != instructions:
        os.environ[VARIABLE] = instructions
        instruction_set()


def _records(cells: Cells, task: ChunkTask) -> list[RunRecord]:
    study, records = cells.study, []
    under_way: list[tuple[int, Cell]] = []
    nothing = [math.nan] * len(study.keep)

    def cases() -> Iterator[SimulationCase]:
        for coordinates, pairs in task.runs:
            for run, repetition in pairs:
                try:
                    cell = cells.cell(coordinates)
                    if cell.is_reference:
                        found = _reference(cell, repetition)
                        records.append(_record(run, cell, found, ""))
                        continue
                    case = cell.case(repetition)
                except Exception as error:  # of the user's own function too
                    records.append(RunRecord(run, *_refusal(error), nothing, {}))
                    continue
                under_way.append((run, cell))
                yield case

    def reduced(number: int, found: Run) -> RunRecord:
        run, cell = under_way[number]
        return _record(run, cell, found, found.failure)

    for result in simulate_stream(
        cases(), reduce=reduced, threads=1, lanes=study.lanes, at_once=AT_ONCE
    ):
        if result.value is None:
            number = under_way[result.number][0]
            records.append(RunRecord(number, result.outcome, result.failure, nothing, {}))
        else:
            records.append(result.value)
    return records


def _record(run: int, cell: Cell, found: Run, failure: str) -> RunRecord:
    values, failed = measured(cell, AnalysedRun(found, cell.target))
    signals = {name: np.array(getattr(found, name)) for name in cell.study.keep_signals}
    error = "; ".join(part for part in (failure, failed) if part)
    return RunRecord(run, found.outcome, error, values, signals)


def _reference(cell: Cell, repetition: int) -> Run:
    made = cell.specification
    assert made is not None
    plant, settings = require_supported(made.plant, made.settings, made.saturation)
    return simulate_reference(plant, settings, cell.w(repetition))


def _refusal(error: Exception) -> tuple[str, str]:
    if isinstance(error, CompensatorError):
        return REFUSED, str(error)
    return FUNCTION_FAILED, f"{type(error).__name__}: {error}"
