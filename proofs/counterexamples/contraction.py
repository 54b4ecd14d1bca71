"""Loops that vary in time, whose matrices are each stable."""

from collections.abc import Iterator

from sympy import Matrix, Rational, Symbol

from compensator_theory import decide_stability
from compensator_theory.matrices._linear_algebra import characteristic_polynomial

Facts = Iterator[tuple[str, bool]]


def stable_matrices_in_turn() -> Facts:
    """A_1 = [1/2 2; 0 1/2] and A_2 = [1/2 0; 2 1/2] have the eigenvalue 1/2 twice; in turn
    they have an eigenvalue above 4.
    """
    q, half = Symbol("q"), Rational(1, 2)
    A_1, A_2 = Matrix([[half, 2], [0, half]]), Matrix([[half, 0], [2, half]])
    for name, A in (("A_1", A_1), ("A_2", A_2)):
        chi = characteristic_polynomial(A, q)
        yield f"{name} is stable", bool(decide_stability(chi, time="discrete").is_stable)
    yield "A_1 A_2 [1; 1] is [21/4; 5/4]", A_1 * A_2 * Matrix([1, 1]) == Matrix([21, 5]) / 4
    both = characteristic_polynomial(A_1 * A_2, q)
    yield "A_1 A_2 is not stable", decide_stability(both, time="discrete").is_stable is False
