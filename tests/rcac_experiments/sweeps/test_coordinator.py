"""The coordinator on an executor with scripted losses: submitted tasks and stored records."""

from concurrent.futures import BrokenExecutor, Executor, Future
from concurrent.futures._base import DoneAndNotDoneFutures
from types import SimpleNamespace

import pytest

from rcac_experiments.sweeps import StoreError
from rcac_experiments.sweeps import _coordinator as coordinators
from rcac_experiments.sweeps._chunk import (
    TIMED_OUT,
    WORKER_DIED,
    ChunkResult,
    ChunkTask,
    RunRecord,
)
from rcac_experiments.sweeps._coordinator import ANSWER, Coordinator, Pool
from rcac_experiments.sweeps._pools import InProcess, WorkerLost
from rcac_experiments.sweeps._progress import Meter
from rcac_experiments.sweeps._worker import run_chunk

SIZE = 5  # runs of a chunk


def completed(run, outcome="completed"):
    return RunRecord(run, outcome, "", [1.0], {})


class Scripted(Executor):
    """Keeps tasks until `wait` works on the oldest; `ends` makes the records of a task."""

    def __init__(self, ends=lambda runs: [completed(run) for run in runs]):
        self.ends, self.pending = ends, {}
        self.submitted, self.beside, self.answers = [], [], 0

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        if fn is not run_chunk:
            self.answers += 1
            future.set_result(0)
            return future
        runs = args[0].numbers
        self.submitted.append(runs)
        self.beside.append(len(self.pending))
        self.pending[future] = runs
        return future

    def work(self, future):
        try:
            future.set_result(ChunkResult(self.ends(self.pending.pop(future)), 0.0))
        except Exception as error:
            future.set_exception(error)


class Local(Scripted, InProcess):
    """As the executor of this process."""


class Store:
    """A folder of chunks in memory."""

    def __init__(self, stored=()):
        self.stored, self.records = {one.number: one for one in stored}, {}

    def read(self, numbers, guarded=True):
        assert not guarded  # it is the coordinator's own folder
        return [self.stored[number] for number in numbers if number in self.stored]

    def put(self, number, records):
        assert number not in self.records
        self.records[number] = sorted((one.run, one.outcome) for one in records)


def task_of(number):
    runs = range(SIZE * (number - 1), SIZE * number)
    return ChunkTask(b"", "", "", [({"a": number}, [(run, 0) for run in runs])])


def whole(number):
    return task_of(number).numbers


@pytest.fixture
def begin(monkeypatch):
    """A coordinator of an executor, or of a function that makes one."""
    executors = []

    def work(futures, timeout, return_when=None):
        done = {one for one in futures if one.done()}
        if not done:
            oldest = next(iter(futures))
            next(one for one in executors if oldest in one.pending).work(oldest)
            done = {oldest}
        return DoneAndNotDoneFutures(done, set(futures) - done)

    monkeypatch.setattr(coordinators, "wait", work)
    monkeypatch.setattr(coordinators.SystemRandom, "shuffle", lambda self, todo: todo.reverse())

    def begun(source, *, is_ours=False, window=2, retries=0, store=None, progress=lambda now: None):
        pool = Pool(source, 0)
        pool.is_ours |= is_ours
        if isinstance(source, Scripted):
            executors.append(source)
        store = Store() if store is None else store
        meter = Meter(total=100, done=0)
        return Coordinator(store, pool, task_of, window, retries, meter, progress)

    begun.executors = executors
    return begun


def test_every_chunk_is_stored_once_within_the_window(begin):
    executor = Scripted(
        lambda runs: [completed(r, "diverged" if r == 7 else "completed") for r in runs]
    )
    done = []
    coordinator = begin(executor, window=3, progress=lambda now: done.append(now.done))
    coordinator.run([1, 2, 3, 4])
    assert executor.submitted == [whole(n) for n in (1, 2, 3, 4)]
    assert executor.beside == [0, 1, 2, 2] and executor.answers == 0
    assert done == [SIZE, 2 * SIZE, 3 * SIZE, 4 * SIZE]
    assert list(coordinator.folder.records) == [1, 2, 3, 4]
    assert (coordinator.meter.diverged, coordinator.meter.failed) == (1, 0)


