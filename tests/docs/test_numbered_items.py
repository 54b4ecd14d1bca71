"""Every numbered item of the text has a place in the table."""

import re

import pytest

from docs.numbered_items import counts, items, quoted_claims, table
from proofs.ledger.ledger import ledger
from rcac_experiments.dissertation._examples import example_ids


@pytest.fixture(scope="module")
def numbered():
    return items()


@pytest.mark.costly
def test_every_item_is_settled_or_says_why_not(numbered):
    assert not [item.name for item in numbered if not item.is_settled]
    assert all(len(why) > 20 for item in numbered for _, why in item.besides)
    assert all(item.claims or item.besides for item in numbered if item.example)


@pytest.mark.costly
def test_every_example_and_every_caption_that_is_quoted_is_an_item(numbered):
    by_name = {item.name: item for item in numbered}
    chapters = [number for number in example_ids() if not number.startswith("9.")]
    assert {item.example for item in numbered if item.name.startswith("Example")} == set(chapters)
    for number in chapters:
        for claim in quoted_claims(number):
            if claim.place.startswith(("Figure", "Table")):
                item = by_name[claim.place]
                assert claim.quote in {ours.quote for ours in item.claims}, claim.place


def test_what_is_proved_is_in_the_ledger(numbered):
    assert {item.ledger for item in numbered} - {""} <= {entry.name for entry in ledger()}


def test_the_tables_are_whole(numbered):
    assert table().count("\n| ") == len(numbered)  # the head has no line before it
    counted = sum(map(int, re.findall(r"\| (\d+)(?= )", counts())))
    assert counted == sum(len(quoted_claims(number)) for number in example_ids())
