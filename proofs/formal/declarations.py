"""What the Coq files declare, where, and what each theorem rests on; read from the files alone."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from .rocq_sources import SOURCES, sources, without_comments

_DECLARES = re.compile(
    r"(?:^|(?<=\.\s))[ \t]*"
    r"(Theorem|Lemma|Corollary|Definition|Fixpoint|Inductive|Let|Notation|Ltac)\s+(\w+)",
    re.M,
)
_REQUIRED = re.compile(r"From\s+Compensators\.(\w+)\s+Require\s+(?:Import\s+)?([^.]*)\.")
WORD = re.compile(r"[A-Za-z_][\w']*(?:\.[A-Za-z_][\w']*)*")


@dataclass(frozen=True)
class Declaration:
    """A theorem, a definition or an abbreviation.

    Attributes
    ----------
    name : str
        ``folder.File.name``.
    line : int
    text : str
        Up to the next one, proof and all.
    is_local : bool
        Whether it is known in its section only.
    """

    name: str
    line: int
    text: str
    is_local: bool


def requirements(folder: Path = SOURCES) -> dict[str, tuple[str, ...]]:
    """List for each file ``folder.File`` the files that it requires.

    Examples
    --------
    >>> from proofs.formal.declarations import requirements
    >>> requirements()["theorems.Kalman"]
    ('foundations.MathComp', 'foundations.Vocabulary', 'foundations.Matrices')
    """
    return {
        _module(path, folder): tuple(
            f"{place}.{name}"
            for place, names in _REQUIRED.findall(without_comments(path.read_text("utf-8")))
            for name in names.split()
        )
        for path in sources(folder)
    }


@cache
def declarations(folder: Path = SOURCES) -> dict[str, Declaration]:
    """List every declaration by its name; of two of one name in a file the first.

    Examples
    --------
    >>> from proofs.formal.declarations import declarations
    >>> declarations()["theorems.Diophantine.lemma_1"].line > 10
    True
    """
    declared: dict[str, Declaration] = {}
    for path in sources(folder):
        text = blanked(path.read_text(encoding="utf-8"))
        places = list(_DECLARES.finditer(text))
        for match, after in zip(places, [*places[1:], None], strict=True):
            name = f"{_module(path, folder)}.{match.group(2)}"
            end = after.start() if after else len(text)
            line = text.count("\n", 0, match.start(2)) + 1
            is_local = match.group(1) == "Let"
            declared.setdefault(name, Declaration(name, line, text[match.start() : end], is_local))
    return declared


def blanked(text: str) -> str:
    r"""Put blanks in the place of comments, so that lines stay where they are.

    Examples
    --------
    >>> from proofs.formal.declarations import blanked
    >>> blanked("a (* b\n (* c *) *) d") == "a     \n            d"
    True
    """
    pieces, depth, at = [], 0, 0
    while at < len(text):
        pair = text[at : at + 2]
        step = 2 if pair == "(*" or (depth and pair == "*)") else 1
        depth += (pair == "(*") if step == 2 else 0
        covered = depth > 0
        depth -= step == 2 and pair == "*)"
        piece = text[at : at + step]
        pieces.append(re.sub(r"[^\n]", " ", piece) if covered else piece)
        at += step
    return "".join(pieces)


def resolved(word: str, module: str, folder: Path = SOURCES) -> str:
    """Return the full name of what a word in a file means; empty if it is none of ours.

    Examples
    --------
    >>> from proofs.formal.declarations import resolved
    >>> resolved("controllable", "theorems.Kalman")
    'foundations.Vocabulary.controllable'
    >>> resolved("mulmxA", "theorems.Kalman")
    ''
    """
    known, near = declarations(folder), _near(folder)[module]
    file, _, name = word.rpartition(".")
    for place in near:
        if not file or place.rpartition(".")[2] == file.rpartition(".")[2]:
            full = f"{place}.{name}"
            if full in known and (place == module or not known[full].is_local):
                return full
    return ""


@cache
def uses(folder: Path = SOURCES) -> Mapping[str, frozenset[str]]:
    """List for each declaration those that its statement and its proof name.

    Examples
    --------
    >>> from proofs.formal.declarations import uses
    >>> "foundations.Vocabulary.controllable" in uses()["theorems.Kalman.controllableP"]
    True
    """
    users = {}
    for name, declaration in declarations(folder).items():
        module = name.rpartition(".")[0]
        words = set(WORD.findall(declaration.text))
        named = {full for word in words if (full := resolved(word, module, folder))}
        users[name] = frozenset(named - {name})
    return users


def rests_on(name: str, among: Iterable[str], folder: Path = SOURCES) -> set[str]:
    """Return the nearest declarations of some that a theorem rests on, directly or through others.

    Examples
    --------
    >>> from proofs.formal.declarations import rests_on
    >>> rests_on("theorems.Resultants.theorem_A2", ["theorems.Resultants.theorem_A1"])
    {'theorems.Resultants.theorem_A1'}
    """
    names, used, visited, waiting = set(among) - {name}, set(), {name}, [name]
    while waiting:
        for other in uses(folder).get(waiting.pop(), ()):
            if other in names:
                used.add(other)
            elif other not in visited:
                visited.add(other)
                waiting.append(other)
    return used


@cache
def _near(folder: Path) -> Mapping[str, tuple[str, ...]]:
    """List for each file itself and the files that it requires, the last first."""
    return {module: (module, *reversed(near)) for module, near in requirements(folder).items()}


def _module(path: Path, folder: Path) -> str:
    return ".".join(path.relative_to(folder).with_suffix("").parts)


def files(folder: Path = SOURCES) -> Iterator[tuple[str, Path]]:
    """List the files, each with its name ``folder.File``."""
    return ((_module(path, folder), path) for path in sources(folder))
