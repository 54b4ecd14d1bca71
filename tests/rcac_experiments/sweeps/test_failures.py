"""What may pass is no result: recorded, counted, in no number, and run again when that is asked."""

import signal
import sys

import numpy as np
import pytest

from compensator_theory.errors import InputError
from rcac_experiments.sweeps import (
    Axis,
    Metric,
    StudyInterrupted,
    export_table,
    read_table,
    run_study,
    summarise,
    sweep_overview,
)
from rcac_experiments.sweeps import (
    _pools as pools,
)
from rcac_experiments.sweeps import (
    _sweep as sweep,
)
from rcac_experiments.sweeps._chunk import LONGEST_TEXT
from tests.support import studies


@pytest.fixture
def small_chunks(monkeypatch):
    monkeypatch.setattr(sweep, "_chunk_size", lambda study, first, pool: 4)


def test_memory_that_comes_back_gives_the_table_of_an_undisturbed_run(tmp_path, monkeypatch):
    study = studies.over_R_theta([1.0, 2.0], studies.short_of_memory, 4)
    store, undisturbed = tmp_path / "store", tmp_path / "undisturbed"
    run_study(study, undisturbed, workers=0)
    short = tmp_path / "short"
    short.touch()
    monkeypatch.setenv("SHORT_OF_MEMORY", str(short))
    assert str(run_study(study, store, workers=0)) == "8 of 8 runs (100 %), 8 failed"
    table = read_table(store)
    assert len(table) == 0 and table.failures == 8 and "8 more failed" in repr(table)
    assert set(table.failed["outcome"]) == {"out of memory"}
    short.unlink()
    assert "8 failed" in str(run_study(study, store, workers=0))  # for good, unless it is asked
    assert str(run_study(study, store, workers=0, retry_failed=True)) == "8 of 8 runs (100 %)"
    assert read_table(store) == read_table(undisturbed)


@pytest.mark.costly
@pytest.mark.parametrize("workers", [0, 1])
def test_whatever_a_measure_raises_is_a_failure_of_its_run(tmp_path, workers, small_chunks):
    values = [*studies.ODD, 8.0]
    store = tmp_path / "store"
    progress = run_study(studies.over_R_theta(values, studies.odd), store, workers=workers)
    assert progress.failed == len(studies.ODD)
    table = read_table(store)
    assert table["R_theta"].tolist() == [8.0] and np.isfinite(table["rms"]).all()
    assert table.failed["R_theta"].tolist() == list(studies.ODD)
    texts = dict(zip(table.failed["R_theta"], table.failed["failure"], strict=True))
    assert texts[1.0] == "measure odd: SystemExit: 3"
    assert texts[2.0] == "measure odd: KeyboardInterrupt: my own"
    assert texts[4.0] == r"measure odd: ValueError: \udcff\x00\x1b[31m red"
    assert len(texts[5.0]) <= LONGEST_TEXT
    outcomes = dict(zip(table.failed["R_theta"], table.failed["outcome"], strict=True))
    assert outcomes.pop(6.0) == "out of memory" and set(outcomes.values()) == {"measure failed"}


def test_a_key_that_is_pressed_in_a_measure_is_no_failure_of_it(tmp_path):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(StudyInterrupted):
            run_study(studies.over_R_theta([1.0], studies.pressing), tmp_path / "s", workers=0)
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.costly
@pytest.mark.cases(1)
@pytest.mark.parametrize("workers", [0, 1])
def test_a_run_that_never_ends_is_ended(tmp_path, workers, small_chunks):
    """The other runs are those of a study in which none hangs."""
    values = [1.0, 2.0, studies.HANGING, 4.0, 3.0]
    store = tmp_path / "store"
    study = studies.over_R_theta(values, studies.hanging)
    limit, progress = 1.0, run_study(study, store, workers=workers, time_limit=1.0)
    while progress.failed > 1 and limit < 100:  # a machine that is so busy that all were too slow
        limit *= 4
        progress = run_study(study, store, workers=workers, time_limit=limit, retry_failed=True)
    assert progress.done == 5 and progress.failed == 1
    table = read_table(store)
    assert table.failed["R_theta"].tolist() == [studies.HANGING]
    assert table.failed["outcome"].tolist() == ["timed out"]
    assert f"longer than {limit:g} s" in table.failed["failure"][0]
    run_study(
        studies.over_R_theta([v for v in values if v != studies.HANGING], studies.hanging),
        tmp_path / "others", workers=0,
    )  # fmt: skip
    assert np.array_equal(table["rms"], read_table(tmp_path / "others")["rms"])


