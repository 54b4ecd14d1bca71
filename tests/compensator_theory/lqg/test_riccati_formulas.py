"""Riccati equations with symbols: formulas at drawn values against the equation with numbers."""

import functools

import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory import (
    CompensatorError,
    InputError,
    riccati_formula,
    solve_riccati,
)
from compensator_theory.errors import NotControllableError
from tests.support.structure_cases import fewer

SCALAR = [["a"]], [["b"]], [["q"]], [["r"]]
FORMULAS = {  # A, B, Q, R and the time domain
    "first order": (*SCALAR, "continuous"),
    "first order, discrete": (*SCALAR, "discrete"),
    "second order": (
        [[0, 1], ["c", "d"]], [[0], ["b"]], [["q", "p"], ["p", "q"]], [["r"]], "continuous"
    ),
    "double integrator": ([[1, 1], [0, 1]], [[0], [1]], [["q", 0], [0, "p"]], [["r"]], "discrete"),
    # A has the eigenvalue 0, and so has A + B K
    "delay": ([[0]], [["b"]], [["q"]], [["r"]], "discrete"),
    "two delays": (
        [[0, 1], [0, 0]], [[0], ["b"]], [["q", "c"], ["c", "p"]], [["r"]], "discrete"
    ),
    "a delay": ([["a", 1], [0, 0]], [[0], [1]], [["q", 0], [0, 0]], [["r"]], "discrete"),
    "two inputs": (
        [["a", 0], [0, "d"]], [[0, "b"], [1, 0]], [["q", 0], [0, "p"]], [["r", 0], [0, 1]],
        "continuous",
    ),
    "two inputs, discrete": (
        [["a", 0], [0, "d"]], [["b", 0], [0, 1]], [["q", 0], [0, "p"]], [["r", 0], [0, 2]],
        "discrete",
    ),
    "an axis, a tank and an idle input": (
        [[0, 0, 1], [0, "a", 0], [0, 0, 0]], [[0, 0, 0], [1, 0, 0], [0, 0, "b"]],
        [["q", 0, 0], [0, "p", 0], [0, 0, 0]], [[1, 0, 0], [0, "c", 0], [0, 0, "r"]], "continuous",
    ),
    "rank one": ([["a", 1], ["a", 1]], [[0], [1]], [[0, 0], [0, 1]], [["r"]], "discrete"),
}  # fmt: skip


@functools.cache
def formula_of(name):
    """One for all the tests of a process, made where one asks for it."""
    *data, time = FORMULAS[name]
    return riccati_formula(*data, time=time)


def scalar(time):
    return formula_of("first order" if time == "continuous" else "first order, discrete")


SYMBOLS = sympy.symbols("a b c d p q r")


@pytest.mark.costly
@pytest.mark.parametrize("name", FORMULAS)
@fewer(2)
@given(values=st.lists(st.integers(-4, 6), min_size=7, max_size=7))
def test_formulas_are_the_stabilising_solutions(name, values):
    """Where the conditions hold; with numbers first, the answer is proven in its field."""
    formula = formula_of(name)
    at = dict(zip(SYMBOLS, map(sympy.Integer, values), strict=True))
    assume(all(factor.subs(at) != 0 for factor in formula.exceptional))
    conditions = [condition.subs(at) for condition in formula.conditions]
    assume(all(value.is_real and value > 0 for value in conditions))
    result = formula.at({symbol.name: value for symbol, value in at.items()})
    for mine, balls in ((formula.K, result.K_enclosure), (formula.P, result.P_enclosure)):
        for entry, ball in zip(mine.subs(at), [b for row in balls for b in row], strict=True):
            assert abs(sympy.N(entry, 40) - ball.centre) < 1e-20 * (1 + abs(ball.centre))


@pytest.mark.parametrize("time", ["continuous", "discrete"])
@given(
    values=st.tuples(st.integers(-3, 5), st.integers(-3, 5), st.integers(0, 5), st.integers(1, 5))
)
def test_conditions_are_those_of_existence(time, values):
    """For weights that are not negative: no solution exactly where a condition fails."""
    formula = scalar(time)
    a, b, q, r = map(sympy.Integer, values)
    at = dict(zip(sympy.symbols("a b q r"), (a, b, q, r), strict=True))
    assume(all(factor.subs(at) != 0 for factor in formula.exceptional))
    holds = all(condition.subs(at) > 0 for condition in formula.conditions)
    try:
        solve_riccati([[a]], [[b]], Q=[[q]], R=[[r]], time=time)
    except CompensatorError:
        assert not holds
    else:
        assert holds


def test_published_formulas():
    a, q = sympy.symbols("a q")
    formula = riccati_formula([["a"]], [[1]], Q=[["q"]], R=[[1]], time="continuous")
    assert formula.P[0] == a + sympy.sqrt(a**2 + q) and formula.conditions == (a**2 + q,)
    double = riccati_formula(
        [[0, 1], [0, 0]], [[0], [1]], Q=[[1, 0], [0, 0]], R=[["r"]], time="continuous"
    )
    root = sympy.sqrt(1 / sympy.Symbol("r"))
    assert [sympy.simplify(x**2) for x in double.K] == [root**2, 2 * root]
    assert "> 0" in str(double) and double._repr_latex_().startswith("$")


@pytest.mark.costly
@pytest.mark.cases(3)
@pytest.mark.parametrize("name", ["w", "w_0", "w_1", "p0", "p1", "p2", "s", "lamda"])
def test_a_symbol_may_have_any_name(name):
    def formulas(x):
        yield riccati_formula([[0, 1], [x, 0]], B, Q=sympy.diag(x, 0), R=[[1]], time="continuous")
        yield riccati_formula([[x]], [[1]], Q=[[x]], R=[[1]], time="discrete")

    B = [[0], [1]]
    for mine, other in zip(formulas(name), formulas("a"), strict=True):
        assert mine.P.subs(name, sympy.Rational(1, 3)) == other.P.subs("a", sympy.Rational(1, 3))


def test_a_pole_on_the_boundary_is_no_solution():
    assert 0 in riccati_formula([[0]], [[1]], Q=[[0]], R=[[1]], time="continuous").conditions


@pytest.mark.parametrize("time", ["continuous", "discrete"])
def test_what_is_refused_with_numbers_is_exceptional_with_symbols(time):
    """An eigenvalue -1 of A has no bilinear image; in continuous time it is like any other."""
    at_minus_one = {factor.subs("a", -1) for factor in scalar(time).exceptional}
    assert (0 in at_minus_one) == (time == "discrete")
    if time == "continuous":
        riccati_formula([[-1]], [["b"]], Q=[[1]], R=[[1]], time=time)


def test_what_is_refused():
    unit = sympy.eye(3)
    with pytest.raises(InputError, match="orders 1 and 2"):
        riccati_formula(unit, [["a"], [1], [1]], Q=unit, R=[[1]], time="continuous")
    with pytest.raises(InputError, match="input"):
        riccati_formula([["a"]], [[1, 1]], Q=[[1]], R=sympy.eye(2), time="continuous")
    with pytest.raises(NotControllableError):
        riccati_formula([["a", 0], [0, "a"]], [[1], [1]], Q=sympy.eye(2), R=[[1]], time="discrete")
    with pytest.raises(InputError, match="eigenvalue -1"):
        riccati_formula([[-1]], [["b"]], Q=[[1]], R=[[1]], time="discrete")
    with pytest.raises(InputError, match="riccati_formula takes them"):
        solve_riccati([["a"]], [[1]], Q=[[1]], R=[[1]], time="continuous")
