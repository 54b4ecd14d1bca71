"""Functions of symbols in both arguments: what is answered is right at numbers, at every function.

Each pair of functions is put in place of two factors of a call that is known to be good. The
answer, at a point where the functions have rational values, is that of the call with these rational
numbers, which nothing of what carries functions decides; or, where an answer is normalised other
with symbols, that of the call with four symbols in place of the functions.
"""

import pickle
import random
from dataclasses import fields, is_dataclass

import pytest
import sympy
from sympy import E, I, Poly, Rational, cos, cosh, exp, log, sin, sinh, sqrt, tan

import compensator_theory as exact
from tests.support.disguises import DOORS, PUBLIC, disguised, inside

T, phi, kappa, mu = sympy.symbols("T phi kappa mu")
FIRST, SECOND = sympy.symbols("FIRST SECOND")
E_HALF, TAN_HALF, ROOT, OTHER = sympy.symbols("e_half tan_half root other")
AS_SYMBOLS = {E_HALF: exp(T / 2), TAN_HALF: tan(phi / 2), ROOT: sqrt(kappa), OTHER: sqrt(mu)}
AS_NUMBERS = {
    E_HALF: Rational(7, 3),
    TAN_HALF: Rational(5, 11),
    ROOT: Rational(13, 7),
    OTHER: Rational(17, 19),
}
"""Four functions without a relation, and a point where they are rational."""
POINT = {
    T: 2 * log(AS_NUMBERS[E_HALF]),
    phi: 2 * sympy.atan(AS_NUMBERS[TAN_HALF]),
    kappa: AS_NUMBERS[ROOT] ** 2,
    mu: AS_NUMBERS[OTHER] ** 2,
} | AS_NUMBERS
E_T = E_HALF**2
SINE, COSINE = 2 * TAN_HALF / (1 + TAN_HALF**2), (1 - TAN_HALF**2) / (1 + TAN_HALF**2)
PAIRS = {
    "exp and its reciprocal": ((exp(-T), 1 / E_T), (exp(T), E_T)),
    "exp and its root": ((exp(-T), 1 / E_T), (exp(T / 2), E_HALF)),
    "exp and cosh": ((exp(2 * T), E_T**2), (cosh(T), (E_T + 1 / E_T) / 2)),
    "sinh and cosh": ((sinh(T), (E_T - 1 / E_T) / 2), (cosh(T), (E_T + 1 / E_T) / 2)),
    "sine and cosine": ((sin(phi), SINE), (cos(phi), COSINE)),
    "sine and tangent": ((sin(2 * phi), 2 * SINE * COSINE), (tan(phi / 2), TAN_HALF)),
    "the circle": ((sin(phi) ** 2, SINE**2), (1 - cos(phi) ** 2, SINE**2)),
    "a root and its square": ((sqrt(kappa), ROOT), (kappa, ROOT**2)),
    "two roots": ((sqrt(kappa) * sqrt(mu), ROOT * OTHER), (sqrt(mu) + 1, OTHER + 1)),
    "a root and exp": ((sqrt(kappa), ROOT), (exp(-T), 1 / E_T)),
    "all kinds": ((exp(T) + sin(phi), E_T + SINE), (cos(phi) * sqrt(kappa), COSINE * ROOT)),
}
"""Two functions, and each as a rational function of the four."""
CARRYING = sorted(name for name in DOORS if getattr(PUBLIC[name], "carries", "none") != "none")
REFUSING = sorted(name for name in DOORS if getattr(PUBLIC[name], "carries", "all") == "none")
DRAWN = 2
# What writes or reads expressions, decides nothing of them, and takes or gives them as they are.
WRITERS = {
    "ball_precision", "budget", "canonical", "check", "claim_exercise", "course_exercises",
    "exact_number", "exceptional_cases", "function_exercise", "judge", "monic", "parse_expression",
    "read_roots", "student_notebook",
}  # fmt: skip
DIGITS = 50


def placed(name, draw):
    """The arguments with two of their numbers multiplied, by FIRST and by SECOND."""
    arguments, keywords = list(DOORS[name][0]), dict(DOORS[name][1])
    for factor in (FIRST, SECOND):
        places = [(arguments, index) for index in range(len(arguments))]
        places += [(keywords, key) for key, value in keywords.items() if isinstance(value, list)]
        ways = [(at, key, way) for at, key in places for way in marked(at[key], factor)]
        if ways:
            at, key, way = draw.choice(ways)
            at[key] = way
    return arguments, keywords


def marked(value, factor):
    """Each way to multiply one number of an argument."""
    yield from disguised(value, factor)
    if isinstance(value, sympy.Expr) and not isinstance(value, sympy.Number | sympy.Symbol):
        yield value * factor
        yield from inside(value, factor)