def test_a_time_limit_needs_a_process_that_can_be_ended(tmp_path):
    study = studies.study(1)
    for options, words in (
        ({"time_limit": 0}, "must be a positive number"),
        ({"time_limit": float("inf")}, "time_limit"),
        ({"time_limit": 1, "executor": pools.InProcess()}, "not ours"),
        ({"retries": -1}, "retries"),
    ):
        with pytest.raises(InputError, match=words):
            run_study(study, tmp_path / "s", workers=0, **options)


@pytest.mark.parametrize("retries", [0, 1])
def test_retries_are_bounded(tmp_path, retries, small_chunks, monkeypatch):
    monkeypatch.setitem(studies.COUNT, "calls", 0)
    study = studies.over_R_theta([1.0, 2.0, 3.0], studies.failing_once)
    progress = run_study(study, tmp_path / "s", workers=0, retries=retries)
    assert progress.failed == 1 - retries and studies.COUNT["calls"] == 3 + retries


@pytest.mark.costly
@pytest.mark.parametrize("killed", [2, 100])
def test_a_worker_that_is_killed_while_it_starts_is_replaced(tmp_path, killed, monkeypatch):
    started = []
    real = pools._Worker.__init__

    def start(worker, alive):
        real(worker, alive)
        started.append(worker)
        if len(started) <= killed:
            worker.process.kill()

    monkeypatch.setattr(pools._Worker, "__init__", start)
    study, store = studies.study(1), tmp_path / "store"
    if killed < pools.STARTS:
        assert run_study(study, store, workers=1).done == 6 and len(started) == killed + 1
        return
    with pytest.raises(InputError, match="5 in a row were ended by SIGKILL") as caught:
        run_study(study, store, workers=1)
    assert "__name__" not in str(caught.value) and "workers=0" in str(caught.value)
    assert len(started) == pools.STARTS


def test_advice_is_given_to_a_script_that_needs_it(tmp_path, monkeypatch):
    script = tmp_path / "script.py"
    monkeypatch.setattr(sys.modules["__main__"], "__file__", str(script), raising=False)
    script.write_text("run_study(study, 'store')")
    assert "under `if __name__" in pools._guard()
    script.write_text("if __name__ == '__main__':\n    run_study(study, 'store')")
    assert pools._guard() == ""


def test_failures_are_in_no_statistic_and_in_the_first_line(tmp_path):
    store = tmp_path / "store"
    axes = [
        Axis("R_theta", [1.0, studies.RAISING], sets="controller.R_theta"),
        Axis("noise", [0.5, 2], sets="signals.w.white_noise"),
    ]
    study = studies.study(3, axes=axes, keep=[Metric("rms"), Metric(studies.raising)])
    run_study(study, store, workers=0)
    table, overview = read_table(store), sweep_overview(store)
    assert len(table) == table.failures == overview.failed == 6
    assert overview.outcomes == {"completed": 6} and list(overview.failures.values()) == [6]
    summary = summarise(table, "rms", by=["R_theta"])
    assert summary["R_theta"].tolist() == [1.0, studies.RAISING]
    assert summary["runs"].tolist() == [6, 0] and summary["failed"].tolist() == [0, 6]
    assert summary["not_completed"].tolist() == [0, 0] and np.isnan(summary["median"][1])
    assert table.where(R_theta=1.0).failures == 0 and table.where(noise=2).failures == 3
    lines = [line for line in overview.report().splitlines() if line.strip()]
    assert any("6 of 12 runs failed" in line for line in lines[:3])
    export_table(store, tmp_path / "runs.csv")
    assert len((tmp_path / "runs.csv").read_text().splitlines()) == 7
