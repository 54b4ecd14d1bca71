"""The reference, made from the packages themselves.

Every public name has a page under the name by which it is imported, and a place in a group of its
task (``reference_groups``); every folder of the packages has a page with its public names and all
that is not public.
"""

import ast
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
GROUPS = Path(__file__).resolve().parent / "reference_groups"
PACKAGES = {
    "rcac_numeric": "The numeric half: RCAC in float64, compared with exact theory.",
    "rcac_experiments": "Experiment files, studies, pages, the dissertation.",
    "compensator_theory": "The exact half: integers, rationals and symbols, no floats.",
}
INDEX = """# Reference

Every public name has a page under its import path: from its package, `from rcac_numeric import
simulate`, or from a namespace, `from rcac_experiments.sweeps import Study`. Result classes are in
`results`. The groups are by task; [the equations](equations.md) of the dissertation and
[the folders](folders.md) of the code are further indexes.

{tables}
```{{toctree}}
:hidden:

{pages}
equations
folders
```
"""
FOLDERS = """# The folders of the packages

In the order of their layers: a folder imports only folders above it. Each page lists public and
internal names.

{tables}
"""
# Their pages stand in no table of contents: the sidebar of every page would list them all.
ORPHAN = "---\norphan: true\n---\n\n"


@dataclass(frozen=True)
class Group:
    """Public names of one task, in their order."""

    package: str
    page: str
    title: str
    says: str
    names: tuple[str, ...]
    terms: tuple[str, ...] = ()  # under which the index has it, where its title has other words
    named: Mapping[str, tuple[str, ...]] = field(default_factory=dict)  # the same of single names


def write_reference(target: Path, layers: dict[str, list[str]]) -> None:
    """Write the pages into a folder; `layers` gives each package's folders in their order."""
    (target / "api").mkdir(parents=True, exist_ok=True)
    pages = dict(_grouped())
    tables = []
    for package, sentence in PACKAGES.items():
        homes = public_names(package)
        rows = []
        for folder in ["", *layers[package]]:
            name = f"{package}.{folder}".rstrip(".")
            page = _folder_page(name, homes)
            if page is None:
                continue
            pages[name] = page
            rows.append((f"[`{name}`]({name}.md)", _sentence(name)))
        tables.append(f"## `{package}`\n\n{sentence}\n\n{_table('folder', rows)}")
    pages["folders"] = FOLDERS.format(tables="\n\n".join(tables) + "\n")
    for name, text in pages.items():
        changed(target / f"{name}.md", text)
    for path in target.rglob("*.md"):
        name = path.relative_to(target).with_suffix("").as_posix()
        if name not in pages and name != "equations":
            path.unlink()


def groups(package: str) -> Iterator[Group]:
    """The public names of a package by task."""
    for group in tomllib.loads((GROUPS / f"{package}.toml").read_text())["group"]:
        yield Group(package=package, **group)


@cache
def public_names(package: str) -> dict[str, str]:
    """The module in which each public name of a package lives, those of its namespaces included."""
    homes = {}
    for space in namespaces(package):
        homes |= _names(space)
    spaces = {space.rpartition(".")[2] for space in namespaces(package)}
    return {name: home for name, home in homes.items() if name not in spaces}


@cache
def namespaces(package: str) -> list[str]:
    """The modules from which the public names of a package are imported, the package first.

    Examples
    --------
    >>> from docs.reference_pages import namespaces
    >>> namespaces("compensator_theory")[:3]
    ['compensator_theory', 'compensator_theory.bezout', 'compensator_theory.errors']
    """
    top = _stubbed(place(package) / "__init__.pyi", package)
    modules = [name for name, home in top.items() if home == package]
    return [package, *sorted(f"{package}.{name}" for name in modules if name != "strategies")]


@cache
def public_path(package: str, name: str) -> str:
    """The dotted name by which a public name is imported.

    Examples
    --------
    >>> from docs.reference_pages import public_path
    >>> public_path("rcac_numeric", "simulate"), public_path("rcac_numeric", "H2Cost")
    ('rcac_numeric.simulate', 'rcac_numeric.results.H2Cost')
    """
    return next(f"{space}.{name}" for space in namespaces(package) if name in _names(space))


