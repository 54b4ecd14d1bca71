"""Kalman's decomposition and minimal realisations, against ranks, minors and python-control."""

import control
import numpy as np
import pytest
import sympy
from hypothesis import given
from sympy import Matrix, eye

import compensator_theory as ct
import compensator_theory as exact
from compensator_theory.errors import BudgetError, ImproperError
from tests.support.structure_cases import (
    G_OF_THE_NOTES,
    fewer,
    pole_polynomial,
    realisations,
    transfer_matrices,
)

s, a, b = sympy.symbols("s a b")
# Order: c and not o, c and o, neither, o and not c; the pole of the transfer function is -2.
HIDDEN = (
    Matrix([[-5, 2, 1, 1], [2, -5, 2, 2], [-5, 5, -11, 7], [0, 0, 0, -9]]) / 3,
    Matrix([1, 2, 1, 0]),
    Matrix([[-2, 2, 1, 1]]) / 3,
)


def krylov(A, B):
    return Matrix.hstack(*(A**k * B for k in range(A.rows)))


def test_a_known_plant_with_every_kind_of_state():
    decomposition = ct.kalman_decomposition(HIDDEN, variable="s")
    assert decomposition.dimensions == (1, 1, 1, 1)
    assert [str(p.as_expr()) for p in decomposition.block_polynomials] == [
        "s + 1",
        "s + 2",
        "s + 3",
        "s + 4",
    ]
    assert decomposition.input_decoupling == exact.polynomial("(s + 3)*(s + 4)")
    assert decomposition.output_decoupling == exact.polynomial("(s + 1)*(s + 3)")
    assert decomposition.minimal.characteristic_polynomial == exact.polynomial("s + 2")
    assert decomposition.is_minimal is False and decomposition.certificate.holds


@given(realisations())
def test_dimensions_are_ranks(plant):
    """The oracle counts by ranks of the two Kalman matrices and of their product."""
    decomposition = ct.kalman_decomposition(plant)
    A, B, C = map(Matrix, (plant.A, plant.B, plant.C))
    reached, shown = krylov(A, B), krylov(A.T, C.T).T
    both = (shown * reached).rank()  # dim R - dim (R and N)
    assert decomposition.dimensions == (
        reached.rank() - both,
        both,
        plant.n - reached.rank() - shown.rank() + both,
        shown.rank() - both,
    )


@given(realisations())
def test_the_basis_and_the_zero_blocks(plant):
    decomposition = ct.kalman_decomposition(plant)
    new, T = decomposition.realisation, Matrix(decomposition.T)
    assert T.det() != 0
    assert (plant.A * T - T * new.A).is_zero_matrix and (plant.C * T - new.C).is_zero_matrix
    assert (plant.B - T * new.B).is_zero_matrix
    first, second, third, _ = np.cumsum(decomposition.dimensions)
    assert new.A[first:, :first].is_zero_matrix and new.A[second:, :second].is_zero_matrix
    assert new.A[third:, :third].is_zero_matrix and new.B[second:, :].is_zero_matrix
    assert new.A[first:second, second:third].is_zero_matrix
    assert new.C[:, :first].is_zero_matrix and new.C[:, second:third].is_zero_matrix
    assert decomposition.input_decoupling == plant.uncontrollable_modes
    assert decomposition.output_decoupling == plant.unobservable_modes


@fewer(2)
@given(realisations())
def test_the_minimal_part_has_the_same_transfer_matrix(plant):
    minimal = ct.minimal_realisation(plant)
    small = minimal.realisation
    assert small.is_minimal and minimal.certificate.holds
    point = sympy.Rational(1001, 7)  # above the size of every eigenvalue

    def value(r):
        return r.C * (point * eye(r.n) - r.A).inv() * r.B + r.D if r.n else r.D

    assert (value(small) - value(plant)).is_zero_matrix
    assert small.n == Matrix(krylov(plant.A.T, plant.C.T).T * krylov(plant.A, plant.B)).rank()


@given(transfer_matrices())
def test_the_least_order_is_the_mcmillan_degree_by_minors(G):
    poles = pole_polynomial(G)
    minimal = ct.minimal_realisation(G)
    assert minimal.order == ct.mcmillan_degree(G) == poles.degree()
    assert minimal.realisation.characteristic_polynomial == poles
    assert minimal.realisation.is_minimal
    assert (
        not minimal.order
        or krylov(minimal.realisation.A, minimal.realisation.B).rank() == minimal.order
    )


@pytest.mark.costly
@fewer(3)
@given(transfer_matrices(extra=2))
def test_poles_at_infinity_count(G):
    """delta(G) is the degree of all minors' poles, the point at infinity moved to 0 by s = 1/w."""
    moved = G.as_matrix().subs(s, 1 / (s + 7)).applyfunc(sympy.cancel)  # no pole is at 0
    assert ct.mcmillan_degree(G) == pole_polynomial(ct.transfer_matrix(moved, "s")).degree()


