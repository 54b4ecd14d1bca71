"""Running a study: the same table whoever runs it, in whatever pieces, stopped by whatever."""

import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import time
import warnings
from concurrent.futures import (
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
)
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from compensator_theory.errors import InputError
from rcac_experiments.sweeps import (
    Axis,
    Metric,
    StoreError,
    StudyInterrupted,
    check_store,
    load_study,
    read_table,
    replay_run,
    run_study,
    sweep_overview,
)
from rcac_experiments.sweeps import (
    _sweep as sweep,
)
from rcac_experiments.sweeps._cells import Cells
from rcac_experiments.sweeps._chunk import ChunkTask
from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._worker import run_chunk
from rcac_numeric import simulate
from rcac_numeric.compiled._controllers import instruction_set
from tests.support import studies

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A study of two axes, run in one process."""
    store = tmp_path_factory.mktemp("undisturbed") / "store"
    run_study(studies.study(), store, workers=0)
    return store


@pytest.fixture
def small_chunks(monkeypatch):
    """So that a small study has many of them."""
    monkeypatch.setattr(sweep, "_chunk_size", lambda study, first, pool: 7)


def test_each_run_is_the_one_that_its_coordinates_ask_for(undisturbed):
    """By another way than the study's own: one case after another, by `simulate`."""
    table = read_table(undisturbed)
    study = studies.study(lanes=False)
    assert len(table) == study.runs == 120 and set(table["outcome"]) == {"completed"}
    cells = Cells(study)
    for i in range(0, 120, 13):
        cell = cells.cell({name: table[name][i] for name in table.axes})
        built = cell.specification
        assert built.settings.update.R_theta == table["R_theta"][i]
        run = simulate(built.plant, built.settings, cell.w(int(table["repetition"][i])))
        assert np.isclose(np.sqrt(np.mean(run.z**2)), table["rms"][i], rtol=1e-9)
        assert np.isclose(np.abs(run.z[100:]).max(), table["late"][i], rtol=1e-9)


@given(data=st.data())
@settings(max_examples=10)
def test_a_run_does_not_depend_on_its_company(data):
    study = studies.study(8)
    numbers = data.draw(st.permutations(range(8)))
    cut = data.draw(st.integers(0, 8))
    place = {"R_theta": 1.0, "noise": 2}
    other = {"R_theta": 0.01, "noise": 0.5}

    def records(runs):
        task = ChunkTask(sweep.pickle.dumps(study), study.fingerprint, instruction_set(), runs)
        return {record.run: record.values for record in run_chunk(task).records}

    whole = records([(place, [(i, i) for i in range(8)])])
    pieces = {
        **records([(place, [(i, i) for i in numbers[:cut]]), (other, [(100, 3)])]),
        **records([(other, [(101, 4)]), (place, [(i, i) for i in numbers[cut:]])]),
    }
    assert {i: pieces[i] for i in range(8)} == whole


def test_threads_give_the_same_table(undisturbed, tmp_path, small_chunks):
    with ThreadPoolExecutor(3) as executor:
        run_study(studies.study(), tmp_path / "store", executor=executor)
    assert read_table(tmp_path / "store") == read_table(undisturbed)


