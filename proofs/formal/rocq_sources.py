"""Which theorems and definitions the formal part states; read from its files, without Coq."""

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

SOURCES = Path(__file__).parents[1] / "rocq"
QUESTION = "Check.v"  # what Coq is asked is a file too, and none of the sources
_STATED = re.compile(r"^\s*(?:Theorem|Lemma|Corollary|Proposition|Fact|Example)\s+(\w+)", re.M)
_DEFINED = re.compile(
    r"(?:^|\.\s)\s*(?:#\[[^\]]*\]\s*)?(?:(?:Local|Global|Program)\s+)*(?:Definition|Fixpoint|CoFixpoint|"
    r"Function|Inductive|CoInductive|Variant|Record|Structure|Class|Instance|Canonical(?:\s+"
    r"Structure)?)\s+(\w+)",
    re.M,
)
_SECTIONS = re.compile(r"^\s*(?:Section|End|Hypothes[ei]s|Context)\b.*?\.(?=\s)", re.M | re.S)
_LOCAL = re.compile(r"^\s*(Section|Module|End|Variables?|Hypothes[ei]s|Context)\b", re.M)
_CHANGED = re.compile(
    r"^\s*(?:#\[[^\]]*\]\s*)?(?:(?:Local|Global)\s+)?"
    r"(?:(?:Reserved\s+)?Notation\s*\"[^\"]*\"|Infix|Tactic\s+Notation|Coercion|Canonical|"
    r"Declare\s+(?:ML|Custom|Scope)|Delimit|Bind|Undelimit|Load|Add\s+\w+|Module|Include|Print\s+\w+|"
    r"Opaque|Transparent|Strategy|Extraction|Drop|Cd|Remove|Set\s+(?!Implicit|Printing)|"
    r"Unset\s+(?!Strict|Printing))\S*",
    re.M,
)
_ASSUMED = re.compile(
    r"\b(?:Admitted|admit|Admit Obligations)\b"
    r"|^\s*(?:#\[[^\]]*\]\s*)?(?:(?:Local|Global)\s+)?(?:Axioms?|Parameters?|Conjectures?)\b"
    r"|\bUnset\s+(?:Guard|Positivity|Universe)\s+Checking\b|\bbypass_check\b",
    re.M,
)


def sources(folder: Path = SOURCES) -> tuple[Path, ...]:
    """List the Coq files, those in folders included.

    Examples
    --------
    >>> from proofs.formal.rocq_sources import SOURCES, sources
    >>> SOURCES / "foundations" / "Vocabulary.v" in sources()
    True
    """
    return tuple(path for path in sorted(folder.rglob("*.v")) if path.name != QUESTION)


def source(name: str, folder: Path = SOURCES) -> Path:
    """Return the file of a theorem or definition ``folder.File.name``.

    Examples
    --------
    >>> from proofs.formal.rocq_sources import SOURCES, source
    >>> source("theorems.Forms.form_is_unique").relative_to(SOURCES).as_posix()
    'theorems/Forms.v'
    """
    return folder.joinpath(*name.split(".")[:-1]).with_suffix(".v")


def missing(theorem: str, folder: Path = SOURCES) -> str:
    """Say why a theorem ``folder.File.name`` is not there; empty if it is.

    Examples
    --------
    >>> from proofs.formal.rocq_sources import missing
    >>> missing("theorems.Nowhere.nothing")
    'proofs/rocq has no file theorems/Nowhere.v'
    """
    path, name = source(theorem, folder), theorem.rsplit(".", maxsplit=1)[-1]
    where = path.relative_to(folder).as_posix()
    if not path.exists():
        return f"proofs/rocq has no file {where}"
    if name not in _STATED.findall(without_comments(path.read_text(encoding="utf-8"))):
        return f"{where} states no theorem {name}"
    return ""


def stated(theorem: str, folder: Path = SOURCES) -> str:
    """Return a theorem as its file states it, after the hypotheses of its section; or nothing.

    Examples
    --------
    >>> from proofs.formal.rocq_sources import stated
    >>> stated("theorems.Nowhere.nothing")
    ''
    """
    if missing(theorem, folder):
        return ""
    text = without_comments(source(theorem, folder).read_text(encoding="utf-8"))
    name = theorem.rsplit(".", maxsplit=1)[-1]
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


def defined(folder: Path = SOURCES) -> tuple[str, ...]:
    """List every definition of every file, as ``folder.File.name``.

    Examples
    --------
    >>> from proofs.formal.rocq_sources import defined
    >>> "foundations.Vocabulary.controllable" in defined()
    True
    """
    definitions = []
    for path in sources(folder):
        module = ".".join(path.relative_to(folder).with_suffix("").parts)
        names = _DEFINED.findall(without_comments(path.read_text(encoding="utf-8")))
        definitions += [f"{module}.{name}" for name in names]
    return tuple(definitions)


def assumed(folder: Path = SOURCES) -> tuple[str, ...]:
    """List the files that assume instead of proving, or change what words mean, each with the word.

    A file may abbreviate (``Notation name``), and no more: no other notation, coercion, canonical
    structure or module, so that what is printed of a theorem means what it means in MathComp.

    Examples
    --------
    >>> from proofs.formal.rocq_sources import assumed
    >>> assumed()
    ()
    """
    names = []
    for path in sources(folder):
        text, where = without_comments(path.read_text(encoding="utf-8")), path.relative_to(folder)
        match = _ASSUMED.search(text) or _CHANGED.search(text)
        words = [match.group()] if match else []
        words += list(_outside_sections(text))
        names += [f"{where.as_posix()}: {word.strip()}" for word in words]
    return tuple(names)


def _outside_sections(text: str) -> Iterator[str]:
    """List what a file would assume for all that follows: variables outside every section."""
    depth = 0
    for match in _LOCAL.finditer(text):
        word = match.group(1)
        depth += {"Section": 1, "Module": 1, "End": -1}.get(word, 0)
        if depth < 1 and word not in ("Section", "Module", "End"):
            yield f"{word} outside a section"


@lru_cache(maxsize=256)
def without_proofs(text: str) -> str:
    r"""Remove comments and proofs, and what layout there is.

    Examples
    --------
    >>> from proofs.formal.rocq_sources import without_proofs
    >>> without_proofs("Lemma a : 1 = 1.  (* b *)\nProof. by []. Qed.")
    'Lemma a : 1 = 1.'
    """
    bare = re.sub(
        r"\bProof\b.*?\b(?:Qed|Defined|Admitted)\.", "", without_comments(text), flags=re.S
    )
    return " ".join(bare.split())


@lru_cache(maxsize=256)
def without_comments(text: str) -> str:
    """Remove comments, nested ones included.

    Examples
    --------
    >>> from proofs.formal.rocq_sources import without_comments
    >>> without_comments("a (* b (* c *) d *) e")
    'a  e'
    """
    previous = None
    while text != previous:
        previous = text
        text = re.sub(r"\(\*(?:(?!\(\*|\*\)).)*\*\)", "", text, flags=re.S)
    return text
