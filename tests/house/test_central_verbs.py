"""What benchmarks/central_verbs.toml lists exists: verbs, functions, tests, living mutants."""

import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
VERBS = tomllib.loads((ROOT / "benchmarks/central_verbs.toml").read_text())


@pytest.fixture(scope="module")
def tester():
    pytest.importorskip("coverage")
    sys.path.insert(0, str(ROOT / "benchmarks"))
    try:
        return import_module("verb_mutants")
    finally:
        sys.path.pop(0)


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
    assert entry["tests"] and all((ROOT / "tests" / file).is_file() for file in entry["tests"])
    assert 0 <= entry.get("share", 1) <= 1
    words = [one["mutant"] for one in entry.get("alive", ())]
    assert len(set(words)) == len(words)
    assert all(set(one) == {"mutant", "reason"} and one["reason"] for one in entry.get("alive", ()))


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
