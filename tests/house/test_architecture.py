"""The rules of the house that a machine can check: layers, circles, documented names."""

import ast
import inspect
from functools import cache
from pathlib import Path

import pytest

from docs.reference_pages import nodes, parsed
from tests.house.layers import FLOORS, LAYERS
from tests.support.public import public_objects

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("compensator_theory", "rcac_numeric", "rcac_experiments", "proofs")

# What a fixed controller does to a loop is computed from its data, never by running it.
WITHOUT_ENGINE = ("analysis",)
# Imports by name in the packages: commands, entries of tables that are tested, optional libraries.
BY_NAME = {
    "rcac_numeric/arrays/_frames.py",
    "rcac_experiments/cli/__main__.py",
    "rcac_experiments/cli/_main.py",
    "rcac_experiments/dissertation/_checking.py",
    "rcac_experiments/sweeps/_versions.py",
}

# Who may import what shows a result, late: its methods, the two functions of `arrays._showing` and
# who draws results of the exact half. A result is imported by what shows it, never the reverse.
SHOWING = ("plot", "_sheet", "report_of", "notebook_of", "picture_of")
SHOWN_IN = ("plots", "reports")

FILES = sorted(p for package in PACKAGES for p in (ROOT / package).rglob("*.py"))
SOURCES = [p for p in FILES if p.name != "__init__.py"]
FOLDERS = sorted({p.parent for p in SOURCES if p.relative_to(ROOT).parts[0] in LAYERS})


def folder(module):
    """The folder of a dotted module of this project, such as rcac_experiments.files."""
    path = ROOT.joinpath(*module.split("."))
    return module if path.is_dir() else module.rpartition(".")[0]


@cache
def imports(path):
    """(line, module, name of the function around it) for every import of this project.

    But for what a method imports to show its result.
    """
    return tuple(_imports(path))


def _imports(path):
    package = path.relative_to(ROOT).with_suffix("").parts[:-1]

    def visit(node, function):
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ImportFrom):
                base = package[: len(package) - child.level + 1] if child.level else ()
                module = ".".join((*base, *([child.module] if child.module else [])))
                for alias in child.names:
                    whole = f"{module}.{alias.name}"
                    yield child.lineno, whole if is_module(whole) else module, function
            elif isinstance(child, ast.Import):
                yield from ((child.lineno, alias.name, function) for alias in child.names)
            inside = function
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                inside = child.name
            elif isinstance(child, ast.If) and any(map(is_type_checking, ast.walk(child.test))):
                inside = "a type checker"
            yield from visit(child, inside)

    for line, module, function in visit(parsed(path), ""):
        shows = function in SHOWING and folder(module).rpartition(".")[2] in SHOWN_IN
        if module.split(".")[0] in PACKAGES and not shows:
            yield line, module, function


def is_type_checking(node):
    return "TYPE_CHECKING" in (getattr(node, "id", ""), getattr(node, "attr", ""))


@cache
def is_module(name):
    path = ROOT.joinpath(*name.split("."))
    return path.is_dir() or path.with_suffix(".py").exists() or path.with_suffix(".pyi").exists()


def rank(module):
    """(package, floor) of a module; what stands beside the folders is on the ground."""
    package, _, rest = folder(module).partition(".")
    floors = (number for number, floor in enumerate(FLOORS.get(package, ())) if rest in floor)
    return package, next(floors) if rest else -1


def wrong_arrows(path):
    """What a module imports that stands above it, as sentences."""
    ours = ".".join(path.relative_to(ROOT).with_suffix("").parts)
    package, floor = rank(ours) if ours.split(".")[0] in LAYERS else (ours.split(".")[0], -1)
    order = ["compensator_theory", "rcac_numeric", "rcac_experiments", "proofs"]
    for line, module, _ in imports(path):
        target = module.split(".")[0]
        where = f"{ours}, line {line}: imports {module}"
        if module == package:
            yield f"{where} itself: name the module"
        elif target != package:
            if order.index(target) > order.index(package):
                yield where
        elif package in LAYERS and rank(module)[1] > floor:
            yield f"{where}, which stands above it"
        elif package in LAYERS and rank(module)[1] == floor and folder(module) != folder(ours):
            yield f"{where}, which stands beside it"


