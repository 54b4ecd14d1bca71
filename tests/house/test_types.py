"""Types that mean it: no public field or parameter of a public class says Any."""

import ast
import re
from pathlib import Path

import pytest

from docs.reference_pages import parsed, public_names

ROOT = Path(__file__).resolve().parents[2]
HOMES = [
    (name, m)
    for p in ("compensator_theory", "rcac_numeric", "rcac_experiments")
    for name, m in public_names(p).items()
]


def fields(name, module):
    """(field, annotation) of a public class; nothing for a function."""
    path = ROOT.joinpath(*module.split("."))
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    for node in parsed(path).body:
        if isinstance(node, ast.ClassDef) and node.name == name:
            for entry in node.body:
                if isinstance(entry, ast.AnnAssign) and isinstance(entry.target, ast.Name):
                    yield entry.target.id, ast.unparse(entry.annotation)
                if isinstance(entry, ast.FunctionDef) and not entry.name.startswith("_"):
                    yield f"{entry.name}()", ast.unparse(entry.returns) if entry.returns else "Any"


@pytest.mark.costly
def test_a_wrong_attribute_is_seen():
    """What is annotated Any hides every mistake behind it."""
    vague = [
        f"{module}.{name}.{f}"
        for name, module in HOMES
        for f, annotation in fields(name, module)
        if re.fullmatch(r"(Any|object)( \| None)?", annotation)
    ]
    assert not vague, ", ".join(vague)
