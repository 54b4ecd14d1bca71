"""Formulas of the docs: what the renderer adds to its library, and what it refuses."""

import pytest
from math_core import LatexError

from docs.formulas import mathml


def test_lines_are_aligned_whether_or_not_a_blank_one_parts_them():
    parted = mathml("a &= b\n\nc &= d", displayed=True)
    assert parted == mathml(r"a &= b \\ c &= d", displayed=True)
    assert parted.count("<mtr>") == 2 and parted.count("<mtd") == 4


def test_a_number_stands_beside_all_lines():
    shown = mathml(r"a &= b \\ c &= d \tag{7.11, 7.12}", displayed=True)
    assert shown.count("(7.11, 7.12)") == 1
    assert "(7.11, 7.12)" not in mathml("a = b", displayed=True)


@pytest.mark.parametrize("formula", [r"\nosuch", r"x^a^b", r"\left( x", r"\begin{bmatrix} 1"])
def test_what_cannot_be_read_is_refused_and_not_shown_in_red(formula):
    with pytest.raises(LatexError):
        mathml(formula)
