"""All stabilising compensators, strong and simultaneous stabilisation."""

import pytest
import sympy

import compensator_theory as ct
from compensator_theory.errors import CompensatorError
from compensator_theory.loops import compensator_from_sensitivity
from tests.support.exercises import equal

s = sympy.Symbol("s")


def loop_is_stable(plant, compensator):
    """Of 1 + P C, from numerators and denominators as they are."""
    (n, d), (n_c, d_c) = (
        sympy.fraction(sympy.cancel(sympy.sympify(g))) for g in (plant, compensator)
    )
    return ct.decide_stability(sympy.expand(d * d_c + n * n_c), time="continuous").is_stable


def test_sensitivity_of_an_integrator():
    """The sensitivity of k/s under unity feedback."""
    assert equal(ct.sensitivity_function("k/s", 1, feedback=-1), "s/(s + k)")


def test_compensator_of_a_wanted_sensitivity():
    """The compensator of 1/(s - 1) whose sensitivity is s (s - 1)/(s + 1)^2."""
    compensator = compensator_from_sensitivity("1/(s - 1)", "s*(s - 1)/(s + 1)**2", feedback=-1)
    assert equal(compensator.reduced(), "(3*s + 1)/s")  # (1/S - 1)/P


def test_sensitivity_that_cancels_an_unstable_pole():
    """The compensator of 1/(s - 1) whose sensitivity is (s + 1)/(s + 2): is the loop stable?"""
    compensator = compensator_from_sensitivity("1/(s - 1)", "(s + 1)/(s + 2)", feedback=-1)
    assert equal(compensator, "(s - 1)/(s + 1)")  # S(1) is not 0: the pole 1 is cancelled
    loop = sympy.expand(
        (s - 1) * compensator.denominator.as_expr() + compensator.numerator.as_expr()
    )
    assert not ct.decide_stability(loop, time="continuous").is_stable


def test_youla_parameter_of_a_proportional_gain():
    """Is u = -3 y among the stabilising compensators of 1/(s - 1), and for which parameter?"""
    every = ct.stabilising_compensators("1/(s - 1)", [-1], [-1], feedback=-1)
    assert every.stabilises(3)
    assert equal(every.compensator(every.parameter(3)).transfer_function().reduced(), 3)


def test_compensator_that_does_not_stabilise():
    """Is u = -y/2 among the stabilising compensators of 1/(s - 1)?"""
    every = ct.stabilising_compensators("1/(s - 1)", [-1], [-1], feedback=-1)
    assert not every.stabilises("1/2")  # the pole is 1/2


@pytest.mark.parametrize("Q", ["0", "1", "-2/(s + 3)", "(s - 1)/(s + 1)"])
def test_every_stable_parameter_stabilises(Q):
    """Does each stable parameter give a compensator that stabilises 1/(s^2 - 1)?"""
    every = ct.stabilising_compensators("1/(s**2 - 1)", [-1, -2], [-3, -3], feedback=-1)
    result = every.compensator(Q).transfer_function().reduced()
    assert loop_is_stable("1/(s**2 - 1)", result.as_expr())


def test_doubly_coprime_fractions():
    """Doubly coprime fractions of 1/(s - 1): does Bezout's identity hold?"""
    result = ct.doubly_coprime_fractions("1/(s - 1)", [-1], [-2])
    names = ("N_r", "M_r", "N_l", "M_l", "U_r", "V_r", "U_l", "V_l")
    N_r, M_r, N_l, M_l, U_r, V_r, U_l, V_l = (getattr(result, n).as_matrix()[0, 0] for n in names)
    assert equal(N_r / M_r, "1/(s - 1)")
    assert equal(N_l / M_l, "1/(s - 1)")
    # positive feedback: u = (U/V) y
    assert equal(V_l * M_r - U_l * N_r, 1)
    assert equal(M_l * V_r - N_l * U_r, 1)


def test_coprime_fraction_of_a_matrix():
    """A left coprime fraction of [[1/s, 1/s], [0, 1/(s + 1)]] and its order."""
    fractions = ct.coprime_fractions([["1/s", "1/s"], [0, "1/(s + 1)"]])
    D, N = (sympy.Matrix(part.as_matrix()) for part in (fractions.D_l, fractions.N_l))
    assert fractions.order == 2
    assert equal(D.inv() * N, [["1/s", "1/s"], [0, "1/(s + 1)"]])
    assert equal(fractions.pole_polynomial, "s*(s + 1)")


@pytest.mark.parametrize(
    ("plant", "strongly"),
    [
        ("(s - 1)/((s - 2)*(s + 1))", False),  # one pole between 1 and infinity
        ("(s - 2)/((s - 1)*(s + 1))", True),  # none
        ("(s - 1)*(s - 4)/((s - 2)*(s - 3)*(s + 1))", True),  # two between 1 and 4
        ("1/((s - 1)*(s - 2)*(s + 1))", True),  # one zero, at infinity
        ("(s - 1)/((s**2 - 4*s + 5)*(s + 1))", True),  # the pair of poles is not real
    ],
)
def test_parity_interlacing(plant, strongly):
    """Can a stable compensator stabilise the plant?"""
    assert ct.decide_strong_stabilisability(plant).is_strongly_stabilisable is strongly


def test_stable_compensator():
    """Find a stable compensator of (s - 3)/((s - 1)(s + 2))."""
    compensator = ct.stable_compensator("(s - 3)/((s - 1)*(s + 2))", feedback=-1).compensator
    assert ct.decide_stability(compensator.denominator, time="continuous").is_stable
    assert loop_is_stable("(s - 3)/((s - 1)*(s + 2))", compensator.as_expr())


def test_two_plants_at_once():
    """Does one compensator stabilise 1/(s - 1) and 1/(s - 5)?"""
    decision = ct.decide_simultaneous_stabilisability("1/(s - 1)", "1/(s - 5)", feedback=-1)
    assert decision.is_stabilisable  # u = -6 y does
    assert all(loop_is_stable(f"1/(s - {a})", decision.compensator.as_expr()) for a in (1, 5))


def test_two_plants_of_opposite_sign():
    """Does one compensator stabilise 1/(s - 1) and -1/(s - 1)?"""
    decision = ct.decide_simultaneous_stabilisability("1/(s - 1)", "-1/(s - 1)", feedback=-1)
    assert (
        not decision.is_stabilisable
    )  # at s = 0: -1 + c and -1 - c of opposite sign to both at infinity


def test_uncontrollable_unstable_plant():
    """Can (s - 1)/((s - 1)(s + 1)) with its hidden mode be stabilised?"""
    with pytest.raises(CompensatorError):
        ct.stabilising_compensators(
            ([[1, 0], [0, -1]], [[0], [1]], [[1, 1]]), [-1, -1], [-1, -1], variable="s", feedback=-1
        )
