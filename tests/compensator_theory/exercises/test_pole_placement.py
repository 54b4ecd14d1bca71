"""Pole placement by state feedback and by dynamic compensators."""

import pytest
import sympy

import compensator_theory as ct
from compensator_theory.errors import CompensatorError, NotControllableError
from tests.support.exercises import equal

s = sympy.Symbol("s")


def test_double_integrator_with_damping():
    """u = K x that gives a double integrator s^2 + 2 d w s + w^2."""
    result = ct.regulator_gain([[0, 1], [0, 0]], [[0], [1]], "s**2 + 2*d*w*s + w**2")
    assert equal(result, [["-w**2", "-2*d*w"]])


def test_inverted_pendulum():
    """Put both poles of x'' = a x + u at -1."""
    assert equal(ct.regulator_gain([[0, 1], ["a", 0]], [[0], [1]], [-1, -1]), [["-1 - a", -2]])


def test_uncontrollable_pair():
    """Can the eigenvalue 2 of diag(1, 2) with B = (1, 0)' be moved?"""
    with pytest.raises(NotControllableError):
        ct.regulator_gain([[1, 0], [0, 2]], [[1], [0]], [-1, -2])


def test_eigenvalues_and_eigenvectors():
    """The K that gives x' = u in the plane the eigenvectors (1, 1) and (1, -1) at -1 and -3."""
    assignment = ct.assign_eigenstructure(
        [[0, 0], [0, 0]], [[1, 0], [0, 1]], [-1, -3], [(1, 1), (1, -1)]
    )
    assert equal(assignment.K, [[-2, 1], [1, -2]])  # V diag(-1, -3) V^-1


def test_reachable_eigenvectors():
    """Which eigenvectors can a chain of three integrators have at -2?"""
    result = ct.reachable_eigenvectors([[0, 1, 0], [0, 0, 1], [0, 0, 0]], [[0], [0], [1]], -2)
    assert equal(result / result[0], [[1], [-2], [4]])  # powers of the eigenvalue


def test_family_of_gains():
    """All gains of two inputs on the plane with s^2 + 3 s + 2: has each member that polynomial?"""
    A, B = [[0, 1], [0, 0]], [[1, 0], [0, 1]]
    family = ct.state_feedback_family(A, B, [-1, -2])
    K = family.gain([[1, 2], [3, 5]])
    assert equal((s * sympy.eye(2) - sympy.Matrix(A) - K).det(), "s**2 + 3*s + 2")
    assert equal(family.gain(family.parameters_of(K)[0]), K)


def test_compensator_of_first_order():
    """Place -2, -2, -3 for 1/(s (s + 1)) with a compensator of first order."""
    placement = ct.place_poles("1/(s*(s + 1))", [-2, -2, -3], feedback=-1)
    # (s^2 + s)(s + d) + n_1 s + n_0 = s^3 + 7 s^2 + 16 s + 12
    assert equal(placement.compensator, "(10*s + 12)/(s + 6)")
    assert placement.is_unique


def test_lead_for_a_double_integrator():
    """Place a triple pole -a for 1/s^2 with a compensator of first order."""
    placement = ct.place_poles("1/s**2", ["-a", "-a", "-a"], feedback=-1)
    assert equal(placement.compensator, "(3*a**2*s + a**3)/(s + 3*a)")


def test_pi_controller():
    """Find the PI controller that gives 1/(s + 1) a double pole at -2."""
    placement = ct.place_matrix_poles(
        [["1/(s + 1)"]], [[-2, -2]], 1, feedback=-1, internal_model="s"
    )
    # s (s + 1) + k_p s + k_i = s^2 + 4 s + 4
    assert equal(placement.compensator, [["3 + 4/s"]])


def test_deadbeat_control():
    """Bring all poles of 1/(z (z - 2)) with a compensator of first order to 0."""
    placement = ct.place_poles("1/(z*(z - 2))", [0, 0, 0], feedback=-1)
    # z (z - 2)(z + d) + n_1 z + n_0 = z^3: d = 2, n_1 = 4, n_0 = 0
    assert equal(placement.compensator, "4*z/(z + 2)")


def test_least_order():
    """How little dynamics puts poles of 1/s^3 among -1, -2, -3, -4, -5?"""
    placement = ct.place_poles("1/s**3", [-1, -2, -3, -4, -5], "least", feedback=-1)
    # s^3 (s + d) + n_1 s + n_0 has no term s^2, as (s + 1) ... (s + 4) has: order 2 at least
    assert equal(placement.compensator, "(225*s**2 + 274*s + 120)/(s**2 + 15*s + 85)")


def test_common_factor_of_the_plant():
    """Can s = 1 of (s - 1)/((s - 1)(s + 2)) be placed?"""
    plant = ct.transfer_function("(s - 1)/((s - 1)*(s + 2))")
    with pytest.raises(CompensatorError):
        ct.place_poles(plant, [-1, -2, -3], feedback=-1)


def test_three_term_controller():
    """The PID controller that gives 1/(s^2 + a s + b) a triple pole at -c."""
    controller = "((c**3) + (3*c**2 - b)*s + (3*c - a)*s**2)/s"
    loop = ct.feedback_connection(
        ct.transfer_function("1/(s**2 + a*s + b)", "s"),
        ct.transfer_function(controller, "s"),
        feedback=-1,
    )
    assert equal(loop.denominator, "(s + c)**3")


def test_matrix_placement():
    """Put s^2 + 3 s + 2 in each channel of diag(1/s, 1/(s - 1)) by a compensator of first order."""
    placement = ct.place_matrix_poles(
        [["1/s", 0], [0, "1/(s - 1)"]], [[-1, -2], [-1, -2]], 1, feedback=-1
    )
    G, C = sympy.Matrix([["1/s", 0], [0, "1/(s - 1)"]]), placement.compensator.as_matrix()
    loop = sympy.factor((sympy.eye(2) + G * C).det())
    zeros = sympy.roots(sympy.fraction(sympy.together(loop))[0], s)
    assert set(zeros) == {-1, -2}