def place(space: str) -> Path:
    """Where the module is installed: in a checkout, or where a wheel laid it."""
    package, *inner = space.split(".")
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"{package} is not installed", name=package)
    return Path(spec.origin).parent.joinpath(*inner)


def _names(space: str) -> dict[str, str]:
    path = place(space)
    if path.is_dir():
        return _stubbed(path / "__init__.pyi", space)
    stub = path.with_suffix(".pyi")
    if stub.exists():
        return _stubbed(stub, space.rpartition(".")[0])
    body = ast.parse(path.with_suffix(".py").read_text()).body
    return {node.name: space for node in body if isinstance(node, ast.ClassDef)}


def _stubbed(stub: Path, package: str) -> dict[str, str]:
    return {
        alias.name: f"{package}.{node.module}" if node.module else package
        for node in ast.parse(stub.read_text()).body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


def page_of(package: str, name: str) -> str:
    """The page of a public name; design and Design differ on every file system."""
    twins = [n for n in public_names(package) if n.lower() == name.lower()]
    suffix = "-class" if len(twins) > 1 and name[0].isupper() else ""
    return f"api/{public_path(package, name)}{suffix}"


def write_rocq(folder: Path) -> None:
    """Write the Coq files as pages, each theorem with the statements that name it."""
    from proofs.ledger.ledger import ledger
    from proofs.output.rocq_pages import rocq_pages

    serves: dict[str, list[str]] = {}
    for entry in ledger():
        for theorem in entry.theorems:
            serves.setdefault(theorem, []).append(entry.name)
    pages = rocq_pages(serves)
    folder.mkdir(parents=True, exist_ok=True)
    for path in folder.glob("*.md"):
        if path.stem not in pages:
            path.unlink()
    for name, text in pages.items():
        changed(folder / f"{name}.md", ORPHAN + text)


def changed(path: Path, text: str) -> None:
    """Write a page only where it differs, so that an unchanged one is not read again."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def _grouped() -> Iterator[tuple[str, str]]:
    """The index, the pages of the groups, and those of the names."""
    tables, pages = [], []
    for package, sentence in PACKAGES.items():
        homes = public_names(package)
        rows = []
        for group in groups(package):
            pages.append(group.page)
            rows.append((f"[{group.title}]({group.page}.md)", group.says))
            yield group.page, _group_page(group, homes)
            for name in group.names:
                yield page_of(package, name), _name_page(group, name, homes[name])
        tables.append(f"## `{package}`\n\n{sentence}\n\n{_table('task', rows)}")
    yield "index", INDEX.format(tables="\n\n".join(tables) + "\n", pages="\n".join(pages))


def _group_page(group: Group, homes: dict[str, str]) -> str:
    rows = [
        (f"[`{name}`]({page_of(group.package, name)}.md)", _summary(homes[name], name))
        for name in group.names
    ]
    indexed = _index_entry(group.terms)
    says = f"{group.says} All of `{group.package}`."
    return f"# {group.title}\n\n{indexed}{says}\n\n{_table('name', rows)}\n"


def _name_page(group: Group, name: str, home: str) -> str:
    if home == group.package:  # a module of its own, as the strategies are
        directive = f".. automodule:: {group.package}.{name}\n   :members:"
        home = f"{group.package}.{name}"
    else:
        module = public_path(group.package, name).rpartition(".")[0]
        kind = "autoclass" if name[0].isupper() else "autofunction"
        directive = f".. currentmodule:: {module}\n\n.. {kind}:: {name}"
        if name[0].isupper():
            directive += "\n   :members:\n   :inherited-members:"
    is_folder = place(home).is_dir()
    folder = home if is_folder else home.rpartition(".")[0]
    return (
        f"{ORPHAN}# {public_path(group.package, name)}\n\n"
        f"{_index_entry(group.named.get(name, ()))}[Reference](../index.md) / "
        f"[{group.title}](../{group.page}.md)\n\n```{{eval-rst}}\n{directive}\n```\n\n"
        f"Written in `{home}`; [its folder](../{folder}.md).\n"
    )


def _index_entry(terms: Sequence[str]) -> str:
    """The directive that puts words of the field into the index, which a search asks first."""
    return f"```{{index}} {', '.join(f'! {term}' for term in terms)}\n```\n\n" if terms else ""


def _folder_page(folder: str, homes: dict[str, str]) -> str | None:
    modules = list(_modules(folder))
    if not modules:
        return None
    package = folder.partition(".")[0]
    parts = [f"{ORPHAN}# `{folder}`", "[The folders](folders.md)", _sentence(folder)]
    public = {
        module: [name for name, home in sorted(homes.items()) if home == module]
        for module in modules
    }
    rows = [
        (f"[`{name}`]({page_of(package, name)}.md)", _summary(module, name))
        for module, names in public.items()
        for name in names
    ]
    if folder in PACKAGES or folder == "compensator_theory.strategies":
        rows += [
            (f"[`{name}`]({page_of(package, name)}.md)", _sentence(f"{folder}.{name}"))
            for name, home in homes.items()
            if home == folder
        ]
    if folder not in modules:
        parts.append(f"```{{eval-rst}}\n.. py:module:: {folder}\n```")
    if rows:
        parts.append(_table("public name", rows))
    for module in modules:
        head = module.removeprefix(folder).lstrip(".") or module
        rest = _automodule(module, public[module])
        parts.append(f"## {head}\n\n```{{eval-rst}}\n{rest}\n```")
    return "\n\n".join(parts) + "\n"


def _automodule(module: str, public: list[str]) -> str:
    """What a module says, and its members that have no page of their own."""
    if module == "compensator_theory.strategies":
        return f"All of :mod:`{module}` are public."
    members = [name for name in _documented(module) if name not in public]
    directive = f".. automodule:: {module}"
    return directive + (f"\n   :members: {', '.join(members)}" if members else "")


def _documented(module: str) -> Iterator[str]:
    """What a module itself makes and describes: no imported name, no alias of a type."""
    path = place(module)
    body = parsed(path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            if not node.name.startswith("_") and ast.get_docstring(node):
                yield node.name
        elif isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            data = isinstance(node, ast.Assign) and not isinstance(node.value, ast.Subscript)
            targets = node.targets if data else []
            yield from (t.id for t in targets if isinstance(t, ast.Name) and t.id[0] != "_")


def _modules(folder: str) -> Iterator[str]:
    directory = place(folder)
    init = directory / "__init__.py"
    is_namespace = "lazy_loader" in init.read_text()  # its names are those of its files
    if not is_namespace and len(init.read_text().splitlines()) > 3:
        yield folder
        if "__all__" in init.read_text():  # it gathers what its files make, as the strategies do
            return
    for path in sorted(directory.glob("*.py")):
        if path.name != "__init__.py":
            yield f"{folder}.{path.stem}"


@cache
def parsed(path: Path) -> ast.Module:
    """The syntax tree of a module, made once: all that read the sources share it."""
    return ast.parse(path.read_text())


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """All nodes of a module, in the order of `ast.walk`, which takes ten times as long."""
    return tuple(ast.walk(parsed(path)))


def _table(head: str, rows: list[tuple[str, str]]) -> str:
    return f"| {head} | |\n|---|---|\n" + "\n".join(f"| {a} | {b} |" for a, b in rows)


def _sentence(folder: str) -> str:
    path = place(folder)
    text = (path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).read_text()
    return (ast.get_docstring(ast.parse(text)) or "").split("\n\n")[0].replace("\n", " ")


def _summary(module: str, name: str) -> str:
    """The first sentence of what stands under a name."""
    path = place(module)
    if (path / name).is_dir():
        return _sentence(f"{module}.{name}")
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    for node in parsed(path).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            text = " ".join((ast.get_docstring(node) or "").split("\n\n")[0].split())
            text = re.sub(r":\w+:`~?([^`<]+)`", r"`\1`", text)
            return re.sub(r"([|\[\]*])", r"\\\1", text)
    return ""
