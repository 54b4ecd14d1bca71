"""Sylvester matrices against SymPy's, planted common roots, and the examples of Appendix B.

SymPy's ``sylvester(f, g, x)`` holds the shifted coefficients in rows, f first, for the true
degrees: the transpose of M_1. ``method=2`` is another matrix (Sylvester's of 1853), not M_2.
"""

import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy.polys.subresultants_qq_zz import sylvester as sympy_sylvester

from compensator_theory import InputError, polynomial, resultant
from compensator_theory.bezout import (
    number_of_common_roots,
    sylvester_m,
    sylvester_m1,
    sylvester_m2,
)
from compensator_theory.matrices._linear_algebra import determinant, rank
from compensator_theory.strategies import polynomials

s = sympy.Symbol("s")
UP_TO_8 = polynomials(min_degree=1, max_degree=8)


@given(UP_TO_8, UP_TO_8)
def test_m1_is_the_transpose_of_sympys(a, b):
    assert sylvester_m1(a, b) == sympy_sylvester(a.as_expr(), b.as_expr(), s).T


@given(UP_TO_8, UP_TO_8)
def test_resultant_is_sympys(a, b):
    # SymPy 1.14 loses the sign if deg a < deg b (its issue 10666); the other order is right.
    k, l = a.degree(), b.degree()
    expected = a.resultant(b) if k >= l else (-1) ** (k * l) * b.resultant(a)
    assert resultant(a, b) == expected


@given(UP_TO_8, polynomials(max_degree=8), polynomials(max_degree=2), st.integers(0, 3))
def test_the_fast_ways_agree_with_the_definition(a, b, common, zeros):
    """Theorem A1 defines both by the Sylvester matrix; python-flint computes them without it."""
    a, b = a * common, b * common
    padded = [0] * zeros + b.all_coeffs()
    matrix = sylvester_m1(a, padded)
    assert resultant(a, padded) == determinant(matrix)
    assert number_of_common_roots(a, padded) == matrix.rows - rank(matrix)


def test_sign_of_the_resultant():
    assert resultant("s + 1", "s**3") == -1  # b at the root -1 of the monic a
    assert resultant("s**3", "s + 1") == 1


@given(UP_TO_8, polynomials(max_degree=8), st.integers(0, 4))
def test_leading_zeros_of_b(a, b, zeros):
    padded = [0] * zeros + b.all_coeffs()
    k, l = a.degree(), b.degree()
    assert sylvester_m1(a, padded) == sylvester_m1(a, b, k, l + zeros)
    # Every zero in front of b multiplies the resultant by a_k.
    assert resultant(a.all_coeffs(), padded) == a.LC() ** zeros * resultant(a, b)


@given(UP_TO_8, polynomials(max_degree=8))
def test_det_m2(a, b):
    k, l = a.degree(), b.degree()
    assume(l <= k)
    assert determinant(sylvester_m2(a, b)) == a.LC() ** (k - l) * resultant(a, b)


@given(
    polynomials(max_degree=3),
    polynomials(max_degree=5),
    polynomials(max_degree=3),
    st.integers(0, 2),
)
def test_theorem_a1_counts_with_multiplicity_also_for_l_above_k(a, b, common, zeros):
    a, b = a * common, b * common
    padded = [0] * zeros + b.all_coeffs()
    assert number_of_common_roots(a, padded) == a.gcd(b).degree() >= common.degree()


def test_theorem_a1_at_its_edges():
    assert number_of_common_roots("(s + 1)**2*s", [0]) == 3
    assert number_of_common_roots("(s + 1)**2*s", [0, 0, 0, 0]) == 3
    assert number_of_common_roots(5, 3) == 0
    assert number_of_common_roots(5, "s**2") == 0
    # One for almost all values, two where b = 0.
    assert number_of_common_roots("(s + a)*(s + b)", "(s + a)*s") is None
    with pytest.raises(InputError, match="leading coefficient"):
        number_of_common_roots([0, 1, 1], [0, 5])
    with pytest.raises(InputError, match="both zero"):
        number_of_common_roots([0], [0])


