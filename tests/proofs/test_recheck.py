"""The second harness: exported certificates of every kind hold, and falsified ones do not."""

import ast
import copy
import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.certificates._records import _WRITERS
from compensator_theory.errors import InputError
from proofs import recheck
from tests.compensator_theory.samples import SAMPLES

KINDS = [kind for kind in _WRITERS if kind in SAMPLES]


@st.composite
def records(draw):
    """A record of a drawn result, as it comes out of a file."""
    kind = draw(st.sampled_from(KINDS))
    try:
        record = ct.certificate_record(draw(SAMPLES[kind]))
    except InputError:  # irrational, or known by enclosures alone
        record = ct.certificate_record(ct.place_poles("1/(s - a)", [-1], feedback=-1))
    return json.loads(json.dumps(record))


def with_another_coefficient(record, draw):
    """Falsify a record: one coefficient of an entry that a claim depends on is another."""
    changed = copy.deepcopy(record)
    name = draw(st.sampled_from(sorted(changed["matrices"])))
    matrix = changed["matrices"][name]
    entries = [entry for entry in matrix["entries"] if entry] or matrix["entries"]
    entry = draw(st.sampled_from(entries)) if entries else []
    step = draw(st.sampled_from([1, -1, Fraction(1, 3), 10**9]))
    if entry:
        term = draw(st.sampled_from(entry))
        term[0] = str(Fraction(term[0]) + step)
    elif entries:
        entry.append([str(step), [0] * len(changed["symbols"])])
    return changed


def value(record):
    """The matrices as the harness reads them, over monic denominators."""
    read = recheck.Record(record)
    return {
        name: [[sorted(p.items()) for p in row] for row in grid]
        for name, (_, _, grid, _) in read.matrices.items()
    }


@given(records())
def test_every_certificate_holds(record):
    assert recheck.failures(record) == []


@given(records(), st.data())
def test_a_falsified_certificate_fails(record, data):
    changed = with_another_coefficient(record, data.draw)
    if recheck.failures(changed):
        return
    # Nothing depends on it: a factor beside it is zero, or it is a value inside of an open set.
    assert is_free(record, changed)


def is_free(record, changed):
    """Whether the change is multiplied by zero in every equation, or keeps a polynomial stable."""
    (name,) = [n for n, m in record["matrices"].items() if m != changed["matrices"][n]]
    if any(claim["is"] == name for claim in record.get("stable", ())):
        return True
    read, other = recheck.Record(record), recheck.Record(changed)
    for terms in record.get("equations", ()):
        for coefficient, names in terms:
            if name in (n.rstrip("'") for n in names):
                before = read.total([[coefficient, names]])[0]
                if before != other.total([[coefficient, names]])[0]:
                    return False
    return True


def test_it_imports_the_standard_library_alone_and_is_short():
    text = Path(recheck.__file__).read_text(encoding="utf-8")
    modules = {
        (node.module if isinstance(node, ast.ImportFrom) else node.names[0].name).split(".")[0]
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Import | ast.ImportFrom)
    }
    assert modules <= set(sys.stdlib_module_names)
    assert len(text.splitlines()) <= 300


def test_as_a_program(tmp_path):
    placement = ct.place_poles("b/(s*(s + a))", "(s + w)**3", feedback=-1)
    file = tmp_path / "records.json"
    file.write_text(json.dumps([ct.certificate_record(placement)]), encoding="utf-8")
    command = [sys.executable, "-I", recheck.__file__, str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "1 placement\nevery certificate holds\n")
    file.write_text(file.read_text().replace('"3"', '"4"', 1), encoding="utf-8")
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "FAILS: equation 1 of placement" in done.stdout


@pytest.mark.parametrize(
    "record",
    [
        {},
        {"kind": "empty", "symbols": [], "matrices": {}},
        {"kind": "x", "symbols": ["s"], "matrices": {}, "equations": [[["1", ["A"]]]]},
        {"kind": "x", "symbols": ["s"], "matrices": {"A": {"rows": 1, "columns": 1, "entries": [],
         "over": [["1", [0]]]}}, "equations": [[["1", ["A"]]]]},
        {"kind": "x", "symbols": ["s"], "matrices": {"A": {"rows": 1, "columns": 1,
         "entries": [[]], "over": []}}, "equations": [[["1", ["A"]]]]},
        {"kind": "x", "symbols": ["s"], "matrices": {"A": {"rows": 1, "columns": 1,
         "entries": [[["x", [0]]]], "over": [["1", [0]]]}}, "equations": [[["1", ["A"]]]]},
    ],
)  # fmt: skip
def test_a_record_that_claims_nothing_or_is_malformed_is_refused(record):
    assert recheck.failures(record)[0].startswith("refused")


ONE = {"rows": 1, "columns": 1, "entries": [[["1", [0]]]], "over": [["1", [0]]]}


@pytest.mark.parametrize(
    "term", [["1e999999999", [0]], ["1", [10**9]], ["1", [True]], [1, [0]], ["1/0", [0]], "x"]
)
def test_what_would_fill_memory_or_is_no_number_is_refused(term):
    matrix = ONE | {"entries": [[term]]}
    record = {"kind": "x", "symbols": ["s"], "matrices": {"A": matrix}}
    record["equations"] = [[["1", ["A"]]]]
    assert recheck.failures(record)[0].startswith("refused")


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "[[]]", "null", "[" * 100_000])
def test_a_file_that_is_no_record_fails_without_a_traceback(text, tmp_path, capsys):
    file = tmp_path / "records.json"
    file.write_text(text, encoding="utf-8")
    limit = sys.get_int_max_str_digits()
    try:
        assert recheck.main([str(file), str(tmp_path / "none.json")]) == 1
    finally:
        sys.set_int_max_str_digits(limit)
    assert "FAILS: refused" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("row", "time", "stable"),
    [
        ([1, 3, 3, 1], "continuous", True),
        ([1, 1, 1, 1], "continuous", False),
        ([1, 0, 1], "continuous", False),
        ([1, -1], "continuous", False),
        ([4, 0, -1], "discrete", True),
        ([1, -2], "discrete", False),
        ([1, 0, 1], "discrete", False),
    ],
)
def test_the_signs_of_the_harness(row, time, stable):
    assert recheck.is_stable([Fraction(c) for c in row], time) is stable


def test_definiteness_of_the_harness():
    assert recheck.is_definite([[Fraction(2), Fraction(1)], [Fraction(1), Fraction(1)]])
    assert not recheck.is_definite([[Fraction(1), Fraction(1)], [Fraction(1), Fraction(1)]])
    assert not recheck.is_definite([[Fraction(1), Fraction(2)], [Fraction(0), Fraction(1)]])
