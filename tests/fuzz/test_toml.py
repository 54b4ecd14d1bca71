"""Experiment files that nobody would write: only our errors, and never much work or memory.

What is tried is made of the shipped files and of the format's own declarations: keys are taken
away, misspelt, moved and repeated, values replaced by others of every kind. The default is a
sample; HYPOTHESIS_PROFILE=thorough tries 10^5.
"""

import copy
import os
import random
import tomllib
from pathlib import Path

import jsonschema
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from compensator_theory.errors import CompensatorError
from rcac_experiments import json_schema, load_experiment
from rcac_experiments.dissertation._examples import example_ids, read_example
from rcac_experiments.files._builder import FILE, build
from rcac_experiments.files._runs import TABLES
from rcac_experiments.format._tables import ByKey, Kinds, PartialTable, Table
from rcac_experiments.format._values import (
    ByStep,
    Choice,
    Either,
    Exact,
    Flag,
    Integer,
    ListOf,
    MapOf,
    Numbers,
    Real,
    Row,
)
from tests.support.work import at_most, at_most_bytes

ROOT = Path(__file__).parents[2]
COUNT = {"thorough": 50_000, "ci": 60}.get(os.environ.get("HYPOTHESIS_PROFILE", ""), 60)
MANY = settings(max_examples=COUNT, deadline=None, suppress_health_check=list(HealthCheck))
CALLS, BYTES = 20_000_000, 200_000_000

SHIPPED = [read_example(number)[0] for number in example_ids()]
SHIPPED += [tomllib.loads(path.read_text()) for path in sorted(ROOT.glob("examples/**/*.toml"))]
VALIDATOR = jsonschema.Draft202012Validator(json_schema())

ODD = [
    0, 1, -1, 2, 3, 17, 400, 20_000, 2**31, 2**63, 10**40, 0.0, -0.0, 0.5, 1.5, -2.5, 1e-300,
    5e-324, 1e300, float("inf"), float("-inf"), float("nan"), True, False, "", "x", "1/3", "pi/8",
    "q", "1/q", "-1/q**2", "(q - 0.5)/(q**2 - 0.25)", "1/(q - 2)", "q**q", "1/0", "0.8j", "sqrt(2)",
    "a*q", "__import__('os')", "1e99999", "((((", "\u202e", "main", "iir", "fir", "ud", "lqg",
    "servo", "standard", "rms", [], [[]], [[[]]], [1], [1, 2], [[1]], [[1, 2], [3, 4]],
    [[1, 2], [3]],
    ["1/2", "-1/2"], ["0.5j"], [True], [[5]], [[5, 0.5]], [[10], [5, 7]], [None], {}, {"a": 1},
    {"z_squared": 1}, {"step": 1}, {"harmonic": "pi/8"}, {"white_noise": 0.1}, {"sum": [1, 2]},
    {"piecewise": [[0, 1], [5, 2]]}, {"recorded": [1.0] * 50}, {"recorded": "no.csv"},
    {"short": 5, "long": 9, "gain": 0.1}, {"at": [5]}, {"model": "fir"}, {"start": 5, "gain": 2},
]  # fmt: skip
KEYS = sorted({name for table in [FILE, *(form.table for form in TABLES.values())]
               for name in table.all_keys()})  # fmt: skip
EXACT = ["1/q", "-1/q", "(q - 0.5)/(q**2 - 0.25)", "1/(q - 2)", "(q - 1.5)/(q*(q - 0.9))", "1/2",
         "-1/2", "0.8j", "q**2 - 1/4", 0.5, -2, 1, "3/2", "1/(q + 1/3)**3"]  # fmt: skip
MATRICES = [[[0.5]], [[1]], [[0.5, 1], [0, 0.2]], [[1], [1]], [[1, 0]], [[0, 1], [1, 0]]]


def written(form, rng, depth=0):
    """A value that a form allows, or nearly so; the grammar is the format's own declarations."""
    if depth > 6 or rng.random() < 0.02:
        return copy.deepcopy(rng.choice(ODD))
    again = lambda inner: written(inner, rng, depth + 1)  # noqa: E731
    if isinstance(form, Integer):
        return rng.choice(
            [0, 1, 1, 2, 3, 5, 10, 50, 300, 5000, 20_000, 10**6, 10**9, form.at_least]
        )
    if isinstance(form, Choice):
        return rng.choice(form.choices)
    if isinstance(form, Flag):
        return rng.random() < 0.5
    if isinstance(form, Real):
        return rng.choice([0, 1, 0.5, 0.99, 1e-10, 1e5, 2.0, "pi/8", "1/3", -1])
    if isinstance(form, Numbers):
        return rng.choice([1.0, 1e-10, 0.1, 100, [0.5] * rng.randrange(1, 12), *MATRICES])
    if isinstance(form, Exact):
        return rng.choice([*EXACT, *MATRICES, rng.sample(EXACT, rng.randrange(5))])
    if isinstance(form, ListOf):
        return [again(form.entry) for _ in range(rng.randrange(4))]
    if isinstance(form, Row):
        return [again(entry) for entry in form.entries]
    if isinstance(form, ByStep):
        return [[k, again(form.entry)] for k in sorted(rng.sample(range(99), rng.randrange(3)))]
    if isinstance(form, MapOf):
        return {name: again(form.entry) for name in rng.sample("wrdv", rng.randrange(3))}
    if isinstance(form, Either):
        return again(rng.choice([form.table, form.other]))
    if isinstance(form, PartialTable):
        return again(form.table)
    if isinstance(form, ByKey):
        kind = rng.choice([None, *form.kinds.values()])
        return rng.choice([0, 1, -0.5]) if kind is None else again(kind)
    if isinstance(form, Table):
        return written_table(form, rng, depth)
    return rng.choice(["main", "x", "PI", "u", "y", "derived", 1, [1.0] * 9, {"step": 1}])