def put(value, factors):
    """The functions, or their values, in place of both."""
    if isinstance(value, dict):
        return {key: put(part, factors) for key, part in value.items()}
    if type(value) in (list, tuple):
        return type(value)(put(part, factors) for part in value)
    if isinstance(value, Poly):
        return Poly(value.as_expr().xreplace(factors), value.gen)
    if isinstance(value, sympy.Expr) and value.free_symbols & set(factors):
        exactly = {number: Rational(str(number)) for number in value.atoms(sympy.Float)}
        result = value.xreplace(factors | exactly)
        return str(result) if len(str(result)) % 2 else result  # texts and expressions, as it comes
    return value


def answer_of(name, call):
    arguments, keywords = call
    try:
        return PUBLIC[name](*arguments, **keywords)
    except exact.CompensatorError as error:
        return error


def values(answer):
    """Every number and expression of an answer, in one order."""
    if isinstance(answer, Poly):
        yield from values(answer.all_coeffs())
    elif isinstance(answer, sympy.MatrixBase):
        yield from values(answer.flat())
    elif isinstance(answer, tuple | list):
        yield len(answer)
        for part in answer:
            yield from values(part)
    elif is_dataclass(answer):
        for field in fields(answer):
            if field.name not in ("certificate", "exceptional", "wording"):
                yield from values(getattr(answer, field.name))
    elif isinstance(answer, sympy.Expr | int | bool | type(None)):
        yield answer


def number(value):
    """The value at the point, where other symbols have values of their own."""
    if not isinstance(value, sympy.Expr):
        return value
    others = {s: Rational(len(s.name) * 31 + ord(s.name[0]), 97) for s in value.free_symbols}
    return value.xreplace(others | POINT).evalf(DIGITS)


def agree(answer, expected):
    answer, expected = [*map(number, values(answer))], [*map(number, values(expected))]
    return len(answer) == len(expected) and all(map(near, answer, expected))


def near(answer, expected):
    if isinstance(answer, sympy.Expr) and isinstance(expected, sympy.Expr | int):
        return bool(abs(answer - expected) < Rational(1, 10**40) * (1 + abs(expected)))
    return answer == expected


def right(name, call, pair):
    """Whether the answer is that of the numbers, or of the symbols; None if it is refused."""
    (first, as_first), (second, as_second) = pair
    functions, symbols = {FIRST: first, SECOND: second}, {FIRST: as_first, SECOND: as_second}
    result = answer_of(name, put(call, functions))
    if result is None or isinstance(result, exact.CompensatorError):
        return None
    numbers = {factor: value.xreplace(AS_NUMBERS) for factor, value in symbols.items()}
    others = (answer_of(name, put(call, values)) for values in (numbers, symbols))
    compare = signs_agree if name == "stability_conditions" else agree
    return any(not isinstance(o, exact.CompensatorError) and compare(result, o) for o in others)


def signs_agree(answer, expected):
    """Whether both say the same of the point: conditions are free up to positive factors."""
    return all(number(x) > 0 for x in answer) == all(number(x) > 0 for x in expected)


def test_every_public_function_carries_or_refuses():
    names = {name for name, result in PUBLIC.items() if name[0].islower() and callable(result)}
    undecided = {name for name in names if not hasattr(PUBLIC[name], "carries")}
    assert undecided == WRITERS


@pytest.mark.costly
@pytest.mark.cases(11)
@pytest.mark.parametrize("name", CARRYING)
def test_functions_are_carried_to_the_answer_of_their_values(name, in_full):
    draw = random.Random(name)
    pairs = list(PAIRS) if in_full else draw.sample(sorted(PAIRS), DRAWN)
    wrong = [pair for pair in pairs if right(name, placed(name, draw), PAIRS[pair]) is False]
    assert wrong == []


@pytest.mark.parametrize("name", REFUSING)
def test_what_asks_for_numbers_refuses_functions_by_name(name):
    call = put(placed(name, random.Random(name)), {FIRST: sin(phi), SECOND: cos(phi)})
    if "phi" in str(call):
        assert isinstance(answer_of(name, call), exact.InputError)


s, z, a, w, zeta, x = sympy.symbols("s z a w zeta x")
S_2, C_2 = sin(a) ** 2, cos(a) ** 2
ROTATION = [[cos(a), -sin(a)], [sin(a), cos(a)]]
DAMPED = w * sqrt(zeta**2 - 1)


PLACED = [-zeta * w + DAMPED, -zeta * w - DAMPED]
MATRIX = [[0, 1], [-sin(a), -cos(a)]]
EIGENVALUES = [cos(a) + I * sin(a), cos(a) - I * sin(a)]
SECOND_ORDER = s**2 + 2 * zeta * w * s + w**2
TENTH = exp(Rational(-1, 10))


