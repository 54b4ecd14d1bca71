"""The rules of the tests themselves: helpers stand in `support`, folders mirror the packages."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
MIRRORED = ("compensator_theory", "rcac_numeric", "proofs")
OTHERS = ("docs", "fuzz", "house", "notebooks", "support")  # they mirror no package
FILES = sorted(TESTS.rglob("*.py"))
HELPERS = sorted(p for p in (TESTS / "support").rglob("*.py") if p.name != "__init__.py")
FOLDERS = sorted({p.parent for p in FILES})
# Also in the text of a program that a test starts, and in a name list on several lines.
OF_A_TEST = re.compile(r"^[ \t]*(?:from|import)\s+(?:[^\n(]*\([^)]*|[^\n]*?)\btest_\w+", re.M)


def of_tests(path):
    """Paths below `tests` as a reader sees them."""
    return str(path.relative_to(TESTS))


@pytest.mark.parametrize("path", FILES, ids=of_tests)
def test_no_test_imports_a_test(path):
    """What two of them use is no test, and stands in `support`."""
    found = OF_A_TEST.search(path.read_text())
    assert not found, found.group()


@pytest.mark.parametrize(
    "line",
    [
        "from tests.rcac_numeric.engine.test_lanes import GOOD",
        "    from .test_lanes import GOOD",
        "import tests.rcac_numeric.engine.test_lanes as lanes",
        "from tests.rcac_numeric.engine import (\n    cases,\n    test_lanes,\n)",
        'PROGRAM = """\nimport numpy\nfrom tests.house.test_tests import ROOT\n"""',
    ],
)  # fmt: skip
def test_every_way_to_import_a_test_is_seen(line):
    assert OF_A_TEST.search(line)


@pytest.mark.parametrize("path", HELPERS, ids=of_tests)
def test_every_helper_has_one_idea_and_a_user(path):
    docstring = ast.get_docstring(ast.parse(path.read_text()))
    assert docstring and docstring.split("\n\n")[0].endswith("."), "says in a sentence what it is"
    name = f"tests.support.{path.stem}"
    imported = re.compile(rf"(from|import) {name}\b|from tests.support import .*\b{path.stem}\b")
    users = [p for p in FILES if p != path and imported.search(p.read_text())]
    assert users, f"nobody imports {name}"


@pytest.mark.parametrize("folder", FOLDERS, ids=of_tests)
def test_folders_mirror_the_packages(folder):
    parts = folder.relative_to(TESTS).parts
    assert (folder / "__init__.py").exists(), "two tests of the same name collide without it"
    if not parts or parts[0] in OTHERS:
        return
    assert parts[0] in MIRRORED
    mirrored = ROOT.joinpath(*parts)
    assert mirrored.is_dir(), f"there is no {mirrored.relative_to(ROOT)}"
