"""Types of definitions and named theorems, as Coq prints them, compared with the committed text.

A type is that after every section is closed: each hypothesis and variable of a section that a
proof uses is in it, whether the source shows it beside the theorem or not.
"""

import hashlib
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from .questions import ask, compiled, say
from .rocq_sources import SOURCES, source

FOLDER = Path("types")
_PREAMBLE = """\
From mathcomp Require Import all_ssreflect all_algebra all_real_closed.
Local Open Scope ring_scope.
Set Printing Width 98. Set Printing Depth 100000."""
_WHOLE = "nothing hidden:"
_HEAD = re.compile(r"^(\w+)  \[(\w+)\]$", re.M)


def printed_statements(
    theorems: Iterable[str], definitions: Iterable[str], folder: Path = SOURCES
) -> tuple[dict[str, str], str]:
    """Ask Coq what theorems and definitions say.

    Returns
    -------
    statements : dict of str
        The type of each theorem and the body of each definition, behind the digest of the same
        with no notation, coercion or implicit argument hidden: what differs in those only is
        printed alike. Empty where Coq gives no answer.
    complaint : str
        What Coq complained of.
    """
    commands = dict.fromkeys(theorems, "Check @{}.") | dict.fromkeys(definitions, "Print {}.")
    questions = {
        name: f"{command}\n{say(_WHOLE)}\nSet Printing All.\n{command}\nUnset Printing All."
        for name, command in commands.items()
        if compiled(name, folder)
    }
    answers, complaint = ask(questions, folder, _PREAMBLE)
    return {name: statement(answers.get(name, "")) for name in commands}, complaint


def statement(answer: str) -> str:
    r"""Join the output of Coq, shortened and whole, in one text; empty if it is incomplete.

    Examples
    --------
    >>> from proofs.formal.types import statement
    >>> text = statement("A.b : 1 = 1\nnothing hidden:\nA.b : @eq nat (S O) (S O)")
    >>> text.splitlines()[1]
    '  A.b : 1 = 1'
    >>> text != statement("A.b : 1 = 1\nnothing hidden:\nA.b : @eq Z (Zpos xH) (Zpos xH)")
    True
    """
    shown, _, whole = (part.strip() for part in answer.partition(_WHOLE))
    if not shown or not whole:
        return ""
    digest = hashlib.sha256(" ".join(whole.split()).encode()).hexdigest()[:12]
    lines = [f"  {line}".rstrip() for line in shown.splitlines()]
    return "\n".join([f"[{digest}]", *lines])


def committed(folder: Path = SOURCES) -> dict[str, str]:
    """Read what is committed.

    Examples
    --------
    >>> from proofs.formal.types import committed
    >>> "foundations.Vocabulary.controllable" in committed()
    True
    """
    types = {}
    root = folder / FOLDER
    for path in sorted(root.rglob("*.txt")):
        module = ".".join(path.relative_to(root).with_suffix("").parts)
        _, *parts = _HEAD.split(path.read_text(encoding="utf-8"))
        for name, digest, text in zip(parts[::3], parts[1::3], parts[2::3], strict=True):
            types[f"{module}.{name}"] = f"[{digest}]\n{text.strip(chr(10))}"
    return types


def commit(statements: Mapping[str, str], folder: Path = SOURCES) -> None:
    """Write statements, one file for each source, in place of all that were committed."""
    for path in (folder / FOLDER).rglob("*.txt"):
        path.unlink()
    texts: dict[Path, str] = {}
    for name, text in sorted(statements.items()):
        path = folder / FOLDER / source(name, folder).relative_to(folder).with_suffix(".txt")
        head = name.rpartition(".")[2]
        texts[path] = texts.get(path, "") + f"{head}  {text}\n\n"
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.rstrip() + "\n", encoding="utf-8")


def changed(statements: Mapping[str, str], folder: Path = SOURCES) -> dict[str, str]:
    """Say of each statement how it differs from the committed one; empty if it does not."""
    known, reasons = committed(folder), {}
    for name, text in statements.items():
        path = FOLDER / source(name, folder).relative_to(folder).with_suffix(".txt")
        where = f"proofs/rocq/{path.as_posix()}"
        if not text:
            reasons[name] = "Coq does not print what it says"
        elif name not in known:
            reasons[name] = f"what it says is not committed in {where}"
        else:
            reasons[name] = "" if text == known[name] else f"says something else than {where}"
    return reasons
