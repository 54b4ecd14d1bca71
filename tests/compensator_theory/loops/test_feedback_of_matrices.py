"""The loop of two transfer matrices: by values, by state space, and where it does not exist."""

import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Rational

import compensator_theory as ct
from compensator_theory.errors import BudgetError, ImproperError
from tests.support.structure_cases import transfer_matrices

SIGNS = st.sampled_from([1, -1])


@given(transfer_matrices(), st.data(), SIGNS)
def test_it_is_the_loop_at_every_point(G, data, sign):
    """SymPy's matrices of numbers as the oracle; two points where nothing is infinite."""
    p, m = G.shape
    K = data.draw(transfer_matrices().filter(lambda K: K.shape == (m, p)))
    try:
        loop = ct.feedback_connection(G, K, feedback=sign)
    except ImproperError:
        limits = [A.as_matrix().applyfunc(lambda e: sympy.limit(e, "s", sympy.oo)) for A in (G, K)]
        assert (sympy.eye(p) - sign * limits[0] * limits[1]).det() == 0
        assume(False)
    for point in (Rational(17, 3), Rational(29, 7)):
        plant, compensator, result = (A.as_matrix().subs("s", point) for A in (G, K, loop))
        assert (sympy.eye(p) - sign * plant * compensator) * result == plant


@given(transfer_matrices(), SIGNS)
def test_realisations_make_the_same_loop(G, sign):
    K = ct.transfer_matrix([[Rational(i + 2 * j, 3) for i in range(G.shape[0])]
                         for j in range(G.shape[1])], "s")  # fmt: skip
    states = [ct.minimal_realisation(part).realisation for part in (G, K)]
    try:
        loop = ct.feedback_connection(G, K, feedback=sign)
    except ImproperError:
        with pytest.raises(ImproperError):
            states[0].feedback_with(states[1], feedback=sign)
        return
    joined = states[0].feedback_with(states[1], feedback=sign)
    difference = joined.transfer_matrix().as_matrix() - loop.as_matrix()
    assert difference.applyfunc(sympy.cancel).is_zero_matrix


def test_a_constant_takes_the_variable_of_the_plant():
    G = ct.transfer_matrix([["1/(z - 1)", 0], [0, "1/z"]])
    loop = ct.feedback_connection(G, [["k", 0], [0, "k"]], feedback=-1)
    assert isinstance(loop, ct.TransferMatrix) and str(loop.variable) == "z"
    assert loop == ct.transfer_matrix([["1/(z - 1 + k)", 0], [0, "1/(z + k)"]], "z")
    assert ct.feedback_connection("1/s", ct.transfer_matrix([["k"]], "s"), feedback=-1)[0, 0] == (
        ct.feedback_connection("1/s", "k", feedback=-1)
    )


def test_what_is_refused():
    G = ct.transfer_matrix([["1/(s + 1)", 1], [0, "1/s"]])
    with pytest.raises(ct.InputError, match="does not fit"):
        ct.feedback_connection(G, [["1"]], feedback=-1)
    with pytest.raises(ct.InputError, match=r"variable s .* z"):
        ct.feedback_connection(G, [["1/z", 0], [0, 1]], feedback=-1)
    with pytest.raises(ct.InputError, match=r"\+1"):
        ct.feedback_connection(G, [[1, 0], [0, 1]], feedback=0)
    one = ct.transfer_matrix([[1]], "s")
    with pytest.raises(ImproperError, match="= 0"):
        ct.feedback_connection(one, one, feedback=1)
    with pytest.raises(ImproperError, match="infinity"):
        ct.feedback_connection(ct.transfer_matrix([["s/(s + 1)"]]), one, feedback=1)
    large = ct.transfer_matrix([[f"1/(s + {i + 3 * j})" for j in range(3)] for i in range(3)])
    with ct.budget(degree=20), pytest.raises(BudgetError):  # too large is not ill posed
        ct.feedback_connection(large, [[1, 0, 0], [0, 1, 0], [0, 0, 1]], feedback=-1)