@pytest.mark.slow
def test_a_cluster_gives_the_same_table(undisturbed, tmp_path, small_chunks):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        distributed = pytest.importorskip("distributed")
        with (
            distributed.LocalCluster(
                n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            run_study(
                studies.study(), tmp_path / "store",
                executor=client.get_executor(pure=False),
            )  # fmt: skip
    assert read_table(tmp_path / "store") == read_table(undisturbed)


def test_never_more_than_a_window_is_under_way(tmp_path, small_chunks):
    class Lazy(Executor):
        """Runs what it was given when it was given enough."""

        def __init__(self):
            self.waiting, self.most = [], 0

        def submit(self, fn, /, *args):
            future = Future()
            self.waiting.append((future, fn, args))
            self.most = max(self.most, len(self.waiting))
            if len(self.waiting) == 3:
                self.work()
            return future

        def work(self):
            for future, fn, args in self.waiting:
                future.set_result(fn(*args))
            self.waiting = []

    executor = Lazy()
    study = studies.study(7)  # six chunks: two windows
    run_study(study, tmp_path / "store", executor=executor, window=3)
    assert executor.most == 3 and len(read_table(tmp_path / "store")) == study.runs


def test_a_study_grows_in_its_store(tmp_path, small_chunks):
    """More repetitions, and a finer grid: the table is that of the large study run at once."""

    def study(values, repetitions):
        axis = Axis("R_theta", values, sets="controller.R_theta")
        noise = Axis("noise", values[:2], sets="signals.w.white_noise")
        return studies.study(repetitions, axes=[axis, noise])

    grown, whole = tmp_path / "grown", tmp_path / "whole"
    run_study(study([1.0, 10.0], 5), grown, workers=0)
    before = read_table(grown)
    run_study(study([1.0, 10.0], 9), grown, workers=0)
    run_study(study([1.0, 10.0, 3.0], 9), grown, workers=0)
    run_study(study([1.0, 10.0, 3.0], 9), whole, workers=0)
    a, b = read_table(grown), read_table(whole)
    assert len(a) == len(b) == 54 and len(before) == 20

    def rows(table):
        keys = (*table.axes, "repetition", "outcome", *table.measures)
        return sorted(zip(*(table[key].tolist() for key in keys), strict=True))

    assert rows(a) == rows(b)
    assert np.array_equal(a["rms"][:20], before["rms"])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"seed": 4}, "seed: 3 before, 4 now"),
        ({"repetitions": 3}, "repetitions: 20 before, 3 now"),
        ({"keep": [Metric("rms")]}, "keep: "),
        ({"base": {**studies.BASE, "run": {"steps": 121}}}, "base.run.steps: 120 before, 121 now"),
        ({"axes": [Axis("R_theta", [0.01], sets="controller.R_theta"),
                   Axis("noise", [0.5, 2], sets="signals.w.white_noise")]},
         "axis R_theta had 1.0, 100.0 before, and has not now"),
        ({"axes": []}, "axes: R_theta, noise before,  now"),
        ({"lanes": False}, "lanes: true before, false now"),
    ],
)  # fmt: skip
def test_another_study_is_refused_and_what_differs_named(undisturbed, changes, words):
    before = studies.contents(undisturbed)
    with pytest.raises(StoreError, match=words):
        run_study(studies.study(**{"repetitions": 20, **changes}), undisturbed, workers=0)
    assert studies.contents(undisturbed) == before


def test_other_versions_are_refused_unless_they_are_meant(tmp_path, monkeypatch, small_chunks):
    store = tmp_path / "store"
    run_study(studies.study(2), store, workers=0)
    monkeypatch.setattr(sweep, "versions", lambda: {"numpy": "0.1"})
    with pytest.raises(StoreError, match=r"numpy .* then, 0.1 now.*mixed=True"):
        run_study(studies.study(3), store, workers=0)
    assert run_study(studies.study(3), store, workers=0, mixed=True).done == 18
    assert any("0.1 now" in words for words in sweep_overview(store).mixed)
    with Folder(store) as opened:
        opened.write(replace(opened.study, instruction_set="of another machine"))
    with pytest.raises(StoreError, match="instruction set of another machine then"):
        run_study(studies.study(4), store, workers=0)
    assert run_study(studies.study(4), store, workers=0, mixed=True).done == 24
    with pytest.raises(StoreError, match="to replay it bit for bit"):
        replay_run(store, 0)


@pytest.mark.costly
def test_processes_give_the_same_table_though_one_dies(undisturbed, tmp_path, small_chunks):
    """It is killed from outside while it works."""
    killed = []

    def kill_one(progress):
        children = multiprocessing.active_children()
        if not killed and children and progress.done:
            killed.append(children[0].pid)
            os.kill(children[0].pid, signal.SIGKILL)

    run_study(studies.study(), tmp_path / "store", workers=2, progress=kill_one)
    assert killed and read_table(tmp_path / "store") == read_table(undisturbed)


@pytest.mark.costly
def test_a_run_that_ends_its_worker_is_one_run_that_failed(tmp_path, small_chunks):
    values = [1.0, 2.0, studies.DEADLY, 4.0, 5.0]
    store = tmp_path / "store"
    study = studies.over_R_theta(values, studies.deadly)
    assert "1 failed" in str(run_study(study, store, workers=1))
    table = read_table(store)
    assert table.failed["R_theta"].tolist() == [studies.DEADLY]
    assert table.failed["outcome"].tolist() == ["worker died"]
    assert "ended with signal 9" in table.failed["failure"][0]
    assert len(table) == 4 and np.isfinite(table["rms"]).all()


