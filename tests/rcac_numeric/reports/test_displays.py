"""What shows a result is imported by the method that shows it, when it is asked."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import get_type_hints

import pytest

import rcac_numeric
from compensator_theory.errors import InputError
from rcac_numeric.reports import _displays as displays
from rcac_numeric.reports._sheet import Sheet

ROOT = Path(__file__).parents[3]


def showing():
    """(class, method, what it imports to show a result) in all packages."""
    for package in ("rcac_numeric", "rcac_experiments"):
        for path in sorted((ROOT / package).rglob("*.py")):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for kind in ast.walk(ast.parse(path.read_text())):
                methods = kind.body if isinstance(kind, ast.ClassDef) else ()
                for method in methods:
                    if getattr(method, "name", "") in ("plot", "_sheet"):
                        late = [n for n in ast.walk(method) if isinstance(n, ast.ImportFrom)]
                        if late:
                            (one,) = late
                            shows = (one.module, one.names[0].name)
                            yield pytest.param(
                                module, kind.name, method.name, *shows,
                                id=f"{kind.name}.{method.name}",
                            )  # fmt: skip


@pytest.mark.parametrize(("module", "kind", "method", "home", "function"), [*showing()])
def test_what_a_method_imports_makes_what_it_answers(module, kind, method, home, function):
    """One import, of a function that makes a sheet or a figure of that class."""
    shows = getattr(import_module(home), function)
    hints = get_type_hints(shows)
    result = hints.pop("return")
    assert result is Sheet if method == "_sheet" else "Figure" in str(result)
    assert kind in str(next(iter(hints.values()))) and getattr(import_module(module), kind)


def test_what_is_derived_is_shown_like_its_base():
    class Derived(rcac_numeric.results.LoopHealth):
        pass

    health = Derived(True, 0.5, "completed", 10, 0, {})
    assert health._sheet().health[0].words.startswith("The closed loop is stable")


def test_what_is_no_result_of_the_exact_half_is_refused_by_its_type():
    with pytest.raises(InputError, match="a complex cannot be shown"):
        displays.picture_of(1j)


@pytest.mark.costly
def test_a_report_loads_no_matplotlib_and_a_picture_no_user_of_the_library():
    code = """if True:
        import sys
        from rcac_numeric import Compensator, check_controller
        gain = Compensator(past_u=[[[0.0]]], past_y=[[[0.5]], [[0.0]]])
        check = check_controller([0.5, 1.0], [1.0, 2.0], compensator=gain)
        check.report()
        assert "matplotlib" not in sys.modules
        check.plot()
        assert "matplotlib" in sys.modules
        print(*{name.partition(".")[0] for name in sys.modules})
    """
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    packages = {"compensator_theory", "rcac_numeric", "rcac_experiments"}
    assert packages & set(done.stdout.split()) == {"compensator_theory", "rcac_numeric"}
