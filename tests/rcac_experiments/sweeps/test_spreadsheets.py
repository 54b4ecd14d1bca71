"""Texts of others in a .csv file: no spreadsheet computes them, wherever it begins a cell."""

import csv
import io
import unicodedata

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rcac_experiments.sweeps._export import _cell
from rcac_numeric.arrays._wording import spreadsheet_text

TEXTS = (
    "=1+1", "＝1+1", "＋cmd|' /C calc'!A0", "x;=1+cmd|A!A0", "\u200b=1", "\ufeff=1", "-A1",
    "+HYPERLINK(A1)", "\u00a0=1", "\u2212=1", "\x00=1", "\t=1", "\r=1", "\n=1", "|=1", "\u00ad=1",
    "\u2060=1", "+WEBSERVICE(A1)", "-(1)^CALL(A1)", '"=1', 'x;"=1', "﹦1", "a;\u3000@x",
    "-1/(q - 2)", "-1;2",
)  # fmt: skip
DELIMITERS = (",", ";", "\t", "|")


def computed(cell):
    """Whether a spreadsheet might take a cell for a formula: what is not seen passed over."""
    shown = [c for c in cell if unicodedata.category(c) not in ("Cc", "Cf", "Mn", "Zl", "Zp", "Zs")]
    observed = unicodedata.normalize("NFKC", "".join(shown).lstrip('"'))
    if not observed.startswith(("=", "+", "-", "@", "\u2212")):
        return False
    try:
        float(observed.rstrip('"'))
    except ValueError:
        return True
    return False


@pytest.mark.parametrize("text", TEXTS)
def test_the_oracle_knows_a_formula(text):
    """A control: as they are, each of them is one in some country."""
    lines = ["".join(text.split("\r")), text]
    cells = [c for d in DELIMITERS for line in lines for c in line.split(d)]
    assert any(map(computed, cells))


@given(st.text(alphabet="=+-@＝＋－＠;|,\t\r\n\"' \u200b\ufeff\u00a0\u2212xA1.(e", max_size=12))
@example("x;=1+cmd|A!A0")
@example('x;"=1')
@example('"";"=1')
@example("-1;-x")
def test_no_cell_is_a_formula_in_any_country(text):
    """The row as it is written, read with the separators of other countries, in quotes or not."""
    row = f"0,{_cell(text)},0.5\n"
    for delimiter in DELIMITERS:
        read = next(csv.reader(io.StringIO(row), delimiter=delimiter))
        # The file's own separator is a comma, and whoever reads by commas knows the quotes.
        raw = [] if delimiter == "," else row.strip("\n").split(delimiter)
        for cell in [*read, *raw]:
            assert not computed(cell), (delimiter, cell)


@pytest.mark.parametrize("text", ["-0.5", "+1e-3", "1/(q - 0.5)", "x; 2", "completed", ".5"])
def test_numbers_and_plain_texts_stay(text):
    assert spreadsheet_text(text) == text


def test_a_list_is_guarded_too():
    assert _cell(["x;=1"]) == '"[""x;\'=1""]"'
    assert [_cell(v) for v in (None, float("nan"), 1, -2.5, True)] == ["", "", "1", "-2.5", "True"]
