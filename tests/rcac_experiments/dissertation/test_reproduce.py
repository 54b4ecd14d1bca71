"""Reproducing: nothing is run twice, nothing is lost, and a kill changes no byte of the page."""

import json
import os
import pickle
import signal
import subprocess
import sys
import time
import zipfile
from concurrent.futures import Executor, Future

import numpy as np
import pytest
from click.testing import CliRunner

from compensator_theory import InputError
from rcac_experiments.cli._main import main
from rcac_experiments.dissertation import load_example, reproduce
from rcac_experiments.dissertation._archive import write_archive
from rcac_experiments.dissertation._reproduction import (
    FEW,
    CompletedCases,
    case_workers,
    digest_of,
    reduced,
    verified_case,
)
from rcac_experiments.judging._claim import Check
from rcac_numeric.arrays._values import replaced as replace

NUMBERS = ("7.1", "7.6", "B.1", "B.2", "B.3")


class Counting(Executor):
    """Runs what it is given at once, and remembers what that was; ends after `at_most`."""

    def __init__(self, at_most=100):
        self.ran, self.at_most = [], at_most

    def submit(self, function, experiment):
        future = Future()
        if len(self.ran) == self.at_most:
            future.set_exception(KeyboardInterrupt())
        else:
            self.ran.append(experiment.id)
            future.set_result(function(experiment))
        return future


@pytest.fixture(scope="module")
def experiments():
    return [load_example(number) for number in NUMBERS]


@pytest.fixture(scope="module")
def undisturbed(experiments, tmp_path_factory):
    return reproduce(experiments, tmp_path_factory.mktemp("whole")).page.read_bytes()


def test_what_is_done_is_not_done_again(experiments, undisturbed, tmp_path):
    first, second = Counting(), Counting()
    reproduce(experiments, tmp_path, executor=first)
    message = []
    reproduction = reproduce(
        experiments, tmp_path, executor=second, progress=lambda *p: message.append(p)
    )
    assert (first.ran, second.ran) == (list(NUMBERS), [])
    assert message == [(n, i, len(NUMBERS)) for i, n in enumerate(NUMBERS, 1)]
    assert reproduction.page.read_bytes() == undisturbed
    assert pickle.loads(pickle.dumps(reproduction)) == reproduction


@pytest.mark.parametrize("at_most", range(len(NUMBERS)))
def test_an_interrupt_costs_only_what_was_running(experiments, undisturbed, tmp_path, at_most):
    first, second = Counting(at_most), Counting()
    with pytest.raises(KeyboardInterrupt):
        reproduce(experiments, tmp_path, executor=first)
    count = len(list((tmp_path / "cases").glob("*"))) if at_most else 0
    assert not (tmp_path / "index.html").exists(), "a page is whole or not there"
    reproduction = reproduce(experiments, tmp_path, executor=second)
    assert len(second.ran) == len(NUMBERS) - count
    assert reproduction.page.read_bytes() == undisturbed


@pytest.mark.parametrize("damage", [b"", b"[]", b'{"digest": 1}', b"\xff\x00"])
def test_a_damaged_file_is_made_anew(experiments, undisturbed, tmp_path, damage):
    reproduce(experiments, tmp_path)
    file = tmp_path / "cases" / "7.6.json"
    whole = file.read_bytes()
    file.write_bytes(damage)
    again = Counting()
    reproduction = reproduce(experiments, tmp_path, executor=again)
    assert again.ran == ["7.6"]
    assert file.read_bytes() == whole and reproduction.page.read_bytes() == undisturbed


def test_a_kept_case_of_other_fields_is_made_anew(experiments, tmp_path):
    remaining = CompletedCases(tmp_path)
    remaining.keep(experiments[0], verified_case(experiments[0]))
    record = json.loads((tmp_path / "7.1.json").read_text())
    del record["case"]["body"]
    (tmp_path / "7.1.json").write_text(json.dumps(record))
    assert remaining.find(experiments[0]) is None


def test_other_data_are_another_case():
    example = load_example("2.2")
    name, run = next(iter(example.runs.items()))
    changed = replace(example, runs={**example.runs, name: replace(run, seed=99)})
    assert digest_of(changed) != digest_of(example) == digest_of(load_example("2.2"))


@pytest.mark.costly
def test_the_digest_is_the_same_in_every_process():
    code = (
        "from rcac_experiments.dissertation import load_example\n"
        "from rcac_experiments.dissertation._reproduction import digest_of\n"
        "print(*(digest_of(load_example(n)) for n in ('2.2', '2.6', '6.4', '7.1')))"
    )
    environment = {**os.environ, "PYTHONHASHSEED": "1"}
    outcome = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    ).stdout
    assert outcome.split() == [digest_of(load_example(n)) for n in ("2.2", "2.6", "6.4", "7.1")]


