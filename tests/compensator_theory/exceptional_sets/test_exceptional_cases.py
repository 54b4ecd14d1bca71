"""Cases of symbolic answers: the oracle substitutes numbers first and constructs afterwards."""

import functools
import inspect
import itertools
from fractions import Fraction

import pytest
import sympy
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import compensator_theory as exact
from compensator_theory import CompensatorError, InputError, exceptional_cases
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._linear_algebra import rank, solve_affine
from compensator_theory.polynomials._substitution import names_in, substituted
from compensator_theory.results import BezoutIdentity, NullSpaceGCD

s = sympy.Symbol("s")
SYMBOLS = a, b, c = sympy.symbols("a b c")
# What stands at the places of a template; equal ones make common factors for all values.
PARTS = ["a", "b", "c", "a - b", "a*b", "a**2 - b", "b + c", "a**2 - 2*a*b", "0", "1", "-2"]


def exactly(point):
    return dict(zip(SYMBOLS, point, strict=True))


def value_of(expression, point):
    return sympy.simplify(sympy.sympify(expression).subs(exactly(point), simultaneous=True))


def polynomial_at(poly, point):
    return sympy.Poly(
        [value_of(coefficient, point) for coefficient in poly.all_coeffs()], poly.gen
    ).as_expr()


def same(one, other, point):
    return sympy.expand(polynomial_at(one, point) - other.as_expr()) == 0


def same_matrices(one, other, point):
    return (one.applyfunc(lambda e: value_of(e, point)) - other).is_zero_matrix


# One construction each: its arguments by four parts, and what must agree at a point.
def placement(p, q, r, t):
    return (f"(s + {p})/(s**2 + {q}*s + {r})", ["-1", "-2", f"-({t})"]), {"feedback": -1}


def placements_agree(one, other, point):
    if other.is_unique:
        pairs = ((one.numerator, other.numerator), (one.denominator, other.denominator))
        return one.is_unique and all(same(x, y, point) for x, y in pairs)
    D, N = other.plant.denominator, other.plant.numerator
    D_c, N_c = (polynomial_at(x, point) for x in (one.denominator, one.numerator))
    closed = sympy.expand(D.as_expr() * D_c + N.as_expr() * N_c - other.target.as_expr())
    return closed == 0 and len(one.homogeneous) == len(other.homogeneous)


def short_placement(p, q, r, t):
    arguments = f"1/(s**2 + {p}*s + {q})", f"s**3 + {r}*s**2 + {t}*s + 1"
    return arguments, {"feedback": -1, "numerator_degree": 0}


def diophantine(p, q, r, t):
    return (f"s**2 + {p}", f"s + {q}", f"{r}*s + {t}"), {"variable": "s"}


def diophantines_agree(one, other, point):
    ours = [getattr(one, name) for name in ("x", "y", "dx", "dy")]
    theirs = [getattr(other, name) for name in ("x", "y", "dx", "dy")]
    return all(same(x, y, point) for x, y in zip(ours, theirs, strict=True))


def matrix_diophantine(p, q, r, t):
    return ([[f"s - ({p})", 0], [0, "s"]], [["1"], [q]], [[f"s + {r}"], [t]]), {"variable": "s"}


def matrix_diophantines_agree(one, other, point):
    A, B, C = (M.as_matrix() for M in (other.A, other.B, other.C))
    X, Y = (M.as_matrix().applyfunc(lambda e: value_of(e, point)) for M in (one.X, one.Y))
    left = (A * X + B * Y - C).applyfunc(sympy.expand)
    return left.is_zero_matrix and one.kernel.indices == other.kernel.indices


def smith(p, q, r, t):
    return ([[f"s + {p}", q], [r, f"s**2 + {t}*s"]], "s"), {}


def smiths_agree(one, other, point):
    return one.rank == other.rank and all(
        same(x, y, point)
        for x, y in zip(one.invariant_polynomials, other.invariant_polynomials, strict=True)
    )


def kalman(p, q, r, t):
    return (([[p, 0], [q, r]], [[1], [t]], [[1, 1]]),), {"variable": "s"}


def sylvester(p, q, r, t):
    return ([[p, 1], [0, q]], [[r]], [[1], [t]]), {}


