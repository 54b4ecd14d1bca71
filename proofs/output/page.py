"""The ledger as a page of the documentation."""

from collections.abc import Iterable, Iterator, Mapping

from ..formal.rocq_sources import stated
from ..formal.types import committed
from ..ledger.checks import resolve, statement_of
from ..ledger.entries import Entry
from ..ledger.ledger import ledger
from .blueprint import dependencies, printed_type, whereabouts
from .coverage import strength
from .formulas import escaped, with_formulas

_CHAPTERS = {
    "2": "Chapter 2: the controller and its update",
    "4": "Chapter 4: the intercalated transfer function",
    "7": "Chapter 7: which compensators are observer-based",
    "8": "Chapter 8: Riccati equations and least squares",
    "9": "Chapter 9: directions of zeros, the joint fit",
    "field": "The field: stability, all compensators, loops that vary in time",
    "A": "Appendix A: LQG and high-authority LQG",
    "B": "Appendix B: Sylvester resultants",
}


def page(entries: Iterable[Entry], errata: Mapping[str, Iterable[tuple[str, str]]] = {}) -> str:
    """Write the entries as Markdown, by chapter.

    Parameters
    ----------
    entries : iterable of Entry
    errata : dict of pairs of str, optional
        For an entry the names and places of the errata that it carries.

    Examples
    --------
    >>> from proofs.ledger.ledger import select
    >>> from proofs.output.page import page
    >>> print(page(select(["theorem-a2"])))  # doctest: +ELLIPSIS
    ## Appendix B: Sylvester resultants
    <BLANKLINE>
    (theorem-a2)=
    ### Theorem A2
    ...
    """
    entries = tuple(entries)
    needs = dependencies(ledger())
    lines: list[str] = []
    for chapter, heading in _CHAPTERS.items():
        of_chapter = [entry for entry in entries if entry.chapter == chapter]
        if of_chapter:
            lines += [f"## {heading}", ""]
            for entry in of_chapter:
                lines += [*_entry(entry, errata.get(entry.name, ())), ""]
                lines += [*_neighbours(entry.name, needs), ""]
    return "\n".join(lines)


def _entry(entry: Entry, errata: Iterable[tuple[str, str]]) -> Iterator[str]:
    yield f"({entry.name})="  # so that other pages can link to it
    yield f"### {escaped(entry.title)}"
    yield ""
    yield f"`{entry.name}`, {escaped(entry.source)}; evidence: {strength(entry)}"
    yield ""
    if entry.hypotheses:
        yield f"Hypotheses: {'; '.join(map(with_formulas, entry.hypotheses))}. Then:"
        yield ""
    if len(entry.conclusion) == 1:
        yield f"> {with_formulas(entry.conclusion[0])}"
    else:
        yield from (f"> {i}. {with_formulas(s)}" for i, s in enumerate(entry.conclusion, start=1))
    yield ""
    yield f"The text: {with_formulas(entry.text)}"
    if entry.difference:
        yield ""
        yield f"The difference: {with_formulas(entry.difference)}"
    yield ""
    yield "Evidence:"
    yield ""
    yield from _formal(entry)
    for identity in entry.symbolic:
        words = statement_of(resolve("symbolic", identity.check))
        yield f"- identity (`{identity.check}`; {identity.scope}): {with_formulas(words)}"
    for claim in entry.properties:
        check = resolve("properties", claim.check)
        yield (
            f"- property (`{claim.check}`; {claim.examples} examples of {escaped(check.drawn)}): "
            f"{with_formulas(check.statement)}"
        )
    for case in entry.counterexamples:
        words = statement_of(resolve("counterexamples", case.check))
        label = "false" if case.in_text else "false, and not said by the text"
        yield f'- {label}: "{with_formulas(case.refutes)}" (`{case.check}`). {with_formulas(words)}'
        if case.formal is not None:
            yield f"  In Coq: `{case.formal}`{'' if stated(case.formal) else ', not there yet'}."
    yield ""
    if carried := [f"[{escaped(where)}](#erratum-{name})" for name, where in errata]:
        yield "Errata: " + ", ".join(carried) + "."
        yield ""
    yield "Relied on by " + ", ".join(f"`{name}`" for name in entry.relied_on_by) + "."


def _neighbours(name: str, needs: Mapping[str, list[str]]) -> Iterator[str]:
    """Link the statements whose theorems this one's rest on, and those that rest on it."""
    used = [other for other, others in needs.items() if name in others]
    for words, others in (("Rests on", needs[name]), ("Used by", used)):
        if others:
            yield f"{words} " + ", ".join(f"[{other}](#{other})" for other in others) + "."
            yield ""


def _formal(entry: Entry) -> Iterator[str]:
    types = committed()
    for theorem in entry.formal:
        says = f", {escaped(theorem.says)}" if theorem.says else ""
        if len(entry.conclusion) > 1:
            says += f"; sentence {', '.join(map(str, theorem.of))}"
        statement = stated(theorem.theorem)
        if not statement:
            yield f"- Coq (`{theorem.theorem}`{says}): not there yet"
            continue
        yield f"- Coq (`{theorem.theorem}`{says}):"
        yield ""
        yield "  ```coq"
        yield from (f"  {line}" for line in statement.splitlines())
        yield "  ```"
        yield ""
        yield f"  <details><summary>{whereabouts(theorem.theorem)}: as Coq prints it</summary>"
        yield "  " + printed_type(theorem.theorem, types).replace("\n", "&#10;")
        yield "  </details>"
        yield ""
