"""Exact linear algebra against SymPy's slow and independent routines."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from compensator_theory import InputError
from compensator_theory.errors import NoSolutionError
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    rank,
    solve,
    solve_affine,
)
from compensator_theory.strategies import matrices

a, b, s = sympy.symbols("a b s")
SQUARE = st.integers(1, 4).flatmap(lambda n: matrices(n, n))
ANY = st.tuples(st.integers(1, 4), st.integers(1, 4)).flatmap(lambda shape: matrices(*shape))


@given(SQUARE, st.booleans())
def test_square(matrix, has_symbol):
    if has_symbol:
        matrix = matrix + a * sympy.eye(matrix.rows)
    assert sympy.expand(determinant(matrix) - matrix.det(method="berkowitz")) == 0
    assert rank(matrix) == matrix.rank(simplify=True)
    chi = characteristic_polynomial(matrix, s).as_expr()
    assert sympy.expand(chi - matrix.charpoly(s).as_expr()) == 0


@given(ANY, st.data(), st.booleans())
def test_affine_solutions(matrix, data, has_symbol):
    if has_symbol:
        matrix = matrix * a + b * sympy.ones(*matrix.shape)
    hidden = data.draw(matrices(matrix.cols, 1))
    right = matrix * hidden
    solution = solve_affine(matrix, right)
    assert (matrix * solution.particular - right).applyfunc(sympy.cancel).is_zero_matrix
    assert len(solution.nullspace) == matrix.cols - rank(matrix)
    for vector in solution.nullspace:
        assert (matrix * vector).applyfunc(sympy.cancel).is_zero_matrix


def test_what_has_no_solution():
    singular = sympy.Matrix([[1, 2], [2, 4]])
    for scale in (1, a):
        with pytest.raises(NoSolutionError):
            solve(scale * singular, sympy.Matrix([1, 1]))
        with pytest.raises(NoSolutionError, match="contradict"):
            solve_affine(scale * singular, sympy.Matrix([1, 1]))
    with pytest.raises(InputError):
        solve(sympy.zeros(2, 3), sympy.zeros(2, 1))
    with pytest.raises(InputError):
        solve_affine(sympy.zeros(2, 3), sympy.zeros(3, 1))
    assert rank(sympy.zeros(0, 3)) == 0
    assert characteristic_polynomial(sympy.zeros(0, 0), s).is_one