def double_integrator():
    placement = exact.place_poles("1/s**2", [*PLACED, -w], feedback=-1)
    return placement.closed_loop_polynomial(placement.compensator).as_expr()


@pytest.mark.parametrize(
    ("result", "expected"),
    [
        (lambda: exact.place_poles("1/(z-exp(-T))", [0], feedback=-1).compensator(2), exp(-T)),
        (lambda: exact.transfer_function("sqrt(k)/(s+1)", "s")(1) ** 2 * 4, sympy.Symbol("k")),
        (lambda: exact.regulator_gain(MATRIX, [[0], [1]], [-1, -2])[0], sin(a) - 2),
        (lambda: exact.regulator_gain(ROTATION, [[0], [1]], EIGENVALUES)[1], 0),
        (lambda: exact.polynomial_from_roots([sqrt(a), -sqrt(a)], "s").as_expr(), s**2 - a),
        (lambda: exact.polynomial_from_roots(PLACED, "s").as_expr(), SECOND_ORDER),
        (double_integrator, sympy.expand(SECOND_ORDER * (s + w))),
        (lambda: exact.transfer_function("1/(z-x)", "z").subs("x", TENTH)(0), -1 / TENTH),
        (lambda: exact.transfer_function("1/(z-exp(-T))", "z").subs("T", log(2))(0), -2),
        (lambda: exact.resultant(s + exp(T), s + exp(T / 2), variable="s"), exp(T / 2) - exp(T)),
        (lambda: exact.mcmillan_degree(1 / (s + C_2) - 1 / (s + 1 - S_2), "s"), 0),
        (lambda: exact.bezout.number_of_common_roots(s + C_2, s + 1 - S_2, variable="s"), 1),
        (lambda: exact.solve_lyapunov([[-exp(T)]], [[log(2)]]).X[0], log(2) * exp(-T) / 2),
        (lambda: exact.resultant("s+exp(1)", "s+exp(1/2)", variable="s"), sqrt(E) - E),
        (lambda: exact.is_controllable([[1, 0], [0, 2]], [[1 + cos(a)], [1]]), None),
        (lambda: exact.is_controllable([[1, 0], [0, 2]], [[exp(a)], [1]]), True),
    ],
)
def test_cases_that_others_would_type(result, expected):
    answer = result()
    assert answer == expected or sympy.simplify(answer - expected) == 0


def test_an_exceptional_set_speaks_of_the_functions():
    assert exact.place_poles("1/(z - exp(-T))", [0], feedback=-1).exceptional == ()
    a_root = exact.place_poles("sqrt(k)/(s + 1)", [-2], feedback=-1, variable="s")
    assert [str(factor) for factor in a_root.exceptional] == ["k"]
    turned = exact.place_poles("1/(s + 1 + cos(a))", [-2], feedback=-1, variable="s")
    assert 1 + cos(a) in turned.exceptional  # where the tangent of a/2 has no value
    by_sine = exact.place_poles("sin(a)/(s + 1)", [-2], feedback=-1)
    for factor in by_sine.exceptional:  # 1 + tan(a/2)**2 vanishes nowhere, and is none of them
        assert any(factor.subs(a, angle) == 0 for angle in (0, sympy.pi))


def test_a_result_goes_into_the_next_call():
    G = exact.transfer_function("sqrt(k)/(s + exp(-T))", "s")
    H = G * "1/(s + k)" + 1 / G
    again = exact.transfer_function(str(H), "s")
    assert exact.mcmillan_degree((H - again).reduced()) == 0
    assert exact.realisation(G).transfer_function() == G
    assert H.subs({"k": 4, "T": 0}) == exact.transfer_function("2/(s+1)*1/(s+4) + (s+1)/2")
    placed_again = exact.place_poles(G, ["-sqrt(k)"], feedback=-1)
    assert placed_again.is_verified
    assert pickle.loads(pickle.dumps(placed_again)) == placed_again
    assert "sqrt(k)" in str(placed_again)
    assert r"\sqrt{k}" in sympy.latex(placed_again)


def test_letters_of_an_answer_are_none_in_a_function():
    a_ = exact.bezout_identity(s + exp(a), s + exp(-a), variable="s")
    assert "a_" in str(a_)
    with pytest.raises(exact.InputError, match="write a symbol"):
        exact.polynomial(x + exp(x), "x")
    with pytest.raises(exact.InputError, match="not evident"):
        exact.polynomial(x + exp(x))
    with pytest.raises(exact.InputError, match="not a variable"):
        exact.polynomial(1 + exp(x))
