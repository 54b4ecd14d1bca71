"""Elimination and products with symbols agree with SymPy's, and with numbers put in."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy.abc import a, b

from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._fraction_free import SymbolicRows
from compensator_theory.matrices._linear_algebra import determinant, rank, solve
from compensator_theory.matrices._rational_functions import vanish
from compensator_theory.matrices._symbolic_matrices import product_with_symbols

ENTRIES = st.sampled_from(
    [sympy.Integer(k) for k in (-2, 0, 0, 1, 3)]
    + [a, b, a - b, a * b + 1, a / 2, 1 / (a + b), (a - 1) / b, sympy.Rational(1, 3)]
)


def matrices(rows, columns):
    size = rows * columns
    return st.lists(ENTRIES, min_size=size, max_size=size).map(
        lambda entries: sympy.ImmutableMatrix(rows, columns, entries)
    )


@pytest.mark.costly
@given(matrices(3, 3), matrices(3, 2))
def test_solutions_solve(M, R):
    value = sympy.cancel(M.det(method="berkowitz"))
    assert sympy.cancel(determinant(M) - value) == 0
    if value != 0:
        X = solve(M, R)
        assert (M * X - R).applyfunc(sympy.cancel).is_zero_matrix
        assert all(entry == sympy.cancel(entry) for entry in X)


@pytest.mark.costly
@given(matrices(3, 2), matrices(1, 2))
def test_echelon_forms_and_ranks_are_sympys(M, more):
    whole = M.row_join(M * more.T).row_join(M[:, 0])
    expected, pivots = whole.applyfunc(sympy.cancel).rref(simplify=sympy.cancel)
    result = echelon(whole)
    assert result.pivots == pivots and rank(whole) == len(pivots)
    assert (result.matrix - expected[: len(pivots), :]).applyfunc(sympy.cancel).is_zero_matrix


@pytest.mark.costly
@given(matrices(2, 3), matrices(3, 2), matrices(2, 2))
def test_products_are_reduced(P, Q, R):
    result, expected = product_with_symbols(P, Q, R), P * Q * R
    if not any(M.free_symbols for M in (P, Q, R)):
        assert result is None
    else:
        assert result == expected.applyfunc(sympy.cancel)
        assert all(vanish(result - expected)) and vanish([expected[0] - result[0] + a]) == [False]


def test_numbers_vanish_with_and_without_symbols_beside_them():
    assert vanish([sympy.Integer(0), sympy.Rational(1, 2)]) == [True, False]
    assert vanish([sympy.Integer(0), a, sympy.sqrt(2)]) == [True, False, None]


def test_what_holds_something_else_is_left_to_sympy():
    root = sympy.sqrt(2)
    for entry in (root * a, sympy.sqrt(a), a**b, sympy.Function("f")(a), sympy.pi * a):
        assert SymbolicRows.of(sympy.Matrix([[entry]])) is None
        assert vanish([entry - entry * (1 + a)]) == [None]
    assert determinant(sympy.Matrix([[root, a], [1, root]])) == 2 - a
