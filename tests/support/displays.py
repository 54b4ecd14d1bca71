"""Tests of the tables of what shows results, of one package or of several."""

import ast
from pathlib import Path
from pkgutil import resolve_name
from typing import get_type_hints

import pytest

from rcac_numeric.reports._sheet import Sheet

ROOT = Path(__file__).parents[2]


def entries_of(page):
    """The test that each entry of a table takes the type that it stands for."""
    entries = [
        pytest.param(kind, shown, made, id=f"{kind} by {shown}")
        for table, made in (
            (page.PICTURES, "Figure"),
            (page.SHEETS, Sheet),
            (page.SMALL_PICTURES, "dict"),
        )
        for kind, shown in table.items()
    ]

    @pytest.mark.parametrize(("kind", "shown", "made"), entries)
    def test(kind, shown, made):
        shows, result = resolve_name(shown), resolve_name(kind)
        hints = get_type_hints(shows)
        assert next(iter(hints.values())) is result
        assert f"{result.__module__}:{result.__qualname__}" == kind  # no name of another's type
        assert hints["return"] is made or made in str(hints["return"])

    return test


def standing_of(packages, page):
    """The test that each class that calls picture_of(self) has a picture, and so on."""
    tables = {
        "picture_of": page.PICTURES,
        "report_of": page.SHEETS,
        "sheet_of": page.SHEETS,
        "notebook_of": page.SHEETS,
    }

    @pytest.mark.costly
    def test():
        asked = {name: set() for name in tables}
        for path in (one for name in packages for one in (ROOT / name).rglob("*.py")):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for kind in ast.walk(ast.parse(path.read_text())):
                if isinstance(kind, ast.ClassDef):
                    for call in ast.walk(kind):
                        name = getattr(getattr(call, "func", None), "id", None)
                        if name in tables:
                            asked[name].add(f"{module}:{kind.name}")
        for name, kinds in asked.items():
            assert kinds <= set(tables[name]), name
        assert asked["picture_of"] == set(tables["picture_of"]) != set()
        reports = set.union(*(asked[n] for n in tables if n != "picture_of"))
        assert reports == set(tables["sheet_of"]) != set()

    return test