def test_one_that_cannot_be_verified_costs_no_other(experiments, tmp_path):
    bad = load_example("B.1")
    [claim, *_] = bad.claims
    unknown = Check("rsm", "main", at_most=1)
    bad = replace(bad, id="bad", claims=[replace(claim, checks=(unknown,))])
    reproduction = reproduce([bad, experiments[1]], tmp_path)
    assert [case.status for case in reproduction.cases] == [2, 0] and reproduction.exit_status == 2
    assert "verification failed" in reproduction.page.read_text()
    assert not (tmp_path / "cases" / "bad.json").exists(), "it is tried again"


def test_a_quick_look_repeats_less_and_says_so():
    example = load_example("4.6")
    quick = reduced(example)
    counts = [run.repetitions for run in quick.runs.values()]
    assert max(counts) == FEW < max(run.repetitions for run in example.runs.values())
    assert "k_w = 5, 1e-20, plain" in quick.reduced_runs
    assert "k_w = 50, 1e-20, UD" not in quick.reduced_runs


@pytest.mark.costly
def test_an_archive_holds_what_a_reader_needs(experiments, tmp_path):
    reproduction = reproduce(experiments, tmp_path)
    for name in ("a.zip", "b.zip"):
        write_archive(reproduction, tmp_path / name)
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        names = set(archive.namelist())
        assert archive.read("index.html") == reproduction.page.read_bytes()
        assert "numpy" in json.loads(archive.read("environment.json"))["versions"]
    needed = {"README.txt", "cases/7.6.json", "examples/4.7.toml", "errata/chapter_7.toml"}
    needed |= {"sources/rcac_experiments/dissertation/_reproduction.py"}
    needed |= {"sources/compensator_theory/errors.py"}
    assert needed <= names


def test_an_archive_of_another_name_is_refused_before_anything_runs(tmp_path):
    for name, message in (("a.tar", "must end in .zip"), ("x/a.zip", "there is no folder")):
        arguments = ["reproduce", "-o", str(tmp_path / "o"), "--archive", str(tmp_path / name)]
        result = CliRunner().invoke(main, arguments)
        assert result.exit_code == 2 and message in result.output
    assert not (tmp_path / "o").exists()


def test_a_folder_that_cannot_be_written_is_named(experiments, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be made"):
        reproduce(experiments[1:2], tmp_path / "file" / "inside")


def test_the_command_writes_a_page_and_says_what_is_so(tmp_path):
    result = CliRunner().invoke(
        main, ["reproduce", "--chapter", "b", "--jobs", "1", "-o", str(tmp_path), "--json"]
    )
    assert result.exit_code == 0, result.output
    loaded = json.loads(result.stdout)
    assert [example["id"] for example in loaded["examples"]] == [f"B.{i}" for i in range(1, 6)]
    assert "Two coprime polynomials" in (tmp_path / "index.html").read_text()
    result = CliRunner().invoke(main, ["reproduce", "--chapter", "10", "-o", str(tmp_path)])
    assert result.exit_code == 2 and "there is no example of chapter" in result.output


@pytest.mark.costly
def test_processes_make_the_same_cases_and_end_with_the_block(experiments, undisturbed, tmp_path):
    with case_workers(2) as executor:
        reproduction = reproduce(experiments, tmp_path, executor=executor)
        processes = list(executor._processes.values())
    assert reproduction.page.read_bytes() == undisturbed
    assert not any(process.is_alive() for process in processes)


@pytest.mark.long
def test_kills_at_random_moments_change_nothing(tmp_path, in_full):
    """SIGKILL of the whole command, again and again, then one that is left alone."""
    if not in_full:
        pytest.skip("starts many processes; --long runs it")
    command = [sys.executable, "-c", "from rcac_experiments.cli._main import main; main()",
               "reproduce", "--chapter", "2", "--jobs", "2"]  # fmt: skip
    subprocess.run([*command, "-o", tmp_path / "a"], check=True, capture_output=True)
    rng = np.random.default_rng(0)
    for _ in range(20):
        run = subprocess.Popen([*command, "-o", tmp_path / "b"], stdout=subprocess.DEVNULL)
        time.sleep(rng.uniform(0.5, 8))
        run.send_signal(signal.SIGKILL)
        run.wait()
    subprocess.run([*command, "-o", tmp_path / "b"], check=True, capture_output=True)
    pages = [(tmp_path / name / "index.html").read_text() for name in "ab"]
    assert pages[0] == pages[1]