def solutions_agree(one, other, point):
    if not other.homogeneous:
        return not one.homogeneous and same_matrices(one.X, other.X, point)
    return len(one.homogeneous) == len(other.homogeneous)


def fractions(p, q, r, t):
    return (([[p, 1], [q, r]], [[0], [t]], [[1, 0]]), [-1, -2], [-1, -3]), {"variable": "s"}


def fractions_agree(one, other, point):
    return same_matrices(one.K, other.K, point) and same_matrices(one.F, other.F, point)


def gains(p, q, r, t):
    return ([[p, 1], [q, r]], [[1, 0], [t, 0]], [-1, -2]), {"variable": "s"}


CASES = {
    "placement": (exact.place_poles, placement, placements_agree),
    "short placement": (exact.place_poles, short_placement, placements_agree),
    "Diophantine": (exact.solve_diophantine, diophantine, diophantines_agree),
    "matrix Diophantine": (
        exact.solve_matrix_diophantine, matrix_diophantine, matrix_diophantines_agree
    ),
    "Smith": (exact.forms.smith_form, smith, smiths_agree),
    "Kalman": (exact.kalman_decomposition, kalman, lambda x, y, _: x.dimensions == y.dimensions),
    "Sylvester": (exact.solve_sylvester, sylvester, solutions_agree),
    "Stein": (
        exact.solve_stein,
        lambda p, q, r, t: (([[p, 1], [0, q]], [[1], [t]], [[r]]), {}),
        solutions_agree,
    ),
    "coprime": (exact.doubly_coprime_fractions, fractions, fractions_agree),
    "gains": (
        exact.state_feedback_family, gains,
        lambda x, y, _: x.form.indices == y.form.indices,
    ),
}  # fmt: skip


def at_numbers(parts, point):
    """The oracle's own substitution: parts are evaluated before the construction sees them."""
    names = {symbol.name: value for symbol, value in exactly(point).items()}
    return [f"({sympy.sympify(part, locals=names)})" for part in parts]


@functools.cache
def analysed(name, parts):
    function, template, _ = CASES[name]
    arguments, options = template(*(f"({part})" for part in parts))
    return exceptional_cases(function, *arguments, **options)


def points_of(analysis, values):
    """Points of a small grid, and one in each case that is solved for its symbols."""
    yield from itertools.product([-1, 0, Fraction(1, 2), 2], repeat=3)
    for case in analysis.cases:
        solved = dict(case.values)
        free = {x: value for x, value in zip(SYMBOLS, values, strict=True) if x not in solved}
        point = [sympy.sympify(solved.get(x, x)).subs(free) for x in SYMBOLS]
        if all(value.is_Rational for value in point):
            yield tuple(Fraction(int(v.p), int(v.q)) for v in point)


@pytest.mark.costly
@pytest.mark.cases(4)
@pytest.mark.parametrize("name", CASES)
def test_cases_are_what_a_construction_answers_at_points(name, in_full):
    function, template, agree = CASES[name]
    observed = {"answered": 0, "refused": 0, "open": 0}

    @settings(
        max_examples=150 if in_full else 3, database=None, derandomize=not in_full,
        phases=[Phase.generate],
    )  # fmt: skip
    @given(
        st.tuples(*[st.sampled_from(PARTS)] * 4),
        st.tuples(*[st.fractions(-4, 4, max_denominator=3)] * 3),
        st.randoms(use_true_random=False),
    )
    def holds(parts, values, random):
        result = analysed(name, parts)
        points = list(dict.fromkeys(points_of(result, values)))
        for point in random.sample(points, min(len(points), 8)):
            at = exactly(point)
            (case,) = [case for case in result.cases if case.contains(at)]
            assert result.at(at) == case
            if case.status == "open" or case.is_generic:
                observed["open"] += 1
                continue
            observed[case.status] += 1
            arguments, options = template(*at_numbers(parts, point))
            if case.status == "refused":
                with pytest.raises(case.error):
                    function(*arguments, **options)
            else:
                assert agree(case.answer, function(*arguments, **options), point), (parts, point)

    holds()
    assert observed["answered"] and observed["open"] < sum(observed.values()) / 5, observed


def conditions(analysis):
    return [(case.conditions, case.status) for case in analysis.cases]


