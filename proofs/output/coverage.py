"""Which equations of the text stand in the ledger, in which strength, and which do not, and why."""

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from ..ledger.entries import Entry
from ..ledger.ledger import LedgerError

FILE = Path(__file__).parents[1] / "unproved.toml"
_NUMBER = r"([1-9AB])\.([1-9]\d{0,2})"
_RANGE = re.compile(rf"\({_NUMBER}\)(?:-\({_NUMBER}\))?")
_STRENGTHS = ("Coq", "Coq in part", "identity", "property")


@dataclass(frozen=True)
class Covered:
    """Where an equation stands.

    Attributes
    ----------
    number : str
    strength : str
        ``Coq`` where every sentence of some statement about it has a theorem, ``Coq in part`` where
        some sentence has, ``identity``, ``property``, or ``none``.
    entries : tuple of str
        The statements that name it as their source.
    why : str
        Why there is none.
    """

    number: str
    strength: str
    entries: tuple[str, ...] = ()
    why: str = ""


def numbers(text: str) -> Iterator[str]:
    """List the numbers of equations in a text, those of a range included.

    Examples
    --------
    >>> from proofs.output.coverage import numbers
    >>> list(numbers("(8.98)-(8.100), after (A.12)"))
    ['8.98', '8.99', '8.100', 'A.12']
    """
    for chapter, first, other, last in _RANGE.findall(text):
        stop = int(last) if last and other == chapter else int(first)
        yield from (f"{chapter}.{i}" for i in range(int(first), stop + 1))


def strength(entry: Entry) -> str:
    """Say which evidence a statement names, before anything is run.

    Examples
    --------
    >>> from proofs.ledger.ledger import select
    >>> from proofs.output.coverage import strength
    >>> strength(select(["lemma-1"])[0]), strength(select(["cross-weight"])[0])
    ('Coq', 'identity')
    """
    sentences = set(range(1, len(entry.conclusion) + 1))
    proved = {n for theorem in entry.formal for n in theorem.of}
    if proved:
        return "Coq" if proved == sentences else "Coq in part"
    return "identity" if entry.symbolic else "property"


def unproved(path: Path = FILE) -> dict[str, str]:
    """Read why equations are in no statement.

    Raises
    ------
    LedgerError
        If one has two reasons.

    Examples
    --------
    >>> from proofs.output.coverage import unproved
    >>> unproved()["1.1"]
    'data of an example: numbers, nothing to prove'
    """
    reasons: dict[str, str] = {}
    for group in tomllib.loads(path.read_text(encoding="utf-8"))["group"]:
        for item in group["equations"]:
            first, _, last = item.partition("-")
            for number in numbers(f"({first})-({last})" if last else f"({first})"):
                if number in reasons:
                    raise LedgerError(f"{path.name} gives two reasons for ({number})")
                reasons[number] = group["why"]
    return reasons


def coverage(used: Iterable[str], entries: Iterable[Entry]) -> tuple[Covered, ...]:
    """Say of each equation that the software uses where it stands.

    Raises
    ------
    LedgerError
        If one is neither in a statement nor has a reason, or has both, or a reason is given for one
        that is not used.

    Examples
    --------
    >>> from proofs.ledger.ledger import ledger
    >>> from proofs.output.coverage import coverage, unproved
    >>> equations = coverage(["2.43", *unproved()], ledger())
    >>> equations[0].strength, equations[0].entries[0]
    ('Coq', 'least-squares-update')
    """
    used, reasons = tuple(used), unproved()
    about: dict[str, list[Entry]] = {}
    for entry in entries:
        for number in numbers(entry.source):
            about.setdefault(number, []).append(entry)
    nowhere = [n for n in used if n not in about and n not in reasons]
    twice = [n for n in reasons if n in about]
    unused = [n for n in reasons if n not in used]
    if nowhere or twice or unused:
        raise LedgerError(
            f"proofs/unproved.toml lacks a reason for {nowhere or 'nothing'}, has one for {twice} "
            f"that statements are about, and for {unused} that nothing uses"
        )
    return tuple(_covered(number, about, reasons) for number in used)


def _covered(number: str, about: Mapping[str, list[Entry]], reasons: Mapping[str, str]) -> Covered:
    if number not in about:
        return Covered(number, "none", why=reasons[number])
    best = min((strength(entry) for entry in about[number]), key=_STRENGTHS.index)
    return Covered(number, best, tuple(entry.name for entry in about[number]))


def table(equations: Iterable[Covered], computed_by: Mapping[str, Iterable[str]]) -> str:
    """Write the coverage as Markdown: how many in which strength, then every equation.

    Parameters
    ----------
    equations : iterable of Covered
    computed_by : dict of iterable of str
        For each equation the public names whose documentation cites it.
    """
    equations = tuple(equations)
    counts = {words: sum(c.strength == words for c in equations) for words in (*_STRENGTHS, "none")}
    lines = ["| strength | equations |", "|---|---|"]
    lines += [f"| {words} | {count} |" for words, count in counts.items()]
    lines += ["", f"Of {len(equations)} equations that the software uses.", ""]
    lines += [
        "| equation | strength | statements, or why none | computed by |",
        "|---|---|---|---|",
    ]
    for c in equations:
        where = ", ".join(f"[{name}](#{name})" for name in c.entries) or c.why
        names = ", ".join(f"`{name.partition('.')[2]}`" for name in computed_by.get(c.number, ()))
        lines.append(f"| ({c.number}) | {c.strength} | {where} | {names} |")
    return "\n".join(lines)
