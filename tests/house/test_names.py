"""A class name means one thing in the three packages together."""

import ast
from collections import defaultdict
from pathlib import Path

from docs.reference_pages import nodes

ROOT = Path(__file__).parents[2]
PACKAGES = ("compensator_theory", "rcac_numeric", "rcac_experiments")
TWICE: dict[str, str] = {}
"""Names that stand for two classes, with the reason."""


def homes():
    """Files by the names of the classes that stand in them, those inside functions too."""
    files = defaultdict(list)
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            for node in nodes(path):
                if isinstance(node, ast.ClassDef):
                    files[node.name].append(str(path.relative_to(ROOT)))
    return files


def test_each_class_has_a_name_of_its_own():
    several = {name: places for name, places in homes().items() if len(places) > 1}
    assert set(several) == set(TWICE), several
