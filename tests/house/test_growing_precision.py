"""One loop doubles a precision, and it has an end: polynomials/_ball_precision.py."""

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
HOME = ("compensator_theory/polynomials/_ball_precision.py", "at_growing_precision")
# What computes at a precision that can be asked again at a higher one.
BALLS = {
    "ball_precision", "root_balls", "decided_balls", "complex_roots", "factor_spectrum",
    "real_root_balls", "balls", "refined", "ball", "evalf", "eval_rational",
}  # fmt: skip
ENDLESS = {"count", "cycle", "repeat"}


def called(node):
    return {
        getattr(call.func, "attr", getattr(call.func, "id", ""))
        for call in ast.walk(node)
        if isinstance(call, ast.Call)
    }


def doubles(node):
    """Whether a number is multiplied by a constant, or shifted, and kept under its name."""
    for part in ast.walk(node):
        grows = isinstance(getattr(part, "op", None), ast.Mult | ast.LShift | ast.Pow)
        if isinstance(part, ast.AugAssign) and grows and isinstance(part.value, ast.Constant):
            return True
        if isinstance(part, ast.Assign) and isinstance(part.value, ast.BinOp):
            names = {t.id for t in part.targets if isinstance(t, ast.Name)}
            sides = part.value.left, part.value.right
            constant = any(isinstance(side, ast.Constant) for side in sides)
            same = any(isinstance(side, ast.Name) and side.id in names for side in sides)
            if constant and same and isinstance(part.value.op, ast.Mult | ast.LShift | ast.Pow):
                return True
    return False


def growing_loops(tree):
    """The functions with a loop without a list to go through that asks balls, or doubles."""
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        for node in ast.walk(function):
            is_open = isinstance(node, ast.While) or (
                isinstance(node, ast.For) and called(node.iter) & ENDLESS
            )
            if is_open and (called(node) & BALLS or doubles(node)):
                yield function.name


@pytest.mark.costly
def test_no_other_loop_doubles_a_precision():
    result = {
        (str(path.relative_to(ROOT)), name)
        for path in FILES
        for name in growing_loops(parsed(path))
    }
    assert result == {HOME}


@pytest.mark.parametrize(
    "body",
    [
        "while True:\n  with ball_precision(bits):\n   pass\n  bits += bits",
        "while not done:\n  bits *= 2",
        "while not done:\n  bits = 2 * bits",
        "for bits in itertools.count(64, 64):\n  balls = p.complex_roots()",
    ],
)
def test_the_search_sees_such_a_loop(body):
    lines = "\n ".join(body.splitlines())
    assert list(growing_loops(ast.parse(f"def f(bits):\n {lines}"))) == ["f"]
