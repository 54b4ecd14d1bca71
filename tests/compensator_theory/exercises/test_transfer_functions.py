"""Transfer functions and realisations."""

import pytest
import sympy

import compensator_theory as ct
from compensator_theory.interpolation import (
    laurent_expansion,
    pade_approximant,
    partial_realisation,
)
from tests.support.exercises import equal


def test_series_circuit():
    """A resistor r, an inductor l and a capacitor c in series: from the voltage to that at c."""
    A, B, C = [[0, "1/c"], ["-1/l", "-r/l"]], [[0], ["1/l"]], [[1, 0]]
    # impedances in series: (1/(c s))/(r + l s + 1/(c s))
    assert equal(ct.transfer_function((A, B, C), "s"), "1/(l*c*s**2 + r*c*s + 1)")


def test_two_carts():
    """Two carts of mass m joined by a spring k, a force on the first: where the second is."""
    A = [[0, 0, 1, 0], [0, 0, 0, 1], ["-k/m", "k/m", 0, 0], ["k/m", "-k/m", 0, 0]]
    G = ct.transfer_function((A, [[0], [0], ["1/m"], [0]], [[0, 1, 0, 0]]), "s")
    # (m s^2 + k) x_1 = k x_2 + f and (m s^2 + k) x_2 = k x_1
    assert equal(G, "k/(m*s**2*(m*s**2 + 2*k))")


def test_controllable_canonical_form():
    """Realise (s^2 + 2 s + 3)/(s^3 + 4 s^2 + 5 s + 6) in controllable canonical form."""
    system = ct.realisation("(s**2 + 2*s + 3)/(s**3 + 4*s**2 + 5*s + 6)")
    assert equal(system.A, [[0, 1, 0], [0, 0, 1], [-6, -5, -4]])  # the last row is -(a_0, a_1, a_2)
    assert equal(system.B, [[0], [0], [1]])
    assert equal(system.C, [[3, 2, 1]])


def test_direct_term():
    """Realise (2 s + 5)/(s + 1), which is proper but not strictly proper."""
    system = ct.realisation("(2*s + 5)/(s + 1)")  # 2 + 3/(s + 1)
    assert equal(system.D, [[2]])
    assert equal(system.A, [[-1]])
    assert equal(system.C * system.B, [[3]])


def test_partial_fractions_of_a_double_pole():
    """Expand (s + 3)/((s + 1) (s + 2)^2) in partial fractions."""
    fractions = ct.partial_fractions("(s + 3)/((s + 1)*(s + 2)**2)")
    terms = {(str(t.factor.as_expr()), t.power): t.numerator.as_expr() for t in fractions.terms}
    # at -1: 2/1; at -2: 1/(-1) above, and -2 below, since the sum falls like s^-2
    assert terms == {("s + 1", 1): 2, ("s + 2", 1): -2, ("s + 2", 2): -1}


def test_fibonacci_numbers_as_an_impulse_response():
    """Give the first eight Markov parameters of 1/(z^2 - z - 1)."""
    result = ct.markov_parameters("1/(z**2 - z - 1)", 8)
    assert result == (0, *(sympy.fibonacci(k) for k in range(7)))


def test_fibonacci_numbers_realised():
    """Find the transfer function of least order whose impulse response is 1, 1, 2, 3, 5, 8."""
    system = partial_realisation([1, 1, 2, 3, 5, 8], "z")
    assert system.is_unique
    assert equal(system.transfer_function, "z/(z**2 - z - 1)")  # h(k + 2) = h(k + 1) + h(k)


def test_order_by_gilbert():
    """How many states does [[1/(s + 1), 2/(s + 2)], [1/(s + 1), 1/(s + 2)]] need?"""
    G = [["1/(s + 1)", "2/(s + 2)"], ["1/(s + 1)", "1/(s + 2)"]]
    minimal = ct.minimal_realisation(G)
    assert minimal.order == 2  # both residues have rank one
    assert equal(minimal.realisation.transfer_matrix(), G)


@pytest.mark.parametrize(("entry", "degree"), [("1/(s + 1)", 1), ("2/(s + 1)", 2)])
def test_mcmillan_degree_of_a_residue(entry, degree):
    """One entry of a 2 x 2 matrix of 1/(s + 1) changes: how many poles has it?"""
    g = "1/(s + 1)"
    assert ct.mcmillan_degree([[g, g], [g, entry]]) == degree  # the rank of the residue at -1


def test_motor_with_unity_feedback():
    """Close the loop k/(s (tau s + 1)) with unity feedback."""
    loop = ct.feedback_connection("k/(s*(tau*s + 1))", 1, feedback=-1)
    assert equal(loop, "k/(tau*s**2 + s + k)")


def test_pade_of_a_delay():
    """Approximate exp(-s) by a quotient of first order."""
    approximant = pade_approximant([1, -1, "1/2"], 1, 1)
    assert equal(approximant.approximant, "(2 - s)/(2 + s)")


def test_laurent_series_at_a_double_pole():
    """Expand 1/(s^2 (s + 1)) about 0 up to the power 1."""
    expansion = laurent_expansion("1/(s**2*(s + 1))", 0, 4)
    # s^-2 times the geometric series 1 - s + s^2 - s^3
    assert (expansion.order, [M[0, 0] for M in expansion.coefficients]) == (2, [1, -1, 1, -1])
    assert expansion.residue[0, 0] == -1


def test_inverse_system():
    """Invert [[1/s, 1], [0, 1/s]], whose inverse is improper."""
    G = ct.transfer_matrix([["1/s", 1], [0, "1/s"]])
    assert equal(G.inverse(), [["s", "-s**2"], [0, "s"]])
