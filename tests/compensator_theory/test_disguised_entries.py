"""Equal entries in disguise, at every public function: the same answer, or a refusal of ours.

Each identity is an expression of the value 1. What multiplies a number of an argument by it must
not change the answer: the coefficient domains decide that it is 1, or refuse it at the door.
"""

import random

import pytest
import sympy
from sympy import E, GoldenRatio, Poly, Rational, S, cos, cot, exp, log, pi, sin, sqrt, tan

import compensator_theory as exact
from tests.support.bad_inputs import GOOD, NOT_DOORS
from tests.support.public import public_objects

a, b, t, theta = sympy.symbols("a b t theta")
GOLDEN = (1 + sqrt(5)) / 2
REFUSED = {
    "sin^2 + cos^2": sin(theta) ** 2 + cos(theta) ** 2,
    "tan cos / sin": tan(theta) * cos(theta) / sin(theta),
    "double angle of 1": 2 * sin(1) * cos(1) / sin(2),
    "log 2 + log 3 = log 6": (log(2) + log(3)) / log(6),
    "log of a quotient": (log(3) - log(2)) / log(Rational(3, 2)),
    "exponentials": (exp(t) + 1) * (exp(t) - 1) - exp(2 * t) + 2,
    "powers of sqrt(e)": (exp(S.Half) + 1) * (exp(S.Half) - 1) - E + 2,
    "exp(sqrt(2))": (exp(sqrt(2)) + 1) * (exp(sqrt(2)) - 1) - exp(2 * sqrt(2)) + 2,
    "square of sqrt(a)": (sqrt(a) + 1) * (sqrt(a) - 1) - a + 2,
    "sqrt(a) sqrt(b)": sqrt(a) * sqrt(b) / sqrt(a * b),
    "square of sqrt(pi)": (sqrt(pi) + 1) * (sqrt(pi) - 1) - pi + 2,
    "powers with symbols": 4**a / 2 ** (2 * a),
    "a conjugate": sympy.conjugate(a) / a,
    "cot tan": cot(pi / 7) * tan(pi / 7),
    "golden ratio and a": (a * GoldenRatio + 1) / (a * GOLDEN + 1),
    "golden ratio and pi": (pi * GoldenRatio + 1) / (pi * GOLDEN + 1),
    "nested roots and a": (a * sqrt(5 + 2 * sqrt(6)) + 1) / (a * (sqrt(2) + sqrt(3)) + 1),
}
DECIDED = {
    "symbols": (a + 1) ** 2 - a**2 - 2 * a,
    "pi": (pi + 1) ** 2 - pi**2 - 2 * pi,
    "pi and e": (pi + E) * (pi - E) - pi**2 + E**2 + 1,
    "a and sqrt(2)": (a + sqrt(2)) * (a - sqrt(2)) - a**2 + 3,
    "pi and sqrt(2)": (pi + sqrt(2)) * (pi - sqrt(2)) - pi**2 + 3,
    "nested roots": sqrt(5 + 2 * sqrt(6)) / (sqrt(2) + sqrt(3)),
    "golden ratio": GoldenRatio**2 - GoldenRatio,
    "golden ratio and a cosine": 2 * cos(pi / 5) / GoldenRatio,
}
IDENTITIES = REFUSED | DECIDED
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
DRAWN = 4


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


def same(found, wanted):
    if isinstance(found, tuple | list) and isinstance(wanted, tuple | list):
        return len(found) == len(wanted) and all(map(same, found, wanted))
    if isinstance(found, sympy.MatrixBase | sympy.Expr):
        return sympy.simplify(found - wanted) == sympy.simplify(wanted - wanted)
    return found == wanted or str(found) == str(wanted)


def differences(name, identities):
    """What a function answers otherwise, or fails of, where one of its numbers is disguised."""
    door = PUBLIC[name]
    arguments, keywords = DOORS[name]
    wanted = door(*arguments, **keywords)
    places = [*range(len(arguments)), *(k for k, v in keywords.items() if isinstance(v, list))]
    for identity in identities:
        for place in places:
            given = arguments[place] if isinstance(place, int) else keywords[place]
            for changed in disguised(given, IDENTITIES[identity]):
                asked, named = list(arguments), dict(keywords)
                if isinstance(place, int):
                    asked[place] = changed
                else:
                    named[place] = changed
                try:
                    found = door(*asked, **named)
                except exact.CompensatorError:
                    continue
                except Exception as error:
                    yield f"{identity}: {type(error).__name__} of {asked} {error}"[:300]
                    continue
                if found is not None and not same(found, wanted):
                    yield f"{identity}: {asked}: {found} instead of {wanted}"[:400]


def test_every_public_function_is_asked():
    missing = {name for name in PUBLIC if name[0].islower()} - NOT_DOORS - set(DOORS)
    assert not missing


@pytest.mark.costly
@pytest.mark.cases(40)
@pytest.mark.parametrize("name", sorted(set(DOORS) - {"exact_number", "parse_expression"}))
def test_disguised_entries_change_no_answer(name, in_full):
    draw = random.Random(name)
    identities = list(IDENTITIES) if in_full else draw.sample(sorted(IDENTITIES), DRAWN)
    assert [*differences(name, identities)] == []
