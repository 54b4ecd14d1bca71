"""The Coq files as pages: every line has an anchor, every name of ours leads to its declaration."""

import html
import re
from collections.abc import Iterator, Mapping

from ..formal.declarations import WORD, blanked, declarations, files, resolved
from ..formal.rocq_sources import SOURCES

PLACE = "reference/rocq"
"""The folder of the pages in the documentation."""

_KEYWORDS = re.compile(
    "Theorem|Lemma|Corollary|Definition|Fixpoint|Let|Notation|Ltac|Section|End|Variables?|"
    "Hypothes[ei]s|Context|Implicit|Types|Local|Proof|Qed|Defined|From|Require|Import|Set|Unset|"
    "Arguments|forall|exists|fun|let|in|if|then|else|match|with|end"
)
_TOKEN = re.compile(rf"{WORD.pattern}|\s+|.", re.S)


def where(name: str) -> str:
    """Return the place of a declaration ``folder.File.name`` among the pages, with its line.

    Examples
    --------
    >>> from proofs.output.rocq_pages import where
    >>> where("theorems.Diophantine.lemma_1").startswith("theorems.Diophantine.html#L")
    True
    """
    return f"{name.rpartition('.')[0]}.html#L{declarations()[name].line}"


def rocq_pages(entries_of: Mapping[str, list[str]]) -> dict[str, str]:
    """Write the page of each file, by ``folder.File``.

    Parameters
    ----------
    entries_of : dict of list of str
        For a theorem the statements of the ledger that name it.

    Examples
    --------
    >>> from proofs.output.rocq_pages import rocq_pages
    >>> page = rocq_pages({"theorems.Diophantine.lemma_1": ["lemma-1"]})["theorems.Diophantine"]
    >>> 'href="../../proofs.html#lemma-1"' in page
    True
    """
    return {
        module: f"# {path.name}\n\n`proofs/rocq/{path.relative_to(SOURCES).as_posix()}`\n\n"
        '<div class="highlight"><pre class="coq" style="font-size: 75%">'
        + _source(module, path.read_text(encoding="utf-8"), entries_of)
        + "</pre></div>\n"
        for module, path in files()
    }


def _source(module: str, text: str, entries_of: Mapping[str, list[str]]) -> str:
    """Write the lines of a file; an empty one keeps a blank, for Markdown ends HTML at it."""
    marks: dict[int, list[str]] = {}
    for name, statements in entries_of.items():
        if name in declarations() and name.rpartition(".")[0] == module:
            marks.setdefault(declarations()[name].line, []).extend(statements)
    lines = "".join(_pieces(module, text)).splitlines()
    shown = []
    for number, line in enumerate(lines, start=1):
        links = "".join(
            f'<a style="float: right" href="../../proofs.html#{name}">{name}</a>'
            for name in dict.fromkeys(marks.get(number, ()))
        )
        shown.append(f'<span id="L{number}"></span>{links}{line or " "}')
    return "\n".join(shown)


def _pieces(module: str, text: str) -> Iterator[str]:
    """Mark comments, keywords and links, each within its line."""
    bare = blanked(text)
    at = 0
    while at < len(text):
        if text[at] != bare[at]:  # in a comment
            end = at
            while end < len(text) and (text[end] != bare[end] or text[end].isspace()):
                end += 1
            comment = html.escape(text[at:end].rstrip(), quote=False)
            space = text[at + len(text[at:end].rstrip()) : end]
            yield "\n".join(f'<span class="c1">{line}</span>' for line in comment.split("\n"))
            yield space
            at = end
            continue
        match = _TOKEN.match(bare, at)
        word = match.group() if match else text[at]
        end = at + len(word)
        if word.isspace():  # as far as no comment begins within
            word = re.match(r"\s+", text[at:end]).group()  # type: ignore[union-attr]
            end = at + len(word)
        yield _linked(module, word)
        at = end


def _linked(module: str, word: str) -> str:
    if _KEYWORDS.fullmatch(word):
        return f'<span class="k">{word}</span>'
    name = resolved(word, module) if WORD.fullmatch(word) else ""
    return f'<a href="{where(name)}">{word}</a>' if name else html.escape(word, quote=False)
