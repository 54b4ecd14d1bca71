"""Resultants and Diophantine equations."""

import pytest
import sympy

import compensator_theory as ct
from compensator_theory.bezout import (
    bezout_matrix,
    cauchy_index,
    gcd_from_null_space,
    number_of_common_roots,
    subresultants,
    sylvester_m1,
)
from compensator_theory.errors import NoSolutionError
from compensator_theory.roots import number_of_real_roots
from tests.support.exercises import equal


def test_discriminant_of_a_quadratic():
    """When has s^2 + a s + b a double root?"""
    assert equal(ct.resultant("s**2 + a*s + b", "2*s + a", variable="s"), "4*b - a**2")


def test_discriminant_of_a_cubic():
    """When has s^3 + p s + q a double root?"""
    result = ct.resultant("s**3 + p*s + q", "3*s**2 + p", variable="s")
    assert equal(result, "4*p**3 + 27*q**2")  # Cardano


def test_elimination():
    """Where do the circle x^2 + y^2 = 1 and the line x = y meet?"""
    assert equal(ct.resultant("x**2 + y**2 - 1", "x - y", variable="x"), "2*y**2 - 1")


def test_sylvester_matrix_of_two_quadratics():
    """The determinant of the Sylvester matrix of (s - 1)(s - 2) and (s - 4)(s - 7)."""
    result = sylvester_m1("(s - 1)*(s - 2)", "(s - 4)*(s - 7)")
    assert result.shape == (4, 4)
    assert result.det() == (1 - 4) * (1 - 7) * (2 - 4) * (2 - 7)  # the product of the differences


def test_common_roots_with_multiplicity():
    """How many roots have (s + 1)^3 (s + 2) and its derivative in common?"""
    p = sympy.expand(sympy.sympify("(s + 1)**3*(s + 2)"))
    assert number_of_common_roots(p, sympy.diff(p)) == 2  # (s + 1)^2


def test_greatest_common_divisor():
    """The greatest common divisor of (s - 1)^2 (s + 2) and (s - 1)(s + 3), and the quotients."""
    gcd = gcd_from_null_space("(s - 1)**2*(s + 2)", "(s - 1)*(s + 3)")
    assert equal(gcd.gcd, "s - 1")
    assert equal(list(gcd.cofactors), ["(s - 1)*(s + 2)", "s + 3"])


def test_bezout_identity():
    """Write 1 as a combination of s^2 + 1 and s + 2."""
    identity = ct.bezout_identity("s**2 + 1", "s + 2")  # s^2 + 1 = (s + 2)(s - 2) + 5
    assert equal([identity.x, identity.y], ["1/5", "(2 - s)/5"])


def test_all_solutions_of_a_diophantine_equation():
    """All polynomials x and y with (s - 1) x + s y = 1."""
    solution = ct.solve_diophantine("s - 1", "s", 1)
    x, y = solution.member("t")  # one for each polynomial t
    assert equal([solution.x, solution.y], [-1, 1])
    assert equal(sympy.expand("(s - 1)") * x.as_expr() + sympy.Symbol("s") * y.as_expr(), 1)


def test_unsolvable_diophantine_equation():
    """Is there a solution of s (s + 1) x + s y = 1?"""
    with pytest.raises(NoSolutionError):  # s divides the left side
        ct.solve_diophantine("s*(s + 1)", "s", 1)


def test_matrix_diophantine_equation():
    """Solve A X + B Y = I for a left coprime pair, and count the degrees of freedom."""
    A, B = sympy.Matrix([["s", 1], [0, "s"]]), sympy.Matrix([[0], [1]])
    solution = ct.solve_matrix_diophantine(A.tolist(), B.tolist(), [[1, 0], [0, 1]], variable="s")
    X, Y = (sympy.Matrix(part.as_matrix()) for part in (solution.X, solution.Y))
    assert equal(A * X + B * Y, sympy.eye(2))
    assert solution.kernel.indices == (2,)  # [A, B] (1, -s, s^2)' = 0


def test_subresultants_find_the_degree():
    """The degree of the gcd of s^4 - 1 and s^6 - 1 by vanishing principal subresultants."""
    chain = subresultants("s**6 - 1", "s**4 - 1")
    assert [bool(c) for c in chain.principal_coefficients[:3]] == [False, False, True]
    assert equal(chain.gcd.monic(), "s**2 - 1")


def test_bezout_matrix_and_companion():
    """The Bezout matrix of p and 1 for p = s^3 + a s^2 + b s + c."""
    result = bezout_matrix("s**3 + a*s**2 + b*s + c", "1", variable="s")
    # (p(s) - p(t))/(s - t): coefficient of s^i t^j is p_(i + j + 1)
    assert equal(result, [["b", "a", 1], ["a", 1, 0], [1, 0, 0]])


def test_real_roots_by_a_cauchy_index():
    """How many real roots has (s - 1)(s - 2)(s^2 + 1)?"""
    p = sympy.expand(sympy.sympify("(s - 1)*(s - 2)*(s**2 + 1)"))
    assert cauchy_index(sympy.diff(p), p) == number_of_real_roots(p) == 2
