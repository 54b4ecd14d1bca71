"""The packages set nothing that another thread of the same process could see."""

import ast
from pathlib import Path

import pytest

from docs.reference_pages import parsed

ROOT = Path(__file__).resolve().parents[2]
FILES = [
    p
    for name in ("compensator_theory", "rcac_numeric", "rcac_experiments")
    for p in (ROOT / name).rglob("*.py")
]
# Each holds for a whole process and all its threads.
SETTERS = {
    "catch_warnings", "simplefilter", "filterwarnings", "resetwarnings", "umask", "chdir",
    "set_int_max_str_digits", "setrecursionlimit", "setswitchinterval", "setlocale", "basicConfig",
    "seterr", "seterrcall", "set_printoptions", "workprec", "workdps", "extraprec", "extradps",
    "init_printing", "rc_context", "signal", "seed", "putenv",
}  # fmt: skip
ATTRIBUTES = {"prec", "dps", "environ", "rcParams", "filters", "umask"}
# The turns of ball_precision; the command line; a worker process, which is its own; and Matplotlib,
# which is for one thread at a time anyway.
ALLOWED = {
    ("compensator_theory/polynomials/_ball_precision.py", "prec"),
    ("rcac_experiments/cli/__main__.py", "signal"),
    ("rcac_experiments/dissertation/_reproduction.py", "signal"),
    ("rcac_experiments/sweeps/_worker.py", "signal"),  # of the main thread, while measuring
    ("rcac_experiments/sweeps/_pools.py", "signal"),
    ("rcac_experiments/sweeps/_pools.py", "environ"),
    ("rcac_experiments/sweeps/_worker.py", "environ"),
    ("rcac_numeric/reports/_svg.py", "rc_context"),
}


def written(node):
    """The attribute under what is assigned to: environ of os.environ[name] = ..."""
    while isinstance(node, ast.Subscript):
        node = node.value
    return node.attr if isinstance(node, ast.Attribute) else ""


def setters(tree):
    """The names of what is called or assigned and belongs to the process."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            of = getattr(getattr(node.func, "value", None), "attr", "")
            if name in SETTERS:
                yield name
            elif of == "environ" and name in ("setdefault", "update", "pop"):
                yield of
        elif isinstance(node, ast.Assign | ast.AugAssign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            for target in targets:
                parts = target.elts if isinstance(target, ast.Tuple) else [target]
                yield from ATTRIBUTES & set(map(written, parts))


@pytest.mark.costly
def test_nothing_of_the_process_is_set():
    result = {
        (path.relative_to(ROOT).as_posix(), name)
        for path in FILES
        for name in setters(parsed(path))
    }
    assert result == ALLOWED


@pytest.mark.parametrize(
    "code",
    [
        "with flint.ctx.workprec(9): pass", "before, ctx.prec = ctx.prec, 9", "os.umask(0)",
        "os.environ['A'] = 'b'", "os.environ.setdefault('A', 'b')", "mpmath.mp.dps = 30",
        "with warnings.catch_warnings(): pass", "sys.set_int_max_str_digits(0)",
    ],
)  # fmt: skip
def test_the_search_finds_them(code):
    assert list(setters(ast.parse(code)))