def test_a_solution_where_the_resultant_vanishes_and_what_was_free():
    """s - a and s - b have 1 as gcd but for a = b, where c must be the common root."""
    cases = exceptional_cases(exact.solve_diophantine, "s - a", "s - b", "s - c", variable="s")
    assert conditions(cases) == [
        ("a - b != 0", "answered"),
        ("a = b, b - c != 0", "refused"),
        ("a = c, b = c", "answered"),
    ]
    assert cases.is_complete and cases.generic == cases.at({"a": 1, "b": 2, "c": "1/3"})
    assert cases.at({a: 1, "b": 1, c: 1}).answer.dx == exact.polynomial("1", "s")


def test_algebraic_values():
    cases = exceptional_cases(
        exact.forms.smith_form, [["s**2", "a**4 - 5*a**2 + 6"], [0, "s"]], "s"
    )
    values = [value for case in cases.cases[1:] for _, value in case.values]
    assert {sympy.expand(v**2) for v in values} == {2, 3} and len(values) == 4
    assert all(len(case.answer.elementary_divisors) == 2 for case in cases.cases[1:])
    cubic = exceptional_cases(exact.forms.smith_form, [["s**2", "a**3 - a - 1"], [0, "s"]], "s")
    assert [case.values[0][1] for case in cubic.cases[1:]] == [sympy.CRootOf(s**3 - s - 1, 0)]
    assert exceptional_cases(exact.forms.smith_form, [["s", "a**2 + 1"], [0, "s"]], "s").is_complete


def test_what_is_left_open_says_why():
    circle = exceptional_cases(exact.forms.smith_form, [["s", "a**2 + b**2 - 1"], [0, "s"]], "s")
    assert circle.cases[1].status == "open" and "linear in no symbol" in circle.cases[1].reason
    assert circle.at({"a": "3/5", "b": "4/5"}) == circle.cases[1] and not circle.is_complete
    with exact.budget(field_degree=2):
        cases = exceptional_cases(exact.forms.smith_form, [["s", "a**3 - a - 1"], [0, "s"]], "s")
        assert "field_degree" in cases.cases[1].reason
    few = exceptional_cases(exact.forms.smith_form, [["s", "a*b"], [0, "s"]], "s", cases=2)
    assert [case.status for case in few.cases] == ["answered", "answered", "open"]
    cases = exceptional_cases(exact.place_poles, "1/(a*s + b)", [-2], feedback=-1)
    assert "drops out" in cases.cases[1].reason
    named = exceptional_cases(
        exact.solve_diophantine, "s - x", "s - y", "1", variable="s", least="y"
    )
    assert named.cases[1].status == "refused"
    other = exceptional_cases(
        exact.solve_diophantine, "s - y", "y*s - 1", "1", variable="s", least="y"
    )
    assert [case.status for case in other.cases[1:]] == ["open", "open"]
    assert "rename" in other.cases[1].reason


def test_assumptions_of_symbols_exclude_cases():
    positive = sympy.Symbol("a", positive=True)
    left, right = exact.polynomial(s - positive, "s"), exact.polynomial(s + positive, "s")
    assert len(exceptional_cases(exact.solve_diophantine, left, right, 1).cases) == 1
    cases = exceptional_cases(exact.solve_diophantine, left, exact.polynomial(s - 4 / positive), 1)
    assert [case.values for case in cases.cases[1:]] == [((positive, 2),)]


def test_systems_and_matrices_are_substituted():
    G = exact.transfer_function("(s - a)/((s - 1)*(s - b))", "s")
    cases = exceptional_cases(exact.minimal_realisation, G)
    assert [len(case.answer.realisation.A.tolist()) for case in cases.cases] == [2, 1, 1, 1][
        : len(cases.cases)
    ]
    matrix = sympy.Matrix([[a, 0], [0, b]])
    plant = exact.Realisation(matrix, [[1], [c]], [[1, 1]])
    same = exceptional_cases(exact.kalman_decomposition, plant)
    texts = exceptional_cases(
        exact.kalman_decomposition, ([["a", 0], [0, "b"]], [[1], ["c"]], [[1, 1]]), variable="s"
    )
    assert [case.answer.dimensions for case in same.cases] == [
        case.answer.dimensions for case in texts.cases
    ]


