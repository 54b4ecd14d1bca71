"""The ledger on a terminal."""

from collections import Counter
from collections.abc import Iterable

from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..formal.rocq_build import Compilation
from ..ledger.entries import Entry
from ..ledger.outcomes import Outcome, Verified

_COLOURS = {"holds": "green", "fails": "bold red", "not compiled": "yellow", "missing": "yellow"}
_KINDS = {
    "formal": "Coq",
    "symbolic": "identity",
    "property": "property",
    "counterexample": "refuted",
    "refutation": "  in Coq",
}


def print_ledger(console: Console, verified_entries: Iterable[Verified]) -> None:
    """Print every entry: its statement, the text's, and the evidence.

    Examples
    --------
    >>> from rich.console import Console
    >>> from proofs.ledger.ledger import select
    >>> from proofs.output.printing import print_ledger
    >>> from proofs.formal.rocq_build import NOT_COMPILED
    >>> from proofs.ledger.verification import verify
    >>> print_ledger(Console(width=80), verify(select(["lemma-1"]), NOT_COMPILED, quick=True))
    <BLANKLINE>
    lemma-1  Lemma 1 ...
    """
    for verified in verified_entries:
        entry = verified.entry
        console.print()
        heading = Text.assemble(
            (entry.name, "bold"), "  ", entry.title, (f"  {entry.source}", "dim")
        )
        console.print(heading)
        words = {
            "if": "; ".join(entry.hypotheses),
            "then": " ".join(entry.conclusion),
            "text": entry.text,
            "but": entry.difference,
        }
        statement = _grid()
        for label, text in words.items():
            if text:
                statement.add_row("", Text(label, "dim"), Text(text))
        evidence = _grid()
        for outcome in verified.outcomes:
            evidence.add_row("", *_words(outcome))
        console.print(statement, evidence, sep="\n")


def print_summary(
    console: Console, verified_entries: Iterable[Verified], compilation: Compilation, *, quick: bool
) -> None:
    """Print how many entries have which evidence, what failed, and what was not done.

    Examples
    --------
    >>> from rich.console import Console
    >>> from proofs.output.printing import print_summary
    >>> from proofs.formal.rocq_build import NOT_COMPILED
    >>> print_summary(Console(width=80), [], NOT_COMPILED, quick=False)
    <BLANKLINE>
    0 entries
    The formal part was not compiled in this run; --formal does.
    """
    verified_entries = tuple(verified_entries)
    strengths = Counter(verified.strength for verified in verified_entries)
    parts = [f"{count} {words}" for words, count in strengths.most_common()]
    console.print()
    entries = "1 entry" if len(verified_entries) == 1 else f"{len(verified_entries)} entries"
    console.print(entries + (": " if parts else "") + ", ".join(parts))
    if quick:
        console.print("Quick: a tenth of the examples, all sizes but the largest.")
    detail = compilation.detail
    console.print(Text(f"{detail[0].upper()}{detail[1:]}."))
    absent = sorted({o.name for v in verified_entries for o in v.outcomes if o.status == "missing"})
    if absent:
        console.print(Text(f"Named but not in proofs/rocq: {', '.join(absent)}."))
    failed = [(v, o) for v in verified_entries for o in v.outcomes if o.status == "fails"]
    for verified, outcome in failed:
        text = f"FAILS  {verified.entry.name}: {outcome.name}: {outcome.detail}"
        console.print(Text(text, "bold red"))


def print_names(console: Console, entries: Iterable[Entry]) -> None:
    """Print chapter, name and title of each entry.

    Examples
    --------
    >>> from rich.console import Console
    >>> from proofs.ledger.ledger import select
    >>> from proofs.output.printing import print_names
    >>> print_names(Console(width=80), select(["lemma-1"]))
    7  lemma-1                        Lemma 1
    """
    for entry in entries:
        console.print(
            f"{entry.chapter}  {entry.name:30} {entry.title}", highlight=False, soft_wrap=True
        )


def _grid() -> Table:
    """Make columns whose last one wraps within itself."""
    grid = Table.grid(padding=(0, 1))
    grid.add_column(width=1)
    grid.add_column(no_wrap=True)
    return grid


def _words(outcome: Outcome) -> tuple[Text, Text, Text]:
    colour = _COLOURS[outcome.status]
    statement = f": {outcome.statement}" if outcome.statement else ""
    text = Text.assemble(
        f"{outcome.name}{statement}",
        (f" ({outcome.scope})" if outcome.scope else "", "dim"),
        (f" [{outcome.detail}]" if outcome.detail else "", colour),
        overflow="fold",  # a name that is cut cannot be looked up
    )
    return Text(outcome.status, colour), Text(_KINDS[outcome.kind]), text
