"""The rules of the house that a machine can check."""

import ast
import importlib
import inspect
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("compensator_theory", "rcac_numeric", "proofs")
ANALYSIS = [
    "closed_loop",
    "comparison",
    "residual_split",
    "compensators",
    "h2_costs",
    "loop_costs",
    "lyapunov",
    "noise",
    "riccati",
    "riccati_obstacles",
    "riccati_solutions",
    "lqg_design",
    "lqg_agreement",
    "state_space_compensators",
    "broken_loops",
    "crossovers",
    "margin_boundaries",
    "margins",
    "disk_margins",
    "internal_models",
    "replays",
    "check_analyses",
    "controller_checks",
    "controller_logs",
    "log_files",
]
MODULES = sorted(p for package in PACKAGES for p in (ROOT / package).rglob("*.py"))


def imports(path):
    """Dotted names of the modules of this project that a file imports, anywhere in it."""
    package = ".".join(path.relative_to(ROOT).with_suffix("").parts[:-1])
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            base = package if node.level else ""
            module = ".".join(part for part in (base, node.module or "") if part)
            yield module
            yield from (f"{module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_arrows_go_one_way(path):
    package, name = path.relative_to(ROOT).parts[0], path.stem
    found = set(imports(path))
    if package == "compensator_theory":
        assert not any(module.startswith(("rcac_numeric", "proofs")) for module in found)
        assert not any(module.split(".")[0] == "numpy" for module in found), "no floats in here"
    if package == "rcac_numeric":
        assert not any(module.startswith("proofs") for module in found)
    if name in ANALYSIS:
        assert "rcac_numeric.simulation" not in found, "analysis never imports simulation"
    if name not in ("cli", "__init__"):
        on_top = {"rcac_numeric.plots", "rcac_numeric.report", "rcac_numeric.cli"}
        assert not on_top & found, "nothing imports what sits on top"


def test_the_list_of_analyses_names_files():
    names = {path.stem for path in MODULES if path.parent.name == "rcac_numeric"}
    assert names.issuperset(ANALYSIS)


def public_names():
    for package in ("compensator_theory", "rcac_numeric"):
        module = importlib.import_module(package)
        for name in sorted(module.__all__):
            value = getattr(module, name)
            if inspect.isclass(value) or inspect.isfunction(value):
                yield pytest.param(value, id=f"{package}.{name}")


@pytest.mark.parametrize("value", list(public_names()))
def test_public_names_are_documented(value):
    text = inspect.getdoc(value) or ""
    assert len(text.splitlines()[0]) > 10
    if inspect.isclass(value) and issubclass(value, Exception):
        return
    assert ">>>" in text or _is_result(value), "a public docstring shows an example that runs"


def _is_result(value):
    """Results are shown where they are made."""
    return inspect.isclass(value) and "Attributes\n----------" in inspect.getdoc(value)
