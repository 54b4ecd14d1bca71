"""The letters are of errata drawn by lot, and what each says is shown by its check."""

import random
import re
from pathlib import Path

import pytest

import docs
from rcac_experiments.dissertation import check_erratum, find_errata

PAGE = (Path(docs.__path__[0]) / "letters.md").read_text("utf-8")
LETTERS = re.findall(r"^## (\S+)\n\n(.*?)(?=\n## |\Z)", PAGE, re.M | re.S)
ERRATA = {entry.name: entry for entry in find_errata()}


def test_the_lot_is_the_one_that_the_page_states():
    """With other errata there is another lot, and other letters are to be written."""
    seed, of = re.search(
        r"Random\((\d+)\).sample\(names, 10\)` of the names of all (\d+)", PAGE
    ).groups()
    assert int(of) == len(ERRATA)
    assert [name for name, _ in LETTERS] == random.Random(int(seed)).sample(sorted(ERRATA), 10)


@pytest.mark.parametrize(("name", "letter"), LETTERS, ids=[name for name, _ in LETTERS])
def test_a_letter_quotes_reads_with_charity_and_is_shown(name, letter, request):
    assert f"`rcac errata {name} --check`" in letter
    assert re.search(r'"[^"]+"|\$', letter) and re.search(
        r"[Ww]e\s+(first\s+)?(read|took|tried)", letter
    )
    if ERRATA[name].evidence.example and not request.config.getoption("--long"):
        pytest.skip("verifies an example of 120 000 steps; --long runs it")
    checked = check_erratum(ERRATA[name])
    assert checked.holds, [fact.words for fact in checked.facts if not fact.holds]
