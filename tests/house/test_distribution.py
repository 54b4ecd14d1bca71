"""What a user meets before any mathematics: the version, the wheel, a checkout without a kernel."""

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import compensator_theory
import rcac_numeric

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PACKAGES = ("compensator_theory", "rcac_numeric", "rcac_experiments")
RECIPE = yaml.safe_load((ROOT / "recipe" / "recipe.yaml").read_text())


def test_the_version_is_that_of_the_distribution(monkeypatch):
    monkeypatch.setattr(importlib.metadata, "version", {"compensator-theory": "9.8.7"}.__getitem__)
    assert compensator_theory.__version__ == rcac_numeric.__version__ == "9.8.7"


def test_a_checkout_that_is_not_installed_says_so(monkeypatch):
    def absent(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", absent)
    assert compensator_theory.__version__ == rcac_numeric.__version__ == "0+not.installed"


@pytest.mark.parametrize("package", PACKAGES)
def test_the_version_is_asked_for_cheaply(package):
    heavy = "{'sympy', 'numpy'}"
    code = f"import sys, {package}; {package}.__version__; print({heavy} & {{*sys.modules}})"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "set()"


def test_one_version_everywhere():
    version = PROJECT["project"]["version"]
    assert re.search(rf"^version: {re.escape(version)}$", (ROOT / "CITATION.cff").read_text(), re.M)
    assert re.search(rf"^## {re.escape(version)}$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert RECIPE["context"]["version"] == version


def test_the_recipe_for_conda_is_this_project():
    """Its names differ in one: conda's Matplotlib without a window, which python-control needs."""
    project, needed = PROJECT["project"], RECIPE["requirements"]
    named = (line.partition(";")[0] for line in project["dependencies"])  # conda has no Pyodide
    lines = {re.sub(r"(?=>=)", " ", line) for line in named}
    (plot,) = project["optional-dependencies"]["plot"]
    lines.add(plot.replace("matplotlib>=", "matplotlib-base >="))
    assert set(needed["run"]) == {"python", *lines}
    build = {re.sub(r"(?=>=)", " ", line) for line in PROJECT["build-system"]["requires"]}
    assert set(needed["host"]) == {"python", "pip", *build}
    assert RECIPE["about"]["summary"] == project["description"]
    assert RECIPE["about"]["license"] == project["license"]
    (script,) = project["scripts"].items()
    assert RECIPE["build"]["python"]["entry_points"] == [" = ".join(script)]


def test_addresses_stand_in_one_place():
    """Before they are known nowhere; after that the citation and the recipe have them, too."""
    address = PROJECT["project"].get("urls", {}).get("Repository")
    cited = re.search(r"^repository-code: (.*)$", (ROOT / "CITATION.cff").read_text(), re.M)
    assert (cited[1].strip("\"'") if cited else None) == address
    assert RECIPE["about"].get("repository") == address


def test_classifiers_name_every_python_from_the_first_on():
    lowest = PROJECT["project"]["requires-python"].removeprefix(">=3.")
    named = [
        int(line.rpartition(".")[2])
        for line in PROJECT["project"]["classifiers"]
        if line.startswith("Programming Language :: Python :: 3.")
    ]
    assert named == list(range(int(lowest), named[-1] + 1))


def test_the_wheel_has_our_three_packages_only():
    assert PROJECT["tool"]["scikit-build"]["wheel"]["packages"] == [*PACKAGES]


@pytest.mark.parametrize(
    ("name", "holder"),
    [("nanobind", "Wenzel Jakob"), ("robin-map", "Thibaut Goetghebuer-Planchon")],
)
def test_the_wheel_holds_the_notices_of_what_is_compiled_in(name, holder):
    """nanobind and the hash map inside it become part of the kernel; their licences ask it."""
    (notice,) = (
        path
        for pattern in PROJECT["project"]["license-files"]
        for path in ROOT.glob(pattern)
        if path.stem == name
    )
    text = notice.read_text()
    assert holder in text and "copyright notice" in text and "PROVIDED" in text
    assert any(line.startswith("nanobind") for line in PROJECT["build-system"]["requires"])


NOT_BUILT = """
import sys
sys.meta_path[:] = [f for f in sys.meta_path if isinstance(f, type)]  # no editable installation
import rcac_numeric
assert rcac_numeric.Plant and rcac_numeric.__file__.startswith(sys.argv[1])
rcac_numeric.simulate
"""


def test_a_checkout_that_is_not_built_says_how_to_build_it(tmp_path):
    for package in PACKAGES:
        compiled = shutil.ignore_patterns("*.so", "*.pyd", "__pycache__")
        shutil.copytree(ROOT / package, tmp_path / package, ignore=compiled)
    out = subprocess.run(
        [sys.executable, "-c", NOT_BUILT, str(tmp_path)],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert out.returncode == 1 and out.stderr.count("Traceback") == 1, out.stderr
    last = out.stderr.splitlines()[-1]
    assert "KernelNotBuiltError: the compiled kernel of rcac_numeric is not built" in last
    assert "-m pip install -e .` builds it; that needs a C++17 compiler" in last
