"""Whole pages: one case, or a gallery of cases with all their claims in one table."""

from __future__ import annotations

import base64
import hashlib
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from importlib import resources
from importlib.metadata import version
from pathlib import Path

from rcac_numeric.arrays.files import replacing
from rcac_numeric.arrays.wording import in_a_line
from rcac_numeric.dissertation.errata.entries import Erratum
from rcac_numeric.dissertation.errata.reading import find_errata
from rcac_numeric.experiments.claims import (
    CORRECTED,
    ILL_POSED,
    NOT_REPRODUCED,
    REPRODUCED,
    VERDICTS,
)
from rcac_numeric.reports.page.cases import Case, ClaimRow, picture_html
from rcac_numeric.reports.page.html import words

NAMED = ("compensator-theory", "numpy", "scipy", "sympy", "python-flint", "matplotlib")
LEADS = {
    REPRODUCED: "good",
    CORRECTED: "warning",
    "not reproduced": "bad",
    "ill-posed": "warning",
}
COLUMNS = ("example", "claim", "claimed", "measured", "verdict")
_EQUATION = re.compile(r"\(([1-9AB]\.\d+)\)")


def case_page(case: Case) -> str:
    """The page of one case, a whole HTML document.

    Examples
    --------
    >>> from rcac_numeric import verify
    >>> from rcac_numeric.dissertation import load_example
    >>> from rcac_numeric.reports.page.cases import case_of
    >>> from rcac_numeric.dissertation.pages import case_page
    >>> page = case_page(case_of(verify(load_example("7.1"))))
    >>> page.startswith("<!DOCTYPE html>"), "Errata of the text" in page
    (True, True)
    """
    wrong = _errata_at([case])
    title = in_a_line(f"{case.id}: {case.title}".strip(": "))
    inside = [
        f'<main id="content" class="one">{_section_of(case, wrong, "Claims and report")}',
        *_errata(wrong),
        *_made_with([case]),
        "</main>",
    ]
    return _document(title, case.source or "A case, its claims and what was measured.", inside)


def gallery_page(cases: Sequence[Case], title: str = "The dissertation's examples") -> str:
    """The page of several cases, with a table of all claims that can be searched.

    Parameters
    ----------
    cases : sequence of Case
    title : str
    """
    wrong = _errata_at(cases)
    inside = [
        '<main id="content">',
        *opening(),
        *_summary(cases),
        *_filters(cases),
        *_claims(cases),
        *(_section_of(case, wrong, f"{case.id} {case.title}") for case in cases),
        *_errata(wrong),
        *_made_with(cases),
        "</main>",
    ]
    return _document(title, LEAD, inside)


def write_page(page: str, path: str | Path) -> None:
    """Write a page; the file that was there stays whole until the new one is."""
    with replacing(path) as new:
        new.write_text(page, encoding="utf-8")


def _document(title: str, lead: str, inside: Sequence[str]) -> str:
    folder = resources.files("rcac_numeric.reports.page")
    css, js = (folder.joinpath(f"page.{kind}").read_text("utf-8") for kind in ("css", "js"))
    css, js = f"\n{css}", f"\n{js}"
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{_policy(css, js)}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<link rel="icon" href="data:,">',
        f"<title>{words(title)}</title>",
        f"<style>{css}</style></head><body>",
        '<a class="skip" href="#content">To the content</a>',
        f"<header><h1>{words(title)}</h1>",
        '<button id="theme" class="theme" type="button" hidden>Light or dark</button>',
        f'<p class="lead">{words(lead)}</p></header>',
        *inside,
        f"<script>{js}</script></body></html>",
    ]
    return "\n".join(lines) + "\n"


def _policy(css: str, js: str) -> str:
    """What a browser may run and load on the page: its one style sheet, its one script.

    Whatever words of others stand on it, nothing else runs, and nothing is asked of a network. The
    attributes `style` are those of the pictures' lines.
    """
    style, script = (
        base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in (css, js)
    )
    return (
        f"default-src 'none'; script-src 'sha256-{script}'; style-src-elem 'sha256-{style}'; "
        "style-src-attr 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'"
    )


