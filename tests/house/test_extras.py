"""The core computes without the libraries of the extras, and names the extra that it lacks."""

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from compensator_theory.libraries import EXTRAS
from docs.reference_pages import nodes

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
OURS = {"compensator_theory", "rcac_numeric", "rcac_experiments"}
# What a library is imported as, where its distribution has another name.
IMPORTED_AS = {"lazy-loader": "lazy_loader", "python-flint": "flint"}

# An interpreter in which none of the libraries of the extras is installed.
WITHOUT = f"""
import sys
sys.modules.update(dict.fromkeys({sorted(EXTRAS)!r}))
from compensator_theory.errors import InputError
"""


def names(requirements):
    return {re.match(r"[\w-]+", line)[0] for line in requirements}


def libraries_of(path):
    """The packages that a file imports, our own and those of Python left out."""
    for node in nodes(path):
        result = []
        if isinstance(node, ast.Import):
            result = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            result = [node.module]
        yield from {name.partition(".")[0] for name in result} - OURS - set(sys.stdlib_module_names)


@pytest.mark.costly
def test_every_library_is_required_or_in_an_extra():
    required = {IMPORTED_AS.get(name, name) for name in names(PROJECT["dependencies"])}
    assert not required & set(EXTRAS)
    for package in OURS:
        for path in (ROOT / package).rglob("*.py"):
            assert not set(libraries_of(path)) - required - set(EXTRAS) - {"mpl_toolkits"}, path


@pytest.mark.parametrize("library", sorted(EXTRAS))
def test_an_extra_brings_what_its_message_says(library):
    assert library in names(PROJECT["optional-dependencies"][EXTRAS[library]])


def run(code, *arguments, cwd=ROOT):
    return subprocess.run(
        [sys.executable, "-c", WITHOUT + code, *arguments],
        capture_output=True, text=True, check=False, cwd=cwd,
    )  # fmt: skip


COMMAND = "from rcac_experiments.cli.__main__ import main\nmain()"


@pytest.mark.costly
def test_the_core_verifies_an_example_without_any_extra():
    out = run(COMMAND, "verify", "4.7")
    assert out.returncode == 0, out.stderr
    assert "-36/25" in out.stdout and not out.stderr


@pytest.mark.costly
@pytest.mark.parametrize("option", [["--plot", "4.7.png"], ["--page", "4.7.html"]])
def test_a_picture_is_refused_before_anything_runs(option, tmp_path):
    out = run(COMMAND, "verify", "4.7", *(str(tmp_path / o) if "." in o else o for o in option))
    assert out.returncode == 2 and not out.stdout
    assert "compensator-theory[plot]" in out.stderr and "Traceback" not in out.stderr


@pytest.mark.costly
def test_every_door_names_its_extra():
    out = run(
        """
import rcac_numeric as r, compensator_theory as c
def said(ask):
    try:
        ask()
    except InputError as error:
        return str(error)
    return "nothing was missing"
plant = r.standard_plant("1/(q - 1.2)")
run = r.simulate(plant, r.FixedController(r.lqg_controller(plant).compensator), [[0.0]] * 9)
assert "Run" in run._repr_html_() and "<svg" not in run._repr_html_()
for ask, extra in (
    (run.plot, "plot"), (r.lqg_controller(plant).plot, "plot"), (run.to_pandas, "pandas"),
    (run.to_xarray, "pandas"), (lambda: c.strategies.polynomials, "proofs"),
):
    assert f"compensator-theory[{extra}]" in said(ask), (ask, said(ask))
print("all of them")
"""
    )
    assert out.stdout == "all of them\n", out.stderr


@pytest.mark.costly
def test_packages_are_walked_and_names_taken_without_any_extra():
    out = run(
        """
import importlib, pkgutil
import compensator_theory, rcac_numeric
sys.modules.update(dict.fromkeys(["distributed", "dask", "IPython", "ipykernel"]))
exec("from compensator_theory import *\\nfrom rcac_numeric import *")
for package in (compensator_theory, rcac_numeric):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        try:
            importlib.import_module(module.name)
        except ModuleNotFoundError as error:
            assert error.name == "hypothesis", (module.name, error)
            assert module.name.startswith("compensator_theory.strategies."), module.name
assert not hasattr(compensator_theory.strategies, "nothing")
print("all of them")
"""
    )
    assert out.stdout == "all of them\n", out.stderr
