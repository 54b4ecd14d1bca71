"""Lyapunov's, Stein's and Sylvester's equations, Gramians and H2 norms."""

import pytest
import sympy

import compensator_theory as ct
from compensator_theory.errors import CompensatorError
from tests.support.exercises import equal

a, b, t = sympy.symbols("a b t", positive=True)


def test_quadratic_cost_of_an_oscillator():
    """The integral of x^2 along x'' + a x' + b x = 0 as a quadratic form of the initial state."""
    A = sympy.Matrix([[0, 1], ["-b", "-a"]])
    P = ct.solve_lyapunov(A.T, [[1, 0], [0, 0]]).X
    # x'Px decreases as x_1^2: entries by hand, P A + A' P = -diag(1, 0)
    assert equal(P, [["a/(2*b) + 1/(2*a)", "1/(2*b)"], ["1/(2*b)", "1/(2*a*b)"]])


def test_gramian_as_an_integral():
    """The controllability Gramian of x_1' = -x_1 + u, x_2' = -2 x_2 + u by its integral."""
    x = sympy.Matrix([sympy.exp(-t), sympy.exp(-2 * t)])
    integral = (x * x.T).applyfunc(lambda e: sympy.integrate(e, (t, 0, sympy.oo)))
    gramian_pair = ct.gramians(([[-1, 0], [0, -2]], [[1], [1]], [[1, 1]]), "s")
    assert equal(gramian_pair.controllability, integral)
    assert equal(gramian_pair.observability, integral)


def test_stein_equation_of_a_first_order_recursion():
    """The variance of x(k + 1) = a x(k) + w(k), w white of variance q."""
    assert equal(ct.solve_stein([["a"]], [["q"]]).X, [["q/(1 - a**2)"]])


def test_stein_equation_of_a_nilpotent_matrix():
    """Solve X = A X A' + Q for a shift A: a finite sum."""
    A, Q = (
        sympy.Matrix([[0, 1, 0], [0, 0, 1], [0, 0, 0]]),
        sympy.Matrix([[2, 1, 0], [1, 3, 1], [0, 1, 4]]),
    )
    assert equal(ct.solve_stein(A, Q).X, Q + A * Q * A.T + A**2 * Q * (A.T) ** 2)


def test_sylvester_equation_by_diagonals():
    """Solve Sylvester's equation for two diagonal matrices."""
    solution = ct.solve_sylvester([[1, 0], [0, 2]], [[3, 0], [0, 5]], [["c", "d"], ["e", "f"]])
    assert equal(solution.X, [["-c/4", "-d/6"], ["-e/5", "-f/7"]])  # -c_ij/(a_i + b_j)


def test_common_eigenvalue_in_a_sylvester_equation():
    """Solve x - x + 1 = 0."""
    with pytest.raises(CompensatorError):
        ct.solve_sylvester([[1]], [[-1]], [[1]])


def test_solutions_that_are_not_unique():
    """All X that commute with a Jordan block of size 2."""
    J = sympy.Matrix([[3, 1], [0, 3]])
    solution = ct.solve_sylvester(J, -J, [[0, 0], [0, 0]])
    assert not solution.is_unique
    assert len(solution.homogeneous) == 2  # polynomials in the block
    assert all(equal(J * X, X * J) for X in solution.homogeneous)


def test_h2_norm_of_a_second_order_plant():
    """The squared H2 norm of w^2/(s^2 + 2 d w s + w^2)."""
    gramian_pair = ct.gramians("w**2/(s**2 + 2*d*w*s + w**2)", "s")
    assert equal(gramian_pair.norm_squared, "w/(4*d)")


def test_h2_norm_by_parseval():
    """The squared H2 norm of (s + 3)/((s + 1)(s + 2)) by its impulse response."""
    g = 2 * sympy.exp(-t) - sympy.exp(-2 * t)  # partial fractions
    gramian_pair = ct.gramians("(s + 3)/((s + 1)*(s + 2))").norm_squared
    assert gramian_pair == sympy.integrate(sympy.expand(g**2), (t, 0, sympy.oo))


def test_discrete_h2_norm():
    """The squared H2 norm of 1/(z - a)."""
    assert equal(ct.gramians("1/(z - a)", "z").norm_squared, "1/(1 - a**2)")


def test_h2_norm_of_an_unstable_plant():
    """Has 1/(s - 1) an H2 norm?"""
    with pytest.raises(CompensatorError):
        ct.gramians("1/(s - 1)")


def test_hankel_singular_values_of_an_all_pass():
    """The Hankel singular values of (1 - s)/(1 + s)."""
    gramian_pair = ct.gramians("(1 - s)/(1 + s)").hankel_polynomial()  # squares of them as roots
    assert sympy.roots(gramian_pair) == {1: 1}  # those of a stable all-pass are one


def test_tracking_of_a_sine():
    """The state and the input with which 1/(s + 1) follows a sine exactly."""
    solution = ct.solve_regulator_equations("1/(s + 1)", [[0, 1], [-1, 0]], [[-1, 0]])
    assert equal(solution.Pi, [[1, 0]])
    assert equal(solution.Gamma, [[1, 1]])  # sin' + sin = cos + sin
