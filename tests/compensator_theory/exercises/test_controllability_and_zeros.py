"""Controllability, Kalman's decomposition, zeros."""

import pytest
import sympy

import compensator_theory as ct
from tests.support.exercises import equal


def test_two_pendulums_on_one_cart():
    """Two inverted pendulums on a cart, g/l_i = a, b: when does one force control both?"""
    A = [[0, 1, 0, 0], ["a", 0, 0, 0], [0, 0, 0, 1], [0, 0, "b", 0]]
    B = [[0], ["a"], [0], ["b"]]
    cases = ct.exceptional_cases(ct.uncontrollable_polynomial, A, B, variable="s")
    assert equal(cases.at({"a": 2, "b": 3}).answer, 1)
    # the difference of equal pendulums obeys d'' = a d, and no force
    assert equal(cases.at({"a": 2, "b": 2}).answer, "s**2 - b")


def test_balanced_bridge():
    """Two capacitors charged over resistors with equal products r c: is the pair controllable?"""
    A, B = [["-1/(r*c)", 0], [0, "-1/(q*d)"]], [["1/(r*c)"], ["1/(q*d)"]]
    assert ct.is_controllable(A, B) is None  # it depends on whether r c = q d
    same = [["-1/(r*c)", 0], [0, "-1/(r*c)"]], [["1/(r*c)"], ["1/(r*c)"]]
    assert ct.is_controllable(*same) is False


def test_equal_eigenvalues_and_one_input():
    """Can one input control two equal uncoupled modes?"""
    assert ct.is_controllable([[1, 0], [0, 1]], [[1], [2]]) is False  # rank [I - I, B] = 1
    assert (
        ct.is_controllable([[1, 1], [0, 1]], [[1], [2]]) is True
    )  # one Jordan block, last entry 2


def test_four_kinds_of_states():
    """Split diag(-1, -2, -3, -4) with B = (1, 1, 0, 0)' and C = (1, 0, 1, 0) as Kalman does."""
    A = sympy.diag(-1, -2, -3, -4)
    decomposition = ct.kalman_decomposition((A, [[1], [1], [0], [0]], [[1, 0, 1, 0]]), "s")
    assert decomposition.dimensions == (1, 1, 1, 1)
    assert equal(decomposition.minimal.transfer_function(), "1/(s + 1)")
    assert equal(decomposition.input_decoupling, "(s + 3)*(s + 4)")
    assert equal(decomposition.output_decoupling, "(s + 2)*(s + 4)")


def test_cancellation_in_controllable_form():
    """(s + 1)/((s + 1) (s + 2)) in controllable form: which mode does the output not show?"""
    plant = [[0, 1], [-2, -3]], [[0], [1]], [[1, 1]]
    assert equal(ct.output_decoupling_zeros(plant, "s").polynomial, "s + 1")
    assert equal(ct.input_decoupling_zeros(plant, "s").polynomial, 1)


def test_controllability_indices():
    """A double integrator with force u_1 beside an integrator of u_2: its Brunovsky indices?"""
    A, B = [[0, 1, 0], [0, 0, 0], [0, 0, 0]], [[0, 0], [1, 0], [0, 1]]
    assert ct.brunovsky_form(A, B).indices == (2, 1)


def test_zero_in_the_right_half_plane():
    """Where does [[1/(s + 1), 2/(s + 3)], [1/(s + 1), 1/(s + 1)]] block an input, and which?"""
    G = [["1/(s + 1)", "2/(s + 3)"], ["1/(s + 1)", "1/(s + 1)"]]
    zeros = ct.transmission_zeros(G)
    assert equal(zeros.polynomial, "s - 1")  # det G = (1 - s)/((s + 1)^2 (s + 3))
    (direction,) = zeros.directions
    assert equal(sympy.Matrix([[1, 1]]) * sympy.Matrix(direction.input), [[0]])  # both rows of G(1)


@pytest.mark.parametrize(
    ("share", "zeros"), [("2/5", "(s - 1/2)*(s + 5/2)"), ("3/5", "(s + 1/3)*(s + 5/3)")]
)
def test_quadruple_tank(share, zeros):
    """Four equal tanks, a share g of each pump to the lower tank: where are the zeros?"""
    direct, crossed = f"({share})/(s + 1)", f"(1 - {share})/(s + 1)**2"
    result = ct.transmission_zeros([[direct, crossed], [crossed, direct]])
    assert equal(result.polynomial, zeros)  # (s + 1)^2 = ((1 - g)/g)^2


def test_input_decoupling_zero_of_a_series_connection():
    """1/(s + 1) after (s + 1)/(s + 2): which mode does the input not reach?"""
    # x_1' = -2 x_1 + u, y_1 = u - x_1, x_2' = -x_2 + y_1
    plant = [[-2, 0], [-1, -1]], [[1], [1]], [[0, 1]]
    assert equal(ct.input_decoupling_zeros(plant, "s").polynomial, "s + 1")
    assert equal(ct.transfer_function(plant, "s").reduced(), "1/(s + 2)")


def test_zeros_do_not_move_with_feedback():
    """Do the invariant zeros of (A + B K, B, C) depend on K?"""
    A = [["k_1", "1 + k_2"], ["k_1 - 2", "k_2 - 3"]]
    zeros = ct.invariant_zeros((A, [[1], [1]], [[1, 0]]), "s")
    # C adj(sI - A) B = s + 3 + 1 at K = 0, A_0 = [[0, 1], [-2, -3]]
    assert equal(zeros.polynomial, "s + 4")


def test_more_outputs_than_inputs():
    """Has (1/s, 1/(s + 1))' a transmission zero?"""
    assert equal(ct.transmission_zeros([["1/s"], ["1/(s + 1)"]]).polynomial, 1)  # never both zero
