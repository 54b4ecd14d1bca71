"""Which small errors in a module the tests of its own name find.

Run with: python benchmarks/mutants.py [COUNT] [SEED] [FOLDER OR MODULE ...]

A mutant is a module in which one comparison, sign, connective, condition or number, of a function
or of a constant, is another, drawn with the seed among all of the modules that have tests of their
name. It is made while the module is imported and stands in no file. The tests of that name run on
it, each mutant in a process of its own; it is killed where one of them fails or they do not come to
an end. What survives is a missing test, or a change that changes nothing.
"""

from __future__ import annotations

import ast
import os
import random
import subprocess
import sys
from collections.abc import Iterator
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("compensator_theory", "rcac_numeric", "rcac_experiments")
# What is printed, drawn, written or read there is held by the tests of other names.
NOT_CORE = {"cli", "dissertation", "experiments", "export", "plots", "reports", "strategies"}
LONGEST = 300  # seconds

SWAPPED = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult, ast.And: ast.Or, ast.Or: ast.And, ast.USub: ast.UAdd,
}  # fmt: skip


def places(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes that a mutant may change: no annotation, no docstring, no text of an error."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.Raise | ast.JoinedStr | ast.Assert):
                continue
            if isinstance(child, ast.AST):
                if changed(child) is not None:
                    yield child
                yield from places(child)


def changed(node: ast.AST) -> tuple[str, Any] | None:
    """The field of a node that becomes another, and what it becomes."""
    match node:
        case ast.Compare(ops=[first, *rest]) if type(first) in SWAPPED:
            return "ops", [SWAPPED[type(first)](), *rest]
        case ast.BinOp(op=op) | ast.BoolOp(op=op) | ast.UnaryOp(op=op) | ast.AugAssign(op=op):
            return ("op", SWAPPED[type(op)]()) if type(op) in SWAPPED else None
        case ast.If(test=test) | ast.IfExp(test=test):
            return "test", ast.UnaryOp(ast.Not(), test)
        case ast.Constant(value=bool(value)):
            return "value", not value
        case ast.Constant(value=int(value)):
            return "value", value + 1
        case ast.Constant(value=float(value)):
            return "value", 1 - value if 0 < value < 1 and value != 0.5 else 2 * value + 1
    return None


def parts(tree: ast.Module) -> list[ast.AST]:
    """The functions of a module, the methods of its classes, and its constants."""
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    return [
        node
        for body in (tree.body, *(one.body for one in classes))
        for node in body
        if isinstance(node, ast.FunctionDef) or (body is tree.body and isinstance(node, ast.Assign))
    ]


def mutants(text: str) -> int:
    """How many mutants a module has."""
    return sum(1 for part in parts(ast.parse(text)) for _ in places(part))


def mutated(text: str, number: int) -> tuple[ast.Module, str]:
    """The mutant of that number, and what was changed in it."""
    tree = ast.parse(text)
    node: Any = [place for part in parts(tree) for place in places(part)][number]
    before = ast.unparse(node).split("\n")[0]
    field, value = changed(node) or ("", None)
    setattr(node, field, value)
    ast.fix_missing_locations(tree)
    return tree, f"line {node.lineno}: {before}  ->  {ast.unparse(node).splitlines()[0]}"


def tests_of(module: Path) -> Path:
    """Where the tests of a module's name stand."""
    return (
        ROOT / "tests" / module.parent.relative_to(ROOT) / f"test_{module.name.removeprefix('_')}"
    )


def modules(chosen: list[str]) -> list[Path]:
    """The modules of the core that have tests of their name, of all or of those chosen."""
    if chosen:
        chosen_modules = [ROOT / one for one in chosen]
        files = [
            m for one in chosen_modules for m in ([one] if one.is_file() else one.rglob("*.py"))
        ]
    else:
        files = [m for package in PACKAGES for m in (ROOT / package).rglob("*.py")]
        files = [m for m in files if not NOT_CORE & set(m.relative_to(ROOT).parts)]
    return sorted(m for m in files if tests_of(m).is_file())


def pytest_configure() -> None:
    """In the process of a mutant pytest has this file for a plugin, before it imports a test."""
    path, number = os.environ["MUTANT"].rsplit(":", 1)
    unchanged = SourceFileLoader.get_code

    def get_code(loader: SourceFileLoader, name: str) -> Any:
        if not os.path.samefile(loader.path, path):
            return unchanged(loader, name)
        return compile(mutated(Path(path).read_text(), int(number))[0], path, "exec")

    SourceFileLoader.get_code = get_code  # type: ignore[assignment, method-assign]


def survives(tests: list[Path], mutant: str, plugin: str = "mutants") -> bool:
    """Whether the tests find nothing wrong with the mutant that the plugin puts in its place."""
    path = os.environ.get("PYTHONPATH")
    environment = {
        **os.environ,
        "MUTANT": mutant,
        "HYPOTHESIS_PROFILE": "ci",
        "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *([path] if path else [])]),
    }
    options = ["-x", "-q", "-n", "0", "--tb=no", "-p", plugin, "-p", "no:cacheprovider"]
    command = [sys.executable, "-m", "pytest", *options, *map(str, tests)]
    try:
        ended = subprocess.run(
            command, cwd=ROOT, env=environment, capture_output=True, timeout=LONGEST, check=False
        )
    except subprocess.TimeoutExpired:
        return False
    if ended.returncode < 0:  # a kernel may end its process
        return False
    if ended.returncode not in (0, 1, 2):
        raise SystemExit(ended.stdout.decode() + ended.stderr.decode())
    return ended.returncode == 0


def main(count: str = "60", seed: str = "0", *chosen: str) -> None:
    """Draw the mutants and judge them."""
    every = [(m, i) for m in modules(list(chosen)) for i in range(mutants(m.read_text()))]
    drawn = random.Random(int(seed)).sample(every, min(int(count), len(every)))
    killed = 0
    for module, number in sorted(drawn):
        survived = survives([tests_of(module)], f"{module}:{number}")
        killed += not survived
        change = mutated(module.read_text(), number)[1]
        print("SURVIVES" if survived else "killed  ", module.relative_to(ROOT), change, flush=True)
    print(f"{killed} of {len(drawn)} killed, drawn among {len(every)} with seed {seed}.")


if __name__ == "__main__":
    main(*sys.argv[1:])
