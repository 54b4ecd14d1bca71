"""What shows a result is found through one table, whose entries are what they say."""

import ast
import subprocess
import sys
from pathlib import Path
from pkgutil import resolve_name
from typing import get_type_hints

import pytest

import rcac_numeric
from compensator_theory.errors import InputError
from rcac_experiments.reports import _displays as more
from rcac_numeric.arrays import _showing as showing
from rcac_numeric.reports import _displays as displays
from rcac_numeric.reports._sheet import Sheet

ENTRIES = [
    pytest.param(kind, shown, made, id=f"{kind} by {shown}")
    for page in (displays, more)
    for table, made in (
        (page.PICTURES, "Figure"),
        (page.SHEETS, Sheet),
        (page.SMALL_PICTURES, "dict"),
    )
    for kind, shown in table.items()
]


@pytest.mark.parametrize(("kind", "shown", "made"), ENTRIES)
def test_an_entry_takes_the_type_that_it_stands_for(kind, shown, made):
    shows, result = resolve_name(shown), resolve_name(kind)
    hints = get_type_hints(shows)
    assert next(iter(hints.values())) is result
    assert f"{result.__module__}:{result.__qualname__}" == kind  # no name of somebody else's type
    assert hints["return"] is made or made in str(hints["return"])


@pytest.mark.costly
def test_every_result_that_asks_the_table_stands_in_it():
    """A class that calls picture_of(self) has a picture, and so on."""
    tables = {
        "picture_of": displays.PICTURES | more.PICTURES,
        "report_of": displays.SHEETS | more.SHEETS,
        "sheet_of": displays.SHEETS | more.SHEETS,
        "notebook_of": displays.SHEETS | more.SHEETS,
    }
    asked = {name: set() for name in tables}
    root = Path(rcac_numeric.__file__).parents[1]
    packages = ("compensator_theory", "rcac_numeric", "rcac_experiments")
    for path in (one for name in packages for one in (root / name).rglob("*.py")):
        module = ".".join(path.relative_to(root).with_suffix("").parts)
        for kind in ast.walk(ast.parse(path.read_text())):
            if isinstance(kind, ast.ClassDef):
                for call in ast.walk(kind):
                    name = getattr(getattr(call, "func", None), "id", None)
                    if name in tables:
                        asked[name].add(f"{module}:{kind.name}")
    for name, kinds in asked.items():
        assert kinds and kinds <= set(tables[name]), name
    assert asked["picture_of"] == set(tables["picture_of"])
    assert set.union(*(asked[n] for n in tables if n != "picture_of")) == set(tables["sheet_of"])


def test_what_is_derived_is_shown_like_its_base():
    class Derived(rcac_numeric.results.LoopHealth):
        pass

    health = Derived(True, 0.5, "completed", 10, 0, {})
    assert showing.sheet_of(health).health[0].words.startswith("The closed loop is stable")


@pytest.mark.parametrize(
    "ask", [showing.picture_of, showing.sheet_of, showing.report_of, showing.notebook_of]
)
def test_what_has_no_entry_is_refused_by_its_type(ask):
    with pytest.raises(InputError, match="a complex cannot be shown"):
        ask(1j)


@pytest.mark.costly
def test_a_report_loads_no_matplotlib_and_a_picture_no_studies():
    code = """if True:
        import sys
        import numpy as np
        from rcac_numeric import Compensator, check_controller
        gain = Compensator(past_u=[[[0.0]]], past_y=[[[0.5]], [[0.0]]])
        check = check_controller([0.5, 1.0], [1.0, 2.0], compensator=gain)
        check.report()
        assert "matplotlib" not in sys.modules
        check.plot()
        assert "matplotlib" in sys.modules
        assert not [name for name in sys.modules if name.startswith("rcac_experiments.sweeps.")]
    """
    subprocess.run([sys.executable, "-c", code], check=True)
