"""The course: its solutions are right, and typical wrong answers have least counterexamples."""

import json
import re
from itertools import pairwise
from pathlib import Path

import pytest
import sympy
from sympy import Rational, exp, eye, sqrt

import compensator_theory as exact
from compensator_theory.errors import CompensatorError, WrongAnswerError
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.teaching import check, course_exercises, judge

NOTEBOOKS = sorted((Path(__file__).parents[3] / "notebooks" / "course").glob("*.ipynb"))
CHECK = re.compile(r'check\("(.*)", (.*)\)')


def sylvester(a, b, *, shift=0, first="a"):
    """A determinant as in exercise 2.1, with a row too few or the blocks exchanged."""
    n, m = a.degree(), b.degree()
    size = n + m + shift
    blocks = {
        "a": [[0] * k + a.all_coeffs() + [0] * (size - n - 1 - k) for k in range(m)],
        "b": [[0] * k + b.all_coeffs() + [0] * (size - m - 1 - k) for k in range(n)],
    }
    rows = blocks["a"] + blocks["b"] if first == "a" else blocks["b"] + blocks["a"]
    return sympy.Matrix(rows).det()


def ackermann(A, B, p, *, sign=-1, first=1):
    """The gain of exercise 4.1, with another sign or another first row."""
    _one, p_1, p_0 = p.all_coeffs()
    row = sympy.Matrix([[0, 1]]) * B.row_join(A * B).inv()
    return sign * row * (A**2 + first * p_1 * A + p_0 * eye(2))


def intercalated(G, C, *, sign=-1, power=0):
    """The quotient of exercise 10.1, with another sign of feedback or another power of q."""
    chi = G.denominator * C.denominator + sign * G.numerator * C.numerator
    q = sympy.Poly(sympy.Symbol("q"), sympy.Symbol("q"))
    return TransferFunction(G.numerator * q ** max(C.denominator.degree() + power, 0), chi)


def can_be_stable(zeros, poles, *, ends=(float("inf"),), parity=2):
    """The test of exercise 7.2, with another end or without the parity."""
    points = [*sorted(zeros), *ends]
    pairs = pairwise(points)
    return all(sum(a < p < b for p in poles) % parity == 0 for a, b in pairs)


