"""Riccati equations and LQG, with the algebraic numbers that they need."""

import pytest
import sympy
from sympy import GoldenRatio, Rational, sqrt

import compensator_theory as ct
from compensator_theory.errors import CompensatorError
from tests.support.exercises import encloses, equal

s = sympy.Symbol("s")
A, B = [[0, 1], [0, 0]], [[0], [1]]


def test_double_integrator_with_unit_weights():
    """The optimal gain of a double integrator with Q = I and R = 1."""
    solution = ct.solve_riccati(A, B, Q=[[1, 0], [0, 1]], R=[[1]], time="continuous")
    # p_12^2 = 1, p_22^2 = 1 + 2 p_12, p_11 = p_12 p_22
    assert equal(solution.P, [[sqrt(3), 1], [1, sqrt(3)]])
    assert equal(solution.K, [[-1, -sqrt(3)]])


def test_scalar_riccati_equation():
    """P of x' = a x + b u with the weights q and r."""
    formula = ct.riccati_formula([["a"]], [["b"]], Q=[["q"]], R=[["r"]], time="continuous")
    numbers = {"a": 2, "b": 3, "q": 5, "r": 1}
    # 2 a p + q = b^2 p^2/r
    assert equal(formula.P.subs(numbers), [[(2 + sqrt(4 + 45)) / 9]])


def test_least_energy():
    """Stabilise x' = a x + u, a = 3, with the least energy of u."""
    solution = ct.solve_riccati([[3]], [[1]], Q=[[0]], R=[[1]], time="continuous")
    assert equal(solution.K, [[-6]])  # the pole is mirrored: 2 a p = p^2


def test_golden_ratio():
    """P of x(k + 1) = x(k) + u(k) with unit weights."""
    solution = ct.solve_riccati([[1]], [[1]], Q=[[1]], R=[[1]], time="discrete")
    golden = GoldenRatio.expand(func=True)  # p^2 = p + 1
    assert equal(solution.P, [[golden]])
    assert equal(solution.K, [[1 - golden]])  # -p/(1 + p)


def test_discrete_unstable_plant():
    """P of x(k + 1) = 2 x(k) + u(k) with unit weights."""
    solution = ct.solve_riccati([[2]], [[1]], Q=[[1]], R=[[1]], time="discrete")
    assert equal(solution.P, [[2 + sqrt(5)]])  # p = 1 + 4 p/(1 + p)


def test_oscillator():
    """The optimal gain of x'' = -x + u with Q = diag(3, 0) and R = 1."""
    solution = ct.solve_riccati(
        [[0, 1], [-1, 0]], B, Q=[[3, 0], [0, 0]], R=[[1]], time="continuous"
    )
    # s^4 + 2 s^2 + 4 = (s^2 + sqrt(2) s + 2)(s^2 - sqrt(2) s + 2)
    assert equal(solution.K, [[-1, -sqrt(2)]])


def test_oscillator_of_any_frequency():
    """The optimal gain of x'' = -w^2 x + u with Q = diag(q, 0) and R = 1."""
    formula = ct.riccati_formula(
        [[0, 1], ["-w**2", 0]], B, Q=[["q", 0], [0, 0]], R=[[1]], time="continuous"
    )
    # P: p_12^2 + 2 w^2 p_12 = q, p_22^2 = 2 p_12
    p_12 = sympy.sympify("sqrt(w**4 + q) - w**2")
    assert equal(formula.K, [[-p_12, -sqrt(2 * p_12)]])


def test_delay_line():
    """x_1(k + 1) = x_2(k), x_2(k + 1) = u(k): the optimal u and P for Q = diag(a, b)."""
    formula = ct.riccati_formula(A, B, Q=[["a", 0], [0, "b"]], R=[["r"]], time="discrete")
    assert equal(formula.K, [[0, 0]])  # nothing that u could make smaller
    assert equal(formula.P, [["a", 0], [0, "a + b"]])


def test_cross_weight():
    """x' = u with the cost x^2 + 2 n x u + u^2, n = 3/5."""
    solution = ct.solve_riccati([[0]], [[1]], Q=[[1]], R=[[1]], N=[["3/5"]], time="continuous")
    assert equal(solution.P, [[Rational(2, 5)]])  # 1 = (p + n)^2
    assert equal(solution.K, [[-1]])


def test_two_inputs():
    """P of two uncoupled integrators with weights 4 and 9 and both inputs of weight 1."""
    solution = ct.solve_riccati(
        [[0, 0], [0, 0]],
        [[1, 0], [0, 1]],
        Q=[[4, 0], [0, 9]],
        R=[[1, 0], [0, 1]],
        time="continuous",
    )
    assert equal(solution.P, [[2, 0], [0, 3]])


