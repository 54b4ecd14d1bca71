"""Jordan's, Smith's and Frobenius's forms, ranks, and the cases of their parameters."""

from contextlib import suppress

import pytest
import sympy as sp

import compensator_theory as ct
from compensator_theory.forms import frobenius_form, jordan_form, smith_form
from tests.support.world import case

DOUBLE_J = [[0, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 1], [0, 0, -1, 0]]
JORDAN = [
    case("SymPy-15858", DOUBLE_J, [("s**2 + 1", 2)]),
    case(
        "SymPy-9274", [[0, 1, 1, 0], [-1, 0, 0, 1], [0, 0, 0, 1], [0, 0, -1, 0]], [("s**2 + 1", 2)]
    ),
    case("Octave-922", [[0, 1], [-1, 0]], [("s**2 + 1", 1)]),
    case(
        "SymPy-10220",
        [[2, 1, 0, 0], [0, 2, 1, 0], [0, 0, 2, 0], [0, 0, 0, 2]],
        [("s - 2", 1), ("s - 2", 3)],
    ),
    case("SymPy-24942", [[0, 0, 1], [1, 0, 1], [0, 1, 0]], [("s**3 - s - 1", 1)]),
    case("pc-318", [[-1, 1, 0], [0, -1, 0], [0, 0, -3]], [("s + 1", 2), ("s + 3", 1)]),
]


@pytest.mark.parametrize(("A", "right"), JORDAN)
def test_rational_jordan_blocks(A, right):
    """By hand: elementary divisors; and T^-1 A T is the form, multiplied out by SymPy."""
    form = jordan_form(A)
    blocks = sorted((str(p.as_expr()), exponent) for p, exponent in form.blocks)
    assert blocks == sorted(right)
    T = sp.Matrix(form.T)
    assert T.inv() * sp.Matrix(A) * T == sp.Matrix(form.form)


SMITH = [
    case("Macaulay2-3017", [["s**3 + 1"], ["s**2 + 1"]], ["1"]),
    case("SymPy-25759", [["s", 0], [0, "s*(s + 1)"]], ["s", "s**2 + s"]),
    case("SymPy-29139", [["s + 1", 0], [0, "s + 2"]], ["1", "s**2 + 3*s + 2"]),
]


@pytest.mark.parametrize(("M", "right"), SMITH)
def test_smith_forms(M, right):
    """By hand, from the gcds of the minors."""
    result = [p.as_expr() for p in smith_form(M, "s").invariant_polynomials]
    assert result == [sp.sympify(r) for r in right]


RANKS = [
    # SymPy #9480: det = 0, so the vectors are parallel.
    case("SymPy-9480", [[1, sp.sqrt(2)], [sp.sqrt(2), 2]], 1),
    case(
        "SymPy-11434",
        [[f"a_{i + j}" if i < 4 else f"a_{j} + a_{j + 1}" for j in range(5)] for i in range(5)],
        4,
    ),
]


@pytest.mark.parametrize(("M", "right"), RANKS)
def test_ranks(M, right):
    """By hand: a row is a sum of others, and the determinant is zero."""
    assert smith_form(M, "s").rank == right


CONDITIONS = [
    # Rank conditions: b times (A b) is k(k - ...) by hand.
    case("SymPy-27986", [[0, 1], [0, 11]], [["1"], ["k"]], "k", {0, 11}),
    case("SymPy-24613", [["a", 0], [0, 1]], [[1], [1]], "a", {1}),
    case("diofant-287", [[1, 0], [0, 2]], [["b"], [1]], "b", {0}),
    case("SymPy-28232", [[0, 1], [0, 0]], [[0], ["c"]], "c", {0}),
    case("exam-beta", [["a", 0], [0, "b"]], [[1], [1]], "a", {sp.Symbol("b")}),
]


@pytest.mark.parametrize(("A", "b", "symbol", "right"), CONDITIONS)
def test_when_a_pair_is_uncontrollable(A, b, symbol, right):
    """By hand: the zeros of det [b, A b] in the symbol."""
    A, b = (sp.Matrix(M).applyfunc(sp.sympify) for M in (A, b))
    roots = set(sp.solve(b.row_join(A * b).det(), sp.Symbol(symbol)))
    assert roots == right  # the question itself
    cases = ct.exceptional_cases(ct.is_controllable, A, b)
    assert cases.is_complete
    for root in right:
        others = dict.fromkeys(map(str, sp.sympify(root).free_symbols), 5)
        at = {symbol: sp.sympify(root).subs(others), **others}
        assert cases.at(at).answer is False


@pytest.mark.parametrize(
    "name",
    [
        case("LQR-weight-q", "q"),
        case("zero-z", "z"),
        case("parameter-s", "s"),
        case("parameter-a", "a"),
    ],
)
def test_a_parameter_may_have_any_name(name):
    """diag(p, name) with b = (p, name)': uncontrollable at 0, 0 and p = name, by hand."""
    cases = ct.exceptional_cases(ct.is_controllable, [["p", 0], [0, name]], [["p"], [name]])
    assert cases.is_complete


def test_a_matrix_equation_has_no_variable():
    cases = ct.exceptional_cases(ct.solve_lyapunov, [["a"]], [[1]])
    assert cases.is_complete and cases.at({"a": 2}).answer.X[0].subs("a", 2) == -sp.Rational(1, 4)


TRIG = [
    case(
        "pendulum-uncontrollable",
        lambda S, C: (
            ct.uncontrollable_polynomial(
                sp.Matrix([[1, 0], [0, S**2 + C**2]]), sp.Matrix([1, 1])
            ).as_expr()
            == sp.Symbol("s") - 1
        ),
    ),
    case("SymPy-17130", lambda S, C: jordan_form([[sp.exp(1), 1], [0, sp.exp(1)]]) is not None),
    case(
        "SymPy-17130b",
        lambda S, C: (
            jordan_form([[sp.exp(sp.Symbol("t")), 1], [0, sp.exp(sp.Symbol("t"))]]) is not None
        ),
    ),
    case(
        "frobenius-sqrt",
        lambda S, C: frobenius_form([[sp.sqrt(sp.Symbol("a")), 1], [0, 2]]) is not None,
    ),
]


@pytest.mark.parametrize("ask", TRIG)
def test_what_is_no_field_is_right_or_refused(ask):
    theta = sp.Symbol("theta")
    with suppress(ct.CompensatorError):
        assert ask(sp.sin(theta), sp.cos(theta))
