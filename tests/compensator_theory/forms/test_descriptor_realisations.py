"""Descriptor realisations of improper matrices: the matrix comes back, and no mode is hidden."""

import sympy
from hypothesis import given
from hypothesis import strategies as st

import compensator_theory as ct
from tests.support.structure_cases import fewer

s = sympy.Symbol("s")


@st.composite
def improper(draw):
    """Entries with a polynomial part of degree 3 at most, over denominators of their own."""

    def entry():
        top = draw(st.lists(st.integers(-3, 3), min_size=1, max_size=4))
        below = draw(st.sampled_from([[1], [1, 1], [1, 0], [1, 2, 5]]))
        return (top if any(top) else [1]), below

    shape = draw(st.sampled_from([(1, 1), (1, 2), (2, 2)]))
    return ct.transfer_matrix([[entry() for _ in range(shape[1])] for _ in range(shape[0])], "s")


@fewer(3)
@given(improper())
def test_the_matrix_comes_back_and_no_mode_is_hidden(G):
    system = ct.descriptor_realisation(G)
    assert system.transfer_matrix().as_matrix().equals(G.as_matrix())
    assert system.is_controllable and system.is_observable
    assert system.is_impulse_controllable and system.is_impulse_observable
    slow = system.slow_part()
    strictly_proper = slow.transfer_matrix()
    assert slow.n == ct.mcmillan_degree(strictly_proper)
    # The poles at infinity: those of G(1/w) at w = 0, counted by the ranks of E.
    turned = G.as_matrix().subs(s, 1 / s).applyfunc(sympy.cancel)
    at_infinity = 0
    for size in range(1, min(G.shape) + 1):
        for rows in sympy.utilities.iterables.subsets(range(G.shape[0]), size):
            for columns in sympy.utilities.iterables.subsets(range(G.shape[1]), size):
                bottom = sympy.fraction(
                    sympy.cancel(turned.extract(list(rows), list(columns)).det())
                )[1]
                order = sympy.Poly(bottom, s).monoms()[-1][0] if bottom.has(s) else 0
                at_infinity = max(at_infinity, order)
    assert system.E.rank() == slow.n + at_infinity


def test_a_pid_controller_with_symbols():
    k_p, k_i, k_d = sympy.symbols("k_p k_i k_d")
    system = ct.descriptor_realisation("k_p + k_i/s + k_d*s", "s")
    assert sympy.cancel(system.transfer_function().as_expr() - k_p - k_i / s - k_d * s) == 0
    assert system.index == 2
    cases = str(ct.exceptional_cases(ct.descriptor_realisation, "k_p + k_i/s + k_d*s", "s"))
    assert "k_d = 0" in cases and "k_i = 0" in cases