def _summary(cases: Sequence[Case]) -> Iterator[str]:
    count = Counter(row.verdict for case in cases for row in case.claims)
    yield '<ul class="counts">'
    for verdict in VERDICTS:
        yield f'<li><span class="{LEADS[verdict]} verdict">{count[verdict]}</span> {verdict}</li>'
    yield "</ul>"
    for case in cases:
        if case.status:
            reason = "a loop diverged unexpectedly" if case.status == 3 else "a verdict has changed"
            yield f'<p class="bad">{_link(case)}: {reason}.</p>'


def _filters(cases: Sequence[Case]) -> Iterator[str]:
    chapters = list(dict.fromkeys(case.chapter for case in cases if case.chapter))
    yield '<form id="filters" class="filters" role="search" hidden>'
    yield '<label>Search <input id="query" type="search" placeholder="words, or press /"></label>'
    yield '<label>Verdict <select id="verdict"><option value="">all</option>'
    yield from (f"<option>{verdict}</option>" for verdict in VERDICTS)
    yield "</select></label>"
    yield '<label>Chapter <select id="chapter"><option value="">all</option>'
    yield from (f"<option>{chapter}</option>" for chapter in chapters)
    yield '</select></label><output id="count" aria-live="polite"></output></form>'


def _claims(cases: Sequence[Case]) -> Iterator[str]:
    yield '<table id="claims" class="claims"><caption>All claims and their verdicts</caption>'
    heads = "".join(f'<th scope="col">{head}</th>' for head in COLUMNS)
    yield f"<thead><tr>{heads}</tr></thead><tbody>"
    for case in cases:
        for row in case.claims:
            entries = [
                _link(case),
                *map(words, (row.text, row.claimed, row.measured)),
                _verdict(row),
            ]
            told = "".join(
                f'<td data-l="{head}"><div>{entry}</div></td>'
                for head, entry in zip(COLUMNS, entries, strict=True)
            )
            yield (
                f'<tr data-case="{case.anchor}" data-chapter="{case.chapter}" '
                f'data-verdict="{row.verdict}">{told}</tr>'
            )
    yield "</tbody></table>"


def _verdict(row: ClaimRow) -> str:
    told = f'<span class="{LEADS.get(row.verdict, "bad")} verdict">{words(row.verdict)}</span>'
    if row.correction:
        told += f'<br><span class="quiet">{words(row.correction)}</span>'
    if row.reason:
        told += f'<br><span class="quiet">{words(row.reason)}</span>'
    if row.was:
        told += f'<br><span class="bad">was: {words(row.was)}</span>'
    return told


def _link(case: Case) -> str:
    return f'<a href="#{case.anchor}">{words(case.id)}</a>'


def _section_of(case: Case, wrong: Sequence[Erratum], heading: str) -> str:
    own = [entry for entry in wrong if f"Example {case.id}" in entry.named]
    lines = [
        f'<section class="case" id="{case.anchor}" data-chapter="{case.chapter}">',
        f"<h2>{words(heading)}</h2>",
        *told_of(case),
        case.body,
        *_pictures(case),
    ]
    if case.details:
        lines += ["<details><summary>Runs and controller</summary>", case.details, "</details>"]
    if own:
        links = ", ".join(f'<a href="#erratum-{entry.name}">{entry.name}</a>' for entry in own)
        lines.append(f'<p class="quiet">Errata of this example: {links}.</p>')
    return "\n".join([*lines, "</section>"])


def _pictures(case: Case) -> Iterator[str]:
    if case.pictures:
        yield '<div class="figures">'
        yield from map(picture_html, case.pictures)
        yield "</div>"


def _errata_at(cases: Sequence[Case]) -> list[Erratum]:
    """The errata of the examples, and of the equations that their sources name."""
    named = {f"Example {case.id}" for case in cases}
    cited = {number for case in cases for number in _EQUATION.findall(case.source)}
    return [
        entry for entry in find_errata() if named & set(entry.named) or cited & set(entry.equations)
    ]


def _errata(entries: Sequence[Erratum]) -> Iterator[str]:
    if not entries:
        return
    yield "<h2>Errata of the text</h2>"
    for entry in entries:
        yield f'<section id="erratum-{entry.name}"><h3>{words(entry.where)}</h3><dl>'
        for name, told in (
            ("printed", entry.printed),
            ("true", entry.true),
            ("evidence", entry.evidence.words),
        ):
            yield f"<div><dt>{name}</dt><dd>{words(told)}</dd></div>"
        yield "</dl></section>"


