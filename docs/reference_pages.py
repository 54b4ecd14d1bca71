"""The reference, one page for each folder of the packages, made from the packages themselves.

A page begins with the folder's sentence and a table of its public names; then comes every module.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from rcac_numeric.errata.reading import find_errata

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = {
    "compensator_theory": "The exact half: integers, rationals and symbols, never a float.",
    "rcac_numeric": "The numeric half: run RCAC in float64, and hold it against exact theory.",
}
INDEX = """# Reference

Every public name is imported from its package, `from rcac_numeric import simulate`; the pages say
in which folder it lives. Folders stand in the order of their layers, from the ground up. Whoever
has the dissertation beside them begins with [its equations](equations.md).

{tables}
```{{toctree}}
:hidden:

equations
{pages}
```
"""


def write_reference(target: Path, layers: dict[str, list[str]]) -> None:
    """Write the pages into a folder; `layers` gives each package's folders in their order."""
    target.mkdir(exist_ok=True)
    tables, names = [], []
    for package, sentence in PACKAGES.items():
        homes = public_names(package)
        rows = []
        for folder in ["", *layers[package]]:
            name = f"{package}.{folder}".rstrip(".")
            page = _page(name, homes)
            if page is None:
                continue
            changed(target / f"{name}.md", page)
            names.append(name)
            rows.append(f"| [`{name}`]({name}.md) | {_sentence(name)} |")
        tables.append(
            f"## `{package}`\n\n{sentence}\n\n| folder | |\n|---|---|\n" + "\n".join(rows)
        )
    index = INDEX.format(tables="\n\n".join(tables) + "\n", pages="\n".join(names))
    changed(target / "index.md", index)
    changed(target / "equations.md", equations_page())
    for page in target.glob("*.md"):
        if page.stem not in (*names, "index", "equations"):
            page.unlink()


def equations_page() -> str:
    """Where each numbered equation, example and section of the dissertation is in the code."""
    found: dict[str, set[str]] = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for number in _cited(path.read_text()):
                found.setdefault(number, set()).add(module.removesuffix(".__init__"))
    wrong: dict[str, list[str]] = {}
    for erratum in find_errata():
        for number in erratum.equations:
            link = f"[{erratum.name}](#erratum-{erratum.name})"
            wrong.setdefault(number, []).append(link)
    rows = [
        f"| ({number}) | {', '.join(f'{{py:mod}}`{m}`' for m in sorted(found.get(number, ())))} "
        f"| {', '.join(wrong.get(number, ()))} |"
        for number in sorted({*found, *wrong}, key=_order)
    ]
    head = (
        "# From an equation to the code\n\nWhat the docstrings cite of the dissertation, and what "
        "is wrong in its [text](../errata.md).\n\n"
    )
    return head + "| equation | modules | errata |\n|---|---|---|\n" + "\n".join(rows) + "\n"


def _cited(text: str) -> Iterator[str]:
    """Numbers such as (2.43) and all of (2.42)-(2.45)."""
    for first, last in re.findall(r"\(([1-9AB]\.\d+)\)(?:-\(([1-9AB]\.\d+)\))?", text):
        chapter, start = first.split(".")
        stop = last.split(".")[1] if last.startswith(f"{chapter}.") else start
        yield from (f"{chapter}.{i}" for i in range(int(start), int(stop) + 1))


def _order(number: str) -> tuple[str, int]:
    chapter, _, index = number.partition(".")
    return chapter, int(index)


def public_names(package: str) -> dict[str, str]:
    """The module in which each public name of a package lives."""
    stub = ast.parse((ROOT / package / "__init__.pyi").read_text())
    return {
        alias.name: f"{package}.{node.module}" if node.module else package
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


def changed(path: Path, text: str) -> None:
    """Write a page only where it differs, so that an unchanged one is not read again."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def _page(folder: str, homes: dict[str, str]) -> str | None:
    modules = list(_modules(folder))
    if not modules:
        return None
    parts = [f"# `{folder}`", _sentence(folder)]
    rows = [
        f"| {{py:obj}}`{name} <{module}.{name}>` | {_summary(module, name)} |"
        for name, module in sorted(homes.items(), key=lambda pair: modules_first(modules, pair))
        if module in modules
    ]
    if rows:
        parts.append("| public name | |\n|---|---|\n" + "\n".join(rows))
    for module in modules:
        head = module.removeprefix(folder).lstrip(".") or module
        parts.append(f"## {head}\n\n```{{eval-rst}}\n.. automodule:: {module}\n   :members:\n```")
    return "\n\n".join(parts) + "\n"


def modules_first(modules: list[str], pair: tuple[str, str]) -> tuple[int, str]:
    """Public names in the order of their modules."""
    name, module = pair
    return (modules.index(module) if module in modules else -1, name)


def _modules(folder: str) -> Iterator[str]:
    directory = ROOT.joinpath(*folder.split("."))
    init = directory / "__init__.py"
    if folder not in PACKAGES and len(init.read_text().splitlines()) > 3:
        yield folder  # it gathers what its files make, as the public strategies do
        return
    for path in sorted(directory.glob("*.py")):
        if path.name != "__init__.py":
            yield f"{folder}.{path.stem}"


def _sentence(folder: str) -> str:
    init = ROOT.joinpath(*folder.split("."), "__init__.py")
    return (
        (ast.get_docstring(ast.parse(init.read_text())) or "").split("\n\n")[0].replace("\n", " ")
    )


def _summary(module: str, name: str) -> str:
    """The first sentence of what stands under a name."""
    path = ROOT.joinpath(*module.split("."))
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            text = (ast.get_docstring(node) or "").split("\n\n")[0]
            return re.sub(r"([|\[\]])", r"\\\1", " ".join(text.split()))
    return ""