@pytest.mark.costly
def test_an_executor_that_a_function_makes_is_made_again(tmp_path, small_chunks):
    """A run that ends its worker breaks the whole pool; it is found by halves, and named."""
    built = []

    def make():
        built.append(ProcessPoolExecutor(1, multiprocessing.get_context("spawn")))
        return built[-1]

    study = studies.over_R_theta([studies.DEADLY, 1.0], studies.deadly)
    assert "1 failed" in str(run_study(study, tmp_path / "s", executor=make))
    table = read_table(tmp_path / "s")
    assert table.failed["R_theta"].tolist() == [studies.DEADLY] and len(built) > 2
    assert table.failed["outcome"].tolist() == ["worker died"] and len(table) == 1
    with (
        ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as one,
        pytest.raises(StoreError, match=r"Run 0 \(R_theta = 13\.0\) ends every worker"),
    ):
        run_study(study, tmp_path / "t", executor=one)
    assert read_table(tmp_path / "t").failed["R_theta"].tolist() == [studies.DEADLY]


@pytest.mark.costly
@pytest.mark.parametrize("losses", [1, 3])
def test_the_run_is_named_whenever_its_executor_gives_up(tmp_path, small_chunks, losses):
    """As dask does whose nannies lost a worker that was starting: it takes nothing more."""

    class Nannies(Executor):
        lost = 0

        def submit(self, fn, /, *args):
            if self.lost >= losses:
                raise RuntimeError("no workers")
            future = Future()
            if fn is run_chunk and any(c["R_theta"] == studies.DEADLY for c, _ in args[0].runs):
                self.lost += 1
                future.set_exception(RuntimeError("KilledWorker"))
            else:
                future.set_result(fn(*args))
            return future

    study = studies.over_R_theta([1.0, studies.DEADLY, 2.0], studies.deadly)
    with pytest.raises(StoreError, match=r"Run 1 \(R_theta = 13\.0\) ends every worker"):
        run_study(study, tmp_path / "s", executor=Nannies())
    table = read_table(tmp_path / "s")
    assert table.failed["R_theta"].tolist() == [studies.DEADLY] and len(table) == 2


def test_an_executor_of_others_that_breaks_is_not_made_again(tmp_path, small_chunks):
    class Broken(Executor):
        def submit(self, fn, /, *args):
            raise BrokenExecutor

    with pytest.raises(StoreError, match="the executor broke"):
        run_study(studies.study(2), tmp_path / "store", executor=Broken())
    assert run_study(studies.study(2), tmp_path / "store", workers=0).done == 12


def test_an_executor_that_forgets_what_it_was_given_is_seen(tmp_path, small_chunks, monkeypatch):
    """As dask does that has lost its scheduler: nothing ends, and it takes nothing more."""
    monkeypatch.setattr("rcac_experiments.sweeps._coordinator.ANSWER", 0.1)

    class Forgetful(Executor):
        def submit(self, fn, /, *args):
            if fn is not run_chunk:
                raise RuntimeError("closed")
            return Future()

    with pytest.raises(StoreError, match="the executor broke"):
        run_study(studies.study(2), tmp_path / "store", executor=Forgetful())
    assert run_study(studies.study(2), tmp_path / "store", workers=0).done == 12


def test_a_measure_that_raises_costs_its_run_and_no_other(tmp_path):
    store = tmp_path / "raising"
    run_study(studies.over_R_theta([1.0, studies.RAISING], studies.raising), store, workers=0)
    table = read_table(store)
    assert table["R_theta"].tolist() == [1.0] and table["raising"].tolist() == [1.0]
    assert table.failed["outcome"].tolist() == ["measure failed"]
    assert table.failed["failure"].tolist() == [
        "measure raising: ZeroDivisionError: there is no seventh root"
    ]  # fmt: skip
    run_study(studies.over_R_theta([1.0], studies.no_number), tmp_path / "none", workers=0)
    assert "no number" in read_table(tmp_path / "none").failed["failure"][0]


def test_a_study_of_a_function(tmp_path):
    axes = [Axis("gain", [1, 3]), Axis("x_0", [0.0, 5.0])]
    study = studies.study(4, base=studies.case_of_functions, axes=axes, keep=[Metric("peak")])
    store = tmp_path / "store"
    run_study(study, store, workers=0)
    table = read_table(store)
    assert set(table["outcome"]) <= {"completed", "diverged"} and len(table) == 16
    replayed = replay_run(store, 6, {"case_of_functions": studies.case_of_functions})
    assert replayed.is_identical and replayed.analysed.run.x_0 is not None


def test_a_study_of_a_function_that_holds_data(tmp_path):
    def of(x_0):
        base = studies.CaseWithData(x_0)
        return studies.study(2, base=base, axes=[Axis("gain", [1, 3])], keep=[Metric("peak")])

    store = tmp_path / "store"
    run_study(of(5.0), store, workers=0)
    assert len(read_table(store)) == 4
    assert of(5.0).fingerprint == of(5.0).fingerprint != of(4.0).fingerprint
    with pytest.raises(StoreError, match="another study"):
        run_study(of(4.0), store, workers=0)
    assert replay_run(store, 1, {"CaseWithData": studies.CaseWithData(5.0)}).is_identical
    with pytest.raises(StoreError, match="holds other data"):
        replay_run(store, 1, {"CaseWithData": studies.CaseWithData(4.0)})


