"""The errata as a page, made from the data that `rcac errata` lists."""

import re
from pathlib import Path

import rcac_experiments.dissertation
from rcac_experiments.dissertation._entries import KINDS, Erratum
from rcac_experiments.dissertation._reading import find_errata

CHAPTERS = Path(rcac_experiments.dissertation.__file__).parent / "errata_files"
HEADINGS = {
    "1": "Chapter 1: plants that are hard to control",
    "2": "Chapter 2: the controller and its update",
    "3": "Chapter 3: the aircraft",
    "4": "Chapter 4: target models, LQG, pole placement",
    "5": "Chapter 5: changes of the plant",
    "6": "Chapter 6: stable controllers",
    "7": "Chapter 7: observer-based compensators",
    "8": "Chapter 8: parameter estimation",
    "9": "Chapter 9: future work",
    "A": "Appendix A: LQG and high-authority LQG",
    "B": "Appendix B: the Sylvester resultant",
}


def errata_page() -> str:
    """All errata as Markdown, by chapter, each with an anchor of its own."""
    entries = find_errata()
    lines = [f"- **{kind}**: {words}; {_count(entries, kind)}." for kind, words in KINDS.items()]
    for chapter, heading in HEADINGS.items():
        if not any(entry.chapter == chapter for entry in entries):
            continue
        lines += ["", f"## {heading}"]
        for entry in entries:
            if entry.chapter == chapter:
                lines += ["", *_entry(entry)]
    return "\n".join(lines) + "\n"


def _entry(entry: Erratum) -> list[str]:
    return [
        f"(erratum-{entry.name})=",
        f"### {escaped(entry.where)}",
        "",
        f"`{entry.name}`, {entry.kind}",
        "",
        f"Printed: {escaped(entry.printed)}",
        "",
        f"> {escaped(entry.true)}",
        "",
        f"Read with charity: {escaped(entry.charity)}",
        "",
        _evidence(entry),
    ]


def _evidence(entry: Erratum) -> str:
    evidence = entry.evidence
    if evidence.check:
        module, _, function = evidence.check.partition(".")
        where = f"rcac_experiments.dissertation.{module}.{function}"
        return f"Shown by a check that runs: {{py:func}}`{where}`."
    if evidence.ledger:
        case = f", refuted by `{evidence.counterexample}`" if evidence.counterexample else ""
        return f"In the ledger of proofs: {{ref}}`{evidence.ledger} <{evidence.ledger}>`{case}."
    return f'Shown by Example {evidence.example}, "{escaped(evidence.claim)}".'


def _count(entries: tuple[Erratum, ...], kind: str) -> int:
    return sum(entry.kind == kind for entry in entries)


def escaped(text: str) -> str:
    """The text without what Markdown would read as markup."""
    return re.sub(r"([\\`*_\[\]<>$|#~^])", r"\\\1", text)
