"""A report is one model: what the terminal says and what JSON holds come from the same sections."""

import io
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from rcac_numeric.reports._sheet import (
    Fact,
    Section,
    Sheet,
    SheetTable,
    Text,
    as_dict,
    as_json,
    cells,
    complex_list,
    rounded,
)
from rcac_numeric.reports._terminal import as_text, print_sheet

WORDS = st.text(st.characters(codec="utf-8", exclude_characters="\n\r"), max_size=40)
NUMBERS = st.floats() | st.integers() | st.complex_numbers() | st.booleans() | st.none()
RECORDS = st.dictionaries(
    st.text(max_size=5),
    st.recursive(
        NUMBERS | st.text(max_size=5),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
        max_leaves=10,
    ),
    max_size=4,
)


@pytest.mark.costly
@given(RECORDS)
def test_json_is_strict_and_loses_only_what_json_lacks(record):
    text = as_json(Sheet("", sections=(Section(record=record),)))
    loaded = json.loads(text, parse_constant=lambda token: pytest.fail(f"{token} is not JSON"))
    assert same(record, loaded)


def same(value, loaded):
    if isinstance(value, complex):
        return same([value.real, value.imag], loaded)
    if isinstance(value, float):
        return loaded == value if math.isfinite(value) else loaded is None
    if isinstance(value, dict):
        return value.keys() == loaded.keys() and all(same(value[k], loaded[k]) for k in value)
    if isinstance(value, list):
        return len(value) == len(loaded) and all(map(same, value, loaded))
    return value == loaded and type(value) is type(loaded)


def test_arrays_become_lists_and_foreign_things_are_a_defect():
    values = {"P": np.eye(2), "poles": np.array([1 + 2j]), "n": np.int64(3), "x": np.float32(0.5)}
    assert as_dict(Sheet("", sections=(Section(record=values),))) == {
        "P": [[1.0, 0.0], [0.0, 1.0]], "poles": [[1.0, 2.0]], "n": 3, "x": 0.5,
    }  # fmt: skip
    with pytest.raises(TypeError):
        as_json(Sheet("", sections=(Section(record={"x": object()}),)))


def test_sections_add_to_one_record_and_never_contradict_each_other():
    parts = Section(record={"a": {"x": 1}}), Section(record={"a": {"y": 2}, "b": 3})
    assert Sheet("", sections=parts).record == {"a": {"x": 1, "y": 2}, "b": 3}
    with pytest.raises(ValueError, match="two sections"):
        _ = Sheet("", sections=(parts[1], parts[1])).record


@given(WORDS, WORDS, st.sampled_from(["plain", "quiet", "good", "warning", "bad"]))
def test_every_word_is_written_and_none_commands_the_terminal(words, name, level):
    """Also markup of the library that writes, such as [bold], is a word."""
    table = SheetTable(
        ("head", words), (cells(words, Text(name, level)), cells([Text("x")] * 2, "y"))
    )
    blocks = (Text(words, level), Fact(name, words, level), table)
    sheet = Sheet(words, name, (Text(words, level),), (Section(name, blocks),), words)
    stream = io.StringIO()
    print_sheet(sheet, Console(file=stream, width=300, force_terminal=False, color_system=None))
    text = stream.getvalue()
    assert not any(ord(c) < 32 and c != "\n" for c in text)
    if words.isprintable() and words.isascii() and words.strip():
        assert text.count(words.strip()) >= 5


def test_lines_are_broken_for_people_only():
    sheet = Sheet("title", sections=(Section("part", (Text("word " * 60),)),))
    assert max(map(len, as_text(sheet, 60).split("\n"))) <= 60
    stream = io.StringIO()
    console = Console(file=stream, width=60, force_terminal=True)
    print_sheet(sheet, console)
    assert "\x1b[1mtitle" in stream.getvalue()


def test_numbers_beyond_float64_are_infinite():
    assert rounded(10**400) == math.inf and rounded(-(10**400)) == -math.inf
    assert complex_list([]) == "none" and complex_list([1 + 0j, 2j]) == "1, 0+2j"


def test_in_a_notebook_a_report_is_a_text_too(monkeypatch):
    """There Rich shows what is printed, to whatever file, unless it is told not to."""
    sheet = Sheet("A case", sections=(Section("The loop", (Text("radius 0.5"),)),))
    elsewhere = as_text(sheet)
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    assert as_text(sheet) == elsewhere and "radius 0.5" in elsewhere
