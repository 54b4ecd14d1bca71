"""Realisations in series, in parallel and in feedback, against their transfer matrices."""

import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

from compensator_theory import InputError, Realisation, budget, solve_stein, transfer_function
from compensator_theory.errors import BudgetError, ImproperError
from compensator_theory.strategies import matrices
from tests.support.structure_cases import fewer, nonzero_point


def systems(p, m):
    return st.integers(0, 2).flatmap(
        lambda n: st.builds(
            Realisation, matrices(n, n), matrices(n, m), matrices(p, n), matrices(p, m)
        )
    )


SIZES = st.tuples(*[st.integers(1, 2)] * 3)


def value(system, point):
    """C (sI - A)^-1 B + D by SymPy's inverse."""
    pencil = point * sympy.eye(system.n) - system.A
    return system.C * pencil.inv() * system.B + system.D


def point_of(*systems):
    return nonzero_point(*(system.characteristic_polynomial for system in systems))


@fewer(2)
@given(SIZES, st.data())
def test_sums_and_products(sizes, data):
    p, m, k = sizes
    G, H, L = data.draw(systems(p, m)), data.draw(systems(p, m)), data.draw(systems(m, k))
    point = point_of(G, H, L)
    assert value(G + H, point) == value(G, point) + value(H, point)
    assert value(G - H, point) == value(G, point) - value(H, point)
    assert value(G @ L, point) == value(G, point) * value(L, point)
    assert G * L == G @ L
    assert value(G.dual(), point) == value(G, point).T
    assert (G + H).n == G.n + H.n and (G @ L).n == G.n + L.n


@fewer(2)
@given(SIZES, st.sampled_from([1, -1]), st.data())
def test_feedback(sizes, sign, data):
    p, m, _ = sizes
    G, K = data.draw(systems(p, m)), data.draw(systems(m, p))
    if (sympy.eye(p) - sign * G.D * K.D).det() == 0:
        with pytest.raises(ImproperError, match="well posed"):
            G.feedback_with(K, feedback=sign)
        return
    loop = G.feedback_with(K, feedback=sign)
    point = point_of(G, K, loop)
    g, k = value(G, point), value(K, point)
    difference = sympy.eye(p) - sign * g * k
    assume(difference.det() != 0)
    assert value(loop, point) == difference.inv() * g
    assert loop.n == G.n + K.n


def test_powers_and_equations_of_zero():
    zero = transfer_function("0", "s")
    assert zero**2 == zero and (zero**0).numerator == 1
    with pytest.raises(InputError, match="no inverse"):
        _ = zero**-1
    X, a, b = solve_stein([["a", 0], [0, "b"]], [[1, 0], [0, 1]]).X, *sympy.symbols("a b")
    assert sympy.simplify(X - sympy.diag(1 / (1 - a**2), 1 / (1 - b**2))).is_zero_matrix


def test_powers_down_to_none():
    G = Realisation([[1, 0], [0, 2]], [[1], [0]], [[1, 0]], variable="s")
    none = G**0  # no inverse is needed, and G has none
    assert none.n == 0 and sympy.eye(1) == none.D
    with budget(entries=16):  # (2 states times 2)**2
        assert (G**2).n == 4
        with pytest.raises(BudgetError):
            _ = G**3


@pytest.mark.parametrize(
    "call",
    [
        lambda G: G + Realisation([[1]], [[1, 0]], [[1]]),
        lambda G: G @ Realisation([[1]], [[1]], [[1], [1]]),
        lambda G: G - Realisation([[1]], [[1]], [[1]], variable="z"),
        lambda G: G.feedback_with(G, feedback=2),
        lambda G: G.feedback_with(Realisation([[1]], [[1, 0]], [[1]]), feedback=1),
    ],
)
def test_bad_connections(call):
    with pytest.raises(InputError):
        call(Realisation([[-1]], [[1]], [[1]]))


def test_only_realisations_are_joined():
    with pytest.raises(TypeError):
        Realisation([[-1]], [[1]], [[1]]) + 1
