"""One declaration of the format: reader, JSON Schema and documentation say the same."""

import copy
import tomllib
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from rcac_experiments import json_schema
from rcac_experiments.dissertation._examples import example_ids, read_example
from rcac_experiments.files import _plants, _structures, _targets
from rcac_experiments.files._builder import FILE, build
from rcac_experiments.files._claims import CHECK, CLAIM
from rcac_experiments.files._controllers import ONE_OF_SEVERAL
from rcac_experiments.files._plants import CHANGE
from rcac_experiments.files._reference import (
    PLACEHOLDERS,
    page_with_tables,
    reference_tables,
)
from rcac_experiments.files._runs import OVERRIDE, TABLES
from rcac_experiments.files._signals import SIGNAL
from rcac_experiments.judging._measures import MEASURES

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "experiment-files.md").read_text()
VALIDATOR = jsonschema.Draft202012Validator(json_schema())
DECLARED = {
    "file": FILE, "plant.changes": CHANGE, "controllers": ONE_OF_SEVERAL.table, "runs": OVERRIDE,
    "claims": CLAIM, "claims.checks": CHECK, **{name: form.table for name, form in TABLES.items()},
    **{f"signals.{name}": table for name, table in SIGNAL.kinds.items()},
}  # fmt: skip
CASE = {
    "plant": {"problem": "servo", "G": "(q - 0.5)/((q - 0.9)*(q - 0.3))"},
    "signals": {"r": 1},
    "target": {"model": "fir"},
    "controller": {"n_c": 3, "R_theta": 0.1},
    "run": {"steps": 100},
}


def shipped_files():
    for number in example_ids():
        yield pytest.param(read_example(number)[0], id=number)
    for path in sorted((ROOT / "examples").glob("**/*.toml")):
        if path.parent.name != "studies":  # tests/rcac_experiments/sweeps has those
            yield pytest.param(tomllib.loads(path.read_text()), id=path.stem)


@pytest.mark.costly
def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(json_schema())


@pytest.mark.parametrize("table", list(shipped_files()))
def test_every_shipped_file_is_valid(table):
    assert not [error.message for error in VALIDATOR.iter_errors(table)]


@pytest.mark.parametrize("name", DECLARED)
def test_every_key_has_words(name):
    for key, result in DECLARED[name].all_keys().items():
        assert any(k.doc for k in result), f"{key} of [{name}] is not described"


@pytest.mark.parametrize(
    ("module", "kinds"),
    [
        (_structures, _structures.STRUCTURES),
        (_targets, _targets.TARGETS),
        (_plants, _plants.PROBLEMS),
    ],
)
def test_what_a_file_says_otherwise_of_a_parameter_is_said_of_one_that_there_is(module, kinds):
    """Renamed in the library, a parameter would lose the words and the bounds that files add."""
    requested = {key.parameter for table in kinds.tables() for key in table.keys}
    for name in ("DOCS", "FORMS", "NAMES"):
        assert set(getattr(module, name, {})) <= requested, name


def test_every_measure_is_a_kind_of_check():
    assert list(CHECK.kinds["measure"].kinds) == list(MEASURES)


def test_every_table_has_a_placeholder():
    """docs/conf.py fills in the tables of docs/experiment-files.md when the pages are built."""
    assert sorted(PLACEHOLDERS.findall(PAGE)) == sorted(reference_tables())
    filled = page_with_tables(PAGE)
    assert "<!-- table" not in filled
    assert all(table in filled for table in reference_tables().values())


@given(st.data())
def test_a_misspelt_key_is_refused_and_the_right_one_suggested(data):
    """By the reader, with the key that was meant, and by the schema."""
    name = data.draw(st.sampled_from([name for name in ["file", *TABLES] if name != "signals"]))
    key = data.draw(st.sampled_from([k for k in DECLARED[name].all_keys() if len(k) > 3]))
    at = data.draw(st.integers(1, len(key) - 2))
    wrong = key[:at] + key[at + 1] + key[at] + key[at + 2 :]  # two letters in the wrong order
    if wrong in DECLARED[name].all_keys() or wrong == key:
        return
    table = copy.deepcopy(CASE)
    (table if name == "file" else table.setdefault(name, {}))[wrong] = 1
    with pytest.raises(InputError, match=f"unknown key '{wrong}'") as refused:
        build(table, "case")
    assert "Did you mean" in str(refused.value)
    assert key in str(refused.value).split("Known keys")[0] or key[:2] in str(refused.value)
    assert list(VALIDATOR.iter_errors(table))


@pytest.mark.parametrize(
    "changes",
    [
        {"controller": {"terms": "PI"}},
        {"controller": {"structure": "pid"}},
        {"controller": {"structure": "lqg"}},
        {"controller": {"structure": "pdi"}},
        {"controller": {"update": "gradient"}},
        {"controller": {"window": 5}},
        {"controller": {"update": "sliding window"}},
        {"controller": {"reflect_poles": 1}},
        {"controller": {"freeze": [[1, 2, 3]]}},
        {"target": {"poles": []}},
        {"target": {"model": "markov"}},
        {"target": {"model": "filter", "G_f": "1/q", "numerator": [0, 1]}},
        {"run": {"steps": 0}},
        {"run": {"stepz": 1}},
        {"signals": {"r": {"chirp": 1}}},
        {"signals": {"r": {"pulse": 1, "hold": 2}}},
        {"claims": [{"text": "x", "checks": []}]},
        {"claims": [{"text": "x", "checks": [{"measure": "rsm", "at_most": 1}]}]},
    ],
)
def test_schema_and_reader_refuse_the_same(changes):
    table = copy.deepcopy(CASE)
    for name, entries in changes.items():
        table[name] = {**table.get(name, {}), **entries} if isinstance(entries, dict) else entries
    assert list(VALIDATOR.iter_errors(table)), "an editor would not notice"
    with pytest.raises(InputError):
        build(table, "case")


def test_what_runs_join_is_not_judged_alone():
    """[controller] may leave to its runs what they say."""
    table = copy.deepcopy(CASE)
    del table["controller"]["n_c"]
    assert list(VALIDATOR.iter_errors(table))
    table["runs"] = [{"name": "a", "controller": {"n_c": 2}}]
    assert not list(VALIDATOR.iter_errors(table))
    assert build(table, "case").main_run.settings.structure.n_c == 2
