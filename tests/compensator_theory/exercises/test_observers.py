"""Observers: full, reduced, functional, for unknown inputs."""

import pytest
import sympy

import compensator_theory as ct
from compensator_theory.errors import CompensatorError, InputError
from tests.support.exercises import equal

s = sympy.Symbol("s")
DOUBLE_INTEGRATOR = [[0, 1], [0, 0]], [[0], [1]], [[1, 0]]


def test_observer_of_a_double_integrator():
    """The F that gives the error of a double integrator the poles -3 and -4."""
    A, _, C = DOUBLE_INTEGRATOR
    assert equal(ct.observer_gain(A, C, [-3, -4]), [[7], [12]])  # s^2 + f_1 s + f_2


def test_observer_of_an_oscillator():
    """The F that gives x'' = -omega^2 x, measured in place, a double pole at -a."""
    gain = ct.observer_gain([[0, 1], ["-omega**2", 0]], [[1, 0]], ["-a", "-a"])
    assert equal(gain, [["2*a"], ["a**2 - omega**2"]])


def test_duality():
    """Is the observer's gain of (A, C) minus the regulator's of (A', C')?"""
    A, C = sympy.Matrix([[1, 2, 0], [0, 1, 3], [1, 0, 1]]), sympy.Matrix([[1, 0, 1]])
    assert equal(ct.observer_gain(A, C, [-1, -2, -3]), -ct.regulator_gain(A.T, C.T, [-1, -2, -3]).T)


def test_two_outputs_have_a_family():
    """A gain of the family with two outputs: has A - F C the poles?"""
    A, C = [[0, 1], [2, 3]], [[1, 0], [0, 1]]
    F = ct.observer_gain_family(A, C, [-1, -4]).gain([[1, 2], [0, 1]])
    assert equal(
        (s * sympy.eye(2) - sympy.Matrix(A) + F * sympy.Matrix(C)).det(), "(s + 1)*(s + 4)"
    )


def test_luenberger_observer_of_the_speed():
    """Estimate the speed of a double integrator from its place by one state with pole -a."""
    observer = ct.reduced_order_observer(DOUBLE_INTEGRATOR, ["-a"], variable="s")
    # z' = -a z - a^2 y + u and the speed is z + a y
    assert equal(
        [observer.N[0], observer.J[0], observer.H[0], observer.E[0]], ["-a", "-a**2", 1, "a"]
    )


def test_order_of_a_functional_observer():
    """One functional of four states measured by two: the error obeys a pole one chooses."""
    # two decoupled double integrators, both places measured: the sum of the speeds
    A = sympy.diag(*[sympy.Matrix([[0, 1], [0, 0]])] * 2)
    B, C = [[0, 0], [1, 0], [0, 0], [0, 1]], [[1, 0, 0, 0], [0, 0, 1, 0]]
    observer = ct.functional_observer((A, B, C), [[0, 1, 0, 1]], [-5], variable="s")
    assert equal(observer.error_polynomial, "s + 5")
    # the sum of two Luenberger observers z_i' = -5 z_i - 25 y_i + u_i
    assert equal(
        sympy.Matrix.hstack(observer.N, observer.J, observer.H, observer.E),
        [[-5, -25, -25, 1, 1, 5, 5]],
    )


def test_speed_under_an_unknown_force():
    """Can the speed of a mass pushed by an unknown force be estimated from its place?"""
    with pytest.raises(CompensatorError):  # C G = 0: the force must be differentiated
        ct.functional_observer(
            DOUBLE_INTEGRATOR, [[0, 1]], [-1], variable="s", unknown_inputs=[[0], [1]]
        )


def test_unknown_input_that_is_measured():
    """x_1' = x_2, x_2' = -x_1 + d with x_2 measured: estimate x_1 without knowing d."""
    A, B, C = [[0, 1], [-1, 0]], [[0], [0]], [[0, 1]]
    # x_1 is the integral of the output, so that the pole 0 cannot be moved
    with pytest.raises(InputError, match=r"the root\(s\) of s cannot be moved"):
        ct.functional_observer((A, B, C), [[1, 0]], [-1], variable="s", unknown_inputs=[[0], [1]])
    observer = ct.functional_observer(
        (A, B, C), [[1, 0]], [], variable="s", unknown_inputs=[[0], [1]]
    )
    assert equal([observer.N[0], observer.J[0], observer.error_polynomial], [0, 1, "s"])


def test_compensator_of_a_double_integrator():
    """The observer-based compensator of 1/s^2 with regulator poles -1 and observer poles -2."""
    compensator = ct.observer_based_compensator(DOUBLE_INTEGRATOR, [-1, -1], [-2, -2], variable="s")
    # K = -(1, 2), F = (4, 4)', and G_c = K (sI - A - B K + F C)^-1 F
    assert equal(compensator.transfer_function, "-(12*s + 4)/(s**2 + 6*s + 13)")


def test_separation():
    """Are the poles of the loop those of the regulator and of the observer together?"""
    compensator = ct.observer_based_compensator(DOUBLE_INTEGRATOR, [-1, -2], [-3, -5], variable="s")
    loop = ct.closed_loop_matrix(compensator.plant, compensator.compensator)
    assert equal(loop.charpoly(s).as_expr(), "(s + 1)*(s + 2)*(s + 3)*(s + 5)")


def test_undetectable_mode():
    """Can an observer of diag(1, -1) be built on y = x_2?"""
    with pytest.raises(CompensatorError):
        ct.observer_gain([[1, 0], [0, -1]], [[0, 1]], [-2, -3])


def test_compensator_with_a_reduced_observer():
    """A double integrator with u = -(1, 2) x and a Luenberger observer at -3: the compensator."""
    observer = ct.reduced_order_observer(DOUBLE_INTEGRATOR, [-3], variable="s").compensator(
        [[-1, -2]]
    )
    # u = -y - 2 (z + 3 y), z' = -3 z - 9 y + u: (s^2)(s + 5) + 7 s + 3 = (s + 1)^2 (s + 3)
    assert equal(observer.transfer_function(), "-(7*s + 3)/(s + 5)")