@given(transfer_matrices())
def test_markov_parameters_of_the_realisation_fill_the_hankel_matrix(G):
    small = ct.minimal_realisation(G).realisation
    H = ct.hankel_matrix(G, 2, 3)
    p, m = G.shape
    for r in range(2):
        for c in range(3):
            expected = small.C * small.A ** (r + c) * small.B if small.n else sympy.zeros(p, m)
            assert (H[p * r : p * r + p, m * c : m * c + m] - expected).is_zero_matrix


def test_the_example_of_the_notes():
    minimal = ct.minimal_realisation(G_OF_THE_NOTES)
    assert minimal.realisation == exact.Realisation(
        [[-1, 0, 0], [0, 0, 1], [0, -2, -3]], [[1, 2], [0, 1], [-1, -2]], [[1, 0, 0], [0, 1, 0]]
    )
    assert [ct.hankel_matrix(G_OF_THE_NOTES, k, k).rank() for k in (1, 2, 3)] == [2, 3, 3]
    assert ct.hankel_matrix("(s + 5)/(s**2 + 3*s + 2)", 2, 2).det() == -12


@given(transfer_matrices())
def test_python_control_agrees(G):
    system = ct.minimal_realisation(G).realisation
    matrices = [np.array(x.tolist(), dtype=float).reshape(x.shape) for x in
                (system.A, system.B, system.C, system.D)]  # fmt: skip
    value = control.ss(*matrices, remove_useless_states=False)(3 + 2j, squeeze=False)
    exactly = np.array(G.as_matrix().subs(s, 3 + 2 * sympy.I).evalf().tolist(), dtype=complex)
    np.testing.assert_allclose(value, exactly, atol=1e-9)


def test_symbols_say_where_they_hold():
    decomposition = ct.kalman_decomposition(
        ([["a", 0], [0, "b"]], [[1], ["c"]], [[1, 1]]), variable="s"
    )
    assert decomposition.dimensions == (0, 2, 0, 0) and decomposition.is_minimal is None
    assert set(decomposition.exceptional) == {a - b, sympy.Symbol("c")}
    equal = ct.kalman_decomposition(([["a", 0], [0, "a"]], [[1], ["c"]], [[1, 1]]), variable="s")
    assert equal.dimensions == (0, 1, 1, 0) and equal.is_minimal is False
    assert equal.exceptional == (
        sympy.Symbol("c") + 1,
    )  # there the reached state is the hidden one
    assert ct.minimal_realisation("(s + 1)/((s + 1)*(s + a))", "s").order == 1
    assert ct.minimal_realisation([["1/(s + a)", "1/(s + b)"]], "s").exceptional == (a - b,)


def test_no_states():
    assert ct.minimal_realisation([[2, 0]], "s").order == 0
    nothing = ct.kalman_decomposition(([[0]], [[0]], [[0]]), variable="s")
    assert nothing.dimensions == (0, 0, 1, 0) and nothing.minimal.n == 0
    assert ct.mcmillan_degree(5, "s") == 0


def test_hidden_modes_of_a_system_of_python_control():
    system = control.ss([[-1, 0], [0, -2]], [[1], [0]], [[1, 1]], 0)
    assert ct.minimal_realisation(system).order == 1
    assert ct.kalman_decomposition(system).input_decoupling == exact.polynomial("s + 2")


def test_the_factorisation_of_a_symbolic_plant_at_an_exceptional_value():
    plant = exact.Realisation([["a", 0], [0, "b"]], [[1], [1]], [[1, 1]])
    assert ct.kalman_decomposition(plant).exceptional == (a - b,)
    at_one = exact.Realisation(plant.A.subs({a: 1, b: 1}), plant.B, plant.C)
    assert ct.kalman_decomposition(at_one).dimensions[1] == 1


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: ct.minimal_realisation("s**2/(s + 1)"), ImproperError),
        (lambda: ct.minimal_realisation([["s", 1]]), ImproperError),
        (lambda: ct.kalman_decomposition(([[1, 2]], [[1]], [[1]]), "s"), ct.InputError),
        (lambda: ct.kalman_decomposition("s"), ImproperError),
        (lambda: ct.kalman_decomposition([[["sqrt(2)"]], [[1]], [[1]]], "s"), ct.InputError),
        (lambda: ct.hankel_matrix("1/s", 0, 1), ct.InputError),
        (lambda: ct.hankel_matrix("1/s", True, 1), ct.InputError),
        (lambda: ct.hankel_matrix("1/s", 600, 600), BudgetError),
        (lambda: ct.hankel_matrix("1/s", 10**6, 10**6), BudgetError),
        (lambda: ct.mcmillan_degree([["1/s", "1/z"]]), ct.InputError),
        (lambda: ct.mcmillan_degree(["1/s"]), ct.InputError),
        (lambda: ct.mcmillan_degree(None), ct.InputError),
    ],
)
def test_bad_input(call, error):
    with exact.budget(entries=10_000), pytest.raises(error):
        call()
