"""What the lists of mutants name exists: verbs and headers, functions, tests, living mutants."""

import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
VERBS, HEADERS = (
    tomllib.loads((ROOT / f"benchmarks/{name}.toml").read_text())
    for name in ("central_verbs", "kernel_updates")
)


def imported(name):
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        return import_module(name)
    finally:
        sys.path.pop(0)


@pytest.fixture(scope="module")
def tester():
    pytest.importorskip("coverage")
    return imported("verb_mutants")


def check_entry(entry):
    """The fields that lists of mutants share."""
    assert entry["tests"] and all((ROOT / "tests" / file).is_file() for file in entry["tests"])
    assert 0 <= entry.get("share", 1) <= 1
    words = [one["mutant"] for one in entry.get("alive", ())]
    assert len(set(words)) == len(words)
    assert all(set(one) == {"mutant", "reason"} and one["reason"] for one in entry.get("alive", ()))


def test_there_are_forty_of_the_three_packages():
    assert len(VERBS) >= 40
    assert {entry["function"].partition(":")[0].partition(".")[0] for entry in VERBS.values()} == {
        "compensator_theory",
        "rcac_numeric",
        "rcac_experiments",
    }


@pytest.mark.parametrize("verb", VERBS)
def test_an_entry_resolves(verb):
    entry = VERBS[verb]
    assert set(entry) <= {"function", "bodies", "tests", "share", "alive"}
    package, _, name = entry["function"].partition(":")
    assert callable(getattr(import_module(package), name))
    check_entry(entry)


def test_the_headers_are_those_of_the_updates_and_their_living_mutants_exist():
    tester = imported("kernel_mutants")
    assert set(HEADERS) == {file.stem for file in (ROOT / "kernel/updates").glob("*.hpp")}
    for name, entry in HEADERS.items():
        assert set(entry) <= {"tests", "share", "alive"}
        check_entry(entry)
        words = [mutant.words for mutant in tester.mutants_of_header(name)]
        assert len(set(words)) == len(words)
        assert {one["mutant"] for one in entry.get("alive", ())} <= set(words)


@pytest.mark.costly
@pytest.mark.parametrize("verb", VERBS)
def test_functions_have_mutants_and_living_mutants_exist(tester, verb):
    """The words of a mutant hold the line that it changes: who changes the line judges it anew."""
    mutants = tester.mutants_of_verb(verb)
    functions = {mutant.function.__qualname__ for mutant in mutants}
    assert {name for names in VERBS[verb]["bodies"].values() for name in names} == functions
    words = [mutant.words for mutant in mutants]
    assert len(set(words)) == len(words)
    assert {one["mutant"] for one in VERBS[verb].get("alive", ())} <= set(words)