def test_a_function_of_several_constructions():
    def both(plant, matrix):
        return exact.place_poles(plant, [-1], feedback=-1), exact.forms.smith_form(matrix, "s")

    cases = exceptional_cases(both, "k/(s + a)", [["s", "a*k"], [0, "s"]])
    assert conditions(cases) == [
        ("k != 0, a != 0", "answered"), ("k = 0, a - 1 != 0", "refused"),
        ("a = 1, k = 0", "answered"), ("a = 0, k != 0", "answered"),
    ]  # fmt: skip


@pytest.mark.parametrize("entry", ["a*k", "b"])
def test_symbols_that_are_not_in_the_arguments_are_refused(entry):
    def hidden(plant):
        placed = exact.place_poles(plant, [-1], feedback=-1)
        return placed, exact.forms.smith_form([["s", entry], [0, "s"]], "s")

    with pytest.raises(exact.errors.FunctionFailedError, match="besides its arguments"):
        exceptional_cases(hidden, "k/(s + a)")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: exceptional_cases("place_poles", "1/s"), "cannot be called"),
        (lambda: exceptional_cases(sympy.Poly, s + a, s), "no exceptional set"),
        (
            lambda: exceptional_cases(exact.forms.smith_form, [["s"]], cases=0),
            "positive integer",
        ),
        (lambda: exceptional_cases(exact.forms.smith_form, [["1/s"]]), "polynomial"),
        (lambda: exceptional_cases(exact.forms.smith_form, [["s"]]).at(1), "mapping"),
        (
            lambda: exceptional_cases(exact.forms.smith_form, [["s", "a"], [0, "s"]], "s").at(
                {"b": 1}
            ),
            "value for a",
        ),
    ],
)
def test_bad_input(call, words):
    with pytest.raises(InputError, match=words):
        call()


def test_an_error_of_the_function_is_named():
    with pytest.raises(exact.errors.FunctionFailedError, match="place_poles failed: TypeError"):
        exceptional_cases(exact.place_poles, "1/(s + a)", [-1])


def test_latex():
    cases = exceptional_cases(exact.place_poles, "b/(s + a)", [-1], feedback=-1)
    text = cases._repr_latex_()
    assert text.startswith(r"$\displaystyle \begin{cases} ") and text.count("$") == 2
    assert r"\text{NotCoprimeError}" in text and r"b \neq 0" in text


def test_a_zero_that_is_not_simplified_is_a_zero():
    """SymPy's sparse matrices keep it as an entry, and elimination would divide by it."""
    zero = (1 - b) / b**2 + (b - 1) / b**2
    matrix = sympy.Matrix([[zero, 1, 1], [0, 1, 1]])
    assert zero != 0 and rank(matrix) == 1 == len(echelon(matrix).pivots)
    assert len(solve_affine(matrix, sympy.Matrix([1, 1])).nullspace) == 2
    parts = ("a**2 - 2*a*b", "a**2 - b", "b + c", "1")
    assert [len(case.answer.homogeneous) for case in analysed("Sylvester", parts).cases
            if case.status == "answered"] == [0, 1]  # fmt: skip


PLAIN = [
    (exact.mcmillan_degree, ([["1/(s + a)", "b/(s + c)"]], "s"), {}),
    (exact.mcmillan_degree, ("a*s**2 + (s + b)/(s + c)", "s"), {}),
    (exact.uncontrollable_polynomial, ([["a", 1], [0, "b"]], [["c"], [1]]), {"variable": "s"}),
    (exact.is_controllable, ([["a", 1], ["b", 0]], [["c", 1], [1, "a"]]), {}),
    (
        exact.bezout.number_of_common_roots,
        ("(s - a)*(s - 1)", "(s - b)*(s - c)"),
        {"variable": "s"},
    ),
    (exact.bezout.number_of_common_roots, ("s**2 + a*s + b", "c*s + 1"), {"variable": "s"}),
    (exact.regulator_gain, ([["a", 1], ["b", 0]], [["c"], [1]], [-1, -2]), {}),
    (exact.bezout.gcd_from_null_space, ("(s - a)*(s - 1)", "(s - b)*(s - c)"), {"variable": "s"}),
    (exact.bezout_identity, ("(s - a)*(s - 1)", "(s - b)*(s - c)"), {"variable": "s"}),
    (exact.resultant, ("s**2 + a*s + b", "s + c"), {"variable": "s"}),
]


