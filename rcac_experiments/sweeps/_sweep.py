"""Run a study into its store, from the start or after an interruption."""

from __future__ import annotations

import math
import os
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, wait
from contextlib import suppress
from itertools import groupby
from pathlib import Path

import numpy as np

from compensator_theory.errors import CompensatorError, InputError
from compensator_theory.libraries import require_library
from rcac_experiments.files._builder import build
from rcac_experiments.sweeps._canonical import canonical_json
from rcac_experiments.sweeps._cells import Cell, Cells
from rcac_experiments.sweeps._chunk import ChunkResult, ChunkTask
from rcac_experiments.sweeps._coordinator import Coordinator, Pool
from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._pools import InProcess, WorkerLost, WorkerPool
from rcac_experiments.sweeps._problems import StoreError
from rcac_experiments.sweeps._progress import Meter, Progress
from rcac_experiments.sweeps._study import Coordinates, Study, require_meant
from rcac_experiments.sweeps._study_file import LARGEST_CHUNK, StoredStudy, begun
from rcac_experiments.sweeps._versions import differing, versions
from rcac_experiments.sweeps._worker import KeyWatch, run_chunk
from rcac_numeric.arrays._validation import instance_of, integer, number
from rcac_numeric.compiled._controllers import VARIABLE, instruction_set

# A chunk takes about so many seconds, and its runs so many bytes.
CHUNK_SECONDS, CHUNK_BYTES = 0.3, 3e7
# Chunks under way for each worker: one that runs, one that waits, and a little more; and over an
# executor of others, whose workers nobody counts.
WINDOW, WINDOW_OF_OTHERS = 3, 64

# Values of one axis that are tried; of a longer one the first, the last, and some between.
LARGEST_TRIALS = 40


class StudyInterrupted(KeyboardInterrupt):
    """Ctrl-C during a study; the store is intact, and the same call continues.

    Attributes
    ----------
    done, total : int
        Runs that are stored, and runs in all.
    """

    def __init__(self, path: Path, done: int, total: int) -> None:
        self.done, self.total = done, total
        super().__init__(f"{done} of {total} runs are stored in {path}; the store is intact")


