"""The ledger, read from the files in ``statements``; needs the standard library only."""

import tomllib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from .entries import Counterexample, Entry, Formal, Property, Symbolic

STATEMENTS = Path(__file__).parents[1] / "statements"
_WORDS = ("title", "source", "text")
LEAST_EXAMPLES = 10
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
    return read(STATEMENTS)


def read(folder: Path) -> tuple[Entry, ...]:
    """Read every entry of a folder of statements.

    Raises
    ------
    LedgerError
        If a file is not TOML or lacks something, a sentence has no evidence, or a property has too
        few examples to say anything.
    """
    entries: list[Entry] = []
    for path in sorted(folder.glob("*.toml"), key=lambda p: (p.stem < "chapter", p.stem)):
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except tomllib.TOMLDecodeError as error:
            raise LedgerError(f"{path.name} is not TOML: {error}") from error
        if not {"chapter", "entry"} <= set(data):
            raise LedgerError(f"{path.name} needs the keys chapter and entry")
        entries += [_entry(data["chapter"], table, path.name) for table in data["entry"]]
    return tuple(entries)


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
    lower = {name.lower() for name in names}
    known = {key.lower() for entry in ledger() for key in (entry.name, entry.chapter)}
    if not lower <= known:
        chapters = sorted({entry.chapter for entry in ledger()})
        raise LedgerError(
            f"the ledger has no entry or chapter {', '.join(sorted(lower - known))}; chapters are "
            f"{', '.join(chapters)}, and --list shows the names"
        )
    if not lower:
        return ledger()
    return tuple(e for e in ledger() if lower & {e.name.lower(), e.chapter.lower()})


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
    allowed = {
        "name",
        "hypotheses",
        "conclusion",
        "difference",
        "relied_on_by",
        *_WORDS,
        *_EVIDENCE,
    }
    needed = allowed - {"difference", *_EVIDENCE}
    named = f"{where}: the entry {table.get('name', '(without a name)')}"
    if not allowed >= set(table) or not needed <= set(table):
        raise LedgerError(
            f"{named} has the unknown keys {sorted(set(table) - allowed)} and lacks "
            f"{sorted(needed - set(table))}; known are {sorted(allowed)}"
        )
    words: dict[str, Any] = {key: _flowed(table[key]) for key in _WORDS}
    sentences = table["conclusion"]
    conclusion = tuple(map(_flowed, [sentences] if isinstance(sentences, str) else sentences))
    try:
        evidence = _evidence(table)
    except TypeError as error:  # a key that the evidence does not have, or one that it lacks
        raise LedgerError(f"{named}: {error}") from error
    _refuse_gaps(named, table, len(conclusion), evidence)
    return Entry(
        name=table["name"],
        chapter=chapter,
        conclusion=conclusion,
        hypotheses=tuple(map(_flowed, table["hypotheses"])),
        difference=_flowed(table.get("difference", "")),
        relied_on_by=tuple(table["relied_on_by"]),
        **words,
        **evidence,
    )


def _evidence(table: dict[str, Any]) -> dict[str, Any]:
    """Read the evidence that an entry names."""

    def tables(key: str) -> list[dict[str, Any]]:
        lists = ("of", "sizes")
        return [
            {k: tuple(v) if k in lists else v for k, v in t.items()} for t in table.get(key, ())
        ]

    return {
        "formal": tuple(Formal(**t) for t in tables("formal")),
        "symbolic": tuple(Symbolic(**t) for t in tables("symbolic")),
        "properties": tuple(Property(**t) for t in tables("property")),
        "counterexamples": tuple(Counterexample(**t) for t in tables("counterexample")),
    }


def _refuse_gaps(
    named: str, table: dict[str, Any], sentences: int, evidence: dict[str, Any]
) -> None:
    """Refuse sentences without evidence, and properties that try next to nothing."""
    about = {
        number
        for kind in ("formal", "symbolic", "properties")
        for piece in evidence[kind]
        for number in piece.of
    }
    if about != set(range(1, sentences + 1)):
        raise LedgerError(
            f"{named} has {sentences} sentences in its conclusion and evidence for the sentences "
            f"{sorted(about)}; say of each piece of evidence, with of = [...], which it is about"
        )
    if sentences > 1:
        for key in ("formal", "symbolic", "property"):
            for t in table.get(key, ()):
                if "of" not in t:
                    raise LedgerError(
                        f"{named}: {t} does not say of which sentences it is evidence"
                    )
    for claim in evidence["properties"]:
        if claim.examples < LEAST_EXAMPLES or not 0 < claim.kept <= 1:
            raise LedgerError(
                f"{named}: {claim.check} needs at least {LEAST_EXAMPLES} examples and keeps a "
                "share between 0 and 1 of what is drawn"
            )


def _flowed(text: str) -> str:
    """Join the lines of a text."""
    return " ".join(text.split())
