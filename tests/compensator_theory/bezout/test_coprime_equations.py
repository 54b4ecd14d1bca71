"""The structured solver against the Sylvester system, and against SymPy's resultant and gcd."""

from math import prod

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Matrix, Poly, Symbol, prevprime
from sympy.polys.subresultants_qq_zz import sylvester

from compensator_theory import certified_roots
from compensator_theory.bezout import _coprime_equations as coprime_equations
from compensator_theory.bezout._coprime_equations import solve_coprime_equation
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.polynomials._poly import canonical
from compensator_theory.strategies import coprime_pairs, polynomials
from compensator_theory.strategies.polynomials import coprime_to

s = Symbol("s")


@pytest.mark.parametrize("tall", [0, 10**9])
@given(coprime_pairs(), polynomials(max_degree=8))
def test_both_routes_satisfy_the_equation_with_the_least_multiplier(tall, pair, c):
    a, b = pair
    usual, coprime_equations.TALL = coprime_equations.TALL, tall
    try:
        x, y = solve_coprime_equation(a, b, c)
    finally:
        coprime_equations.TALL = usual
    assert a * x + b * y == c and y.degree() < a.degree()


@pytest.mark.parametrize("scale", [1, 7**40])
@given(coprime_pairs(), polynomials(max_degree=8))
def test_the_resultant_is_a_multiple_of_the_denominator(scale, pair, c):
    a, b = pair[0] * scale, pair[1]
    usual = coprime_equations.TALL, coprime_equations.LONG
    coprime_equations.TALL = coprime_equations.LONG = 0
    try:
        x, y = solve_coprime_equation(a, b, c)
    finally:
        coprime_equations.TALL, coprime_equations.LONG = usual
    assert a * x + b * y == c and y.degree() < a.degree()


@given(coprime_pairs(), polynomials(max_degree=3))
def test_it_is_the_solution_of_the_sylvester_system(pair, c):
    a, b = pair
    b = b if b.degree() else coprime_to(a, b * Poly(s, s))
    k, l = int(a.degree()), int(b.degree())
    c = canonical(c.rem(a * b))  # so that the system has k + l rows
    x, y = solve_coprime_equation(a, b, c)
    right = [0] * (k + l - 1 - max(int(c.degree()), 0)) + c.all_coeffs()
    solved = sylvester(a.as_expr(), b.as_expr(), s).T.LUsolve(Matrix(right))
    listed = [0] * (l - len(x.all_coeffs())) + x.all_coeffs() if l else []
    listed += [0] * (k - len(y.all_coeffs())) + y.all_coeffs()
    assert list(solved) == listed


@given(coprime_pairs(max_degree=3), polynomials(min_degree=1, max_degree=2))
def test_a_common_root_is_seen(pair, g):
    a, b = (canonical(p * g) for p in pair)
    assert solve_coprime_equation(a, b, canonical(g)) is None


def test_integer_roots_take_the_p_adic_route():
    """Remainder sequences of these swell to 13 000 bits, the answer has 450."""
    n = 40
    a = prod((Poly(s - k, s) for k in range(1, n + 1)), start=Poly(1, s))
    b = prod((Poly(2 * s - 2 * k - 1, s) for k in range(1, n)), start=Poly(1, s))
    c = prod((Poly(4 * s + k, s) for k in range(1, 2 * n)), start=Poly(1, s))
    a, b, c = map(canonical, (a, b, c))
    assert coprime_equations._is_tall(to_flint_polynomial(a), to_flint_polynomial(b))
    x, y = solve_coprime_equation(a, b, c)
    assert a * x + b * y == c and y.degree() < n


@given(polynomials())
def test_conversion_there_and_back(p):
    assert from_flint_polynomial(to_flint_polynomial(p), p.gen) == p


@pytest.mark.parametrize("prime_route", [True, False])
def test_a_prime_that_divides_the_data_is_passed_over(prime_route):
    p = prevprime(2**61)
    a = canonical(Poly([p if prime_route else 1, 1, 1], s))
    b, c = canonical(Poly([1, p + 1], s)), canonical(Poly([1, 0, 0, 1], s))
    usual, coprime_equations.TALL = coprime_equations.TALL, 0
    try:
        x, y = solve_coprime_equation(a, b, c)
    finally:
        coprime_equations.TALL = usual
    assert a * x + b * y == c


@given(st.integers(21, 30), st.integers(1, 3))
def test_close_rational_roots_of_high_degree_are_split_off(n, m):
    p = canonical(prod((Poly(3 * s + k, s) for k in range(1, n)), start=Poly(s**2 + 2, s) ** m))
    roots = certified_roots(p)
    real = [r.value.real for r in roots[: n - 1]]
    assert real == pytest.approx([-k / 3 for k in range(n - 1, 0, -1)])
    assert {r.multiplicity for r in roots[n - 1 :]} == {m}
