"""Nothing is read out of a message: what a program needs of an error is an attribute of it."""

import ast
import importlib
import inspect
import pkgutil
from pathlib import Path

import pytest

from compensator_theory.errors import Advice, CompensatorError, InputError
from docs.reference_pages import nodes
from rcac_experiments.cli._exits import AT_THE_SHELL, at_the_shell
from tests.support.advice import has_argument, known

ROOT = Path(__file__).parents[2]
PACKAGES = ("compensator_theory", "rcac_numeric", "rcac_experiments")
READS = {
    "replace", "startswith", "endswith", "partition", "rpartition", "removeprefix", "removesuffix",
    "split", "rsplit", "splitlines", "find", "rfind", "index", "rindex", "count", "translate",
}  # fmt: skip
SEARCHES = {"search", "match", "fullmatch", "findall", "finditer", "sub", "subn"}
OF_OTHERS = {
    "compensator_theory/libraries.py": "SymPy raises a plain ValueError; only its words tell which",
}


def is_error(annotation):
    """Whether a parameter is annotated as an exception."""
    names = {n.id for n in ast.walk(annotation) if isinstance(n, ast.Name)}
    return any(name.endswith(("Error", "Exception")) for name in names)


def errors_of(inside):
    """Names that hold an exception somewhere in a function."""
    caught = {h.name for h in inside if isinstance(h, ast.ExceptHandler) and h.name}
    parameters = [p for p in inside if isinstance(p, ast.arg) and p.annotation]
    return caught | {p.arg for p in parameters if is_error(p.annotation)}


def readings(module):
    """Lines where a text that was made of an exception is searched, taken apart or compared."""
    lines = set()
    for function in module:
        if not isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        inside = tuple(ast.walk(function))
        errors, texts = errors_of(inside), set()
        if not errors:
            continue

        def is_text(node, errors=errors, texts=texts):
            if isinstance(node, ast.Name):
                return node.id in texts
            if isinstance(node, ast.JoinedStr | ast.FormattedValue):
                return any(map(is_text, ast.iter_child_nodes(node))) or any(
                    isinstance(n, ast.Name) and n.id in errors for n in ast.iter_child_nodes(node)
                )
            if not isinstance(node, ast.Call):
                return False
            if isinstance(node.func, ast.Name) and node.func.id in ("str", "repr"):
                return any(isinstance(n, ast.Name) and n.id in errors for n in ast.walk(node))
            method = isinstance(node.func, ast.Attribute) and node.func.attr in READS | {"rstrip"}
            return method and is_text(node.func.value)

        for node in inside:
            if isinstance(node, ast.Assign) and is_text(node.value):
                texts |= {t.id for t in node.targets if isinstance(t, ast.Name)}
        for node in inside:
            if isinstance(node, ast.Compare) and any(map(is_text, [node.left, *node.comparators])):
                lines.add(node.lineno)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                is_split = node.func.attr in READS and is_text(node.func.value)
                searched = node.func.attr in SEARCHES and any(map(is_text, node.args))
                if is_split or searched:
                    lines.add(node.lineno)
    return lines


@pytest.mark.parametrize("package", PACKAGES)
def test_no_message_is_read(package):
    wrong = []
    for path in sorted((ROOT / package).rglob("*.py")):
        name = str(path.relative_to(ROOT))
        if name not in OF_OTHERS:
            wrong += [f"{name}:{line}" for line in readings(nodes(path))]
    assert not wrong, "give the error an attribute that says it"


@pytest.mark.parametrize(
    ("code", "is_read"),
    [
        ("if 'n_c' in str(error): pass", True),
        ("text = str(error); text = text.replace('B', 'C')", True),
        ("re.search('n_c', str(error))", True),
        ("PATTERN.sub('', f'{error}')", True),
        ("kind = str(error).partition(': ')", True),
        ("if error.key == 'n_c': pass", False),
        ("reason = str(error).rstrip('.')", False),
        ("raise InputError('file: ', *error.args)", False),
        ("if len(str(error)) > 5: pass", False),
    ],
)
def test_a_reading_is_found(code, is_read):
    for head in ("try:\n  call()\n except InputError as error:\n  ", ""):
        parameters = "" if head else "error: CompensatorError"
        function = f"def f({parameters}):\n {head}{code}"
        assert bool(readings(ast.walk(ast.parse(function)))) == is_read


def advices():
    """Each advice that stands in the packages as a constant."""
    for package in PACKAGES:
        for module in pkgutil.walk_packages(
            importlib.import_module(package).__path__, f"{package}."
        ):
            if not module.name.endswith("__main__"):
                for _, value in inspect.getmembers(importlib.import_module(module.name)):
                    parts = value if isinstance(value, tuple) else (value,)
                    yield from (part for part in parts if isinstance(part, Advice))


def written():
    """Names of functions and of their first argument, of every Advice(...) in the packages."""
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            for node in nodes(path):
                if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Advice":
                    function, arguments, _ = node.args
                    pairs = [p.elts[0] for p in getattr(arguments, "elts", ())]
                    names = [n.value if isinstance(n, ast.Constant) else None for n in pairs]
                    yield f"{path.relative_to(ROOT)}:{node.lineno}", function.value, names


WRITTEN = [*written()]
TABLE = known()


@pytest.mark.parametrize("place", WRITTEN, ids=lambda one: one[0])
def test_an_advice_names_a_function_and_its_arguments(place):
    _, function, names = place
    for name in names or [""]:
        assert has_argument(TABLE, function, name), (function, name)


@pytest.mark.parametrize("key", AT_THE_SHELL, ids=":".join)
def test_the_table_of_the_shell_has_no_advice_that_nobody_gives(key):
    function, argument = key
    advised = {(f, n) for _, f, names in WRITTEN for n in names or [""]}
    assert any(f == function and argument in ("", n) for f, n in advised)


@pytest.mark.parametrize("advice", set(advices()), ids=lambda one: one.function)
def test_an_advice_is_said_to_either_reader(advice):
    assert str(advice) and "{" not in str(advice)
    assert at_the_shell(advice) != str(advice)


def test_a_message_of_parts():
    advice = Advice("place_poles", (("n_c", "2"),), "from {function}(..., n_c={n_c}) on")
    inner = InputError("no solution; ", advice, ".")
    outer = InputError("the file: ", *inner.args)
    assert str(inner) == "no solution; from place_poles(..., n_c=2) on."
    assert outer.advice == inner.advice == (advice,)
    assert outer.message_for(at_the_shell) == "the file: no solution; From --order 2 on."
    unknown = Advice("no_option", (("a", "{1}"),), "give {function}(a={a})")
    assert InputError(unknown).message_for(at_the_shell) == "give no_option(a={1})"
    assert not CompensatorError("plain").advice and str(CompensatorError()) == ""
