"""The dissertation's equations by number: which code computes each, and what is wrong with it."""

import ast
import functools
import io
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass, field

from docs.reference_pages import PACKAGES, ROOT, parsed, place, public_names, public_path
from proofs.ledger.ledger import ledger
from rcac_experiments.dissertation._reading import find_errata

CHAPTERS = {c: f"Chapter {c}" for c in "123456789"} | {c: f"Appendix {c}" for c in "AB"}
NUMBER = re.compile(r"\(([1-9AB])\.([1-9]\d{0,2})\)(?:-\(([1-9AB])\.([1-9]\d{0,2})\))?")
HEAD = """# From an equation to the code

The dissertation's equations by number: the public names whose documentation cites each, the
modules that mention it elsewhere, entries of the [ledger of proofs](../proofs.md),
[errata](../errata.md), and pages. A number in parentheses on any page leads here.
"""


@dataclass
class Places:
    """Where an equation is cited."""

    names: dict[str, None] = field(default_factory=dict)
    modules: dict[str, None] = field(default_factory=dict)
    kernel: dict[str, None] = field(default_factory=dict)
    ledger: dict[str, str] = field(default_factory=dict)
    errata: dict[str, str] = field(default_factory=dict)
    pages: dict[str, None] = field(default_factory=dict)


def cited(text: str) -> Iterator[str]:
    """Numbers such as (2.43) and all of (2.42)-(2.45).

    Examples
    --------
    >>> from docs.equation_index import cited
    >>> list(cited("the update (2.42)-(2.44), from (A.7)"))
    ['2.42', '2.43', '2.44', 'A.7']
    """
    for chapter, first, other, last in NUMBER.findall(text):
        stop = int(last) if last and other == chapter else int(first)
        yield from (f"{chapter}.{i}" for i in range(int(first), stop + 1))


@functools.cache
def equations() -> dict[str, Places]:
    """Every equation that is cited, in its order."""
    places_of: dict[str, Places] = {}

    def at(number: str) -> Places:
        return places_of.setdefault(number, Places())

    for package in PACKAGES:
        public = {
            (home, name): public_path(package, name) for name, home in public_names(package).items()
        }
        folder = place(package)
        for path in sorted(folder.rglob("*.py")):
            module = ".".join(path.relative_to(folder.parent).with_suffix("").parts)
            module = module.removesuffix(".__init__")
            for owner, text in texts(path.read_text(), parsed(path)):
                for number in cited(text):
                    name = public.get((module, owner))
                    if name:
                        at(number).names[name] = None
                    else:
                        at(number).modules[module] = None
    for path in sorted((ROOT / "kernel").rglob("*.?pp")):
        for number in cited(path.read_text()):
            at(number).kernel[path.relative_to(ROOT).as_posix()] = None
    for entry in ledger():
        for number in cited(f"{entry.source} {entry.text} {entry.difference or ''}"):
            at(number).ledger[entry.name] = entry.title
    for erratum in find_errata():
        for number in erratum.equations:
            at(number).errata[erratum.name] = erratum.where
    for path in sorted((ROOT / "docs").rglob("*.md")):
        name = path.relative_to(ROOT / "docs").with_suffix("").as_posix()
        if not name.startswith(("reference/", "_build/")):
            for number in cited(path.read_text()):
                at(number).pages[name] = None
    return dict(sorted(places_of.items(), key=lambda pair: _order(pair[0])))


def equations_page(index: dict[str, Places]) -> str:
    """The index as a page."""
    parts, chapter = [HEAD], ""
    for number, places in index.items():
        if number[0] != chapter:
            chapter = number[0]
            parts.append(f"## {CHAPTERS[chapter]}\n")
        parts.append("```{eval-rst}\n" + "\n".join(_entry(number, places)) + "\n```\n")
    return "\n".join(parts)


def _entry(number: str, places: Places) -> Iterator[str]:
    modules = set(places.modules) - {_home(name) for name in places.names}
    yield f".. equation:: {number}"
    yield ""
    for words, links in (
        ("Computed by", [f":py:obj:`{name}`" for name in places.names]),
        ("Mentioned in", [f":py:mod:`{name}`" for name in places.modules if name in modules]),
        ("Kernel", [f"``{name}``" for name in places.kernel]),
        ("Proofs", [f":ref:`{_plain(t)} <{name}>`" for name, t in places.ledger.items()]),
        ("Errata", [f":ref:`{_plain(w)} <erratum-{n}>`" for n, w in places.errata.items()]),
        ("Pages", [f":doc:`/{name}`" for name in places.pages]),
    ):
        if links:
            yield f"   | {words}: {', '.join(links)}"


def _plain(text: str) -> str:
    return re.sub(r"[`<>\\*]", "", text)


def _home(name: str) -> str:
    return public_names(name.partition(".")[0])[name.rpartition(".")[2]]


def texts(source: str, tree: ast.Module) -> Iterator[tuple[str | None, str]]:
    """(top-level owner, words): docstrings without their examples, and comments."""
    for node in tree.body:
        owner = node.name if isinstance(node, ast.ClassDef | ast.FunctionDef) else None
        for inner in ast.walk(node):
            if isinstance(inner, ast.ClassDef | ast.FunctionDef):
                yield owner, _words(ast.get_docstring(inner) or "")
    yield None, _words(ast.get_docstring(tree) or "")
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield None, token.string


def _words(docstring: str) -> str:
    paragraphs = re.split(r"\n\s*\n", docstring)
    return "\n\n".join(p for p in paragraphs if ">>>" not in p)


def _order(number: str) -> tuple[str, int]:
    chapter, _, index = number.partition(".")
    return chapter, int(index)