def run_study(
    study: Study,
    store: str | Path,
    *,
    workers: int | None = None,
    executor: Executor | Callable[[], Executor] | None = None,
    window: int | None = None,
    progress: Callable[[Progress], None] | None = None,
    many: bool = False,
    mixed: bool = False,
    time_limit: float | None = None,
    retries: int = 0,
    retry_failed: bool = False,
) -> Progress:
    """Run the missing runs of a study, and store each run when its chunk ends.

    A run's numbers depend on its own coordinates and the seed alone: neither on chunks, workers
    and their order, nor, bit for bit for one instruction set, on the machine. Called again after
    whatever stopped it, it goes on, and computes again what is damaged; several processes may
    work on one store at a time. A study with more repetitions or more values of an axis goes on in
    the store of the smaller one; any other change is refused.

    A run that diverges or cannot be made is a result. A run has failed where its measure, or
    another function of the study, raised anything but a `CompensatorError`, where memory or time
    ran out, or its process died: it is counted, it is in no table, and it can be run again.

    Parameters
    ----------
    study : Study
    store : path
        A folder, made where there is none: study.toml, and chunks/NUMBER.parquet, which pandas,
        polars, DuckDB and dask read without us. It needs pyarrow (`compensator-theory[studies]`).
    workers : int, optional
        Processes; as many as there are processors by default, and 0 for this process alone.
    executor : concurrent.futures.Executor, or a function that makes one; optional
        In place of processes of our own: `distributed.Client(...).get_executor(pure=False)`, or
        that of `mpi4py.futures`. It is not shut down; what a function makes is, and is made
        again where it breaks.
    window : int, optional
        How many chunks are under way at a time: three for each process of our own, and 64 over an
        executor; three for each worker are enough.
    progress : callable, optional
        Called with a `Progress` while it goes on; `ProgressLine()` writes it down.
    many : bool
        That more than a million runs are meant.
    mixed : bool
        Go on although the store was begun with other versions or instructions, so that its runs
        agree up to rounding only; the store says so from then on.
    time_limit : float, optional
        Seconds that one run may take, its measures included. A process in which nothing ends for
        so long is ended, what it was at is run again one by one, and a run that takes so long by
        itself has failed. With workers=0 an exception (by SIGALRM) interrupts Python's code, and
        compiled code that never returns is not reached. Workers of an executor of others cannot
        be ended from here: it is refused there.
    retries : int
        How often a run that failed is run again at once.
    retry_failed : bool
        Run those again that had failed when they were run before.

    Raises
    ------
    InputError
        Where something of the study cannot be run: before anything is.
    StoreError
        Where the store cannot be written, is of another study, or has lost its own.
    StudyInterrupted
        On Ctrl-C, within half a second.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_experiments.sweeps import Axis, Metric, Study, read_table, run_study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"},
    ...     "signals": {"w": {"white_noise": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2}, "run": {"steps": 200}}
    >>> study = Study(
    ...     base, [Axis("R_theta", [0.01, 100], sets="controller.R_theta")], [Metric("rms")],
    ...     repetitions=10)
    >>> store = tempfile.mkdtemp() + "/study"
    >>> print(run_study(study, store, workers=0))
    20 of 20 runs (100 %)
    >>> table = read_table(store)
    >>> len(table), sorted(set(table["R_theta"].tolist()))
    (20, [0.01, 100.0])
    """
    instance_of(study, "study", Study)
    require_meant(study, many)
    count = integer(os.cpu_count() or 1 if workers is None else workers, "workers")
    limit = None if time_limit is None else number(time_limit, "time_limit")
    if limit is not None and not 0 < limit < math.inf:
        raise InputError(f"time_limit = {limit:g} must be a positive number of seconds.")
    if limit is not None and executor is not None:
        raise InputError(
            "time_limit ends the process of a run that takes too long, and those of an executor "
            "are not ours: leave out executor, or set its own limits."
        )
    again = integer(retries, "retries", at_least=0)
    instance_of(retry_failed, "retry_failed", bool)
    usual = WINDOW * max(count, 1) if executor is None else WINDOW_OF_OTHERS
    under_way = usual if window is None else integer(window, "window", at_least=1)
    pool = Pool(executor, count, limit)
    require_library("pyarrow")
    first = checked_first_cell(study)
    with Folder(store, make=True) as opened, KeyWatch():
        meter, coordinator = Meter(study.runs, 0), None
        try:
            if opened.is_new:
                size = _chunk_size(study, first, pool)
                opened.begin(begun(study, instruction_set(), size))
            _tidy(opened)
            before: StoredStudy | None = None
            while before != opened.refreshed():  # another process may have made the study grow
                differences = _require_same(opened, mixed)
                opened.grow(study, differences, among_others=before is not None)
                before = opened.study
                absent, anew = _scan(opened, meter, retry_failed)
                if progress is not None:
                    progress(meter.now())
                if absent or anew:
                    coordinator = Coordinator(
                        opened, pool,
                        _tasks(opened, study, "" if mixed else opened.study.instruction_set, limit),
                        under_way, again, meter, progress or _no_progress,
                    )  # fmt: skip
                    coordinator.run(absent, anew)
            pool.end()
            return meter.now()
        except BaseException as error:
            pool.leave() if coordinator is None else coordinator.leave()
            if isinstance(error, KeyboardInterrupt):
                raise StudyInterrupted(opened.path, meter.done, meter.total) from None
            raise


def _scan(folder: Folder, meter: Meter, retry_failed: bool) -> tuple[list[int], list[int]]:
    """Return the missing chunks and those to be replaced; the meter counts the others."""
    plan, there, anew = folder.study.plan, set(), []
    meter.total, meter.done, meter.failed = plan.runs, 0, 0
    for chunk in folder.read():
        there.add(chunk.number)
        if chunk.fault or (retry_failed and chunk.failed):
            anew.append(chunk.number)
        else:
            meter.done += chunk.last - chunk.first + 1
            meter.failed += chunk.failed
    return [number for number in range(1, plan.chunks + 1) if number not in there], anew


def _tidy(folder: Folder) -> None:
    """Remove the incomplete files of killed processes, if permitted."""
    with suppress(OSError):
        folder.directory.remove_abandoned()
        if folder.chunks is not None:
            folder.chunks.remove_abandoned()


