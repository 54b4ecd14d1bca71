"""What a blueprint shows beside the words: types with links, and the graph of the files."""

import html
import re
from collections.abc import Iterable, Iterator, Mapping

from ..formal.declarations import declarations, rests_on
from ..formal.rocq_sources import SOURCES, source
from ..formal.types import committed
from ..ledger.entries import Entry
from ..ledger.ledger import theorems
from .coverage import strength
from .rocq_pages import PLACE, where

_WORD = re.compile(r"(?:\w+\.)*\w+")
_WIDTH, _HEIGHT, _GAP, _COLUMNS = 178, 26, 30, 4
COLOURS = {"Coq": "#1f6f54", "Coq in part": "#5b8a2d", "identity": "#2f62a3", "property": "#8a5a2b"}
"""Of the boxes of the graph, by the strength of a statement; white on each can be read."""


def anchor(name: str) -> str:
    """Return the anchor of a definition or theorem ``folder.File.name`` on the page.

    Examples
    --------
    >>> from proofs.output.blueprint import anchor
    >>> anchor("foundations.Vocabulary.controllable")
    'coq-foundations-Vocabulary-controllable'
    """
    return "coq-" + name.replace(".", "-")


def printed_type(name: str, types: Mapping[str, str]) -> str:
    """Write what Coq prints of a theorem or definition as HTML, each definition in it a link.

    Examples
    --------
    >>> from proofs.formal.types import committed
    >>> from proofs.output.blueprint import printed_type
    >>> text = printed_type("theorems.Kalman.duality", committed())
    >>> '<a href="#coq-foundations-Vocabulary-observable">observable</a>' in text
    True
    """
    known = {key.partition(".")[2]: key for key in types}

    def linked(match: re.Match[str]) -> str:
        word = match.group()
        key = known.get(word) or known.get(f"{name.split('.')[1]}.{word}")
        if key is None or key == name:
            return word
        return f'<a href="#{anchor(key)}">{word.rpartition(".")[2]}</a>'

    text = html.escape("\n".join(types.get(name, "").splitlines()[1:]), quote=False)
    return (
        f'<pre class="coq" style="font-size: 81%; overflow-x: auto">{_WORD.sub(linked, text)}</pre>'
    )


def whereabouts(name: str) -> str:
    """Lead to the file and line of a theorem or definition.

    Examples
    --------
    >>> from proofs.output.blueprint import whereabouts
    >>> "theorems/Diophantine.v, line " in whereabouts("theorems.Diophantine.lemma_1")
    True
    """
    path = source(name).relative_to(SOURCES).as_posix()
    return f'<a href="{PLACE}/{where(name)}">{path}, line {declarations()[name].line}</a>'


def definitions() -> str:
    """Write every definition as Coq prints it, by file, each with an anchor."""
    types = committed()
    lines = []
    for name, text in types.items():
        printed, short = text.splitlines()[1], re.escape(name.rpartition(".")[2])
        is_definition = " =" in printed and re.search(rf"\b{short}\s*=", printed)
        if is_definition or printed.strip().startswith("Inductive "):
            lines.append(
                f'<div id="{anchor(name)}"><p><code>{name}</code> ({whereabouts(name)})</p>'
                f"{printed_type(name, types)}</div>"
            )
    return "\n".join(lines)


def dependencies(entries: Iterable[Entry]) -> dict[str, list[str]]:
    """List for each statement those whose theorems its own rest on, as the Coq files name them.

    Examples
    --------
    >>> from proofs.ledger.ledger import ledger
    >>> from proofs.output.blueprint import dependencies
    >>> dependencies(ledger())["exact-match-bound"]
    ['least-squares-update']
    """
    entries = tuple(entries)
    home: dict[str, str] = {}
    for entry in entries:
        for proof in entry.formal:
            home.setdefault(proof.theorem, entry.name)
    named = theorems(entries)
    needs = {}
    for entry in entries:
        mine = {proof.theorem for proof in entry.formal}
        others = {
            home[other]
            for theorem in mine
            for other in rests_on(theorem, named)
            if other in home and home[other] != entry.name and other not in mine
        }
        needs[entry.name] = [name for name in (e.name for e in entries) if name in others]
    return _without_circles(needs)