@functools.cache
def cases_of(index):
    function, arguments, options = PLAIN[index]
    return exceptional_cases(function, *arguments, **options)


@pytest.mark.costly
@pytest.mark.parametrize("index", range(len(PLAIN)))
@given(values=st.lists(st.integers(-2, 2), min_size=3, max_size=3))
def test_plain_answers_hold_where_the_cases_say(index, values):
    """Substituting first is the oracle: numbers, bools and polynomials are generic ones too."""
    function, arguments, options = PLAIN[index]
    at = dict(zip("abc", values, strict=True))
    case = cases_of(index).at(at)
    put = {sympy.Symbol(name): sympy.Integer(value) for name, value in at.items()}
    try:
        expected = function(*(substituted(argument, put) for argument in arguments), **options)
    except CompensatorError as error:
        assert case.status == "refused" and case.error is type(error)
        return
    assert case.status == "answered"
    answer = case.answer
    if isinstance(answer, NullSpaceGCD | BezoutIdentity):
        answer, expected = answer.gcd, expected.gcd
    if isinstance(answer, sympy.Poly):
        answer, expected = (p.as_expr() for p in (answer, expected))
    if isinstance(answer, sympy.MatrixBase | sympy.Expr):
        answer = answer.subs(put)
    assert answer == expected


PAIR = "s**2 + a*s", "b*s + 1"
FALLS = "(s - 1)/((b*s + 1)*(s - a))"
AB = [["a", 1], [0, "b"]], [["b"], [1]]
FORMULAS = {
    "polynomial": (PAIR[1], "s"), "transfer_function": (FALLS, "s"), "realisation": (FALLS, "s"),
    "transfer_matrix": ([[FALLS, "1/(s - a)"]], "s"), "polynomial_matrix": ([PAIR], "s"),
    "standard_problem": (FALLS, "s"), "markov_parameters": ("1/(a*s + b)", 3),
    "hankel_matrix": ("1/(a*s + b)", 2, 2), "controllability_matrix": AB,
    "reachable_eigenvectors": (*AB, 1), "partial_fractions": ("1/((s - a)*(s - b))", "s"),
    "feedback_connection": ("1/(s - a)", "b/(s + 1)"), "stability_conditions": PAIR[1:],
    "sensitivity_function": ("1/(s - a)", "b/(s + 1)"), "decide_stability": (PAIR[1], "s"),
    "observer_based_compensator": ("1/(a*s + b)", [-1], [-2]),
    "predictive_cost_compensator": ((["b"], ["1/a"]), [["c"]]),
    "monic": (exact.polynomial("a*s + b", "s"),),
    "bezout.sylvester_m1": PAIR, "bezout.sylvester_m2": PAIR, "bezout.bezout_matrix": PAIR,
    "bezout.subresultants": PAIR,
}  # fmt: skip


@pytest.mark.parametrize("name", FORMULAS)
def test_plain_answers_say_where_they_hold(name):
    """Each case, evaluated at points in it, is the answer that numbers give there."""
    function, argument = functools.reduce(getattr, name.split("."), exact), FORMULAS[name]
    takes = inspect.signature(function).parameters
    options = {"variable": "s"} if "variable" in takes and "s" not in argument else {}
    if name == "predictive_cost_compensator":
        options = {}  # in discrete time
    if "feedback" in takes:
        options["feedback"] = -1
    cases = exceptional_cases(function, *argument, **options)
    compared = 0
    for point in ((0, 1), (1, 1), (0, 0), (2, 0), (3, 5), (-1, 2)):
        values = dict(zip((a, b), map(sympy.Integer, point), strict=True))
        try:
            case = cases.at({k: v for k, v in values.items() if str(k) in names_in(argument)})
            there = function(*substituted(argument, values), **options)
        except CompensatorError:
            continue
        generic = substituted(case.answer, values)
        if name == "reachable_eigenvectors":
            assert generic.shape == there.shape and rank(generic.row_join(there)) == there.cols
        elif name not in ("stability_conditions", "decide_stability"):
            assert sorted(str(generic).split(" + ")) == sorted(str(there).split(" + "))
        compared += 1
    assert compared > 1
