"""Running a study into its store, from the start or from wherever it was stopped."""

from __future__ import annotations

import math
import os
import pickle
import time
from collections.abc import Callable
from concurrent.futures import Executor
from itertools import groupby
from pathlib import Path

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays.validation import instance_of, integer, one_of
from rcac_numeric.engine.compiled.instruction_sets import VARIABLE, instruction_set
from rcac_numeric.sweeps.chunks.chunk import ChunkTask
from rcac_numeric.sweeps.chunks.worker import run_chunk
from rcac_numeric.sweeps.running.pools import InProcess, WorkerPool
from rcac_numeric.sweeps.running.progress import Meter, Progress
from rcac_numeric.sweeps.running.schedule import Schedule
from rcac_numeric.sweeps.store.claims import Claim, Claims
from rcac_numeric.sweeps.store.problems import StoreError
from rcac_numeric.sweeps.store.store import JOURNALS, Store, coordinates_in, versions
from rcac_numeric.sweeps.study.cells import Cell
from rcac_numeric.sweeps.study.study import Study, require_meant
from rcac_numeric.sweeps.study.trials import tried

# A chunk takes about so many seconds, and its runs so many bytes.
CHUNK_SECONDS, CHUNK_BYTES, LARGEST_CHUNK = 0.3, 3e7, 512
# Chunks under way for each worker: one that runs, one that waits, and a little more.
WINDOW = 3


class StudyInterrupted(KeyboardInterrupt):
    """Ctrl-C while a study ran; the store is whole, and the same call goes on.

    Attributes
    ----------
    done, total : int
        Runs that are stored, and runs in all.
    """

    def __init__(self, path: Path, done: int, total: int) -> None:
        self.done, self.total = done, total
        super().__init__(f"{done} of {total} runs are stored in {path}, which is whole")


def run_study(
    study: Study,
    store: str | Path,
    *,
    workers: int | None = None,
    executor: Executor | Callable[[], Executor] | None = None,
    window: int | None = None,
    progress: Callable[[Progress], None] | None = None,
    many: bool = False,
    journal: str = "wal",
    mixed: bool = False,
) -> Progress:
    """Run what a study asks for and its store has not, and store each run when its chunk ends.

    A run's numbers depend on its own coordinates and the seed alone: neither on chunks, workers
    and their order, nor, bit for bit for one instruction set, on the machine. Called again after
    whatever stopped it, it goes on; several processes may work on one store at a time. A study
    with more repetitions or more values of an axis goes on in the store of the smaller one; any
    other change is refused.

    Parameters
    ----------
    study : Study
    store : path
        An SQLite file; made where there is none.
    workers : int, optional
        Processes; as many as there are processors by default, and 0 for this process alone.
    executor : concurrent.futures.Executor, or a function that makes one; optional
        In place of processes of our own: `distributed.Client(...).get_executor(pure=False)`, or
        that of `mpi4py.futures`. It is not shut down.
    window : int, optional
        How many chunks are under way at a time.
    progress : callable, optional
        Called with a `Progress` while it goes on; `ProgressLine()` writes it down.
    many : bool
        That more than a million runs are meant.
    journal : {"wal", "rollback"}
        "rollback" for a store on a network file system, which one process alone may then use.
    mixed : bool
        Go on although the store was begun with other versions or instructions, so that its runs
        agree up to rounding only.

    Raises
    ------
    InputError
        Where something of the study cannot be run: before anything is.
    StoreError
        Where the store is damaged, full, in use, or of another study.
    StudyInterrupted
        On Ctrl-C, within half a second.

    Examples
    --------
    >>> import tempfile
    >>> from rcac_numeric import Axis, Kept, Study, read_table, run_study
    >>> base = {
    ...     "plant": {"problem": "standard", "G": "1/(q - 0.9)"},
    ...     "signals": {"w": {"white_noise": 1}},
    ...     "target": {"model": "fir"}, "controller": {"n_c": 2}, "run": {"steps": 200}}
    >>> study = Study(
    ...     base, [Axis("R_theta", [0.01, 100], sets="controller.R_theta")], [Kept("rms")],
    ...     repetitions=10)
    >>> store = tempfile.mkdtemp() + "/study.sqlite"
    >>> print(run_study(study, store, workers=0))
    20 of 20 runs (100 %)
    >>> table = read_table(store)
    >>> len(table), sorted(set(table["R_theta"].tolist()))
    (20, [0.01, 100.0])
    """
    instance_of(study, "study", Study)
    one_of(journal, "journal", list(JOURNALS))
    require_meant(study, many)
    count = integer(os.cpu_count() or 1 if workers is None else workers, "workers")
    first = tried(study)
    with Store(store, journal) as opened:
        made = opened.is_new and opened.create(study, instruction_set(), _chunk_size(study, first))
        if not made:
            _require_same(opened, mixed)
            opened.grow(study)
        return _run(opened, study, _maker(executor, count), window or WINDOW * max(count, 1),
                    progress or _silence)  # fmt: skip