def _made_with(cases: Sequence[Case]) -> Iterator[str]:
    versions = ", ".join(f"{name} {version(name)}" for name in NAMED)
    yield f'<h2>How this page was made</h2><p class="quiet">{words(versions)}.</p><dl>'
    for case in cases:
        if case.settings:
            yield f"<div><dt>{_link(case)}</dt><dd>{words(case.settings)}</dd></div>"
    yield "</dl>"


# What a page opens with, for a reader who does not know the dissertation.

LEAD = (
    "Retrospective cost adaptive control (RCAC) changes the coefficients of a discrete-time "
    "controller at every step, by recursive least squares, so that the loop comes near to a target "
    "model that the designer has chosen. A dissertation shows what it can do on numbered examples. "
    "Each of them was run again from what the text prints, and each thing that the text says of it "
    "was made a check with a tolerance. Below stand what was claimed, what was measured, and, "
    "where the two differ, why. A verdict is computed from the runs; none is typed in."
)
MEANINGS = {
    REPRODUCED: "the claim holds for the settings that the text prints",
    CORRECTED: "it holds once something in the text is read differently, or what it leaves out is "
    "filled in; the correction stands beside the verdict",
    NOT_REPRODUCED: "it does not hold, and the reason stands beside the verdict",
    ILL_POSED: "the last digits of the data decide, so that neither is true",
}
PHRASES = {
    REPRODUCED: "true as the text has it",
    CORRECTED: "true with a correction",
    NOT_REPRODUCED: "not true",
    ILL_POSED: "decided by rounding alone",
}
LETTERS = {
    "k, q": "the step, and the forward shift: q y(k) = y(k + 1)",
    "y, u, z": "what is measured, what is applied, and the performance that is to be small",
    "w; r, d, v": "all that acts from outside: a command, a disturbance, the noise of a sensor",
    "G": "the plant; G_zu is its transfer function from u to z",
    "theta": "the coefficients of the controller; n_c is its order, and theta(k) changes from step "
    "k_w on",
    "R_theta, R_u": "weights that hold theta and u back; lambda below 1 forgets old data",
    "G_f": "the target model. It holds the nonminimum-phase zeros of G_zu, those outside the unit "
    "circle, which RCAC has to know; (2.49) holds none, (2.50) these",
    "intercalated transfer function": "what the loop answers at z to an injection into the "
    "controller; RCAC fits it to G_f",
    "LQG": "the optimal controller for white noise, with the plant known; of high authority where "
    "u costs nothing. H2 cost: the mean square of z that white noise makes",
    "frozen": "with the coefficients of one step kept, as a fixed controller",
}


def opening() -> Iterator[str]:
    """What the verdicts and the letters mean."""
    yield "<details><summary>What the verdicts and the letters mean</summary><dl>"
    for name, told in (*MEANINGS.items(), *LETTERS.items()):
        yield f"<div><dt>{words(name)}</dt><dd>{words(told)}.</dd></div>"
    yield "</dl></details>"


def told_of(case: Case) -> Iterator[str]:
    """What is so of a case, in sentences: how many claims hold, and why the others do not."""
    count = Counter(row.verdict for row in case.claims)
    if not case.claims:
        return
    of = len(case.claims)
    said = ", ".join(f"{count[v]} {phrase}" for v, phrase in PHRASES.items() if count[v])
    yield f'<p class="told">Of {of} claim{"s" if of > 1 else ""}: {said}.</p>'
    corrections = dict.fromkeys(
        row.correction for row in case.claims if row.verdict == CORRECTED and row.correction
    )
    if corrections:
        yield f'<p class="told">Read differently: {words("; ".join(corrections))}.</p>'
    lost = [row for row in case.claims if row.verdict in (NOT_REPRODUCED, ILL_POSED)]
    if lost:
        yield '<p class="told">What does not hold, and why:</p><ul class="told">'
        yield from (f"<li>{told}</li>" for told in _lost(lost))
        yield "</ul>"


def _lost(rows: Iterable[ClaimRow]) -> Iterator[str]:
    """What is claimed, of which variants it does not hold, and why; each claim once."""
    variants: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        variants.setdefault((row.text, row.reason), []).append(row.run)
    for (text, reason), runs in variants.items():
        named = [run for run in runs if run]
        where = f" (Run {', '.join(named)}.)" if named else ""
        because = f" <strong>But</strong> {words(reason)}." if reason else ""
        yield f"{words(text + where)}{because}"
