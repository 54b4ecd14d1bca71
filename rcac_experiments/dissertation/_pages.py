"""The pages of the dissertation's examples: origin and verdict of each claim, with its place."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from rcac_experiments.dissertation._entries import KINDS, Erratum
from rcac_experiments.dissertation._reading import find_errata
from rcac_experiments.dissertation._typesetting import typeset, typeset_quotes
from rcac_experiments.judging._claim import (
    CLASSES,
    DEPENDS,
    MISPRINT,
    NOT_REPRODUCED,
    OUTCOMES,
    READING,
    REPRODUCED,
    TEXT,
    UNDETERMINED,
    VERDICTS,
)
from rcac_experiments.reports._cases import Case, ClaimRow, case_page, versions_of
from rcac_numeric.reports._rendering import whole_page

HOME = "rcac_experiments.dissertation"
# Whose work it is. The text that we worked from names neither year nor repository.
WORK = {
    "title": "Intercalated Injection, Target Model Construction and H2 Performance of "
    "Retrospective Cost Adaptive Control",
    "author": "Y. Rahman",
    "kind": "doctoral dissertation",
    "year": "year not printed in our copy",
}
CHAPTERS = {
    "1": "Introduction", "2": "Retrospective cost adaptive control",
    "3": "Aircraft with a transition to nonminimum-phase dynamics",
    "4": "Target models and H2 performance", "5": "Robustness to unmodeled changes",
    "6": "Quasi-FIR controllers", "7": "Observer-based compensators",
    "8": "Parameter estimation by retrospective cost model refinement", "9": "Future work",
    "A": "High-authority LQG", "B": "Resultants",
}  # fmt: skip
LEVELS = {REPRODUCED: "good", MISPRINT: "good", DEPENDS: "warning", NOT_REPRODUCED: "warning"}
LEAD = (
    "Retrospective cost adaptive control (RCAC) changes the coefficients of a discrete-time "
    "controller at every step, by recursive least squares, so that the loop comes near to a target "
    "model of the designer. The dissertation demonstrates RCAC on numbered examples. Each example "
    "was "
    "simulated again from the printed data. A check decides each quoted sentence of the text; for "
    "settings that the text leaves open, plausible values were simulated. All verdicts are "
    "computed "
    "from the runs."
)
LETTERS = {
    "k, q": "the step, and the forward shift: q y(k) = y(k + 1)",
    "y, u, z": "measured output, control input, and performance variable, which RCAC drives to "
    "zero",
    "w; r, d, v": "exogenous input: command, disturbance, sensor noise",
    "G": "the plant; G_zu is its transfer function from u to z",
    "theta": "the coefficients of the controller; n_c is its order, and theta(k) changes from step "
    "k_w on",
    "R_theta, R_u": "weights on the change of theta and on u; lambda below 1 forgets old data",
    "G_f": "the target model. It holds the nonminimum-phase zeros of G_zu, those outside the unit "
    "circle, which RCAC has to know; (2.49) holds none, (2.50) these",
    "intercalated transfer function": "the response at z to an injection into the "
    "controller; RCAC fits it to G_f",
    "LQG": "the optimal controller for white noise and a known plant; high authority means no "
    "weight on u. H2 cost: the mean square of z under white noise",
    "frozen": "with the coefficients of one step, as a fixed controller",
    "control": "a run on which the same checks must hold, so that a failure is significant",
}
_EQUATION = re.compile(r"\(([1-9AB]\.\d+)\)")


def example_page(case: Case) -> str:
    """Return the HTML page of one example."""
    return case_page(
        _set(case),
        template="example.html",
        home=HOME,
        work=WORK,
        errata=_errata_entries(_errata_at([case])),
    )


def gallery_page(
    cases: Sequence[Case],
    title: str = "The examples of the dissertation, simulated again",
    *,
    is_quick: bool = False,
) -> str:
    """Return the HTML page of several examples by chapter, with a table of all claims."""
    wrong = _errata_at(cases)
    cases = [_set(case) for case in cases]
    return whole_page(
        "gallery.html",
        HOME,
        title=title,
        work=WORK,
        lead=LEAD,
        is_quick=is_quick,
        cases=cases,
        failed=[case for case in cases if case.status],
        headline=headline(cases),
        classes=CLASSES,
        verdicts=VERDICTS,
        outcomes=OUTCOMES,
        letters=LETTERS,
        levels=LEVELS,
        chapters=_chapters(cases, wrong),
        errata=_errata_entries(wrong),
        kinds=KINDS,
        typeset=typeset,
        made=versions_of(cases),
    )


def _set(case: Case) -> Case:
    """Return the case with typeset formulas in its quotes."""
    return replace(case, body=str(typeset_quotes(case.body)))


def headline(cases: Iterable[Case]) -> dict[str, Counter[str]]:
    """Count the verdicts on sentences of the text and on interpretations.

    A sentence with several claims counts once, with the least favourable verdict.
    """
    worst: dict[tuple[str, ...], ClaimRow] = {}
    order = (REPRODUCED, MISPRINT, DEPENDS, UNDETERMINED, NOT_REPRODUCED)
    for case in cases:
        for row in case.claims:
            if row.owner in (TEXT, READING):
                key = (case.id, row.owner, row.quote, row.place)
                old = worst.get(key)
                if old is None or order.index(row.verdict) > order.index(old.verdict):
                    worst[key] = row
    count = {owner: Counter[str]() for owner in (TEXT, READING)}
    for row in worst.values():
        count[row.owner][row.verdict] += 1
    return count


def _chapters(cases: Sequence[Case], wrong: Sequence[Erratum]) -> list[dict[str, Any]]:
    """Return the cases by chapter; cases without a chapter come first."""
    chapters = []
    for number in dict.fromkeys(case.chapter for case in cases):
        cases_of_chapter = [case for case in cases if case.chapter == number]
        name = "Appendix" if number in ("A", "B") else "Chapter"
        title = f"{name} {number}: {CHAPTERS[number]}" if number else "Cases"
        examples = [
            {
                "case": case,
                "errata": _errata_of(case, wrong),
                "count": Counter(row.verdict for row in case.claims),
            }
            for case in cases_of_chapter
        ]
        counts = headline(cases_of_chapter)
        total = counts[TEXT] + counts[READING]
        chapters.append({"number": number, "title": title, "examples": examples, "count": total})
    return chapters


def _errata_of(case: Case, wrong: Iterable[Erratum]) -> list[str]:
    return [entry.name for entry in wrong if f"Example {case.id}" in entry.named]


def _errata_at(cases: Sequence[Case]) -> list[Erratum]:
    """Return the errata of the examples and of the equations in their sources."""
    named = {f"Example {case.id}" for case in cases}
    cited = {number for case in cases for number in _EQUATION.findall(case.source)}
    return [
        entry for entry in find_errata() if named & set(entry.named) or cited & set(entry.equations)
    ]


def _errata_entries(entries: Iterable[Erratum]) -> list[dict[str, str]]:
    return [
        {
            "name": entry.name,
            "where": entry.where,
            "kind": entry.kind,
            "printed": entry.printed,
            "true": entry.true,
            "charity": entry.charity,
            "evidence": entry.evidence.words,
        }
        for entry in entries
    ]
