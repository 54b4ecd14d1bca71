"""Equal entries in disguise, at every public function: the same answer, or a refusal of ours.

Each identity is an expression of the value 1. What multiplies a number of an argument by it must
not change the answer: the coefficient domains decide that it is 1, or refuse it at the door.
"""

import random

import pytest
import sympy
from sympy import E, GoldenRatio, Rational, S, cos, cot, exp, log, pi, sin, sqrt, tan

import compensator_theory as exact
from tests.support.bad_inputs import NOT_DOORS
from tests.support.disguises import DOORS, PUBLIC, disguised

a, b, t, theta = sympy.symbols("a b t theta")
GOLDEN = (1 + sqrt(5)) / 2
FUNCTIONS = {
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
IDENTITIES = FUNCTIONS | DECIDED
NUMBERS = [
    sqrt(2), sqrt(2 + sqrt(3)), GoldenRatio, cos(pi / 7), cot(pi / 7), pi, E, exp(S.Half), log(2),
    sin(1), sqrt(a), exp(t), sin(theta), a**b, sqrt(2) * a, sympy.Abs(a), sympy.I,
]  # fmt: skip
"""What a number of an argument is multiplied by: any answer, or a refusal, and no foreign error."""
DRAWN = 3
# What writes an expression and decides nothing of it.
WRITERS = {"canonical", "exact_number", "parse_expression"}


def same(answer, expected):
    if isinstance(answer, tuple | list) and isinstance(expected, tuple | list):
        return len(answer) == len(expected) and all(map(same, answer, expected))
    if isinstance(answer, sympy.MatrixBase | sympy.Expr):
        return sympy.simplify(answer - expected) == sympy.simplify(expected - expected)
    if isinstance(answer, exact.results.JordanForm):  # blocks stand in the order of the letters
        answer, expected = (sorted(map(str, form.blocks)) for form in (answer, expected))
    return answer == expected or str(answer) == str(expected)


def answers(name, factor):
    """Each call with one number of its arguments multiplied, and its answer; refusals left out."""
    arguments, keywords = DOORS[name]
    places = [*range(len(arguments)), *(k for k, v in keywords.items() if isinstance(v, list))]
    for place in places:
        argument = arguments[place] if isinstance(place, int) else keywords[place]
        for changed in disguised(argument, factor):
            requested, named = list(arguments), dict(keywords)
            if isinstance(place, int):
                requested[place] = changed
            else:
                named[place] = changed
            try:
                yield requested, PUBLIC[name](*requested, **named)
            except exact.CompensatorError:
                continue
            except Exception as error:
                yield requested, error


def foreign(name, numbers):
    """The errors that are not ours."""
    for number in numbers:
        for requested, result in answers(name, number):
            if isinstance(result, Exception):
                yield f"{type(result).__name__} of {requested}: {result}"[:300]


def differences(name, identities):
    """What a function answers otherwise, or fails of, where one of its numbers is disguised."""
    arguments, keywords = DOORS[name]
    expected = PUBLIC[name](*arguments, **keywords)
    for identity in identities:
        for requested, result in answers(name, IDENTITIES[identity]):
            if isinstance(result, Exception):
                yield f"{identity}: {type(result).__name__} of {requested}: {result}"[:300]
            elif result is not None and not same(result, expected):
                yield f"{identity}: {requested}: {result} instead of {expected}"[:400]


def test_every_public_function_is_asked():
    missing = {name for name in PUBLIC if name[0].islower()} - NOT_DOORS - set(DOORS)
    assert not missing


@pytest.mark.costly
@pytest.mark.cases(12)
@pytest.mark.parametrize("name", sorted(set(DOORS) - WRITERS))
def test_disguised_entries_change_no_answer(name, in_full):
    draw = random.Random(name)
    identities = list(IDENTITIES) if in_full else draw.sample(sorted(IDENTITIES), DRAWN)
    assert [*differences(name, identities)] == []


@pytest.mark.costly
@pytest.mark.cases(12)
@pytest.mark.parametrize("name", sorted(DOORS))
def test_no_irrational_number_ends_in_a_foreign_error(name, in_full):
    numbers = NUMBERS if in_full else random.Random(name).sample(NUMBERS, DRAWN)
    assert [*foreign(name, numbers)] == []


s = sympy.Symbol("s")
ROOT, SUM = sqrt(5 + 2 * sqrt(6)), sqrt(2) + sqrt(3)


@pytest.mark.parametrize(
    ("door", "arguments", "says"),
    [
        (exact.stability_conditions, (s**2 + sin(theta) * s + 1, "s"), "write two sym"),
        (exact.stability_conditions, (s**2 + sqrt(a) * s + 1, "s"), "its square for a"),
        (exact.mcmillan_degree, (1 / (s + log(6)) - 1 / (s + log(2) + log(3)), "s"), "write a sym"),
        (exact.bezout_identity, (s + log(6), s + log(2) + log(3)), r"log\(\d\)"),
        (exact.resultant, (s + sqrt(a), s + sqrt(a * b)), r"a symbol for sqrt\(a\*b\)"),
        (exact.regulator_gain, ([[log(2)]], [[1]], [pi]), r"log\(2\)"),
        (exact.realisation, (exp(-theta) / (s + theta), "theta"), "dead time|write a symbol"),
        (exact.realisation, (exp(-s) / (s + 1),), "pade"),
        (exact.partial_fractions, ("exp(-0.25*s)/(s + 1)",), "pade"),
        (exact.h_infinity_norm, ("exp(-a*s)/(s + 1)",), "pade"),
        (exact.forms.smith_form, ([[s, sympy.Abs(a)]], "s"), r"Abs\(a\) is no rational"),
        (exact.solve_stein, ([[exp(exp(theta))]], [[1]]), "write a symbol"),
        (exact.exceptional_cases, (exact.mcmillan_degree, 1 / (s + exp(a)), "s"), "write a symbol"),
        (exact.solve_lyapunov, ([[-1]], [[a * ROOT]]), "write a rational number"),
        (exact.polynomial, ([1, a, a * GoldenRatio], "s"), "occurs with the unknown a"),
    ],
)  # fmt: skip
def test_what_is_not_decided_is_refused_by_name(door, arguments, says):
    with pytest.raises(exact.InputError, match=says):
        door(*arguments)


def test_algebraic_numbers_are_decided_in_matrices_too():
    assert exact.bezout.number_of_common_roots(s + ROOT, s + SUM, variable="s") == 1
    assert exact.minimal_realisation((s + SUM) / ((s + ROOT) * (s + 1)), "s").order == 1
    gain = exact.regulator_gain([[0, 1], [0, 0]], [[0], [1]], [-ROOT, -SUM])
    assert sympy.simplify(gain[0, 0] + 5 + 2 * sqrt(6)) == 0
