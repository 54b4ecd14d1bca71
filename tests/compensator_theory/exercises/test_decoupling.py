"""Decoupling, disturbance decoupling, interactors, fixed modes."""

import pytest
import sympy

from compensator_theory.errors import CompensatorError
from compensator_theory.geometry import (
    controlled_invariant_subspaces,
    decentralised_fixed_modes,
    decouple,
    decouple_disturbance,
    interactor,
)
from tests.support.exercises import equal

s = sympy.Symbol("s")
CHAIN = [[0, 1, 0], [0, 0, 1], [0, 0, 0]]


def test_relative_degrees():
    """Decouple x_1' = x_2, x_2' = x_3 + u_1, x_3' = x_1 + u_2 with the outputs x_1 and x_3."""
    A = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    B, C = [[0, 0], [1, 0], [0, 1]], [[1, 0, 0], [0, 0, 1]]
    decoupling = decouple((A, B, C), ["s**2 + 2*s + 1", "s + 3"], variable="s")
    assert tuple(decoupling.relative_degrees) == (2, 1)
    # u_1 = -x_3 - x_1 - 2 x_2 + v_1, u_2 = -x_1 - 3 x_3 + v_2
    assert equal(decoupling.F, [[-1, -2, -1], [-1, 0, -3]])
    assert equal(decoupling.W, sympy.eye(2))


def test_plant_that_cannot_be_decoupled():
    """Can [[1/s, 1/s], [1/s, 1/s + 1/s^2]] be decoupled by static state feedback?"""
    # x_1' = u_1 + u_2, x_2' = u_2: y = (x_1, x_1 + x_3), x_3' = x_2
    plant = [[0, 0, 0], [0, 0, 0], [0, 1, 0]], [[1, 1], [0, 1], [0, 0]], [[1, 0, 0], [1, 0, 1]]
    with pytest.raises(CompensatorError):  # both first derivatives feel u_1 + u_2 alone
        decouple(plant, variable="s")


def test_interactor_of_a_diagonal_matrix():
    """The interactor of diag(1/s, 1/s^2)."""
    assert equal(interactor([["1/s", 0], [0, "1/s**2"]]).matrix, [["s", 0], [0, "s**2"]])


def test_interactor_that_is_not_diagonal():
    """The interactor of [[1/s, 1/s], [1/s, 1/s + 1/s^2]]."""
    interactor_matrix = interactor([["1/s", "1/s"], ["1/s", "1/s + 1/s**2"]])
    assert equal(
        interactor_matrix.matrix, [["s", 0], ["-s**2", "s**2"]]
    )  # the rows' difference is (0, 1/s^2)
    assert equal(interactor_matrix.limit, [[1, 1], [0, 1]])


def test_largest_controlled_invariant_subspace():
    """V* of a chain of three integrators with the output 6 x_1 + 5 x_2 + x_3."""
    subspaces = controlled_invariant_subspaces((CHAIN, [[0], [0], [1]], [[6, 5, 1]]), "s")
    assert equal(subspaces.zero_polynomial, "(s + 2)*(s + 3)")
    assert sympy.Matrix(subspaces.V).shape == (3, 2)  # the kernel of C
    assert equal(sympy.Matrix([[6, 5, 1]]) * sympy.Matrix(subspaces.V), [[0, 0]])


def test_disturbance_that_can_be_hidden():
    """A disturbance enters x_2 of a chain x_1' = x_2 + x_3, x_3' = u: hide it from x_1."""
    A, B, E = [[0, 1, 1], [0, 0, 0], [0, 0, 0]], [[0], [0], [1]], [[0], [1], [-1]]
    decoupling = decouple_disturbance((A, B, [[1, 0, 0]]), E, variable="s")
    closed = sympy.Matrix(A) + sympy.Matrix(B) * sympy.Matrix(decoupling.F)
    # E raises x_2 and lowers x_3 alike: their sum, and so x_1, does not feel it
    map_to_output = sympy.Matrix([[1, 0, 0]]) * (s * sympy.eye(3) - closed).inv() * sympy.Matrix(E)
    assert decoupling.is_solvable
    assert equal(map_to_output, [[0]])


def test_disturbance_that_cannot_be_hidden():
    """A disturbance enters x_2 of a chain of three integrators: hide it from x_1."""
    decoupling = decouple_disturbance(
        (CHAIN, [[0], [0], [1]], [[1, 0, 0]]), [[0], [1], [0]], variable="s"
    )
    assert not decoupling.is_solvable  # V* = 0


def test_matched_disturbance():
    """A disturbance enters with the input of a chain: can state feedback hide it?"""
    decoupling = decouple_disturbance(
        (CHAIN, [[0], [0], [1]], [[1, 0, 0]]), [[0], [0], [1]], variable="s"
    )
    assert not decoupling.is_solvable  # it is not measured


def test_decentralised_fixed_mode():
    """The modes of x_1' = u_1, x_2' = x_2 + u_1, x_3' = u_2 that two channels cannot move."""
    A, B = sympy.diag(0, 1, 0), [[1, 0], [1, 0], [0, 1]]
    C = [[1, 0, 0], [0, 1, 1]]
    modes = decentralised_fixed_modes((A, B, C), [([0], [0]), ([1], [1])], variable="s")
    assert equal(modes.polynomial, "s - 1")  # of u_1 only y_2 sees x_2, which is channel 2
    whole = decentralised_fixed_modes((A, B, C), [([0, 1], [0, 1])], variable="s")
    assert equal(whole.polynomial, 1)