def test_in_this_process_each_chunk_is_stored_before_the_next_begins(begin):
    executor = Local()
    begin(executor, window=3).run([1, 2, 3])
    assert executor.beside == [0, 0, 0]


def chunk(number, fault=""):
    outcomes = ["completed", "diverged", WORKER_DIED, "completed", "completed"]
    return SimpleNamespace(number=number, fault=fault, failed=1, columns={"outcome": outcomes})


def test_what_another_coordinator_stored_is_counted_and_not_computed(begin):
    """Chunk 2 is damaged, and chunk 4 is to be replaced."""
    store = Store([chunk(1), chunk(2, "its digest differs"), chunk(4)])
    executor = Scripted()
    coordinator = begin(executor, store=store)
    coordinator.run([1, 2, 3], again=[4])
    assert sorted(executor.submitted) == [whole(2), whole(3), whole(4)]
    meter = coordinator.meter
    assert (meter.done, meter.failed, meter.diverged) == (4 * SIZE, 1, 1)


# Losses.


def losing(run, error, times=100):
    """Ends of tasks of which those with this run are lost, so often."""
    lost = []

    def ends(runs):
        if run in runs and len(lost) < times:
            lost.append(runs)
            raise error
        return [completed(one) for one in runs]

    return ends


def test_a_run_that_ends_a_worker_of_ours_is_found_one_by_one(begin):
    executor = Scripted(losing(3, WorkerLost(WORKER_DIED, "it was killed")))
    coordinator = begin(executor, is_ours=True, window=1)
    coordinator.run([1])
    assert executor.submitted == [whole(1), [0], [1], [2], [3], [4], [3]]
    assert executor.answers == 0
    assert coordinator.folder.records[1] == [
        (run, WORKER_DIED if run == 3 else "completed") for run in whole(1)
    ]
    meter = coordinator.meter
    assert (meter.done, meter.failed, meter.diverged) == (SIZE, 1, 0)


def test_a_run_that_takes_too_long_is_not_repeated_alone(begin):
    executor = Scripted(losing(3, WorkerLost(TIMED_OUT, "it took too long")))
    coordinator = begin(executor, is_ours=True, window=1)
    coordinator.run([1])
    assert executor.submitted == [whole(1), [0], [1], [2], [3], [4]]
    assert dict(coordinator.folder.records[1])[3] == TIMED_OUT


def test_a_run_that_is_lost_once_is_a_result(begin):
    executor = Scripted(losing(3, WorkerLost(WORKER_DIED, "killed from outside"), times=2))
    coordinator = begin(executor, is_ours=True, window=1)
    coordinator.run([1])
    assert coordinator.folder.records[1] == [(run, "completed") for run in whole(1)]


def test_a_loss_elsewhere_is_repeated_by_itself_and_halved(begin):
    executor = Scripted(losing(3, RuntimeError("KilledWorker")))
    coordinator = begin(executor, window=2)
    coordinator.run([1, 2, 3])
    assert executor.submitted == [
        whole(1), whole(2), whole(1), [0, 1, 2], [3, 4], [3], [4], [3], whole(3),
    ]  # fmt: skip
    assert executor.beside == [0, 1, *[0] * 7]
    assert executor.answers == 7  # before each of those six, and before a run counts as failed
    assert dict(coordinator.folder.records[1])[3] == WORKER_DIED
    assert len(coordinator.folder.records) == 3


def test_a_single_run_elsewhere_is_first_repeated_by_itself(begin, monkeypatch):
    monkeypatch.setitem(globals(), "SIZE", 1)
    executor = Scripted(losing(0, RuntimeError("KilledWorker")))
    coordinator = begin(executor)
    coordinator.run([1])
    assert executor.submitted == [[0]] * 3
    assert coordinator.folder.records == {1: [(0, WORKER_DIED)]}


def test_a_broken_executor_of_a_function_is_made_again_once(begin):
    """Both tasks of it are lost, and the second loss is not one of the new executor."""

    def make():
        broken = not begin.executors

        def ends(runs):
            if broken:
                raise BrokenExecutor
            return [completed(run) for run in runs]

        begin.executors.append(Scripted(ends))
        return begin.executors[-1]

    coordinator = begin(make)
    coordinator.run([1, 2, 3])
    assert len(begin.executors) == 2
    assert {number: len(rows) for number, rows in coordinator.folder.records.items()} == {
        1: SIZE, 2: SIZE, 3: SIZE
    }  # fmt: skip


