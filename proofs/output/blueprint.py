"""What a blueprint shows beside the words: types with links, and the graph of the files."""

import html
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from ..formal.rocq_sources import SOURCES, source, sources, without_comments
from ..formal.types import committed
from ..ledger.entries import Entry

_REQUIRED = re.compile(r"From\s+Compensators\.(\w+)\s+Require\s+(?:Import\s+)?([^.]*)\.")
_WORD = re.compile(r"(?:\w+\.)*\w+")
_WIDTH, _HEIGHT, _GAP, _COLUMNS = 178, 26, 34, 5


def anchor(name: str) -> str:
    """Return the anchor of a definition or theorem ``folder.File.name`` on the page.

    Examples
    --------
    >>> from proofs.output.blueprint import anchor
    >>> anchor("foundations.Vocabulary.controllable")
    'coq-foundations-Vocabulary-controllable'
    """
    return "coq-" + name.replace(".", "-")


def line_of(name: str, folder: Path = SOURCES) -> int:
    """Return the line of a file on which a theorem or definition begins; 0 if it is not there.

    Examples
    --------
    >>> from proofs.output.blueprint import line_of
    >>> line_of("theorems.Diophantine.lemma_1") > 10
    True
    """
    path = source(name, folder)
    short = re.escape(name.rpartition(".")[2])
    begins = re.compile(rf"\s*(?:Theorem|Lemma|Corollary|Definition|Fixpoint)\s+{short}\b")
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return next((i for i, line in enumerate(lines, start=1) if begins.match(line)), 0)


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
    """Say in which file and line a theorem or definition stands."""
    return f"proofs/rocq/{source(name).relative_to(SOURCES).as_posix()}, line {line_of(name)}"


def definitions() -> str:
    """Write every definition as Coq prints it, by file, each with an anchor."""
    types = committed()
    lines = []
    for name, text in types.items():
        if re.search(rf"\b{re.escape(name.rpartition('.')[2])}\s*=", text.splitlines()[1] + "="):
            if " =" not in text.splitlines()[1]:
                continue
            lines.append(
                f'<div id="{anchor(name)}"><p><code>{name}</code> ({whereabouts(name)})</p>'
                f"{printed_type(name, types)}</div>"
            )
    return "\n".join(lines)


def requirements(folder: Path = SOURCES) -> dict[str, tuple[str, ...]]:
    """List for each file ``folder.File`` the files that it requires.

    Examples
    --------
    >>> from proofs.output.blueprint import requirements
    >>> requirements()["theorems.Kalman"]
    ('foundations.Vocabulary', 'foundations.Matrices')
    """
    found = {}
    for path in sources(folder):
        text = without_comments(path.read_text(encoding="utf-8"))
        module = ".".join(path.relative_to(folder).with_suffix("").parts)
        found[module] = tuple(
            f"{place}.{name}" for place, names in _REQUIRED.findall(text) for name in names.split()
        )
    return found


def graph(entries: Iterable[Entry]) -> str:
    """Draw which file of theorems rests on which, as SVG: dark where statements of the ledger rest.

    Examples
    --------
    >>> from proofs.ledger.ledger import ledger
    >>> from proofs.output.blueprint import graph
    >>> graph(ledger()).startswith("<svg") and 'href="#intercalation"' in graph(ledger())
    True
    """
    needs = {
        name: [other for other in others if other.startswith("theorems.")]
        for name, others in requirements().items()
        if name.startswith("theorems.")
    }
    first: dict[str, str] = {}
    for entry in entries:
        for theorem in entry.formal:
            first.setdefault(theorem.theorem.rpartition(".")[0], entry.name)
    rows = list(_rows(needs))
    place = {
        name: (10 + i * (_WIDTH + 14), 10 + depth * (_HEIGHT + _GAP))
        for depth, row in enumerate(rows)
        for i, name in enumerate(row)
    }
    width = max(x for x, _ in place.values()) + _WIDTH + 10
    height = len(rows) * (_HEIGHT + _GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" '
        'aria-label="Which file of theorems rests on which" style="width:100%">'
    ]
    for name, others in needs.items():
        x, y = place[name]
        for other in others:
            from_x, from_y = place[other]
            parts.append(
                f'<path d="M{from_x + _WIDTH // 2} {from_y + _HEIGHT} C{from_x + _WIDTH // 2} '
                f'{from_y + _HEIGHT + _GAP} {x + _WIDTH // 2} {y - _GAP} {x + _WIDTH // 2} {y}" '
                'fill="none" stroke="#8a94a0" stroke-width="1"/>'
            )
    for name, (x, y) in place.items():
        colour, ink = ("#1f6f54", "#ffffff") if name in first else ("#dfe5ea", "#1c2733")
        box = (
            f'<rect x="{x}" y="{y}" width="{_WIDTH}" height="{_HEIGHT}" rx="4" fill="{colour}"/>'
            f'<text x="{x + _WIDTH // 2}" y="{y + 17}" text-anchor="middle" font-size="12" '
            f'font-family="sans-serif" fill="{ink}">{name.rpartition(".")[2]}</text>'
        )
        parts.append(f'<a href="#{first[name]}">{box}</a>' if name in first else box)
    return "".join([*parts, "</svg>"])


def _rows(needs: Mapping[str, list[str]]) -> Iterator[list[str]]:
    """Sort files into rows, each below all that it needs."""
    placed: set[str] = set()
    while len(placed) < len(needs):
        row = [name for name in needs if name not in placed and placed.issuperset(needs[name])]
        if not row:
            raise ValueError("the files of proofs/rocq require one another in a circle")
        yield from (row[i : i + _COLUMNS] for i in range(0, len(row), _COLUMNS))
        placed.update(row)