def _without_circles(needs: Mapping[str, list[str]]) -> dict[str, list[str]]:
    """Drop what would close a circle: two statements may each rest on one theorem of the other."""
    edges: dict[str, list[str]] = {name: [] for name in needs}

    def reaches(start: str, goal: str) -> bool:
        return start == goal or any(reaches(other, goal) for other in edges[start])

    for name, others in needs.items():
        for other in others:
            if not reaches(other, name):
                edges[name].append(other)
    return edges


def graph(entries: Iterable[Entry]) -> str:
    """Draw which statement rests on which, as SVG, coloured by strength, each box a link.

    Examples
    --------
    >>> from proofs.ledger.ledger import ledger
    >>> from proofs.output.blueprint import graph
    >>> graph(ledger()).startswith("<svg") and 'href="#intercalation"' in graph(ledger())
    True
    """
    entries = tuple(entries)
    needs = dependencies(entries)
    joined = {name for name, others in needs.items() if others} | {
        other for others in needs.values() for other in others
    }
    rows = list(_rows({name: others for name, others in needs.items() if name in joined}))
    alone = [entry.name for entry in entries if entry.name not in joined]
    rows += [alone[i : i + _COLUMNS] for i in range(0, len(alone), _COLUMNS)]
    place = {
        name: (10 + i * (_WIDTH + 14), 10 + depth * (_HEIGHT + _GAP))
        for depth, row in enumerate(rows)
        for i, name in enumerate(row)
    }
    width = max(x for x, _ in place.values()) + _WIDTH + 10
    height = len(rows) * (_HEIGHT + _GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" '
        'aria-label="Which statement rests on which" style="width:100%">'
    ]
    for name, others in needs.items():
        x, y = place[name]
        for other in _nearest(others, needs):
            from_x, from_y = place[other]
            parts.append(
                f'<path d="M{from_x + _WIDTH // 2} {from_y + _HEIGHT} C{from_x + _WIDTH // 2} '
                f'{from_y + _HEIGHT + _GAP} {x + _WIDTH // 2} {y - _GAP} {x + _WIDTH // 2} {y}" '
                'fill="none" stroke="#8a94a0" stroke-width="1"/>'
            )
    for entry in entries:
        x, y = place[entry.name]
        parts.append(
            f'<a href="#{entry.name}"><title>{html.escape(entry.title)}</title>'
            f'<rect x="{x}" y="{y}" width="{_WIDTH}" height="{_HEIGHT}" rx="4" '
            f'fill="{COLOURS[strength(entry)]}"/>'
            f'<text x="{x + _WIDTH // 2}" y="{y + 17}" text-anchor="middle" font-size="12" '
            f'font-family="sans-serif" fill="#ffffff">{entry.name}</text></a>'
        )
    return "".join([*parts, "</svg>"])


def _nearest(others: list[str], needs: Mapping[str, list[str]]) -> list[str]:
    """Leave out what is reached through another one."""

    def below(name: str) -> set[str]:
        return {name}.union(*(below(other) for other in needs[name]))

    through = {x for other in others for x in below(other) - {other}}
    return [other for other in others if other not in through]


def _rows(needs: Mapping[str, list[str]]) -> Iterator[list[str]]:
    """Sort statements into rows, each below all that it needs, near what it needs."""
    placed: dict[str, float] = {}
    while len(placed) < len(needs):
        row = [name for name in needs if name not in placed and placed.keys() >= {*needs[name]}]
        row.sort(key=lambda name: sum(placed[o] for o in needs[name]) / (len(needs[name]) or 1))
        for i in range(0, len(row), _COLUMNS):
            yield row[i : i + _COLUMNS]
        placed |= {name: i % _COLUMNS for i, name in enumerate(row)}
