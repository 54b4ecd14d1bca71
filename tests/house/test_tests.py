"""The rules of the tests themselves: helpers stand in `support`, folders mirror the packages."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
MIRRORED = ("compensator_theory", "rcac_numeric", "rcac_experiments", "proofs")
OTHERS = ("docs", "fuzz", "house", "notebooks", "support", "world")  # they mirror no package
EXERCISES = ("compensator_theory", "exercises")  # of many folders at once, by chapters of a course
FILES = sorted(TESTS.rglob("*.py"))
HELPERS = sorted(p for p in (TESTS / "support").rglob("*.py") if p.name != "__init__.py")
FOLDERS = sorted({p.parent for p in FILES})
# Also in the text of a program that a test starts, and in a name list on several lines.
OF_A_TEST = re.compile(r"^[ \t]*(?:from|import)\s+(?:[^\n(]*\([^)]*|[^\n]*?)\btest_\w+", re.M)


def test_no_test_imports_a_test():
    """What two of them use is no test, and stands in `support`."""
    for path in FILES:
        result = OF_A_TEST.search(path.read_text())
        assert not result, f"{path}: {result.group()}"


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


@pytest.mark.costly
def test_every_helper_has_one_idea_and_a_user():
    texts = {path: path.read_text() for path in FILES}
    for path in HELPERS:
        docstring = ast.get_docstring(ast.parse(texts[path]))
        assert docstring and docstring.split("\n\n")[0].endswith("."), f"{path} says what it is"
        name = f"tests.support.{path.stem}"
        # Imported, or run with -m by a test.
        used = re.compile(rf"\b{name}\b|from tests.support import .*\b{path.stem}\b")
        users = [p for p in FILES if p != path and used.search(texts[p])]
        assert users, f"nobody uses {name}"


def test_folders_mirror_the_packages():
    for folder in FOLDERS:
        parts = folder.relative_to(TESTS).parts
        assert (folder / "__init__.py").exists(), f"{folder}: tests of one name collide without it"
        if parts and parts[0] not in OTHERS and parts != EXERCISES:
            assert parts[0] in MIRRORED
            assert ROOT.joinpath(*parts).is_dir(), f"{folder} mirrors nothing"
