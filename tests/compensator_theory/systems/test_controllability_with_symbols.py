"""Controllability with several symbols: known for all values, or undecided, without long minors."""

import sympy

from compensator_theory import is_controllable
from tests.support.work import at_most


def test_minors_that_vary_with_several_symbols_are_not_multiplied_out():
    a, b, c = sympy.symbols("a b c")
    A = sympy.Matrix([[a, 1, 0], [b, c, 1], [1, a * b, c]])
    B = sympy.Matrix([[1, 0], [a, b], [0, c]])
    with at_most(150_000):  # cancelled minors take 30 times as many
        assert is_controllable(A, B) is None
    twice = sympy.Matrix([[1, 1], [a, a], [0, 0]])
    with at_most(150_000):  # most of these minors are 0
        assert is_controllable(A, twice) is None
    assert is_controllable(sympy.Matrix([[a, b], [1, c]]), sympy.Matrix([[1, 0], [a, 1]])) is True
    p, q = sympy.symbols("p q", positive=True)
    assert is_controllable(sympy.Matrix([[p, q], [q, p]]), sympy.Matrix([1, 0])) is True
