"""Every numbered item of the text and where it stands, made from the claims, errata and proofs."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from docs.errata_page import escaped
from rcac_experiments.dissertation import find_errata, load_example
from rcac_experiments.dissertation._entries import KINDS
from rcac_experiments.dissertation._examples import example_ids
from rcac_experiments.judging._claim import (
    DEPENDS,
    MISPRINT,
    NOT_REPRODUCED,
    OURS,
    READING,
    REPRODUCED,
    TEXT,
    UNDETERMINED,
    Claim,
)

FILE = Path(__file__).with_suffix(".toml")
ORDER = (REPRODUCED, MISPRINT, DEPENDS, UNDETERMINED, NOT_REPRODUCED)


@dataclass(frozen=True)
class Item:
    """A numbered item of the text.

    Attributes
    ----------
    name : str
        ``Figure 3.1``.
    example : str
        The example whose claims decide its sentences.
    claims : tuple of Claim
    besides : mapping from sentences
        Those that no claim decides, with the reason.
    ledger : str
        Its entry in the ledger of proofs.
    is_diagram : bool
        Whether it states nothing that could be checked.
    """

    name: str
    example: str = ""
    claims: tuple[Claim, ...] = ()
    besides: tuple[tuple[str, str], ...] = ()
    ledger: str = ""
    is_diagram: bool = False

    @property
    def errata(self) -> tuple[str, ...]:
        """The names of the errata that name it."""
        return _named_by_errata().get(self.name, ())

    @property
    def is_settled(self) -> bool:
        """Whether a claim, a proof, or a reason why there is none stands with it."""
        return bool(self.claims or self.besides or self.ledger or self.is_diagram)


def items() -> list[Item]:
    """All of them: examples, figures and tables in order, then what is proved.

    Raises
    ------
    KeyError
        If a figure or a table of the text is in no list.
    ValueError
        If `states` is the beginning of no quote, or a list names what the text has not.
    """
    data = tomllib.loads(FILE.read_text("utf-8"))
    every_item = [*_examples(data), *_placed(data, "Figure"), *_placed(data, "Table")]
    return every_item + [Item(name, ledger=entry) for name, entry in data["ledger"].items()]


def table() -> str:
    """All items as a table in Markdown."""
    lines = ["| item | what is said with it, and where that stands |", "|---|---|"]
    return "\n".join([*lines, *(f"| {item.name} | {_cell(item)} |" for item in items())]) + "\n"


def counts() -> str:
    """How many claims have which verdict of record, by class, and how many errata which kind."""
    claims = [claim for number in example_ids() for claim in quoted_claims(number)]
    lines = [f"| | {' | '.join(ORDER)} |", "|---" * (len(ORDER) + 1) + "|"]
    for owner in (TEXT, READING):
        verdicts = [claim.recorded for claim in claims if claim.owner == owner]
        lines.append(
            f"| {owner} | {' | '.join(str(verdicts.count(verdict)) for verdict in ORDER)} |"
        )
    kinds = [entry.kind for entry in find_errata()]
    summary = ", ".join(f"{kinds.count(kind)} *{kind}*" for kind in KINDS)
    after = f"Errata: 129 before, 59 of them called false; {len(kinds)} after: {summary}."
    return "\n".join([*lines, "", after])


def _numbers(data: dict[str, Any], kind: str) -> list[str]:
    return [f"{c}.{i}" for c, last in data["last"][kind].items() for i in range(1, last + 1)]


def _examples(data: dict[str, Any]) -> Iterator[Item]:
    for number in _numbers(data, "Example"):
        besides = data["Example"].get(number, {}).get("besides", {})
        yield Item(f"Example {number}", number, _claims(number), tuple(besides.items()))


def _placed(data: dict[str, Any], kind: str) -> Iterator[Item]:
    of_kind = data[kind]
    diagrams = of_kind.get("diagrams", [])
    numbers = _numbers(data, kind)
    if extra := set(of_kind) - {"diagrams", *numbers} | set(diagrams) - set(numbers):
        raise ValueError(f"{FILE.name} has {kind} {', '.join(sorted(extra))}; the text has not")
    for number in numbers:
        if number in diagrams:
            yield Item(f"{kind} {number}", is_diagram=True)
            continue
        row = of_kind[number]
        claims = tuple(_named(row["example"], words) for words in row.get("states", []))
        besides = tuple(row.get("besides", {}).items())
        yield Item(f"{kind} {number}", row["example"], claims, besides)


@cache
def _named_by_errata() -> dict[str, tuple[str, ...]]:
    """From the items that errata name to the names of those errata."""
    errata: dict[str, tuple[str, ...]] = {}
    for entry in find_errata():
        for name in dict.fromkeys(entry.named):
            errata[name] = (*errata.get(name, ()), entry.name)
    return errata


@cache
def quoted_claims(number: str) -> tuple[Claim, ...]:
    """The claims of an example that quote the text."""
    return tuple(claim for claim in load_example(number).claims if claim.owner != OURS)


@cache
def _claims(number: str) -> tuple[Claim, ...]:
    """Those of an example, each quote once, with the harshest verdict of it."""
    worst: dict[str, Claim] = {}
    for claim in quoted_claims(number):
        old = worst.get(claim.quote)
        if old is None or ORDER.index(claim.recorded) > ORDER.index(old.recorded):
            worst[claim.quote] = claim
    return tuple(worst.values())


def _named(number: str, words: str) -> Claim:
    claims = [claim for claim in _claims(number) if claim.quote == words]
    claims += [claim for claim in _claims(number) if claim.quote.startswith(words)]
    if not claims:
        raise ValueError(f"no claim of example {number} quotes {words!r}")
    return claims[0]


def _cell(item: Item) -> str:
    """An example by its verdicts, a figure or a table by its sentences."""
    if item.is_diagram:
        return "a diagram: nothing to check"
    if item.ledger:
        parts = [f"ledger of proofs: {{ref}}`{item.ledger} <{item.ledger}>`"]
    elif item.name.startswith("Example"):
        verdicts = [claim.recorded for claim in item.claims]
        summary = (f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts))
        parts = [f"{', '.join(summary)}: `rcac verify {item.example}`"]
    else:
        parts = [f'"{_quoted(claim.quote)}": **{claim.recorded}**' for claim in item.claims]
        parts = [f"{'; '.join(parts)} (Example {item.example})"] if parts else []
    parts += [f'"{_quoted(words)}": no claim, {escaped(why)}' for words, why in item.besides]
    if item.errata:
        parts.append("errata " + ", ".join(f"[{n}](errata.md#erratum-{n})" for n in item.errata))
    return "; ".join(parts)


def _quoted(text: str) -> str:
    """A quote in a cell: its formulas as they are, without the bar that ends a cell."""
    return text.replace("|", "\\|")