def test_coloured_noise():
    """A stable mode that the input does not reach: the regulator's gain all the same."""
    solution = ct.solve_riccati(
        [[-1, 1], [0, -2]], [[1], [0]], Q=[[1, 0], [0, 0]], R=[[1]], time="continuous"
    )
    # p_11 = sqrt(2) - 1, p_12 (3 + p_11) = p_11
    p = sqrt(2) - 1
    assert equal(solution.K, [[-p, -p / (3 + p)]])


def test_unstable_mode_that_no_input_reaches():
    """x_2' = x_2 without an input: is there a stabilising solution?"""
    with pytest.raises(CompensatorError):
        ct.solve_riccati(
            [[0, 1], [0, 1]], [[1], [0]], Q=[[1, 0], [0, 1]], R=[[1]], time="continuous"
        )


def double_integrator(variable="s"):
    """With unit weights on place, control, force and measurement."""
    return ct.StandardProblem(
        A=A, B=B, C=[[1, 0]], D_1=[[0, 0], [1, 0]], D_0=None, D_2=[[0, 1]],
        E_1=[[1, 0], [0, 0]], E_2=[[0], [1]], E_0=None, variable=variable,
    )  # fmt: skip


def test_lqg_of_a_double_integrator():
    """The LQG compensator of a double integrator with unit weights, and its cost."""
    controller = ct.lqg_controller(double_integrator())
    # K = -(1, sqrt(2)), F = (sqrt(2), 1)'
    K, F = sympy.Matrix([[-1, -sqrt(2)]]), sympy.Matrix([[sqrt(2)], [1]])
    closed = sympy.Matrix(A) + sympy.Matrix(B) * K - F * sympy.Matrix([[1, 0]])
    compensator = (K * (s * sympy.eye(2) - closed).inv() * F)[0]
    assert equal(controller.compensator, compensator)
    # tr(Q S) + tr(P F F'), S = P mirrored: sqrt(2) + (2 sqrt(2) + 2 sqrt(2) + sqrt(2))
    assert equal(controller.cost, 6 * sqrt(2))


def test_poles_of_lqg():
    """The poles of LQG for a double integrator with unit weights."""
    poles = ct.lqg_poles(double_integrator())
    for part in (poles.regulator, poles.estimator):  # s^4 + 1, mirrored at the axis
        assert all(map(encloses, part.enclosure.coefficients[1:], (sqrt(2), 1)))


def test_kalman_filter_of_a_random_walk():
    """The variance of the prediction of a random walk, all variances one, by duality."""
    solution = ct.solve_riccati([[1]], [[1]], Q=[[1]], R=[[1]], time="discrete").P
    m = sympy.Symbol("m", positive=True)
    (variance,) = sympy.solve(m - m**2 / (m + 1) + 1 - m, m)  # predict, correct
    assert equal(solution, [[variance]])


def test_symmetric_root_locus():
    """The polynomial whose stable roots are the regulator's poles of a double integrator."""
    spectrum = ct.regulator_spectrum(A, B, [[1, 0], [0, 0]], [[1]], time="continuous")
    assert equal(spectrum, "1 + s**4")  # R + G(s) G(-s) over D(s) D(-s)


def test_cheap_control_mirrors_zeros():
    """Where do the regulator's poles of (s - 1)/((s - 3)(s + 2)) stay when control is cheap?"""
    result = ct.regulator_locus("s - 1", "(s - 3)*(s + 2)")
    assert equal(result.cheap.polynomial, "s + 1")  # the mirror image of the zero
    assert result.number_to_infinity == 1
    assert equal(result.expensive.polynomial, "(s + 3)*(s + 2)")


def test_butterworth_pattern():
    """At which angles do the poles of 1/s^3 go to infinity when control is cheap?"""
    plant = ct.StandardProblem(
        A=[[0, 1, 0], [0, 0, 1], [0, 0, 0]], B=[[0], [0], [1]], C=[[1, 0, 0]], D_1=[[0], [0], [1]],
        D_0=None, D_2=[[0]], E_1=[[1, 0, 0]], E_2=[[0]], E_0=None, variable="s",
    )  # fmt: skip
    (pattern,) = ct.high_authority_limits(plant).regulator.patterns
    assert set(pattern.angles) == {2 * sympy.pi / 3, sympy.pi, 4 * sympy.pi / 3}  # of s^6 = 1


def test_spectral_factor_of_an_autocovariance():
    """The stable factor of the covariances 5, 2 at the lags 0 and 1."""
    factor = ct.spectral_factor("(2*z + 1)*(z + 2)", "z**2", time="discrete")
    stable = [
        f for f in sympy.factor_list(factor.polynomial.as_expr())[1] if f[0].subs("z", 0) != 0
    ]
    assert equal(
        stable[0][0] / sympy.LC(stable[0][0]), "z + 1/2"
    )  # (2 z + 1)(2/z + 1) = 5 + 2 z + 2/z
