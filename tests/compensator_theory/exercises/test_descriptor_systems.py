"""Descriptor systems."""

import pytest
import sympy

from compensator_theory import DescriptorSystem, descriptor_realisation, mcmillan_degree
from compensator_theory.errors import CompensatorError
from tests.support.exercises import equal


def test_capacitor_at_a_voltage_source():
    """The current of a capacitor c at a voltage source: its transfer function and index."""
    # c v' = i, 0 = v - u
    system = DescriptorSystem([["c", 0], [0, 0]], [[0, 1], [1, 0]], [[0], [-1]], [[0, 1]])
    assert equal(system.transfer_function(), "c*s")
    assert system.index == 2


def test_resistor_and_capacitor():
    """The voltage of a capacitor charged over a resistor, with the current as a variable."""
    # c v' = i, 0 = v + r i - u
    system = DescriptorSystem([["c", 0], [0, 0]], [[0, 1], [1, "r"]], [[0], [-1]], [[1, 0]])
    assert equal(system.transfer_function(), "1/(r*c*s + 1)")
    assert system.index == 1


def test_linearised_pendulum_with_its_constraint():
    """Place, speed and constraint force of a mass held at x = 0: the index."""
    # x' = v, v' = lambda + u, 0 = x
    E, A = sympy.diag(1, 1, 0), [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    system = DescriptorSystem(E, A, [[0], [1], [0]], [[0, 0, 1]])
    assert system.index == 3
    assert equal(system.transfer_function(), -1)  # the force balances u


def test_weierstrass_form():
    """The finite modes and the nilpotent part of a pencil with the modes -1, -2 and index 2."""
    E = sympy.diag(1, 1, sympy.Matrix([[0, 1], [0, 0]]))
    A = sympy.diag(-1, -2, 1, 1)
    P = sympy.Matrix([[1, 1, 0, 0], [0, 1, 2, 0], [0, 0, 1, 1], [1, 0, 0, 1]])
    Q = sympy.Matrix([[1, 0, 0, 0], [2, 1, 0, 0], [0, 1, 1, 0], [1, 0, 3, 1]])
    system = DescriptorSystem(P * E * Q, P * A * Q, P * sympy.ones(4, 1), sympy.ones(1, 4))
    form = system.weierstrass_form()
    assert P.det() != 0
    assert Q.det() != 0
    assert equal(form.J.charpoly(sympy.Symbol("s")).as_expr(), "(s + 1)*(s + 2)")
    assert (form.index, form.N.rank(), form.N**2) == (2, 1, sympy.zeros(2))


def test_singular_pencil():
    """Is 0 = 0, x_2' = x_1 a system?"""
    with pytest.raises(CompensatorError):  # det(s E - A) = 0
        DescriptorSystem([[0, 1], [0, 0]], [[1, 0], [0, 0]], [[0], [1]], [[1, 0]])


def test_pid_controller():
    """Realise k_p + k_i/s + k_d s without hidden modes."""
    system = descriptor_realisation("k_p + k_i/s + k_d*s", "s")
    assert equal(system.transfer_function(), "k_p + k_i/s + k_d*s")
    assert system.index == 2
    assert system.n == 3  # the least: the McMillan degree is 2, one more for the impulse


def test_double_differentiator():
    """Realise s^2: the order, the index and the McMillan degree."""
    system = descriptor_realisation("s**2", "s")
    assert (system.n, system.index) == (3, 3)  # a nilpotent block of size 3
    assert mcmillan_degree("s**2", "s") == 2  # dynamic order: the rank of E
    assert sympy.Matrix(system.E).rank() == 2


def test_impulses_that_no_input_reaches():
    """x_2' = x_1, 0 = x_2 + u and 0 = x_2 with u elsewhere: is each controllable at infinity?"""
    E, A = [[0, 1], [0, 0]], [[1, 0], [0, 1]]
    assert DescriptorSystem(E, A, [[0], [1]], [[1, 0]]).is_impulse_controllable
    assert not DescriptorSystem(E, A, [[1], [0]], [[1, 0]]).is_impulse_controllable
    assert not DescriptorSystem(E, A, [[0], [1]], [[1, 0]]).is_impulse_free


def test_slow_part():
    """The state-space part of x_1' = -x_1 + u, 0 = x_2 + x_1 + u."""
    system = DescriptorSystem([[1, 0], [0, 0]], [[-1, 0], [1, 1]], [[1], [1]], [[0, 1]])
    # y = x_2 = -x_1 - u
    assert equal(system.realisation().transfer_function(), "-1/(s + 1) - 1")
    assert system.is_impulse_free


def test_inverse_of_a_strictly_proper_plant():
    """1/(s + 1) with its input as the output: its inverse s + 1 as a descriptor system."""
    # x' = -x + v, 0 = x - u, y = v
    system = DescriptorSystem([[1, 0], [0, 0]], [[-1, 1], [1, 0]], [[0], [-1]], [[0, 1]])
    assert equal(system.transfer_function(), "s + 1")
    assert system.characteristic_polynomial.degree() == 0  # no finite mode