def with_local_pool(begin, local, monkeypatch):
    """Let the coordinator fall back to an executor as its local pool."""
    begin.executors.append(local)
    ours = Pool(local, 0)
    ours.is_ours = True
    monkeypatch.setattr(coordinators, "Pool", lambda executor, workers: ours)


def test_a_broken_executor_of_the_user_ends_the_study_with_the_run_that_broke_it(
    begin, monkeypatch
):
    """A local process repeats the chunks that were under way, the last first."""

    def breaks(runs):
        raise BrokenExecutor

    coordinator = begin(Scripted(breaks))
    local = Scripted(losing(7, WorkerLost(WORKER_DIED, "it was killed")))
    with_local_pool(begin, local, monkeypatch)
    with pytest.raises(StoreError, match=r"Run 7 \(a = 2\) ends every worker"):
        coordinator.run([1, 2, 3])
    assert list(coordinator.folder.records) == [2]


def test_an_executor_that_takes_nothing_more_after_a_loss_names_the_run(begin, monkeypatch):
    """As dask does whose nannies gave up: the loss came before, and is that of a suspect."""

    class Nannies(Scripted):
        def submit(self, fn, /, *args, **kwargs):
            if self.submitted:
                raise RuntimeError("no workers")
            return super().submit(fn, *args, **kwargs)

    coordinator = begin(Nannies(losing(3, RuntimeError("KilledWorker"))), window=1)
    local = Scripted(losing(3, WorkerLost(WORKER_DIED, "it was killed")))
    with_local_pool(begin, local, monkeypatch)
    with pytest.raises(StoreError, match=r"Run 3 \(a = 1\) ends every worker"):
        coordinator.run([1, 2])
    assert list(coordinator.folder.records) == [1]


# Runs that failed.


def failing(times):
    count = dict.fromkeys((1, 4), 0)

    def ends(runs):
        records = []
        for run in runs:
            fails = run in count and count[run] < times
            count[run] = count.get(run, 0) + 1
            records.append(completed(run, "measure failed" if fails else "completed"))
        return records

    return ends


@pytest.mark.parametrize(
    ("times", "retries", "submitted", "failed"),
    [
        (1, 0, [[0, 1, 2, 3, 4]], 2),
        (1, 1, [[0, 1, 2, 3, 4], [1, 4]], 0),
        (2, 1, [[0, 1, 2, 3, 4], [1, 4]], 2),
        (2, 2, [[0, 1, 2, 3, 4], [1, 4], [1, 4]], 0),
    ],
)
def test_failed_runs_alone_are_repeated(begin, times, retries, submitted, failed):
    executor = Scripted(failing(times))
    coordinator = begin(executor, retries=retries)
    coordinator.run([1])
    assert executor.submitted == submitted
    assert [run for run, _ in coordinator.folder.records[1]] == whole(1)
    assert (coordinator.meter.done, coordinator.meter.failed) == (SIZE, failed)
    assert coordinator.meter.diverged == 0


# Silence.


@pytest.mark.parametrize(
    ("elapsed", "progressed", "is_ours", "answers"),
    [
        (ANSWER + 1, False, False, 1),
        (ANSWER, False, False, 0),
        (ANSWER + 1, True, False, 0),
        (ANSWER + 1, False, True, 0),
    ],
)
def test_an_executor_of_others_that_is_silent_is_spoken_to(
    begin, monkeypatch, elapsed, progressed, is_ours, answers
):
    clock = SimpleNamespace(monotonic=lambda: 1000.0)
    monkeypatch.setattr(coordinators, "time", clock)
    executor = Scripted()
    coordinator = begin(executor, is_ours=is_ours)
    clock.monotonic = lambda: 1000.0 + elapsed
    coordinator._require_alive(progressed)
    assert executor.answers == answers
    coordinator._require_alive(False)  # the silence is counted anew
    assert executor.answers == answers
