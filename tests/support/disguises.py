"""Calls that are known to be good, and the same with one of their numbers multiplied."""

import sympy
from sympy import Poly, Rational

from tests.support.bad_inputs import GOOD, NOT_DOORS
from tests.support.public import public_objects

PUBLIC = public_objects("compensator_theory")
CLASSES = {
    "Realisation": ([[[0, 1], [-2, -3]], [[0], [1]], [[5, 1]]], {}),
    "DescriptorSystem": ([[[1]], [[-1]], [[1]], [[1]]], {}),
    "exact_number": (["1/2"], {}),
    "StandardProblem": (
        [], {"A": [[0]], "B": [[1]], "C": [[1]], "D_1": [[1, 0]], "D_0": None, "D_2": [[0, 1]],
             "E_1": [[2], [0]], "E_2": [[0], [1]], "E_0": None, "variable": "s"},
    ),
}  # fmt: skip
DOORS = {name: case for name, case in GOOD.items() if name not in NOT_DOORS} | CLASSES


def disguised(value, one):
    """The value with one number in it multiplied by an expression of the value 1, in each way."""
    if isinstance(value, str):
        try:
            expression = sympy.sympify(value, {"q": sympy.Symbol("q"), "S": sympy.Symbol("S")})
        except (sympy.SympifyError, SyntaxError, TypeError):
            return
        if isinstance(expression, sympy.Expr) and not expression.is_Symbol:
            yield expression * one
            yield from inside(expression, one)
    elif isinstance(value, Poly):
        yield Poly(value.as_expr() * one, value.gen)
    elif isinstance(value, int | Rational) and not isinstance(value, bool):
        yield value * one
    elif isinstance(value, list | tuple):
        for place in {0, len(value) - 1} if value else ():
            for changed in disguised(value[place], one):
                yield type(value)([*value[:place], changed, *value[place + 1 :]])


def inside(expression, one):
    """A term of the first sum in it, times one."""
    for part in sympy.preorder_traversal(expression):
        if part.is_Add:
            first, *rest = part.args
            yield expression.xreplace({part: sympy.Add(first * one, *rest)})
            return
