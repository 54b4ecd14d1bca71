"""Zeros of every kind against determinants, ranks, decoupled modes and python-control."""

import control
import numpy as np
import pytest
import sympy
from hypothesis import given
from sympy import Matrix, Poly, eye

import compensator_theory as exact
from compensator_theory import (
    InputError,
    input_decoupling_zeros,
    invariant_zeros,
    kalman_decomposition,
    minimal_realisation,
    output_decoupling_zeros,
    polynomial,
    transmission_zeros,
)
from compensator_theory.errors import ImproperError
from compensator_theory.forms import smith_mcmillan_form
from tests.support.structure_cases import G_OF_THE_NOTES, fewer, realisations, transfer_matrices

s, a, b = sympy.symbols("s a b")
HIDDEN = (
    Matrix([[-5, 2, 1, 1], [2, -5, 2, 2], [-5, 5, -11, 7], [0, 0, 0, -9]]) / 3,
    Matrix([1, 2, 1, 0]),
    Matrix([[-2, 2, 1, 1]]) / 3,
)


def system_matrix(plant):
    upper = Matrix(s * eye(plant.n) - plant.A).row_join(-plant.B)
    return upper.col_join(Matrix(plant.C).row_join(plant.D))


def vanishes(vector, factor):
    """Whether every entry is a multiple of the factor, by SymPy's remainder."""
    return all(Poly(sympy.expand(e), s).rem(Poly(factor.as_expr(), s)).is_zero for e in vector)


@given(realisations(max_block=1))
def test_the_system_matrix_is_singular_in_the_directions(plant):
    zeros = invariant_zeros(plant)
    P = system_matrix(plant)
    assert zeros.certificate.holds
    for d in zeros.directions:
        right, left = d.state.col_join(d.input), d.costate.col_join(d.output)
        assert vanishes(P * right, d.factor) and vanishes(P.T * left, d.factor)
        assert any(e != 0 for e in right) and any(e != 0 for e in left)


@given(realisations(max_block=1))
def test_as_many_directions_as_the_rank_falls(plant):
    P = system_matrix(plant)
    normal = max(P.subs(s, sympy.Rational(k, 97)).rank() for k in (101, 1001, 5))
    zeros = invariant_zeros(plant)
    linear = [d for d in zeros.directions if d.factor.degree() == 1]
    for factor in {d.factor for d in linear}:
        zero = sympy.solve(factor.as_expr(), s)[0]
        together = [d.state.col_join(d.input) for d in linear if d.factor == factor]
        assert normal - P.subs(s, zero).rank() == len(together)
        assert Matrix.hstack(*together).rank() == len(together)


@given(realisations(max_block=1))
def test_of_a_square_plant_they_are_the_roots_of_the_determinant(plant):
    P = system_matrix(plant)
    if P.rows == P.cols:
        determinant = sympy.expand(P.det(method="berkowitz"))
        if determinant != 0:
            assert invariant_zeros(plant).polynomial == exact.monic(polynomial(determinant, "s"))


@fewer(2)
@given(realisations(max_block=1))
def test_decoupling_zeros_are_the_hidden_modes(plant):
    reach, show = input_decoupling_zeros(plant), output_decoupling_zeros(plant)
    assert reach.polynomial == plant.uncontrollable_modes
    assert show.polynomial == plant.unobservable_modes
    parts = kalman_decomposition(plant)
    assert reach.polynomial == parts.input_decoupling
    assert show.polynomial == parts.output_decoupling
    for d in reach.directions:
        assert vanishes((s * eye(plant.n) - plant.A).T * d.costate, d.factor)
        assert vanishes(plant.B.T * d.costate, d.factor) and any(e != 0 for e in d.costate)
        assert not (d.state or d.input or d.output)
    for d in show.directions:
        assert vanishes((s * eye(plant.n) - plant.A) * d.state, d.factor)
        assert vanishes(plant.C * d.state, d.factor) and any(e != 0 for e in d.state)
    assert len(reach.directions) == 0 or reach.polynomial.degree() > 0


@given(transfer_matrices())
def test_transmission_zeros_are_those_of_the_minimal_realisation(G):
    zeros = transmission_zeros(G)
    assert zeros.polynomial == smith_mcmillan_form(G).zero_polynomial
    assert zeros.polynomial == invariant_zeros(minimal_realisation(G).realisation).polynomial
    for d in zeros.directions:
        assert any(e != 0 for e in d.input) and any(e != 0 for e in d.output)
        if G.denominator.gcd(d.factor).degree() == 0:  # then G has a value there
            assert vanishes(G.numerator_matrix() * d.input, d.factor)
            assert vanishes(G.numerator_matrix().T * d.output, d.factor)