def _tasks(
    folder: Folder, study: Study, instructions: str, time_limit: float | None
) -> Callable[[int], ChunkTask]:
    """Return the function that makes the task of a chunk."""
    pickled, fingerprint = pickle.dumps(study), study.fingerprint
    # A clock that starts anew with every run is read between few of them.
    at_once = 256 if time_limit is None else 8

    def task_of(chunk: int) -> ChunkTask:
        plan = folder.study.plan
        places = plan.places(chunk)
        by_cell = groupby(places, key=lambda place: place[1])
        runs = [[(run, repetition) for run, _, repetition in some] for _, some in by_cell]
        cells = plan.coordinates(range(places[0][1], places[-1][1] + 1))
        return ChunkTask(
            pickled, fingerprint, instructions, list(zip(cells, runs, strict=True)), at_once
        )

    return task_of


def _chunk_size(study: Study, first: Cell, pool: Pool) -> int:
    """Return the number of runs that take a fraction of a second, measured on a few runs.

    The runs use the executor of the study if it can be restarted, since a run may end it.
    """
    runs, seconds = 1, 0.0
    for attempt in range(5):
        numbers = [(i, i % study.repetitions) for i in range(runs)]
        task = ChunkTask(pickle.dumps(study), study.fingerprint, instruction_set(),
                         [(first.coordinates, numbers)])  # fmt: skip
        ours = pool.executor if pool.is_ours or pool.renewable else InProcess()
        try:
            future: Future[ChunkResult] = ours.submit(run_chunk, task)
            while not wait([future], timeout=0.1).done:
                pass  # here Ctrl-C is answered
            seconds = future.result().seconds
        except BrokenExecutor as error:
            if isinstance(ours, WorkerPool):
                raise InputError(
                    f"worker processes cannot be started: {error} Use workers=0 for one process."
                ) from None
            pool.renew()
            seconds = CHUNK_SECONDS
        except WorkerLost:
            seconds = CHUNK_SECONDS  # one by one, where it is recorded what is wrong with them
        if attempt == 0 and seconds < 10 * CHUNK_SECONDS:
            continue  # it read libraries
        if seconds > CHUNK_SECONDS / 8 or runs * 8 > study.runs:
            break
        runs *= 8
    by_time = CHUNK_SECONDS * runs / max(seconds, 1e-9)
    case = first.case(0)
    steps, plant = len(np.asarray(case.w)), case.plant
    width = plant.l_w + 2 * plant.l_u + plant.l_y + plant.l_z
    by_memory = CHUNK_BYTES / (8 * max(steps * width, 1))
    fair = math.ceil(study.runs / 8)  # for two workers and a few chunks each
    size = min(by_time, by_memory, LARGEST_CHUNK, fair)
    return max(1, int(size) // 8 * 8 or int(size))


def _require_same(store: Folder, mixed: bool) -> list[str]:
    """Return differing versions, which change bits; refuse them unless `mixed`."""
    row = store.study
    differences = [
        f"{name} {before} then, {now} now"
        for name, (before, now) in differing(row.versions, versions()).items()
    ]
    if instruction_set() != row.instruction_set:
        differences.append(
            f"instruction set {row.instruction_set} then, {instruction_set()} now (the environment "
            f"variable {VARIABLE} selects it)"
        )
    if differences and not mixed:
        raise StoreError(
            f"{store.path} was begun with other versions: {'; '.join(differences)}. New runs would "
            "agree only up to rounding. To continue: mixed=True, or --mixed on the command line."
        )
    return differences


def _no_progress(progress: Progress) -> None:
    """Report no progress."""


def checked_first_cell(study: Study) -> Cell:
    """Return the first cell, after a check of each value of each axis.

    Only a run of its cell reveals an invalid combination of values, as an outcome.
    """
    try:
        pickle.dumps(study)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InputError(f"the study cannot be sent to another process: {error}.") from None
    cells = Cells(study)
    first = {axis.name: axis.values[0] for axis in study.axes}
    if isinstance(study.base, dict):
        # The whole file once: keys that no run reads, and what one run takes.
        build(study.document(first), study.file)
    for name, coordinates in _trials(study, first):
        try:
            cells.cell(coordinates).case(0)
        except CompensatorError as error:
            where = (f"the axis {name!r} at {coordinates[name]!r}: ",) if name else ()
            raise type(error)(*where, *error.args) from None
    cell = cells.cell(first)
    canonical_json(study.resolved)
    return cell


def _trials(study: Study, first: Coordinates) -> Iterator[tuple[str, Coordinates]]:
    yield "", first
    for axis in study.axes:
        step = max(1, -(-len(axis) // LARGEST_TRIALS))
        for i in sorted({*range(0, len(axis), step), len(axis) - 1} - {0}):
            yield axis.name, {**first, axis.name: axis.values[i]}