# By exercise: a sign error, a missing condition, a degree off by one.
WRONG = {
    "1.1": {
        "observability forgotten": lambda A, B, C: B.row_join(A * B).rank() < 2,
        "controllability forgotten": lambda A, B, C: C.col_join(C * A).rank() < 2,
        "both needed": lambda A, B, C: (
            B.row_join(A * B).rank() < 2 and C.col_join(C * A).rank() < 2
        ),
    },
    "1.2": {
        "stability forgotten": lambda G: G(0) if G.denominator.eval(0) else None,
        "initial value": lambda G: 0,
        "sign": lambda G: -G(0) if exact.decide_stability(G) else None,
    },
    "1.3": {
        "the wrong truth value": True,
        "no hidden mode": ([[0, 1], [-1, -2]], [[0], [1]], [[1, 0]]),
    },
    "2.1": {
        "blocks exchanged": lambda a, b: sylvester(a, b, first="b"),
        "squared": lambda a, b: sylvester(a, b) ** 2,
        "degrees off by one": lambda a, b: sylvester(a, b) * a.LC(),
    },
    "2.2": {
        "b_0 = 0 forgotten": lambda b_0, b_1: b_0 == b_1,
        "b_0 = b_1 forgotten": lambda b_0, b_1: b_0 == 0,
        "sign": lambda b_0, b_1: b_0 in (0, -b_1),
    },
    "2.3": {"the wrong truth value": False, "coprime sum": ("s", "s + 1")},
    "3.1": {
        "sign": "-(s + 1)/(s + 2)",
        "degree too low": "1",
        "degree too high": "(s + 1)/(s**2 + 3*s + 2)",
    },
    "3.2": {
        "sign": lambda a, b, p: Rational(a - p, b),
        "b forgotten": lambda a, b, p: p - a,
        "pole p": lambda a, b, p: Rational(-p - a, b),
    },
    "3.3": {
        "one too many": lambda n, is_strictly_proper: n,
        "one too few": lambda n, is_strictly_proper: n - 1,
    },
    "4.1": {
        "sign": lambda A, B, p: ackermann(A, B, p, sign=1),
        "p_1 forgotten": lambda A, B, p: ackermann(A, B, p, first=0),
        "transposed": lambda A, B, p: ackermann(A, B, p).T,
    },
    "4.2": {"sign": [[-6], [-6]], "A forgotten": [[7], [12]], "transposed": [[6, 6]]},
    "4.3": {
        "the wrong truth value": False,
        "hidden modes": tuple(
            sympy.ImmutableMatrix(m) for m in (eye(2), [0, 0], [[0, 0]], [[1, 1]], [1, 1])
        ),
    },
    "5.1": {
        "pairs forgotten": lambda real, pairs: sympy.binomial(
            real + 2 * pairs, real // 2 + pairs
        ),
        "real poles forgotten": lambda real, pairs: sympy.binomial(pairs, pairs // 2),
    },
    "5.2": {"the wrong truth value": True, "two real roots": (2, 0), "even half": (0, 2)},
    "5.3": {
        "real roots": exact.place_poles(
            "1/(s**3 + s)", "-1, -2, -3, -4, -5, -6", feedback=-1, properness="strictly proper"
        ).compensator,
        "unstable": "1/(s + 1)**3",
        "order too low": "1/(s + 1)",
    },
    "6.1": {
        "0 < k forgotten": lambda k: k < 6,
        "k < 6 forgotten": lambda k: k > 0,
        "boundary": lambda k: 0 < k <= 6,
    },
    "6.2": {
        "positive coefficients": lambda k_0, k_1: k_0 > 0 and k_1 > 0,
        "boundary": lambda k_0, k_1: 0 < k_0 <= 2 * k_1,
        "factor": lambda k_0, k_1: 0 < k_0 < k_1,
    },
    "6.3": {
        "angle for time": lambda tau: tau < Rational(9046, 10000),
        "always": lambda tau: True,
        "degrees": lambda tau: tau < 51,
    },
    "7.1": {
        "sign": lambda G, Q: Q / (1 + G * Q),
        "the parameter itself": lambda G, Q: Q,
        "Q for G Q": lambda G, Q: Q / (1 - Q),
    },
    "7.2": {
        "infinity forgotten": lambda zeros, poles: can_be_stable(zeros, poles, ends=()),
        "zeros forgotten": lambda zeros, poles: len(poles) % 2 == 0,
        "no pole at all": lambda zeros, poles: can_be_stable(zeros, poles, parity=99),
    },
    "7.3": {"the wrong truth value": True, "stable": ("1/(s + 1)",), "even": ("1/(s - 1)",)},
    "8.1": {
        "b forgotten": lambda a, b, q, r: -sqrt(a**2 + Rational(q, r)),
        "sign": lambda a, b, q, r: sqrt(a**2 + Rational(b**2 * q, r)),
        "r and q exchanged": lambda a, b, q, r: -sqrt(a**2 + Rational(b**2 * r, q)),
    },
    "8.2": {
        "does not stabilise": [[-sqrt(3), 1], [1, -sqrt(3)]],
        "sign": [[sqrt(3), -1], [-1, sqrt(3)]],
        "a float": [[1.732, 1], [1, 1.732]],
    },
    "8.3": {"the wrong truth value": True, "q > 0": (1, 1), "stable": (-1, 0)},
    "9.1": {
        "a = 0 forgotten": lambda a, h: ((1 - exp(-a * h)) / a, exp(-a * h)),
        "sign": lambda a, h: ((exp(a * h) - 1) / a if a else h, exp(a * h)),
        "Euler": lambda a, h: (h, 1 - a * h),
    },
    "9.2": {
        "continuous": lambda k: k > -1,
        "boundary": lambda k: -1 <= k < 3,
        "symmetric": lambda k: abs(k) < 1,
    },
    "9.3": {"the wrong truth value": True, "a quarter": (2,), "three quarters": (6,)},
    "10.1": {
        "sign": lambda G, C: intercalated(G, C, sign=1),
        "degree": lambda G, C: intercalated(G, C, power=-1),
        "closed loop": lambda G, C: exact.feedback_connection(G, C, feedback=1),
    },
    "10.2": {
        "sign": exact.place_poles(
            "(q - 1/2)/((q - 1)*(q - 2))", "q**3", feedback=-1
        ).compensator,
        "order": "1/q**2",
        "poles": exact.place_poles(
            "(q - 1/2)/((q - 1)*(q - 2))", "q**2*(q - 1/2)", feedback=1
        ).compensator,
    },
    "10.3": {"the wrong truth value": False, "allowed zeros": ("1/(q - 1)", "1/q")},
}  # fmt: skip
CASES = [(number, name) for number, answers in WRONG.items() for name in answers]


def solutions():
    """Run the teacher's notebooks; the answers that they check."""
    answers = {}
    for path in NOTEBOOKS:
        names = {}
        for cell in json.loads(path.read_text("utf-8"))["cells"]:
            code = "".join(cell["source"])
            if cell["cell_type"] == "code" and (line := CHECK.match(code)):
                answers[line[1]] = names[line[2]]
            elif cell["cell_type"] == "code":
                exec(code, names)
    return answers


@pytest.mark.costly
def test_the_solutions_are_right_and_each_exercise_has_one():
    answers = solutions()
    assert list(answers) == list(course_exercises()) == list(WRONG)
    for number, answer in answers.items():
        assert check(number, answer, seed=5).is_right
        assert judge(number, answer, draws=200)


def faults(exercise, answer, case):
    """What is wrong with an answer in a case, computed anew; what it raises is wrong, too."""
    try:
        return exercise.fault(answer, *case)
    except (CompensatorError, ZeroDivisionError) as error:
        return str(error)


@pytest.mark.costly
@pytest.mark.parametrize(("number", "name"), CASES, ids=str)
def test_a_wrong_answer_is_refuted_by_a_case_that_recomputes(number, name):
    answer, exercise = WRONG[number][name], course_exercises()[number]
    with pytest.raises(WrongAnswerError) as refused:
        check(number, answer)
    judgement = refused.value.judgement
    assert not judgement and str(refused.value) == str(judgement)
    if judgement.case or not exercise.cases:
        assert faults(exercise, answer, judgement.case) in judgement.reason


def test_each_exercise_has_two_wrong_answers_at_least():
    assert all(len(answers) >= 2 for answers in WRONG.values())