def test_a_case_that_raises_is_a_run_that_failed(tmp_path):
    study = studies.study(
        12, base=studies.case_that_raises, axes=[Axis("gain", [1, 3])], keep=[Metric("steps")]
    )
    run_study(study, tmp_path / "store", workers=0)
    failed = read_table(tmp_path / "store").failed
    assert set(failed["gain"]) == {3} and 0 < len(failed["run"]) < 12
    assert set(failed["outcome"]) == {"function failed"}
    assert set(failed["failure"]) == {"RuntimeError: no such gain"}


def test_cells_that_cannot_be_made_are_outcomes(tmp_path):
    """k_w = 3 is long enough for n_c = 3 and not for n_c = 5: seen only where both meet."""
    axes = [
        Axis("n_c", [3, 5], sets="controller.n_c"), Axis("k_w", [6, 3], sets="controller.k_w")
    ]  # fmt: skip
    run_study(studies.study(1, axes=axes), tmp_path / "store", workers=0)
    table = read_table(tmp_path / "store")
    refused = table["outcome"] == "refused"
    assert [table[name][refused].tolist() for name in ("n_c", "k_w")] == [[5], [3]]
    assert "k_w = 3 is shorter" in table["failure"][refused][0]


def test_ball_arithmetic_and_signals_that_are_kept(tmp_path):
    axis = Axis("arithmetic", ["ud", "reference"], sets="run.arithmetic")
    base = {**studies.BASE, "run": {"steps": 30}}
    store = tmp_path / "store"
    study = studies.study(1, base=base, axes=[axis], common_noise=True,
                          keep=[Metric("rms")], keep_signals=["z", "theta"])  # fmt: skip
    run_study(study, store, workers=0)
    table = read_table(store)
    assert table["rms"][0] == pytest.approx(table["rms"][1], rel=1e-10)
    remaining = pytest.importorskip("pyarrow.parquet").read_table(store / "chunks")
    assert remaining["z.shape"].to_pylist() == [[30, 1]] * 2
    assert remaining["theta.shape"].to_pylist() == [[30, 6]] * 2
    assert len(remaining["theta.values"][0]) == 180
    z = [values.as_py() for values in remaining["z.values"]]
    assert z[0] == pytest.approx(z[1], abs=1e-10)
    again = replay_run(store, 0).analysed.run
    assert np.array_equal(again.z.ravel(), z[0])
    assert all(replay_run(store, run).is_identical for run in (0, 1))


def test_every_run_is_replayed_bit_for_bit(undisturbed):
    for run in (0, 17, 64, 119):
        replayed = replay_run(undisturbed, run)
        assert replayed.is_identical, replayed.differences
        assert replayed.analysed.run.steps == 120
    with pytest.raises(StoreError, match="has no run 120; its runs are 0 to 119"):
        replay_run(undisturbed, 120)


def test_a_key_pressed_leaves_a_whole_store(undisturbed, tmp_path, small_chunks):
    store = tmp_path / "store"

    def press(progress):
        if progress.done > 30:
            raise KeyboardInterrupt

    with pytest.raises(StudyInterrupted) as caught:
        run_study(studies.study(), store, workers=0, progress=press)
    assert 30 < caught.value.done < caught.value.total == 120
    assert len(read_table(store)) == caught.value.done
    run_study(studies.study(), store, workers=0)
    assert read_table(store) == read_table(undisturbed)


@pytest.mark.slow
def test_two_coordinators_finish_with_one_table(tmp_path):
    """What both compute is the same; neither waits for the other."""
    file, store = tmp_path / "study.toml", tmp_path / "store"
    file.write_text(studies.FILE % {"steps": 4000, "repetitions": 60})
    started = [_sweep(file, store, "--workers", "0") for _ in range(2)]
    assert [_status(process) for process in started] == [0, 0]
    run_study(load_study(file), tmp_path / "one", workers=0)
    assert check_store(store).is_whole and read_table(store) == read_table(tmp_path / "one")


def test_two_coordinators_leave_out_what_the_other_has_written(tmp_path, small_chunks):
    """The second goes through the whole study while the first is at its first chunk."""
    study, store = studies.study(), tmp_path / "store"
    observed = []

    def other(progress):
        if not observed and progress.done:
            observed.append(run_study(study, store, workers=0))

    progress = run_study(study, store, workers=0, progress=other)
    assert observed[0].done == progress.done == 120 and check_store(store).is_whole


