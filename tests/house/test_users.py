"""The library does not know its users: no package names one that stands above it.

Code, strings, docstrings, doctests and comments count. One thing is allowed: the prose of a
docstring, or the words of an error, may point a person of the exact half on to a public name of
rcac_numeric.
"""

import ast
import doctest
import re
from functools import cache
from pathlib import Path

import pytest

from docs.reference_pages import namespaces, public_names, public_path

ROOT = Path(__file__).resolve().parents[2]
ABOVE = {
    "compensator_theory": ("rcac_numeric", "rcac_experiments"),
    "rcac_numeric": ("rcac_experiments",),
    "kernel": ("rcac_experiments",),
}
# To whom the prose of a package may point on.
POINTS_TO = {"compensator_theory": "rcac_numeric"}
WORDS = {".py", ".pyi", ".html", ".css", ".js", ".hpp", ".cpp", ".h", ".c", ".txt", ".md", ".toml"}
FILES = sorted(
    path for package in ABOVE for path in (ROOT / package).rglob("*") if path.suffix in WORDS
)
TESTS = ROOT / "tests"
IMPORTED = re.compile(
    r"^[ \t>.]*(?:from|import)[ \t]+([\w.]+)(?:[ \t]+import[ \t]+(\([^)]*|[^\n]*))?", re.M
)


@cache
def public(package):
    """The dotted names that a person can import."""
    return {*namespaces(package), *(public_path(package, name) for name in public_names(package))}


def named(package, suffix, text):
    """Each place where a source names what stands above its package, as a sentence."""
    above = "|".join(ABOVE[package])
    pattern = re.compile(rf"\b(?:{above})\b[\w.:]*")
    allowed = set(_pointers(package, text)) if suffix == ".py" else set()
    for number, line in enumerate(text.split("\n"), 1):
        for result in pattern.finditer(line):
            if (number, name := result.group().rstrip(".:")) not in allowed:
                yield f"line {number} names {name}"


def _pointers(package, text):
    """(line, name) of what prose and errors may say."""
    target = POINTS_TO.get(package)
    if target is None:
        return
    tree = ast.parse(text)
    lines = text.split("\n")
    docstrings, raised = set(), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0] if node.body else None
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                docstrings.add(first.value)
        elif isinstance(node, ast.Raise) and node.exc is not None:
            raised |= {part for part in ast.walk(node.exc) if isinstance(part, ast.Constant)}
    for node in docstrings | raised:
        if not isinstance(node.value, str):
            continue
        shown = set()
        if node in docstrings:
            for one in doctest.DocTestParser().get_examples(node.value):
                first = node.lineno + one.lineno
                length = one.source.count("\n") + one.want.count("\n")
                shown |= set(range(first, first + length))
        for number in range(node.lineno, (node.end_lineno or node.lineno) + 1):
            for result in re.finditer(rf"\b{target}\b[\w.:]*", lines[number - 1]):
                name = result.group().rstrip(".:")
                if number not in shown and name in public(target):
                    yield number, name


@pytest.mark.costly
@pytest.mark.parametrize("package", ABOVE)
def test_no_package_names_its_users(package):
    result = [
        f"{path.relative_to(ROOT)}: {place}"
        for path in FILES
        if path.relative_to(ROOT).parts[0] == package
        for place in named(package, path.suffix, path.read_text(encoding="utf-8"))
    ]
    assert len(FILES) > 400 and not result, "\n".join(result)


