"""What a page opens with, for a reader who does not know the dissertation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from rcac_numeric.experiments.claims import CORRECTED, ILL_POSED, NOT_REPRODUCED, REPRODUCED
from rcac_numeric.reports.page.cases import Case, ClaimRow
from rcac_numeric.reports.page.html import words

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
