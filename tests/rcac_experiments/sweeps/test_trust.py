"""A store chooses no code and no files: what a replay runs and reads comes from who calls it."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from compensator_theory.errors import CompensatorError, InputError
from rcac_experiments.cli._main import main
from rcac_experiments.sweeps import Metric, StoreError, load_study, replay_run, run_study
from rcac_experiments.sweeps._canonical import digest, source_of
from rcac_experiments.sweeps._chunk_files import decode, encode
from rcac_experiments.sweeps._folder import Folder
from rcac_experiments.sweeps._reader import file_of
from tests.support import studies


@pytest.fixture
def evil(tmp_path, monkeypatch):
    """A module that leaves a mark when it is imported, and one more when it is called."""
    mark = tmp_path / "mark"
    (tmp_path / "evil_module.py").write_text(
        f"open({str(mark)!r}, 'a').close()\ndef edit(*a, **k):\n    return 1.0\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    return "evil_module:edit", mark


def altered(path, **changes):
    """Rewrite the study of a store and its chunks with the right digests, as anybody can."""
    with Folder(path) as store:
        chunks = [decoded(store, number) for number in store.numbers()]
        store.write(replace(store.study, resolved={**store.study.resolved, **changes}))
        store.refreshed()
        for number, columns in enumerate(chunks, 1):
            store.chunks.put(file_of(number), encode(store.layout(number), number, columns))


def decoded(store, number):
    layout, (first, last) = store.layout(number), store.study.plan.chunk(number)
    data = store.chunks.read(file_of(number), 10**9)
    return decode(layout, number, last - first + 1, data)


@pytest.mark.parametrize("table", ["keep", "base"])
def test_a_store_that_names_a_function_imports_nothing(tmp_path, evil, table):
    """Also where the hash of its source is right."""
    name, mark = evil
    path = tmp_path / "store"
    run_study(studies.study(1, keep=[Metric("rms")], axes=[]), path, workers=0)
    CliRunner().invoke(main, ["replay", str(tmp_path / "none"), "0"])  # imports what refusals need
    source = "def edit(*a, **k):\n    return 1.0\n"
    for function, hashed in ((name, digest(source)), ("click.termui:edit", "0" * 16)):
        named = {"function": function, "source": hashed}
        arguments = {"editor": f"sh -c 'touch {mark}'", "filename": "x"}
        keep = [{"name": "rms", "measure": named, "arguments": arguments}]
        altered(path, **({"keep": keep} if table == "keep" else {"base": named}))
        modules = set(sys.modules)
        with pytest.raises(StoreError, match=r"the function .*edit, and a store runs no code"):
            replay_run(path, 0)
        result = CliRunner().invoke(main, ["replay", str(path), "0"])
        assert result.exit_code == 2 and "--measures FILE.py" in result.stderr
        assert "evil_module" not in sys.modules and not mark.exists()
        assert not {m for m in set(sys.modules) - modules if not m.startswith("rcac_numeric")}


def test_functions_of_the_caller_must_be_those_of_then(tmp_path):
    path = tmp_path / "store"
    run_study(studies.over_R_theta([1.0], studies.raising), path, workers=0)
    for name in ("raising", "tests.support.studies:raising"):
        assert replay_run(path, 0, {name: studies.raising}).is_identical
    with pytest.raises(StoreError, match=r"not the one that .* was made with: its source"):
        replay_run(path, 0, {"raising": studies.deadly})
    with pytest.raises(StoreError, match="a store runs no code"):
        replay_run(path, 0, {"deadly": studies.deadly})
    with pytest.raises(InputError, match="must be a function"):
        replay_run(path, 0, {"raising": 3})


def test_functions_come_from_a_file_that_the_command_names(tmp_path):
    file, path = tmp_path / "mine.py", tmp_path / "store"
    run_study(studies.over_R_theta([1.0], studies.deadly), path, workers=0)
    with open(studies.__file__) as source:
        file.write_text(source.read())
    good = CliRunner().invoke(main, ["replay", str(path), "0", "--measures", str(file)])
    assert good.exit_code == 0, good.output
    file.write_text("def deadly(r):\n    return 2.0\n")
    for words in ("its source differs", "cannot be run: ZeroDivisionError"):
        bad = CliRunner().invoke(main, ["replay", str(path), "0", "--measures", str(file)])
        assert bad.exit_code == 2 and words in bad.stderr
        file.write_text("1 / 0\n")


def test_a_failure_of_then_is_said_again(tmp_path):
    path = tmp_path / "store"
    run_study(studies.over_R_theta([studies.RAISING], studies.raising), path, workers=0)
    with pytest.raises(CompensatorError, match="measure raising raised ZeroDivisionError"):
        replay_run(path, 0, {"raising": studies.raising})


def test_a_store_opens_no_file_but_in_the_folder_that_is_given(tmp_path, monkeypatch):
    folder, path = tmp_path / "data", tmp_path / "store"
    folder.mkdir()
    np.savetxt(folder / "w.csv", np.linspace(0, 1, 120), header="w", comments="")
    base = {**studies.BASE, "signals": {"w": {"recorded": "w.csv"}}}
    study = studies.study(1, base=base, axes=[], file=str(folder / "study.toml"))
    run_study(study, path, workers=0)
    assert replay_run(path, 0, data=folder).is_identical
    opened = []
    sys.addaudithook(lambda event, of: opened.append(str(of[0])) if event == "open" else None)
    with pytest.raises(StoreError, match=r"opens no file of your disk.*data=FOLDER"):
        replay_run(path, 0)
    with pytest.raises(StoreError, match="is not there, or is not what"):
        replay_run(path, 0, data=tmp_path)
    outside = {**base, "signals": {"w": {"recorded": "../data/../../secret.csv"}}}
    altered(path, base=outside, files={"../data/../../secret.csv": "0" * 16})
    with pytest.raises(StoreError, match="which is not in"):
        replay_run(path, 0, data=folder)
    assert not [name for name in opened if name.endswith(".csv")]
    altered(path, base=base, files=study.resolved["files"])
    (folder / "w.csv").write_text("w\n" + "2\n" * 120)
    with pytest.raises(StoreError, match="is not what"):
        replay_run(path, 0, data=folder)


@pytest.mark.parametrize("measure", ["os:system", "evil_module:edit", "evil_module.edit"])
def test_a_study_file_names_no_code(tmp_path, evil, measure):
    file = tmp_path / "study.toml"
    text = studies.FILE % {"steps": 50, "repetitions": 1}
    file.write_text(text.replace('measure = "rms"', f'measure = "{measure}"'))
    with pytest.raises(InputError, match="must be one of"):
        load_study(file)
    assert "evil_module" not in sys.modules and not evil[1].exists()


def test_the_source_of_a_function_is_what_tells_it():
    assert source_of(studies.raising) != source_of(studies.deadly)
    assert source_of(print) == ""
