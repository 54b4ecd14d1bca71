"""Every erratum has evidence that stands: checks hold, entries of the ledger and claims exist."""

import pickle

import pytest

from compensator_theory import InputError
from proofs.ledger.checks import run_counterexample
from proofs.ledger.ledger import ledger
from rcac_experiments.dissertation import check_erratum, find_errata, load_example
from rcac_experiments.dissertation._checking import SHOWN_BY, can_run
from rcac_experiments.dissertation._entries import EVIDENCE
from rcac_experiments.dissertation._examples import example_ids
from rcac_experiments.dissertation._reading import CHAPTERS, read_chapter
from rcac_experiments.results import ErratumEvidence
from rcac_numeric.arrays._values import replaced as replace

ERRATA = find_errata()
OF = {kind: [e for e in ERRATA if e.evidence.kind == kind] for kind in EVIDENCE}


def named(entry):
    return entry.name


def test_every_chapter_has_some():
    """Chapter 9 is of work to come."""
    assert {entry.chapter for entry in ERRATA} == set(CHAPTERS) - {"9"}


@pytest.mark.costly
@pytest.mark.parametrize("erratum", OF["check"], ids=named)
def test_the_check_holds(erratum):
    checked = check_erratum(erratum)
    assert len(checked.facts) >= 1
    assert checked.holds, [fact.words for fact in checked.facts if not fact.holds]
    assert pickle.loads(pickle.dumps(checked)) == checked


@pytest.mark.parametrize("erratum", OF["ledger"], ids=named)
def test_the_ledger_has_the_entry_and_its_counterexample_holds(erratum):
    entry = next(entry for entry in ledger() if entry.name == erratum.evidence.ledger)
    cases = {case.check: case for case in entry.counterexamples}
    if erratum.evidence.counterexample:
        result = run_counterexample(cases[erratum.evidence.counterexample])
        assert result.status == "holds", result.detail
    else:
        assert entry.difference or erratum.where in entry.text


# Hypotheses more than needed, and customs that are not spelt out: nothing is wrong.
READING_NOTES = {
    "placement.more_states_than_the_plant",
    "placement.separated_pair",
    "placement.too_many_target_poles",
    "resultants.multiple_roots",
    "theorem_1.distinct_roots",
    "theorem_1.multiplicity",
}


def test_no_wording_that_the_ledger_refutes_is_missing():
    """Each counterexample to a wording of the text is that of an erratum, or a reading note."""
    known = {erratum.evidence.counterexample for erratum in ERRATA}
    known |= {name for erratum in ERRATA for name in erratum.evidence.others}
    refuted = {case.check for entry in ledger() for case in entry.counterexamples if case.in_text}
    assert refuted - known == READING_NOTES


@pytest.mark.costly
@pytest.mark.parametrize("erratum", OF["example"], ids=named)
def test_the_claim_exists_and_its_verdict_goes_with_the_kind(erratum):
    """A misprint shows as one, and what depends on something does."""
    assert erratum.evidence.example in example_ids()
    example = load_example(erratum.evidence.example)
    message = {c.text for c in example.claims if c.text.startswith(erratum.evidence.claim)}
    assert len(message) == 1, "the words are those of one claim"
    claims = [claim for claim in example.claims if claim.text in message]
    verdicts = {claim.recorded for claim in claims if claim.quote or len(claims) == 1}
    assert verdicts <= set(SHOWN_BY.get(erratum.kind, verdicts))


def test_each_says_its_charitable_reading_and_can_be_run():
    assert all(len(erratum.charity) > 12 and erratum.charity.endswith(".") for erratum in ERRATA)
    assert all(can_run(erratum) for erratum in ERRATA)


def test_few_are_called_false():
    """Where a charitable reading holds the kind says so."""
    assert {erratum.name for erratum in ERRATA if erratum.kind == "false"} == {"redrawn-points"}


def test_a_claim_as_evidence_is_run():
    entry = next(erratum for erratum in ERRATA if erratum.name == "theorem-of-b-5")
    assert check_erratum(entry).holds
    other = replace(entry, kind="depends")  # its claim is a misprint: the kinds do not agree
    assert not check_erratum(other).holds


@pytest.mark.parametrize(
    ("where", "name"),
    [
        ("(2.31)", "transposed-vec"),
        ("(A.16)", "missing-poles"),
        ("7.1", "coefficient-8-26"),
        ("example 7.1", "coefficient-8-26"),
        ("Table 5.2", "seconds-and-steps"),
        ("b", "theorem-of-b-5"),
        ("leading-zeros", "leading-zeros"),
    ],
)
def test_a_place_finds_its_errata(where, name):
    assert name in {entry.name for entry in find_errata(where)}


def test_an_equation_is_no_example():
    assert "coefficient-8-26" not in {entry.name for entry in find_errata("(7.1)")}
    assert find_errata("Example 4.7") == ()


@pytest.mark.parametrize("where", ["99", "chapter 8", "(10.3)", "no-such-name"])
def test_what_is_no_place_is_refused(where):
    with pytest.raises(InputError, match="is no place of the dissertation"):
        find_errata(where)


GOOD = {
    "name": "a", "where": "(2.1)", "kind": "false", "printed": "x", "true": "y",
    "evidence": {"check": "chapter_2.servo_performance"},
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"evidence": {}}, "exactly one"),
        ({"evidence": {"check": "a.b", "ledger": "c"}}, "exactly one"),
        ({"evidence": {"example": "4.6"}}, "go together"),
        ({"evidence": {"counterexample": "c.d", "check": "a.b"}}, "belongs to an entry"),
        ({"kind": "wrong"}, "kind"),
        ({"true": ""}, "needs true"),
        ({"proof": "none"}, "unknown key 'proof'"),
    ],
)
def test_an_entry_that_says_too_little_is_refused(change, message):
    assert read_chapter({"chapter": "2", "erratum": [GOOD]}, "f.toml")[0].equations == ("2.1",)
    with pytest.raises(InputError, match=message):
        read_chapter({"chapter": "2", "erratum": [{**GOOD, **change}]}, "f.toml")


def test_two_of_one_name_are_refused():
    with pytest.raises(InputError, match="two errata are named 'a'"):
        read_chapter({"chapter": "2", "erratum": [GOOD, GOOD]}, "f.toml")


def test_a_check_that_is_not_there_is_named():
    [entry] = read_chapter(
        {"chapter": "2", "erratum": [{**GOOD, "evidence": {"check": "chapter_2.nothing"}}]}, "f"
    )
    with pytest.raises(InputError, match=r"no check 'chapter_2\.nothing'"):
        check_erratum(entry)


def test_evidence_says_itself_in_a_line():
    assert (
        ErratumEvidence(ledger="x", counterexample="m.c").words
        == "ledger of proofs: x, refuted by m.c"
    )