def _run(
    store: Store,
    study: Study,
    make: Callable[[], Executor],
    window: int,
    progress: Callable[[Progress], None],
) -> Progress:
    done, total = store.counts()
    meter = Meter(total, done)
    progress(meter.now())
    if done == total:
        return meter.now()
    pickled, row, blocks = pickle.dumps(study), store.study, store.blocks

    def task_of(claim: Claim) -> ChunkTask:
        block = next(b for b in reversed(blocks) if b.first_run <= claim.first)
        places = [(run, *block.place(run)) for run in range(claim.first, claim.last + 1)]
        found = coordinates_in(store, range(places[0][1], places[-1][1] + 1))
        runs = [
            (found[cell], [(run, repetition) for run, _, repetition in some])
            for cell, some in groupby(places, key=lambda place: place[1])
        ]
        return ChunkTask(pickled, study.fingerprint, row.instruction_set, runs)

    claims = Claims(store)
    schedule = Schedule(claims, task_of, make, window, meter, progress)
    try:
        claims.take_over()
        schedule.run()
    except KeyboardInterrupt:
        schedule.leave()
        claims.close()
        raise StudyInterrupted(store.path, *store.counts()) from None
    except BaseException:
        schedule.leave()
        claims.close_quietly()
        raise
    if isinstance(schedule.executor, WorkerPool):
        schedule.executor.shutdown()
    claims.close()
    meter.done, meter.total = store.counts()
    return meter.now()


def _maker(
    executor: Executor | Callable[[], Executor] | None, workers: int
) -> Callable[[], Executor]:
    if isinstance(executor, Executor):
        return lambda: executor
    if executor is not None:
        if not callable(executor):
            raise InputError(f"executor = {executor!r} is no concurrent.futures.Executor.")
        return executor
    return InProcess if workers == 0 else lambda: WorkerPool(workers)


def _chunk_size(study: Study, first: Cell) -> int:
    """As many runs as take a fraction of a second, found by running a few; their memory too."""
    runs, seconds = 1, 0.0
    for _ in range(4):
        numbers = [(i, i % study.repetitions) for i in range(runs)]
        task = ChunkTask(pickle.dumps(study), study.fingerprint, instruction_set(),
                         [(first.coordinates, numbers)])  # fmt: skip
        start = time.perf_counter()
        run_chunk(task)
        seconds = time.perf_counter() - start
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


def _require_same(store: Store, mixed: bool) -> None:
    """Refuse to go on with what would give other bits, unless that is meant."""
    row, now = store.study, versions()
    differences = [
        f"{name} {before} then, {now.get(name, 'absent')} now"
        for name, before in row.versions.items()
        if now.get(name) != before
    ]
    if instruction_set() != row.instruction_set:
        differences.append(
            f"instructions {row.instruction_set} then, {instruction_set()} now (the environment "
            f"variable {VARIABLE} chooses them)"
        )
    if differences and not mixed:
        raise StoreError(
            f"{store.path} was begun elsewhere: {'; '.join(differences)}. Its runs would agree up "
            "to rounding only. To go on all the same: mixed=True, or --mixed on the command line."
        )


def _silence(progress: Progress) -> None:
    """Say nothing of how far it is."""
