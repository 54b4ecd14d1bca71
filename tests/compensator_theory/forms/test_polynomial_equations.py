"""The Diophantine equation between polynomials, against Euclid's algorithm of SymPy."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError, polynomial, solve_diophantine
from compensator_theory.errors import BudgetError, NoSolutionError
from compensator_theory.results import DiophantineSolution
from compensator_theory.strategies import polynomials

s, a, b = sympy.symbols("s a b")
SIDES = st.sampled_from(["x", "y"])


@given(polynomials(), polynomials(), polynomials(max_degree=6), SIDES)
def test_against_euclid(first, second, right, least):
    u, v, g = sympy.gcdex(first, second)
    if not right.rem(g).is_zero:
        with pytest.raises(NoSolutionError, match="share the factor"):
            solve_diophantine(first, second, right, least=least)
        return
    solution = solve_diophantine(first, second, right, least=least)
    assert (first * solution.x + second * solution.y - right).is_zero
    scale = right.quo(g)
    if least == "y":  # the one solution modulo a/g
        assert solution.y == (v * scale).rem(first.quo(g))
    else:
        assert solution.x == (u * scale).rem(second.quo(g))


@given(polynomials(), polynomials(), polynomials(), polynomials())
def test_every_solution_is_a_member(first, second, x, y):
    solution = solve_diophantine(first, second, first * x + second * y)
    t, rest = (x - solution.x).div(solution.dx)
    assert rest.is_zero
    assert solution.member(t) == (x, y)


def test_the_example_of_the_notes():
    solution = solve_diophantine("s - 1", "1", "(s + 1)**2", least="x")
    d = sympy.Symbol("d")
    x, y = solution.member(sympy.Poly(s + d, s))
    assert x.as_expr() == s + d
    assert sympy.expand(y.as_expr() - ((3 - d) * s + 1 + d)) == 0


def test_symbols_say_where_they_hold():
    solution = solve_diophantine("s**2 - a", "s - b", "(s + 1)**3", variable="s")
    assert solution.exceptional == (a - b**2,) and solution.certificate.holds
    # The exceptional polynomial is the resultant, where a solution exists for special c only.
    assert sympy.resultant(s**2 - a, s - b, s) == b**2 - a
    with pytest.raises(NoSolutionError):
        solve_diophantine("s**2 - 4", "s - 2", "(s + 1)**3")
    double = solve_diophantine("a*s**2 + a", "s - b", "s + 1", variable="s")
    assert a in double.exceptional


def irreducible(expressions):
    """The irreducible factors with symbols, up to their sign."""
    factors = {f for e in expressions for f, _ in sympy.factor_list(e)[1] if f.free_symbols}
    return {max(f, sympy.expand(-f), key=str) for f in factors}


@pytest.mark.costly
@given(
    polynomials(min_degree=1, max_degree=3, is_monic=True),
    polynomials(max_degree=2),
    st.tuples(st.integers(0, 2), st.integers(0, 2)),
)
def test_the_exceptional_set_is_the_resultants(first, second, powers):
    """With a monic first polynomial the roots of the resultant are where no solution of 1 is."""
    i, j = min(powers[0], first.degree() - 1), powers[1]
    p = sympy.expand(first.as_expr() + a * s**i)
    q = sympy.expand(second.as_expr() + b * s**j)
    if (expected := sympy.resultant(p, q, s)) == 0:  # a common factor for all values
        with pytest.raises(NoSolutionError):
            solve_diophantine(p, q, "1", variable="s")
        return
    solution = solve_diophantine(p, q, "1", variable="s")
    assert irreducible(solution.exceptional) == irreducible([expected])
    assert sympy.expand(p * solution.x.as_expr() + q * solution.y.as_expr() - 1).equals(0)


def test_no_gap_between_the_two_orders_of_solution():
    least_y = solve_diophantine("s**2 - 1", "s - 2", "(s + 1)**3")
    least_x = solve_diophantine("s**2 - 1", "s - 2", "(s + 1)**3", least="x")
    assert isinstance(least_y, DiophantineSolution)
    assert least_x.x == polynomial("9", "s") and least_y.y.degree() == 1


@pytest.mark.parametrize(
    ("arguments", "options", "error"),
    [
        (("s", "0", "1"), {}, InputError),
        (("0", "s", "1"), {}, InputError),
        (("s", "s + 1", "1"), {"least": "z"}, InputError),
        (("s", "z", "1"), {}, InputError),
        (("s**900", "s**200 + 1", "1"), {}, BudgetError),
        (("1/s", "s", "1"), {}, InputError),
        (([1, 2], [1], [1]), {}, InputError),
    ],
)
def test_bad_input(arguments, options, error):
    with pytest.raises(error):
        solve_diophantine(*arguments, **options)
