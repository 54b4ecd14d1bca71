"""Which theorems the formal part states; read from its files, without Coq."""

import re
from pathlib import Path

SOURCES = Path(__file__).parent / "rocq"
_STATED = re.compile(r"^\s*(?:Theorem|Lemma|Corollary|Proposition|Fact|Example)\s+(\w+)", re.M)
_SECTIONS = re.compile(r"^\s*(?:Section|End|Hypothes[ei]s|Context)\b.*?\.(?=\s)", re.M | re.S)
_ASSUMED = re.compile(
    r"\b(?:Admitted|admit|Admit Obligations)\b"
    r"|^\s*(?:#\[[^\]]*\]\s*)?(?:(?:Local|Global)\s+)?(?:Axioms?|Parameters?|Conjectures?)\b"
    r"|\bUnset\s+(?:Guard|Positivity|Universe)\s+Checking\b|\bbypass_check\b",
    re.M,
)


def missing(theorem: str, folder: Path = SOURCES) -> str:
    """Say why a theorem ``File.name`` is not there; empty if it is.

    Examples
    --------
    >>> from proofs.rocq_sources import missing
    >>> missing("Nowhere.nothing")
    'proofs/rocq has no file Nowhere.v'
    """
    file, _, name = theorem.partition(".")
    path = folder / f"{file}.v"
    if not path.exists():
        return f"proofs/rocq has no file {file}.v"
    if name not in _STATED.findall(without_comments(path.read_text(encoding="utf-8"))):
        return f"{file}.v states no theorem {name}"
    return ""


def stated(theorem: str, folder: Path = SOURCES) -> str:
    """Return a theorem as its file states it, after the hypotheses of its section; or nothing.

    Examples
    --------
    >>> from proofs.rocq_sources import stated
    >>> stated("Nowhere.nothing")
    ''
    """
    if missing(theorem, folder):
        return ""
    file, _, name = theorem.partition(".")
    text = without_comments((folder / f"{file}.v").read_text(encoding="utf-8"))
    start = next(m.start() for m in _STATED.finditer(text) if m.group(1) == name)
    statement = re.split(r"^\s*Proof\b", text[start:], maxsplit=1, flags=re.M)[0].strip()
    return "\n".join([*_hypotheses(text[:start]), statement])


def _hypotheses(before: str) -> list[str]:
    """List the hypotheses of the sections that are open at the end of a text."""
    opened: list[list[str]] = [[]]
    for match in _SECTIONS.finditer(before):
        words = " ".join(match.group().split())
        if words.startswith("Section"):
            opened.append([])
        elif words.startswith("End"):
            opened.pop()
        else:
            opened[-1].append(words)
    return [hypothesis for section in opened for hypothesis in section]


def assumed(folder: Path = SOURCES) -> tuple[str, ...]:
    """List the files that assume instead of proving, each with the word that does it.

    Examples
    --------
    >>> from proofs.rocq_sources import assumed
    >>> assumed()
    ()
    """
    found = []
    for path in sorted(folder.glob("*.v")):
        match = _ASSUMED.search(without_comments(path.read_text(encoding="utf-8")))
        if match:
            found.append(f"{path.name}: {match.group().strip()}")
    return tuple(found)


def without_comments(text: str) -> str:
    """Remove comments, nested ones included.

    Examples
    --------
    >>> from proofs.rocq_sources import without_comments
    >>> without_comments("a (* b (* c *) d *) e")
    'a  e'
    """
    previous = None
    while text != previous:
        previous = text
        text = re.sub(r"\(\*(?:(?!\(\*|\*\)).)*\*\)", "", text, flags=re.S)
    return text
