"""Pages: whole, without a network, the same words as the report, one id for each thing."""

import base64
import hashlib
import re
from itertools import pairwise

import pytest

from rcac_experiments import verify
from rcac_experiments.dissertation import load_example
from rcac_experiments.dissertation._pages import LETTERS, WORK, example_page, gallery_page, headline
from rcac_experiments.dissertation._typesetting import typeset
from rcac_experiments.files._builder import build
from rcac_experiments.judging._claim import CLASSES, DEPENDS, NOT_REPRODUCED, REPRODUCED, VERDICTS
from rcac_experiments.reports._cases import Case, ClaimRow, case_of, case_page
from rcac_experiments.reports._verification import verification_sheet
from rcac_numeric.arrays._values import replaced as replace
from rcac_numeric.reports._rendering import words
from rcac_numeric.reports._terminal import as_text
from tests.support.pages import Page

NUMBERS = ("2.2", "2.5", "7.1", "B.2")


@pytest.fixture(scope="module")
def cases():
    return [case_of(verify(load_example(number))) for number in NUMBERS]


@pytest.fixture(scope="module")
def gallery(cases):
    return gallery_page(cases)


def test_every_element_is_closed_and_no_id_stands_twice(gallery):
    page = Page(gallery)
    assert not page.open
    assert len(page.ids) == len(set(page.ids))


def test_it_asks_for_nothing_from_a_network(gallery):
    page = Page(gallery)
    outside = [
        (tag, value)
        for tag, attributes in page.elements
        for name, value in attributes.items()
        if name in ("src", "href", "xlink:href", "action", "srcset") and value[0] != "#"
    ]
    assert outside == [("link", "data:,")]
    assert not re.search(r"@import|url\((?!#)|fetch\(|https?://(?!www\.w3\.org)", gallery)


def test_every_reference_has_its_target(gallery):
    page = Page(gallery)
    names = set(re.findall(r'(?:href="#|url\(#)([^")]+)', gallery))
    drawn = [a for a in page.all("svg") if "aria-hidden" not in a]
    names |= {a["aria-labelledby"] for a in drawn}
    assert names <= set(page.ids)


def test_every_claim_stands_in_the_table_with_its_verdict(gallery, cases):
    rows = [row for row in Page(gallery).all("tr") if "data-verdict" in row]
    requested = [(case.anchor, claim.verdict) for case in cases for claim in case.claims]
    assert [(row["data-case"], row["data-verdict"]) for row in rows] == requested
    text = Page(gallery).text
    for case in cases:
        for claim in case.claims:
            assert claim.quote or " ".join(claim.text.split()) in text
            assert " ".join(claim.place.split()) in text


def test_the_headline_counts_sentences_and_none_of_ours(cases):
    row = ClaimRow("the text", "a", "(1)", "", "x", "", DEPENDS, "depends on w", (), "", "", "")
    same, ours = replace(row, verdict=REPRODUCED), replace(row, owner="ours", quote="")
    other = replace(row, owner="a reading", verdict=NOT_REPRODUCED)
    case = replace(cases[0], claims=(row, same, ours, other))
    count = headline([case])
    assert count == {"the text": {DEPENDS: 1}, "a reading": {NOT_REPRODUCED: 1}}


def test_the_author_stands_first_and_a_case_of_ones_own_knows_none(gallery, cases):
    text = Page(gallery).text
    assert text.index(WORK["author"]) < text.index("Sentences of the text")
    ours = case_page(replace(cases[0], id="mine", source=""))
    assert "issertation" not in ours.split("<h2>Claims")[0] and WORK["author"] not in ours


@pytest.mark.costly
def test_a_quick_look_says_so(cases):
    assert "Quick run" in Page(gallery_page(cases, is_quick=True)).text
    assert "Quick run" not in Page(gallery_page(cases)).text


def test_an_example_is_one_click_away_and_opens_with_its_picture(gallery, cases):
    page = Page(gallery)
    links = [a["href"] for a in page.all("a") if a.get("href")]
    for case in cases:
        assert f"#{case.anchor}" in links
        section = gallery[gallery.index(f'id="{case.anchor}"') :]
        if case.pictures:
            assert section.index("<svg") < section.index("<table")


def test_every_verdict_is_explained(gallery):
    text = Page(gallery).text
    for name, message in (*VERDICTS.items(), *CLASSES.items(), *LETTERS.items()):
        assert name in text and " ".join(message.split()) in text


@pytest.mark.costly
def test_quotes_are_typeset(gallery):
    assert "<i>M<sub>" in str(typeset(r"$M_{2}$"))
    message = re.findall(
        "\N{LEFT DOUBLE QUOTATION MARK}[^\N{RIGHT DOUBLE QUOTATION MARK}]*", gallery
    )
    message += re.findall("<q>.*?</q>", gallery)
    assert any("<sub>" in words for words in message) and all(
        words.count("$") < 2 for words in message
    )  # one alone is no formula