def test_arrows_go_one_way():
    wrong = [sentence for path in SOURCES for sentence in wrong_arrows(path)]
    assert not wrong, "\n".join(wrong)


def test_imports_stand_at_the_top():
    """An import in a function, or for type checking only, hides a circle; libraries may come late.

    So may a package that stands below, which knows nothing of its users. An import by name hides a
    circle too.
    """
    for path in SOURCES:
        package = path.relative_to(ROOT).parts[0]
        within = [result for result in imports(path) if result[1].split(".")[0] == package]
        late = [(line, module) for line, module, function in within if function]
        assert not late, f"{path}: {late}"
        name, text = path.relative_to(ROOT).as_posix(), path.read_text()
        by_name = any(word in text for word in ("import_module", "resolve_name", "__import__"))
        assert not (by_name and not name.startswith("proofs/")) or name in BY_NAME, name


def test_only_the_engine_knows_the_kernel():
    kernel = "rcac_numeric.compiled._kernel"
    for path in SOURCES:
        if not {"compiled", "engine"} & {*path.relative_to(ROOT).parts}:
            assert kernel not in {module for _, module, _ in imports(path)}, path


@pytest.mark.costly
def test_analyses_run_nothing():
    """They read a Run, which is data; nothing that they import imports the kernel."""
    graph = _graph()
    for name in WITHOUT_ENGINE:
        reached = {m for m in graph if m.startswith(f"rcac_numeric.{name}.")}
        assert reached, f"there is no {name}"
        while more := {m for one in reached for m in graph.get(one, ())} - reached:
            reached |= more
        users = [m for m in reached if "rcac_numeric.compiled._kernel" in graph.get(m, ())]
        assert not users, f"{name} comes to the kernel by {users}"


@pytest.mark.costly
def test_the_exact_half_has_no_floats():
    for path in (ROOT / "compensator_theory").rglob("*.py"):
        for node in nodes(path):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] == "numpy" for name in names), path


def test_no_import_circle():
    """Also between the files of one folder."""
    graph = _graph()
    done, path = set(), []

    def visit(module):
        assert module not in path, " -> ".join([*path[path.index(module) :], module])
        if module in done or module not in graph:
            return
        path.append(module)
        for other in sorted(graph[module]):
            visit(other)
        path.pop()
        done.add(module)

    for module in graph:
        visit(module)


def test_a_folder_says_in_a_sentence_what_it_is():
    for folder in FOLDERS:
        docstring = ast.get_docstring(ast.parse((folder / "__init__.py").read_text()))
        assert docstring and docstring.split("\n")[0].endswith("."), folder


def test_the_list_of_layers_is_the_tree():
    for package, layers in LAYERS.items():
        result = {
            ".".join(p.relative_to(ROOT / package).parts)
            for p in (ROOT / package).rglob("*")
            if (p / "__init__.py").exists()
        }
        assert result == set(layers)


def test_public_names_are_documented():
    for package in ("compensator_theory", "rcac_numeric", "rcac_experiments"):
        for name, value in public_objects(package).items():
            if not (inspect.isclass(value) or inspect.isfunction(value)):
                continue
            text = inspect.getdoc(value) or ""
            assert len(text.splitlines()[0]) > 10, f"{package}.{name} says nothing"
            error = inspect.isclass(value) and issubclass(value, Exception)
            # A result is shown where it is made.
            shown = ">>>" in text or "Attributes\n----------" in text
            assert error or shown, f"{package}.{name} shows no example that runs"


def _graph():
    """From each module of the packages to those that it imports."""
    return {
        ".".join(p.relative_to(ROOT).with_suffix("").parts): {m for _, m, _ in imports(p)}
        for p in SOURCES
    }