def test_the_examples_of_the_notes():
    (zero,) = transmission_zeros(G_OF_THE_NOTES).directions
    assert zero.factor == polynomial("s + 3")
    assert zero.input == Matrix([2, -1]) and zero.output == Matrix([1, -1])
    G = [["(s - 1)/(s + 2)", "4/(s + 2)"], ["(9/2)/(s + 2)", "(2*s - 2)/(s + 2)"]]
    (zero,) = transmission_zeros(G).directions
    assert zero.factor == polynomial("s - 4")
    assert zero.input == Matrix([4, -3]) and zero.output == Matrix([3, -2])
    assert exact.mcmillan_degree(G) == 1
    assert invariant_zeros(HIDDEN, variable="s").polynomial == polynomial("(s + 1)*(s + 3)*(s + 4)")
    assert input_decoupling_zeros(HIDDEN, variable="s").polynomial == polynomial("(s + 3)*(s + 4)")
    assert output_decoupling_zeros(HIDDEN, variable="s").polynomial == polynomial("(s + 1)*(s + 3)")
    companion = [[0, 1, 0], [0, 0, 1], [-6, -11, -6]], [[0], [0], [1]], [[2, 1, 0]]
    (zero,) = invariant_zeros(companion, "s").directions
    assert zero.factor == polynomial("s + 2") and zero.state == Matrix([1, -2, 4])


@pytest.mark.parametrize("shape", [(3, 1), (3, 2), (4, 2)])
def test_python_control_agrees(shape):
    n, m = shape
    rng = np.random.default_rng(n)
    A, B, C = (rng.integers(-3, 4, size).tolist() for size in ((n, n), (n, m), (m, n)))
    mine = np.array([root.value for root in invariant_zeros((A, B, C), variable="s").roots])
    theirs = control.ss(A, B, C, np.zeros((m, m))).zeros()
    theirs = theirs[np.abs(theirs) < 1e6]  # those at infinity come out large
    np.testing.assert_allclose(np.sort_complex(mine), np.sort_complex(theirs), rtol=1e-6, atol=1e-6)


def test_irrational_zeros_have_one_direction_for_all_roots():
    (zero,) = invariant_zeros("(s**2 + 2)/(s**3 + 1)").directions
    assert zero.factor == polynomial("s**2 + 2")
    root = sympy.sqrt(2) * sympy.I
    A, B, C, _ = (
        exact.realisation("(s**2 + 2)/(s**3 + 1)").A,
        Matrix([0, 0, 1]),
        Matrix([[2, 0, 1]]),
        0,
    )
    x, u = zero.state.subs(s, root), zero.input.subs(s, root)
    assert ((root * eye(3) - A) * x - B * u).applyfunc(sympy.expand).is_zero_matrix
    assert (C * x).applyfunc(sympy.expand).is_zero_matrix


def test_symbols_say_where_they_hold():
    zeros = transmission_zeros([["(s + a)/(s**2 + b)", 0], [1, "(s - 1)/(s + 1)"]], "s")
    assert zeros.polynomial == polynomial("(s + a)*(s - 1)")
    assert zeros.certificate.holds and set(zeros.exceptional) == {a - 1, a**2 + b}
    assert transmission_zeros("(s + a)/(s**2 + b)", "s").exceptional == (a**2 + b,)


def test_no_zeros():
    for result in (transmission_zeros([[0]], "s"), invariant_zeros("2", "s"),
                  input_decoupling_zeros("2", "s"), output_decoupling_zeros("1/s")):  # fmt: skip
        assert result.polynomial.degree() == 0 and result.directions == result.roots == ()


@pytest.mark.parametrize("function", [invariant_zeros, input_decoupling_zeros,
                                      output_decoupling_zeros])  # fmt: skip
@pytest.mark.parametrize(
    ("plant", "error"),
    [("s", ImproperError), ((1, 2, 3), InputError), (([[1]], [[1, 2]], [[1], [2, 3]]), InputError),
     (None, InputError), (([["sqrt(2)"]], [[1]], [[1]]), InputError)],
)  # fmt: skip
def test_bad_plants(function, plant, error):
    with pytest.raises(error):
        function(plant)


def test_bad_transfer_matrices():
    for bad in (None, [["1/s"], [1, 2]], [["1/s", "1/z"]], "1/0"):
        with pytest.raises(InputError):
            transmission_zeros(bad)
