"""The ledger, read from the files in ``statements``; needs the standard library only."""

import tomllib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from .entries import Counterexample, Entry, Formal, Property, Symbolic

STATEMENTS = Path(__file__).parents[1] / "statements"
_WORDS = ("title", "source", "conclusion", "text")
_EVIDENCE = ("formal", "symbolic", "property", "counterexample")


class LedgerError(ValueError):
    """A file in ``statements`` is not part of a ledger, or the ledger has no such entry."""


@cache
def ledger() -> tuple[Entry, ...]:
    """Read every entry: chapters before appendices, in the order of the files and within them.

    Examples
    --------
    >>> from proofs.ledger.ledger import ledger
    >>> next(entry.source for entry in ledger() if entry.name == "lemma-1")
    'Lemma 1'
    """
    found: list[Entry] = []
    for path in sorted(STATEMENTS.glob("*.toml"), key=lambda p: (p.stem < "chapter", p.stem)):
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except tomllib.TOMLDecodeError as error:
            raise LedgerError(f"{path.name} is not TOML: {error}") from error
        if not {"chapter", "entry"} <= set(data):
            raise LedgerError(f"{path.name} needs the keys chapter and entry")
        found += [_entry(data["chapter"], table, path.name) for table in data["entry"]]
    return tuple(found)


def select(names: Iterable[str]) -> tuple[Entry, ...]:
    """Return the entries of the given chapters and names, all of them for none.

    Raises
    ------
    LedgerError
        If a name is neither a chapter nor an entry.

    Examples
    --------
    >>> from proofs.ledger.ledger import select
    >>> [entry.name for entry in select(["B"])]
    ['theorem-a1', 'theorem-a2', 'resultant-determinants']
    """
    wanted = {name.lower() for name in names}
    known = {key.lower() for entry in ledger() for key in (entry.name, entry.chapter)}
    if not wanted <= known:
        chapters = sorted({entry.chapter for entry in ledger()})
        raise LedgerError(
            f"the ledger has no entry or chapter {', '.join(sorted(wanted - known))}; chapters are "
            f"{', '.join(chapters)}, and --list shows the names"
        )
    if not wanted:
        return ledger()
    return tuple(e for e in ledger() if wanted & {e.name.lower(), e.chapter.lower()})


def theorems(entries: Iterable[Entry]) -> tuple[str, ...]:
    """List the theorems of the formal part that entries name, each once.

    Examples
    --------
    >>> from proofs.ledger.ledger import ledger, theorems
    >>> "theorems.Diophantine.lemma_1" in theorems(ledger())
    True
    """
    return tuple(dict.fromkeys(name for entry in entries for name in entry.theorems))


def _entry(chapter: str, table: dict[str, Any], where: str) -> Entry:
    allowed = {"name", "hypotheses", "difference", "relied_on_by", *_WORDS, *_EVIDENCE}
    needed = allowed - {"difference", *_EVIDENCE}
    named = f"{where}: the entry {table.get('name', '(without a name)')}"
    if not allowed >= set(table) or not needed <= set(table):
        raise LedgerError(
            f"{named} has the unknown keys {sorted(set(table) - allowed)} and lacks "
            f"{sorted(needed - set(table))}; known are {sorted(allowed)}"
        )
    words: dict[str, Any] = {key: _flowed(table[key]) for key in _WORDS}
    try:
        evidence = _evidence(table)
    except TypeError as error:  # a key that the evidence does not have, or one that it lacks
        raise LedgerError(f"{named}: {error}") from error
    return Entry(
        name=table["name"],
        chapter=chapter,
        hypotheses=tuple(map(_flowed, table["hypotheses"])),
        difference=_flowed(table.get("difference", "")),
        relied_on_by=tuple(table["relied_on_by"]),
        **words,
        **evidence,
    )


def _evidence(table: dict[str, Any]) -> dict[str, Any]:
    """Read the evidence that an entry names."""
    symbolic = (t | {"sizes": tuple(t.get("sizes", ()))} for t in table.get("symbolic", ()))
    return {
        "formal": tuple(Formal(**t) for t in table.get("formal", ())),
        "symbolic": tuple(Symbolic(**t) for t in symbolic),
        "properties": tuple(Property(**t) for t in table.get("property", ())),
        "counterexamples": tuple(Counterexample(**t) for t in table.get("counterexample", ())),
    }


def _flowed(text: str) -> str:
    """Join the lines of a text."""
    return " ".join(text.split())
