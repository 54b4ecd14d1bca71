"""Every equation that the software uses is in the ledger or has a reason, and the reverse."""

import pytest

from docs.equation_index import equations
from proofs.ledger.ledger import LedgerError, ledger
from proofs.output import coverage as module
from proofs.output.coverage import coverage, numbers, strength, table, unproved


@pytest.fixture(scope="module")
def used():
    """Equations that functions, modules or the kernel cite."""
    places = equations().items()
    return [n for n, result in places if result.names or result.modules or result.kernel]


def test_every_used_equation_is_in_a_statement_or_has_a_reason(used):
    result = coverage(used, ledger())
    assert {c.number for c in result} == set(used)
    assert all(c.entries or c.why for c in result)


def test_coverage_does_not_shrink(used):
    """Counts of today; a statement that is withdrawn, or loses its theorem, shows here."""
    result = coverage(used, ledger())
    assert sum(c.strength == "Coq" for c in result) >= 159
    assert sum(c.strength != "none" for c in result) >= 159


def test_what_statements_are_about_is_used():
    """An equation of a statement's source is known to the index of equations."""
    unused = {
        number
        for entry in ledger()
        for number in numbers(entry.source)
        if number not in equations()
    }
    assert unused == set()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[[group]]\nwhy = "x"\nequations = ["2.43"]', "statements are about"),
        ('[[group]]\nwhy = "x"\nequations = ["1.99"]', "nothing uses"),
        ("group = []", "lacks a reason"),
    ],
)
def test_a_wrong_reason_is_named(used, monkeypatch, tmp_path, text, words):
    path = tmp_path / "unproved.toml"
    path.write_text(text)
    argument = unproved(path)
    monkeypatch.setattr(module, "unproved", lambda: argument)
    with pytest.raises(LedgerError, match=words):
        coverage(used, ledger())


def test_two_reasons_for_one_equation_are_refused(tmp_path):
    path = tmp_path / "unproved.toml"
    path.write_text('[[group]]\nwhy = "x"\nequations = ["1.1", "1.1-1.2"]')
    with pytest.raises(LedgerError, match="two reasons"):
        unproved(path)


def test_the_table_links_statements_and_names_functions(used):
    result = [c for c in coverage(used, ledger()) if c.number == "2.43"]
    text = table(result, {"2.43": ["rcac_numeric.UD"]})
    assert "| (2.43) | Coq |" in text and "[ud-update](#ud-update)" in text and "`UD`" in text


def test_strength_is_that_of_every_sentence():
    kinds = {entry.name: strength(entry) for entry in ledger()}
    assert kinds["theorem-1-pairs"] == "Coq" and kinds["count-of-forms"] == "Coq in part"
    assert kinds["cross-weight"] == "identity"