NAMES = {
    "an import": "from rcac_experiments import verify",
    "an import in a function": "def f():\n    import rcac_experiments.cli",
    "a path that code resolves": 'TABLE = "rcac_experiments.reports._displays"',
    "a path in a call": 'import_module("rcac_experiments.reports")',
    "a docstring": '"""See `rcac_experiments.tune`."""',
    "a doctest": 'def f():\n    """F.\n\n    >>> from rcac_experiments import tune\n    """',
    "a comment": "x = 1  # rcac_experiments reads it",
    "an error": 'raise ValueError("ask rcac_experiments.tune")',
}
OF_THE_EXACT_HALF = {
    "an import": "from rcac_numeric import simulate",
    "a late import": "def f():\n    from rcac_numeric import simulate",
    "a path that code resolves": 'TABLE = "rcac_numeric.reports._displays:picture_of"',
    "a public path that code resolves": 'TABLE = "rcac_numeric.plots.plot_runs"',
    "a docstring with an inner name": '"""See ``rcac_numeric.plots._runs.plot_runs``."""',
    "a docstring with no name of it": '"""See ``rcac_numeric.numeric_forms``."""',
    "a doctest": 'def f():\n    """F.\n\n    >>> from rcac_numeric import simulate\n    """',
    "the answer of a doctest": 'def f():\n    """F.\n\n    >>> f()\n    rcac_numeric.fir\n    """',
    "a comment": "x = 1  # rcac_numeric.simulate asks it",
    "an error with an inner path": 'raise ValueError("see rcac_numeric.engine._runs")',
    "an error that resolves": 'raise getattr(import_module("rcac_numeric._errors"), "X")("x")',
}
MAY_SAY = {
    "a docstring": '"""``rcac_numeric.observer_forms`` answers this."""',
    "a docstring with a namespace": '"""``rcac_numeric.plots.plot_stability_region`` draws it."""',
    "an error": 'raise ValueError("use rcac_numeric.stability_margins.")',
    "an error with a value": 'raise ValueError(f"{x}: use rcac_numeric.stability_margins.")',
    "an error with the package": 'raise ValueError("install rcac_numeric.")',
}


@pytest.mark.parametrize("package", ABOVE)
@pytest.mark.parametrize("name", NAMES)
def test_a_source_that_names_its_user_is_found(package, name):
    assert list(named(package, ".py", NAMES[name]))


@pytest.mark.parametrize("name", OF_THE_EXACT_HALF)
def test_a_source_of_the_exact_half_that_needs_the_numeric_one_is_found(name):
    assert list(named("compensator_theory", ".py", OF_THE_EXACT_HALF[name]))


@pytest.mark.parametrize("name", MAY_SAY)
def test_prose_may_point_a_person_on(name):
    assert not list(named("compensator_theory", ".py", MAY_SAY[name]))
    assert list(named("compensator_theory", ".pyi", MAY_SAY[name]))


# The tests of a package use no user of it, in what they import from tests.support neither.


def imported(text):
    """The modules that a source imports, in programs that it holds as strings, too."""
    for module, names in IMPORTED.findall(text):
        yield module
        if module in ("tests", "tests.support"):
            yield from (f"{module}.{name}" for name in re.findall(r"\w+", names))


def users_in(path, above, visited=()):
    """What of the packages above a test reaches, by which way."""
    for module in imported(path.read_text(encoding="utf-8")):
        if module.split(".")[0] in above:
            yield " -> ".join([*visited, path.relative_to(ROOT).as_posix(), module])
        other = ROOT.joinpath(*module.split(".")).with_suffix(".py")
        name = other.relative_to(ROOT).as_posix()
        if module.startswith("tests.") and other.exists() and name not in visited and other != path:
            yield from users_in(other, above, (*visited, path.relative_to(ROOT).as_posix()))


@pytest.mark.parametrize("package", ["compensator_theory", "rcac_numeric"])
def test_tests_of_a_package_import_no_user_of_it(package):
    result = [
        way for path in (TESTS / package).rglob("*.py") for way in users_in(path, ABOVE[package])
    ]
    assert not result, "\n".join(result)


@pytest.mark.parametrize(
    "text",
    [
        "from rcac_experiments import verify",
        "    import rcac_experiments.cli",
        'PROGRAM = """\nfrom rcac_experiments import verify\n"""',
        "from tests.support.mutations import outcomes",
        "from tests.support import comparisons, mutations",
        "from tests.support import (\n    comparisons,\n    mutations,\n)",
    ],
)
def test_a_test_that_imports_a_user_is_found(text, monkeypatch):
    file = TESTS / "rcac_numeric" / "__init__.py"
    read = Path.read_text

    def changed(path, *arguments, **options):
        return text if path == file else read(path, *arguments, **options)

    monkeypatch.setattr(Path, "read_text", changed)
    assert list(users_in(file, ABOVE["rcac_numeric"]))
