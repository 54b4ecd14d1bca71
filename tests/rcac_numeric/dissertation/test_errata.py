"""Every erratum has evidence that stands: checks hold, entries of the ledger and claims exist."""

import pickle
from collections import Counter

import pytest

from compensator_theory import InputError
from proofs.ledger.checks import run_counterexample
from proofs.ledger.ledger import ledger
from rcac_numeric.dissertation import check_erratum, find_errata, load_example
from rcac_numeric.dissertation.errata.entries import EVIDENCE
from rcac_numeric.dissertation.errata.reading import CHAPTERS, read_chapter
from rcac_numeric.dissertation.examples import example_ids
from rcac_numeric.results import ErratumEvidence

ERRATA = find_errata()
OF = {kind: [e for e in ERRATA if e.evidence.kind == kind] for kind in EVIDENCE}


def named(entry):
    return entry.name


def test_every_chapter_has_some_and_most_are_shown_by_what_runs():
    assert {entry.chapter for entry in ERRATA} == set(CHAPTERS)
    count = Counter(entry.evidence.kind for entry in ERRATA)
    assert sum(count.values()) - count["derivation"] > 3 * count["derivation"]


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
        found = run_counterexample(cases[erratum.evidence.counterexample])
        assert found.status == "holds", found.detail
    else:
        assert entry.difference or erratum.where in entry.text


def test_no_wording_that_the_ledger_refutes_is_missing():
    """Each counterexample to a wording of the text is the evidence of an erratum."""
    known = {erratum.evidence.counterexample for erratum in ERRATA}
    refuted = {case.check for entry in ledger() for case in entry.counterexamples if case.in_text}
    assert refuted <= known


@pytest.mark.parametrize("erratum", OF["example"], ids=named)
def test_the_claim_exists_and_its_verdict_is_not_plainly_reproduced(erratum):
    """What is wrong in the text shows as a correction, or as a claim that does not reproduce."""
    assert erratum.evidence.example in example_ids()
    example = load_example(erratum.evidence.example)
    said = {c.text for c in example.claims if c.text.startswith(erratum.evidence.claim)}
    assert len(said) == 1, "the words are those of one claim"
    verdicts = {claim.recorded for claim in example.claims if claim.text in said}
    assert verdicts != {"reproduced"} or "diverges" in said.pop()


@pytest.mark.parametrize("erratum", OF["derivation"], ids=named)
def test_a_derivation_is_two_sentences(erratum):
    text = erratum.evidence.derivation
    assert text.endswith(".")
    assert 1 <= text.count(". ") <= 2


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
