"""Descriptor systems against SymPy's solution of (sE - A) x = B at points, and by hand."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import ImmutableMatrix, Matrix, Rational, diag, eye

import compensator_theory as ct
from compensator_theory.errors import BudgetError, CompensatorError, ImproperError
from compensator_theory.forms import kronecker_form
from compensator_theory.strategies.plants import unimodular_matrices
from tests.support.structure_cases import fewer

s = sympy.Symbol("s")
SMALL = st.integers(-3, 3)


def drawn_matrix(draw, rows, columns):
    return Matrix(
        rows, columns, draw(st.lists(SMALL, min_size=rows * columns, max_size=rows * columns))
    )


@st.composite
def disguised(draw):
    """A slow part and nilpotent blocks, multiplied by nonsingular matrices from both sides."""
    n_1 = draw(st.integers(0, 2))
    lengths = draw(st.lists(st.integers(1, 3), min_size=not n_1, max_size=2))
    J = drawn_matrix(draw, n_1, n_1)
    shifts = [Matrix(k, k, lambda i, j: int(j == i + 1)) for k in lengths]
    N = diag(*shifts) if shifts else Matrix(0, 0, [])
    n, m, p = n_1 + sum(lengths), draw(st.integers(1, 2)), draw(st.integers(1, 2))
    left, right = draw(unimodular_matrices(n)), draw(unimodular_matrices(n))
    E, A = left * diag(eye(n_1), N) * right, left * diag(J, eye(n - n_1)) * right
    B, C, D = drawn_matrix(draw, n, m), drawn_matrix(draw, p, n), drawn_matrix(draw, p, m)
    return ct.DescriptorSystem(E, A, B, C, D), J, max(lengths, default=0)


@fewer(3)
@given(disguised(), st.lists(st.integers(5, 60), min_size=3, max_size=3, unique=True))
def test_slow_and_fast_part_are_found_again(case, points):
    system, J, index = case
    form = system.weierstrass_form()
    n_1 = J.rows
    assert form.certificate.holds and form.index == system.index == index and form.J.rows == n_1
    assert diag(eye(n_1), form.N) == form.P * system.E * form.Q
    assert diag(form.J, eye(system.n - n_1)) == form.P * system.A * form.Q
    assert form.P.det() != 0 and form.Q.det() != 0
    charpoly = (s * eye(n_1) - J).det() if n_1 else sympy.Integer(1)
    assert sympy.expand((s * eye(n_1) - form.J).det() - charpoly) == 0
    pencil = sympy.expand((s * system.E - system.A).det())
    assert sympy.expand(system.characteristic_polynomial.as_expr() - pencil) == 0
    assert system.is_impulse_free is (index <= 1)
    G = system.transfer_matrix()
    for number in points:  # beyond every eigenvalue but by chance
        point = Rational(number, 2)
        if pencil.subs(s, point) == 0:
            continue
        x = (point * system.E - system.A).LUsolve(system.B)
        assert G.as_matrix().subs(s, point) == ImmutableMatrix(system.C * x + system.D)
    infinite = kronecker_form(system.A, system.E).infinite_orders
    assert max(infinite, default=0) == index and sum(infinite) == system.n - n_1


@fewer(3)
@given(disguised())
def test_its_realisation_is_the_same_system_or_refused(case):
    system, _, _ = case
    G = system.transfer_matrix()
    proper = all(entry.is_proper for row in range(G.shape[0]) for entry in
                 (G[row, column] for column in range(G.shape[1])))  # fmt: skip
    if not proper:
        with pytest.raises(ImproperError, match="power"):
            system.realisation()
        return
    result = system.realisation()
    assert result.transfer_matrix().as_matrix().equals(G.as_matrix())
    assert result.characteristic_polynomial.degree() == system.characteristic_polynomial.degree()
    assert system.dual().transfer_matrix().as_matrix().equals(G.T.as_matrix())
    assert (system.is_controllable, system.is_observable) == (
        result.is_controllable, result.is_observable
    )  # fmt: skip


@fewer(3)
@given(disguised())
def test_hautus_ranks_decide_the_hidden_modes(case):
    """rank [sE - A, B] at every finite mode, by the roots of the pencil; at infinity by rank."""
    system, _, _ = case
    E, A, B, n = system.E, system.A, system.B, system.n
    lost = [
        root
        for root in sympy.roots(sympy.Poly(system.characteristic_polynomial.as_expr(), s))
        if (root * E - A).row_join(B).applyfunc(sympy.simplify).rank(simplify=True) < n
    ]
    assert system.is_controllable is (not lost)
    assert (system.uncontrollable_modes.degree() == 0) is (not lost)
    kernel = E.nullspace()
    columns = [E, A * Matrix.hstack(*kernel), B] if kernel else [E, B]
    # Impulse controllable: im E + A ker E + im B is the whole space (Dai 1989, Theorem 2-3.1).
    assert system.is_impulse_controllable is (Matrix.hstack(*columns).rank() == n)


@fewer(3)
@given(st.data())
def test_with_a_nonsingular_e_it_is_a_realisation(data):
    n = data.draw(st.integers(1, 3))
    E = data.draw(unimodular_matrices(n))
    A, B, C = (drawn_matrix(data.draw, *shape) for shape in ((n, n), (n, 1), (1, n)))
    system = ct.DescriptorSystem(E, A, B, C, variable="z", sample_time=Rational(1, 10))
    plain = ct.Realisation(E.inv() * A, E.inv() * B, C, None, "z", sample_time="1/10")
    assert system.index == 0 and system.is_impulse_free
    assert system.transfer_function() == plain.transfer_function()
    assert system.transfer_function().sample_time == Rational(1, 10)
    assert system.realisation().sample_time == Rational(1, 10)


def test_two_masses_on_one_rod():
    """m_1 x_1'' = u + f, m_2 x_2'' = -f, x_1 = x_2: one mass, and f = -m_2 u/(m_1 + m_2)."""
    E = diag(1, "m_1", 1, "m_2", 0)
    A = [[0, 1, 0, 0, 0], [0, 0, 0, 0, 1], [0, 0, 0, 1, 0], [0, 0, 0, 0, -1], [1, 0, -1, 0, 0]]
    system = ct.DescriptorSystem(
        E, A, [[0], [1], [0], [0], [0]], [[1, 0, 0, 0, 0], [0, 0, 0, 0, 1]]
    )
    m_1, m_2 = sympy.symbols("m_1 m_2")
    G = system.transfer_matrix().as_matrix()
    assert sympy.cancel(G[0] - 1 / ((m_1 + m_2) * s**2)) == 0
    assert sympy.cancel(G[1] + m_2 / (m_1 + m_2)) == 0
    assert system.index == 3 and system.is_impulse_free is None and m_1 + m_2 in (
        system.weierstrass_form().exceptional
    )  # fmt: skip
    numbers = ct.DescriptorSystem(E.subs({m_1: 2, m_2: 1}), A, system.B, system.C)
    assert numbers.is_impulse_free is False
    assert not numbers.is_impulse_controllable and not numbers.dual().is_impulse_observable


def test_the_cases_of_a_circuit():
    """Without its capacitor, or without its resistor, it is another circuit."""

    def circuit(c, r):
        return ct.DescriptorSystem(
            [[c, 0], [0, 0]], [[0, 1], [1, r]], [[0], [-1]], [[0, 1]]
        ).weierstrass_form()

    cases = str(ct.exceptional_cases(circuit, "c", "r"))
    assert "c = 0" in cases and "r = 0" in cases and "index 2" in cases


def test_what_the_value_of_a_symbol_decides():
    """None with the symbol, True for one value of it and False for another."""

    def system(a):
        return ct.DescriptorSystem(
            [[1, 0, 0], [0, a, 1], [0, 0, 0]], [[-1, 0, 0], [0, 1, 0], [0, a, 1]], [[a], [0], [a]],
            [[a, 0, a]],
        )  # fmt: skip

    for question in ("is_controllable", "is_observable", "is_impulse_controllable",
                     "is_impulse_observable"):  # fmt: skip
        assert getattr(system("a"), question) is None
        assert [getattr(system(a), question) for a in (0, 1)] == [False, True], question
    swapped = ct.DescriptorSystem([["a", 1], [0, 0]], [[1, 0], [0, 1]], [[0], [1]], [[1, 0]])
    assert swapped.is_impulse_free is None
    for a in (0, 1):
        known = ct.DescriptorSystem([[a, 1], [0, 0]], [[1, 0], [0, 1]], [[0], [1]], [[1, 0]])
        assert known.is_impulse_free is (a == 1)


def test_functions_read_it_as_the_system_that_it_is():
    lag = ct.DescriptorSystem([[1, 0], [0, 0]], [[-1, 1], [0, 1]], [[0], [-1]], [[1, 0]])
    assert str(ct.transfer_function(lag)) == "(1)/(s + 1)" == str(ct.transfer_matrix([[lag]])[0, 0])
    assert ct.realisation(lag).A[0, 0] == -1 and ct.h_infinity_norm(lag).value == 1
    assert ct.place_poles(lag, [-2], feedback=-1).compensator.order == 0
    assert ct.invariant_zeros(lag).polynomial.degree() == 0
    assert ct.decide_stability(lag.characteristic_polynomial, time="continuous").is_stable
    with pytest.raises(ct.InputError, match="in s, not in z"):
        ct.transfer_matrix(lag, "z")
    ideal = ct.DescriptorSystem([[0, 1], [0, 0]], eye(2), [[0], [1]], [[-1, 0]])
    with pytest.raises(ImproperError):
        ct.realisation(ideal)


@pytest.mark.parametrize(
    ("matrices", "words"),
    [(([[1, 0], [1, 0]], [[1, 0], [1, 0]], [[1], [0]], [[1, 0]]), "contradict"),
     (([[1]], [[1, 0], [1, 0]], [[1], [0]], [[1, 0]]), "E is 1 x 1"),
     (([["s"]], [[1]], [[1]], [[1]]), "E contains s"),
     (([[0]], [[1]], [[1, 2]], [[1], [2]], [[1]]), "D is"),
     (([["sqrt(2)"]], [[1]], [[1]], [[1]]), "irrational"), (("1", [[1]], [[1]], [[1]]), "rows"),
     (([[float("nan")]], [[1]], [[1]], [[1]]), "finite")],
)  # fmt: skip
def test_what_is_no_descriptor_system(matrices, words):
    with pytest.raises(CompensatorError, match=words):
        ct.DescriptorSystem(*matrices)


def test_a_large_one_asks_first():
    n = range(4)
    full = [[[f"{letter}_{i}{j}" for j in n] for i in n] for letter in "ef"]
    dense = ct.DescriptorSystem(*full, [[1]] * 4, [[1] * 4])
    with pytest.raises(BudgetError, match="terms"):
        dense.transfer_function()
    with pytest.raises(BudgetError):
        ct.DescriptorSystem(eye(150), eye(150), Matrix([1] * 150), Matrix([[1] * 150]))
