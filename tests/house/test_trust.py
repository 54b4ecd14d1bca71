"""A file never chooses code: what a file's text can reach is a list, and nothing else looks up."""

import ast
import tomllib
from collections import Counter, defaultdict
from functools import cache
from pathlib import Path

import pytest

from docs.reference_pages import nodes
from tests.house.reachable import PAGE, reachable, written

ROOT = Path(__file__).parents[2]
JUSTIFIED = tomllib.loads((Path(__file__).parent / "trust.toml").read_text())
# What runs a text, imports by a name, or starts a program.
CALLS = {
    "eval": "eval", "exec": "exec", "compile": "exec", "__import__": "import",
    "import_module": "import", "sympify": "sympify", "parse_expr": "sympify",
    "system": "process", "popen": "process", "execv": "process", "execvp": "process",
    "spawnl": "process", "posix_spawn": "process", "Popen": "process", "load_library": "process",
    "CDLL": "process",
}  # fmt: skip
BUILTINS = ("eval", "exec", "compile", "__import__")
MODULES = {"pickle": "pickle", "marshal": "pickle", "shelve": "pickle", "dill": "pickle",
           "cloudpickle": "pickle", "joblib": "pickle", "subprocess": "process",
           "runpy": "exec", "code": "exec"}  # fmt: skip
LOADERS = ("load", "loadtxt", "read_array", "genfromtxt", "fromfile", "memmap")


def kinds_in(module):
    """What the nodes of a module do of this, once for each place."""
    for node in module:
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [alias.name for alias in node.names]
            module = (node.module or "") if isinstance(node, ast.ImportFrom) else ""
            kinds = [MODULES.get(name.partition(".")[0]) for name in (module, *names)]
            if module.partition(".")[0] in ("os", "sympy", "importlib", "builtins", "ctypes"):
                kinds += [CALLS.get(name) for name in names]
            yield from filter(None, kinds)
        elif isinstance(node, ast.Name | ast.Attribute):
            is_name = isinstance(node, ast.Name)
            ours = node.id if is_name else node.attr
            # A polynomial has a method eval, and a variable may be called system.
            if ours in BUILTINS if is_name else ours in CALLS and _is_module(node.value):
                yield CALLS[ours]
        if isinstance(node, ast.Call):
            yield from kinds_of_call(node)


def kinds_of_call(node):
    """A lookup by a name that is not written there, and a reader that could unpickle."""
    function = node.func
    ours = function.id if isinstance(function, ast.Name) else getattr(function, "attr", "")
    if ours == "getattr" and not isinstance(node.args[1], ast.Constant):
        yield "getattr"
    argument = {word.arg: word.value for word in node.keywords}
    allowed = argument.get("allow_pickle")
    if allowed is not None and getattr(allowed, "value", True) is not False:
        yield "pickle"
    of_numpy = isinstance(function, ast.Attribute) and _is_module(function.value)
    if ours in LOADERS and of_numpy and function.value.id in ("np", "npy", "numpy", "format"):
        yield "numpy reader" if ours != "read_array" or allowed is None else "numpy array"


def _is_module(node):
    return isinstance(node, ast.Name) and node.id in (
        "np", "npy", "numpy", "format", "os", "builtins", "sympy", "importlib", "ctypes",
    )  # fmt: skip


@cache
def occurring():
    """How often each kind occurs in each file of the packages."""
    result = defaultdict(Counter)
    for package in ("compensator_theory", "rcac_numeric", "rcac_experiments"):
        for path in sorted((ROOT / package).rglob("*.py")):
            for kind in kinds_in(nodes(path)):
                result[kind][path.relative_to(ROOT).as_posix()] += 1
    return result


@pytest.mark.costly
@pytest.mark.parametrize("kind", sorted(JUSTIFIED))
def test_what_could_run_a_text_stands_in_named_places(kind):
    """A new place must be looked at, and named in trust.toml with its reason; an old one goes."""
    assert JUSTIFIED[kind]["why"]
    assert sorted(occurring()[kind]) == sorted(JUSTIFIED[kind].get("files", []))


def test_every_kind_is_justified():
    assert set(occurring()) <= set(JUSTIFIED)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("eval(x)", "eval"), ("__import__(x)", "import"), ("import pickle", "pickle"),
        ("from importlib import import_module as i\nimportlib.import_module(x)", "import"),
        ("getattr(a, name)", "getattr"), ("np.load(f, allow_pickle=True)", "pickle"),
        ("np.load(f)", "numpy reader"), ("sympy.sympify(t)", "sympify"),
        ("os.system(t)", "process"), ("from os import system", "process"),
        ("from sympy import sympify", "sympify"), ("from subprocess import run", "process"),
        ("map(eval, texts)", "eval"), ("np.load(f, allow_pickle=flag)", "pickle"),
    ],
)  # fmt: skip
def test_the_search_finds(text, kind):
    assert kind in set(kinds_in(ast.walk(ast.parse(text))))


@pytest.mark.parametrize(
    "text", ["poly.eval(0)", "re.compile(t)", "getattr(a, 'b', None)", "system(t)", "system.poles"]
)
def test_the_search_leaves_alone(text):
    assert not set(kinds_in(ast.walk(ast.parse(text))))


def test_the_list_of_what_a_file_can_reach_is_the_one_in_the_docs():
    """After a look at what is new: `python -m tests.house.reachable`."""
    assert written() == PAGE.read_text("utf-8")


def test_what_a_file_can_reach_is_ours():
    for functions in reachable().values():
        assert functions
        for function, _ in functions:
            assert function.startswith(
                ("rcac_experiments.", "rcac_numeric.", "compensator_theory.")
            ), function