@given(polynomials(min_degree=0, max_degree=4))
def test_zero_shares_every_root(b):
    """Res(0, b) = (-1)**0 Res(b, 0): zero unless b is a constant, which has no root."""
    assert number_of_common_roots([0], b) == number_of_common_roots(b, [0]) == b.degree()
    assert resultant([0], b) == resultant(b, [0]) == (0 if b.degree() > 0 else 1)


def test_arguments_of_m1():
    with pytest.raises(InputError):
        sylvester_m1([1], [2])
    with pytest.raises(InputError):
        sylvester_m1("s**2", "s", k=1)
    with pytest.raises(InputError):
        sylvester_m2("s", "s**2")
    with pytest.raises(InputError):
        sylvester_m1([], [1, 2])


def test_examples_of_appendix_b():
    assert sylvester_m1("s + 1", "s + 2") == sympy.Matrix([[1, 1], [1, 2]])  # B.1
    b2 = sylvester_m1("s + 1", "(s + 1)*(s + 2)")
    assert b2 == sympy.Matrix([[1, 0, 1], [1, 1, 3], [0, 1, 2]])
    assert (rank(b2), number_of_common_roots("s + 1", "(s + 1)*(s + 2)")) == (2, 1)
    cubic = "s**3 + 2*s**2 + 4*s + 1"
    assert sylvester_m1(cubic, 6) == 6 * sympy.eye(3)  # B.3
    b4 = sylvester_m2(cubic, [0, 0, 0, 6])
    assert b4 == sylvester_m2(cubic, 6)
    assert b4[:, 0] == sympy.Matrix([1, 2, 4, 1, 0, 0])
    assert b4[:, 3] == sympy.Matrix([0, 0, 0, 6, 0, 0])
    assert determinant(b4) == 216
    b5 = sylvester_m2(cubic, 0)
    assert (rank(b5), number_of_common_roots(cubic, [0, 0, 0, 0])) == (3, 3)


@given(
    polynomials(min_degree=1, max_degree=5, is_monic=True),
    polynomials(max_degree=4),
    st.integers(0, 6),
)
def test_m_is_m1_with_formal_degree_n_c(D, N, n_c):
    n = D.degree()
    assume(N.degree() < n and n_c >= n - 1 and n + n_c >= 1)
    assert sylvester_m(D, N, n_c, n - 1) == sylvester_m1(D, N, n, n_c)
    if n_c == n:
        assert sylvester_m(D, N, n_c, n - 1) == sylvester_m2(D, N)


@given(
    polynomials(min_degree=1, is_monic=True), polynomials(max_degree=3), polynomials(max_degree=3),
    polynomials(max_degree=3),
)  # fmt: skip
def test_m_multiplies_polynomials(D, N, left, right):
    n_c, m_hat = left.degree() + 1, right.degree()
    assume(N.degree() + m_hat < D.degree() + n_c)
    M = sylvester_m(D, N, n_c, m_hat)
    assert M.shape == (D.degree() + n_c, n_c + m_hat + 1)
    product = M * sympy.Matrix(left.all_coeffs() + right.all_coeffs())
    assert polynomial(list(product), "s") == D * left + N * right


def test_shape_of_m_is_guarded():
    assert sylvester_m("s + 1", "1", 1, -1) == sympy.Matrix([1, 1])  # N_c = 0
    with pytest.raises(InputError, match="exceeds the degree"):
        sylvester_m("s", "s", 1, 1)
    with pytest.raises(InputError):
        sylvester_m("s", "1", -1, 0)


def test_common_roots_that_depend_on_symbols_are_not_guessed():
    assert number_of_common_roots("s + a", "s + b") is None
    assert number_of_common_roots("s**2 + a", "a*s + b") is None
    assert number_of_common_roots("s**2 + a*s", "s**2 + a*s + 1") == 0  # whatever a is
