"""Every name of the packages that a page or a lecture writes is there; the docs build runs them."""

import ast
import json
import re
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("compensator_theory", "rcac_numeric", "rcac_experiments")
BLOCK = re.compile(r"^```(?:\{code-cell\} )?python\n(?:---\n.*?^---\n)?(.*?)^```", re.M | re.S)
GENERATED = {"_build", "reference", "notebooks", "jupyter_execute"}
SOURCES = [
    ROOT / "README.md",
    *(
        p
        for p in sorted((ROOT / "docs").rglob("*.md"))
        if not GENERATED & set(p.relative_to(ROOT).parts)
    ),
    *sorted((ROOT / "notebooks").rglob("*.ipynb")),
]


def blocks(path):
    """The code of a page or a lecture, without prompts, options and magics."""
    text = path.read_text("utf-8")
    if path.suffix == ".ipynb":
        cells = json.loads(text)["cells"]
        return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    result = []
    for code in BLOCK.findall(text):
        lines = code.splitlines()
        if ">>>" in code:
            lines = [line[4:] for line in lines if line.startswith((">>> ", "... "))]
        result.append("\n".join(line for line in lines if not line.startswith((":", "%"))))
    return result


def is_there(module, name):
    """Whether a module has a name, or a module of that name."""
    try:
        getattr(import_module(module), name)
    except AttributeError:
        try:
            import_module(f"{module}.{name}")
        except ImportError:
            return False
    return True


def names_used(tree):
    """The modules of the packages, and the names that are asked of them."""
    homes = {name: name for name in PACKAGES}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            homes |= {one.asname: one.name for one in node.names if one.asname}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in PACKAGES:
            yield from ((node.module, one.name) for one in node.names)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            home = homes.get(node.value.id, "")
            if home.split(".")[0] in PACKAGES and not node.attr.startswith("_"):
                yield home, node.attr


@pytest.mark.costly
@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_what_is_asked_for_is_there(path):
    code = []
    for block in blocks(path):
        try:
            code += ast.parse(block).body
        except SyntaxError:  # a sketch, with dots where the reader's own words go
            continue
    names = set(names_used(ast.Module(code, [])))
    assert not {pair for pair in names if not is_there(*pair)}