def written_table(table, rng, depth=0):
    """A table with the keys that it needs and some of the others."""
    result = {}
    for key in table.keys:
        if isinstance(key.form, Kinds):
            name = rng.choice(list(key.form.kinds))
            result[key.name] = name
            result.update(
                written_table(rng.choice(key.form.kinds[name].variants).table, rng, depth)
            )
        elif key.is_required or rng.random() < 0.15:
            result[key.name] = written(key.form, rng, depth + 1)
    return result


def places(value, path=()):
    """Every place in a table, as the path that leads there."""
    yield path
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from places(entry, (*path, key))
    elif isinstance(value, list):
        for i, entry in enumerate(value[:8]):
            yield from places(entry, (*path, i))


def mutated(rng):
    """A shipped file after some accidents; short, so that a run takes no time."""
    table = copy.deepcopy(rng.choice(SHIPPED))
    if rng.random() < 0.7:
        table.pop("claims", None)
    if rng.random() < 0.5:
        table.pop("runs", None)
    for name in rng.sample(list(TABLES), rng.choice([0, 1, 1, 2])):
        old = table.get(name, {})
        table[name] = {
            **(old if rng.random() < 0.5 else {}),
            **written_table(TABLES[name].table, rng),
        }
    for _ in range(rng.choice([0, 0, 1, 1, 2, 4])):
        inner = [p for p in places(table) if len(p) > (rng.random() < 0.8)]
        path = rng.choice(inner or [("x",)])
        holder = table
        for step in path[:-1]:
            holder = holder[step]
        accident = rng.randrange(7)
        if (accident == 0 and path[-1] in holder) or (accident == 0 and isinstance(holder, list)):
            del holder[path[-1]]
        elif accident == 1 and isinstance(holder, dict):
            holder[rng.choice(KEYS)] = copy.deepcopy(rng.choice(ODD))
        elif accident == 2 and isinstance(holder, dict) and path[-1] in holder:
            name = str(path[-1])
            at = rng.randrange(len(name) + 1)
            holder[name[:at] + rng.choice(["", "x", "\u00e9", " "]) + name[at + 1 :]] = holder.pop(
                path[-1]
            )
        elif accident == 3:
            other = rng.choice(list(places(rng.choice(SHIPPED)))[1:])
            holder[path[-1]] = copy.deepcopy(value_at(rng.choice(SHIPPED), other))
        elif accident == 4 and isinstance(holder, dict) and path[-1] not in holder:
            continue
        elif accident == 4 and isinstance(holder[path[-1]], list):
            holder[path[-1]] = holder[path[-1]] * rng.choice([2, 3])
        else:
            holder[path[-1]] = copy.deepcopy(rng.choice(ODD))
    return table


def value_at(table, path):
    """What stands at a path as far as it goes."""
    for step in path:
        if not isinstance(table, dict | list) or (isinstance(table, dict) and step not in table):
            break
        if isinstance(table, list) and (not isinstance(step, int) or step >= len(table)):
            break
        table = table[step]
    return table


def require_civil(make):
    """Build something: it is made, or refused by one of our errors, with little work and space."""
    try:
        with at_most(CALLS), at_most_bytes(BYTES):
            return make()
    except CompensatorError as error:
        assert len(str(error)) < 2000
        assert str(error).startswith("case")
        return None


@pytest.mark.costly
@MANY
@example(seed=27479)  # a zero with a symbol
@given(seed=st.integers(0, 2**64))
def test_mutated_tables(seed):
    table = mutated(random.Random(seed))
    experiment = require_civil(lambda: build(table, "case.toml"))
    if experiment is not None:
        errors = [error.message[:300] for error in VALIDATOR.iter_errors(table)]
        assert not errors, "the schema refuses what is accepted"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("files")


@pytest.mark.costly
@MANY
@given(seed=st.integers(0, 2**64))
def test_mutated_text(seed, folder):
    rng = random.Random(seed)
    paths = sorted(ROOT.glob("rcac_experiments/dissertation/example_files/*.toml"))
    text = bytearray(rng.choice(paths).read_bytes())
    for _ in range(rng.choice([1, 1, 2, 4, 8])):
        at = rng.randrange(len(text))
        accident = rng.randrange(4)
        if accident == 0:
            text[at] = rng.randrange(256)
        elif accident == 1:
            del text[at : at + rng.choice([1, 1, 5, 50])]
        elif accident == 2:
            text[at:at] = bytes(
                rng.choice([b"[", b"]", b"{", b'"', b"'''", b"\n", b"=", b"9", b"-"])
            )
        else:
            start = rng.randrange(len(text))
            text[at:at] = text[start : start + rng.randrange(60)]
    file = folder / "case.toml"
    file.write_bytes(text)

    def make():
        try:
            return load_experiment(file)
        except CompensatorError as error:
            raise type(error)(str(error).replace(str(folder) + "/", "")) from None

    require_civil(make)