def test_examples_that_run_have_pictures_with_titles(gallery, cases):
    page = Page(gallery)
    pictures = [picture for case in cases for picture in case.pictures]
    drawn = [svg for svg in page.all("svg") if "aria-hidden" not in svg]
    assert len(drawn) == len(pictures) > 0
    small = len(page.all("svg")) - len(drawn)
    assert (
        small
        == sum("href" in one for one in page.all("use"))
        == sum(bool(case.pictures) for case in cases)
    )
    for case in cases:
        experiment = load_example(case.id)
        requested = [figure.caption for figure in experiment.figures if figure.kind != "sheet"]
        result = [picture.title for picture in case.pictures]
        assert result == requested or (
            not requested and len(result) == (4 if experiment.runs else 0)
        )
    assert all(svg["role"] == "img" and svg["viewbox"] for svg in drawn)
    assert all(picture.svg.count("<path") > 10 for picture in pictures)


def test_headings_leave_no_level_out(gallery):
    levels = [int(tag[1]) for tag, _ in Page(gallery).elements if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(b - a <= 1 for a, b in pairwise(levels))


def test_every_control_has_a_label(gallery):
    page = Page(gallery)
    assert len(page.all("label")) == len(page.all("input")) + len(page.all("select")) == 3
    assert all("scope" in head for head in page.all("th"))


def test_errata_of_the_examples_are_told(gallery):
    assert 'id="erratum-coefficient-8-26"' in gallery
    assert "Errata of the text" in example_page(case_of(verify(load_example("7.1"))))
    assert "8.25 s + 23.25" in Page(gallery).text


@pytest.mark.costly
def test_the_same_case_gives_the_same_page(cases):
    again = case_of(verify(load_example("2.5")))
    assert again == cases[1]
    assert Case.from_record(again.to_record()) == again


def test_words_of_a_user_are_words_and_no_markup():
    table = {
        "id": "<b>x", "title": '<script>alert("x")</script>', "notes": "a & b",
        "exact": {"a": "s + 1", "b": "s + 2"},
        "claims": [{"text": "<img src=x>", "checks": [{"statement": "common_roots", "equals": 0}]}],
    }  # fmt: skip
    page = Page(case_page(case_of(verify(build(table, "case.toml")))))
    assert len(page.all("script")) == 1 and not page.all("b") and not page.all("img")
    assert '<script>alert("x")</script>' in page.text and "<img src=x>" in page.text
    assert "a & b" in page.text and words("<\x1b") == "&lt;\\x1b"


def policy_of(text):
    (policy,) = [a["content"] for a in Page(text).all("meta") if "http-equiv" in a]
    return {name: rest for name, _, rest in (d.partition(" ") for d in policy.split("; "))}


def test_the_policy_lets_run_what_is_ours_and_nothing_else(gallery):
    """One script and one style sheet, by their hashes; no handler, no frame, no network."""
    policy = policy_of(gallery)
    assert policy["default-src"] == policy["base-uri"] == policy["form-action"] == "'none'"
    assert policy["img-src"] == "data:"
    allowed = {"script": policy["script-src"], "style": policy["style-src-elem"]}
    sources = Page(gallery).sources
    assert sorted(tag for tag, _ in sources) == ["script", "style"]
    for tag, text in sources:
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert allowed[tag] == f"'sha256-{digest}'"
    assert not [name for _, a in Page(gallery).elements for name in a if name.startswith("on")]
    before = gallery[: gallery.index("Content-Security-Policy")]
    assert "<script" not in before and "<style" not in before and "<link" not in before


@pytest.mark.costly
@pytest.mark.parametrize("field", ["id", "title", "source", "body", "details", "settings"])
def test_a_script_in_any_field_is_words_or_has_no_hash(cases, field):
    """The body is HTML that was made from words; kept cases are files, and may hold anything."""
    injected = "<script>document.title = 'run'</script><img src=x onerror=alert(1)>"
    text = case_page(replace(cases[0], **{field: injected}))
    allowed = policy_of(text)["script-src"]
    for tag, source in Page(text).sources:
        digest = base64.b64encode(hashlib.sha256(source.encode()).digest()).decode()
        assert tag == "style" or (digest in allowed) == ("document.title" not in source)
    if field not in ("body", "details"):
        assert len(Page(text).all("script")) == 1 and not Page(text).all("img")


def test_control_characters_of_a_user_are_written_out():
    table = {
        "id": "x", "title": "a", "exact": {"a": "s + 1", "b": "s + 2"},
        "claims": [{"text": "d", "checks": [{"statement": "common_roots", "equals": 0}]}],
    }  # fmt: skip
    plain = build(table, "case.toml")  # a file with such characters is refused
    claims = tuple(replace(claim, text="d\x07") for claim in plain.claims)
    user = replace(plain, title="a\x1b[31m\nb\u202e", notes="c\x9b\u2066", claims=claims)
    verification = verify(user)
    for text in (
        case_page(case_of(verification)),
        as_text(verification_sheet(verification)),
        verification.report(),
    ):
        assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]", text)
        assert r"a\x1b[31m\nb\u202e" in text and r"c\x9b\u2066" in text and r"d\x07" in text