def test_two_that_make_a_study_grow_at_a_time_end_with_both(tmp_path, small_chunks):
    """Who wrote study.json last has the plan; the other sees it, and computes what it lost."""

    def study(values, repetitions):
        axis = Axis("R_theta", values, sets="controller.R_theta")
        return studies.study(repetitions, axes=[axis], keep=[Metric("rms")])

    store, observed = tmp_path / "store", []
    run_study(study([1.0], 9), store, workers=0)

    def other(progress):
        if not observed and progress.done > 9:
            observed.append(1)
            with Folder(store) as opened:  # as it does that read study.json before we wrote it
                opened.write(before)
            run_study(study([1.0, 2.0], 9), store, workers=0)

    with Folder(store) as opened:
        before = opened.study
    run_study(study([1.0], 30), store, workers=0, progress=other)
    table = read_table(store)
    assert observed and check_store(store).is_whole and len(table) == 60
    run_study(study([1.0, 2.0], 30), tmp_path / "whole", workers=0)
    a, b = ({(R, n): rms for R, n, rms in zip(t["R_theta"], t["repetition"], t["rms"], strict=True)}
            for t in (table, read_table(tmp_path / "whole")))  # fmt: skip
    assert a == b


@pytest.mark.costly
def test_a_study_that_is_killed_goes_on(tmp_path, in_full):
    """At random moments, by SIGKILL; the table is that of an undisturbed run."""
    file = tmp_path / "study.toml"
    file.write_text(studies.FILE % {"steps": 4000, "repetitions": 60})
    store, undisturbed = tmp_path / "store", tmp_path / "undisturbed"
    run_study(load_study(file), undisturbed, workers=0)
    rng = random.Random(1)
    kills = 0
    while kills < (25 if in_full else 2):
        if store.exists() and check_store(store).done == 360:
            shutil.rmtree(store)
        before = _done(store)
        process = _sweep(file, store, "--workers", str(rng.choice([0, 1])))
        while process.poll() is None and _done(store) <= before:
            time.sleep(rng.uniform(0.0, 0.05))
        time.sleep(rng.uniform(0.0, 0.1))
        workers = _children(process.pid)
        process.kill()
        kills += _status(process) == -signal.SIGKILL
        assert all(map(_ends, workers)), "a worker outlives its parent"
    run_study(load_study(file), store, workers=0)
    assert read_table(store) == read_table(undisturbed)


@pytest.mark.costly
@pytest.mark.cases(1)
@pytest.mark.parametrize("workers", ["0", "1"])
def test_ctrl_c_says_how_to_go_on(tmp_path, workers, at_a_terminal):
    file, store = tmp_path / "study.toml", tmp_path / "store"
    file.write_text(studies.FILE % {"steps": 100_000, "repetitions": 500})
    process = _sweep(file, store, "--workers", workers)
    while _done(store) < 1:
        time.sleep(0.05)
        assert process.poll() is None
    process.send_signal(signal.SIGINT)
    _, message = process.communicate()
    assert process.returncode == 130, message
    assert (
        "runs are stored" in message and f"sweep {file} -o {store} --workers {workers}" in message
    )
    assert 0 < len(read_table(store)) < 3000


def test_bad_arguments_are_refused(tmp_path):
    study, store = studies.study(2), tmp_path / "store"
    for options, words in (
        ({"workers": -1}, "workers = -1"),
        ({"executor": 3}, "no concurrent.futures.Executor"),
    ):
        with pytest.raises(InputError, match=words):
            run_study(study, store, **options)


def _sweep(file, store, *options):
    command = [sys.executable, "-c", "from rcac_experiments.cli._main import main; main()", "sweep"]
    return subprocess.Popen(
        [*command, str(file), "-o", str(store), *options],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=ROOT,
    )  # fmt: skip


def _children(pid):
    """The processes that any thread of a process has started."""
    result = []
    for listed in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):
            result += listed.read_text().split()
    return result


def _ends(pid):
    """Whether a process ends by itself, for which it has minutes; a zombie has ended."""
    for _ in range(6000):
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return True
        if state == "Z":
            return True
        time.sleep(0.05)
    return False


def _status(process):
    """How it ended; what it said is in the way of an assertion that fails."""
    _, message = process.communicate()
    assert "Traceback" not in message, message
    return process.returncode


def _done(store):
    """Chunks that are stored."""
    return len(list((store / "chunks").glob("*.parquet")))
