"""Canonical forms of matrices and of polynomial matrices."""

import pytest
import sympy

from compensator_theory import exceptional_cases
from compensator_theory.forms import (
    frobenius_form,
    hermite_form,
    jordan_form,
    kronecker_form,
    minimal_basis,
    popov_form,
    row_reduced_form,
    smith_form,
    smith_mcmillan_form,
)
from tests.support.exercises import equal


def test_jordan_form_with_symbols():
    """The Jordan form of [[a, 1], [0, b]], where a = b and where not."""
    cases = exceptional_cases(jordan_form, [["a", 1], [0, "b"]])
    assert equal(cases.at({"a": 5, "b": 5}).answer.form, [["b", 1], [0, "b"]])
    assert cases.at({"a": 5, "b": 7}).answer.form.is_diagonal()


def test_nilpotent_matrix():
    """The Jordan blocks of a nilpotent 4 x 4 matrix with ranks 2, 1, 0 of its powers."""
    A = [[0, 1, 2, 3], [0, 0, 1, 2], [0, 0, 0, 0], [0, 0, 0, 0]]
    # 4 - 2 = 2 blocks, 2 - 1 = 1 of them longer than one, 1 - 0 = 1 longer than two
    assert sorted(
        block.shape[0] for block in sympy.Matrix(jordan_form(A).form).get_diag_blocks()
    ) == [1, 3]


def test_rotation():
    """The real and the complex Jordan form of the generator of a rotation with speed 3."""
    A = [[0, -3], [3, 0]]
    assert set(jordan_form(A, over="complex").form.diagonal()) == {3 * sympy.I, -3 * sympy.I}
    real = jordan_form(A, over="real").form
    assert real == -real.T
    assert abs(real[0, 1]) == 3


def test_jordan_form_transforms():
    """Bring a matrix with the double eigenvalue 2 and the eigenvalue 1 to Jordan form by T."""
    A = sympy.Matrix([[5, 4, 2], [0, 1, -1], [-1, -1, 3]])[:2, :2]
    form = jordan_form(A)
    assert set(form.form.diagonal()) == {5, 1}  # triangular
    assert equal(form.T.inv() * A * form.T, form.form)


def test_frobenius_form_of_a_diagonal_matrix():
    """The invariant polynomials of diag(1, 1, 2)."""
    form = frobenius_form([[1, 0, 0], [0, 1, 0], [0, 0, 2]])
    polynomials = [p.as_expr() for p in form.invariant_polynomials if p.degree() > 0]
    assert [sympy.factor(p) for p in polynomials] == [
        sympy.sympify("s - 1"),
        sympy.sympify("(s - 2)*(s - 1)"),
    ]
    assert not form.is_cyclic


def test_minimal_polynomial():
    """The minimal polynomial of [[2, 1, 0], [0, 2, 0], [0, 0, 2]]."""
    form = frobenius_form([[2, 1, 0], [0, 2, 0], [0, 0, 2]])
    assert equal(form.minimal_polynomial, "(s - 2)**2")  # the longest Jordan block


def test_smith_form_of_a_diagonal_matrix():
    """The Smith form of diag(s (s + 1), s (s + 2))."""
    form = smith_form([["s*(s + 1)", 0], [0, "s*(s + 2)"]])
    assert equal(form.form, [["s", 0], [0, "s*(s + 1)*(s + 2)"]])  # gcd and lcm


def test_smith_form_of_a_jordan_block():
    """The elementary divisors of sI - A for a Jordan block of size 3 at a."""
    form = smith_form([["s - a", -1, 0], [0, "s - a", -1], [0, 0, "s - a"]], "s")
    assert equal(form.form, [[1, 0, 0], [0, 1, 0], [0, 0, "(s - a)**3"]])


def test_smith_mcmillan_form():
    """The Smith-McMillan form of a 3 x 2 matrix with poles -1 and -2."""
    d = "(s**2 + 3*s + 2)"
    G = [
        [f"1/{d}", f"-1/{d}"],
        [f"(s**2 + s - 4)/{d}", f"(2*s**2 - s - 8)/{d}"],
        ["(s - 2)/(s + 1)", "(2*s - 4)/(s + 1)"],
    ]
    form = smith_mcmillan_form(G)
    # minors of d G: 1 and 3 (s^2 - 4), 3 (s^2 - 4), 3 s (s^2 - 4)
    assert [p.as_expr() for p in form.numerators] == [1, sympy.sympify("s - 2")]
    assert equal(form.denominators[0], "(s + 1)*(s + 2)")
    assert equal(form.denominators[1], "s + 1")
    assert form.mcmillan_degree == 3


def test_kronecker_form_of_a_hidden_pencil():
    """Kronecker's invariants of a 4 x 5 pencil mixed by constant matrices."""
    E = sympy.diag(sympy.Matrix([[1, 0]]), 1, sympy.Matrix([[0, 1], [0, 0]]))
    A = sympy.diag(sympy.Matrix([[0, 1]]), 3, sympy.eye(2))
    P = sympy.Matrix([[1, 2, 0, 1], [0, 1, 3, 0], [0, 0, 1, 1], [0, 0, 0, 1]])
    Q = sympy.Matrix(5, 5, lambda i, j: 1 if i == j else (i + 2 * j) % 3 if i > j else 0)
    form = kronecker_form(P * A * Q, P * E * Q)
    assert (form.right_indices, form.left_indices) == ((1,), ())
    assert equal(form.finite_polynomial, "s - 3")
    assert form.infinite_orders == (2,)


def test_hermite_form():
    """The Hermite form of [[s, 1], [s^2, s + 1]]."""
    form = hermite_form([["s", 1], ["s**2", "s + 1"]])
    assert equal(form.form, [["s", 0], [0, 1]])  # row 2 less s times row 1 is (0, 1)


def test_unimodular_matrix():
    """The Popov form and the Smith form of a unimodular matrix."""
    U = [["s + 1", "s"], ["s + 2", "s + 1"]]  # (s + 1)^2 - s (s + 2) = 1
    assert equal(popov_form(U).form, sympy.eye(2))
    assert equal(smith_form(U).form, sympy.eye(2))


@pytest.mark.parametrize(
    ("rows", "degrees"),
    [
        ([["s**2", "s"], ["s", 2]], (1, 1)),
        ([["s", 1], [1, "s"]], (1, 1)),
        ([["s**3", "s**3 + 1"], [1, 1]], (0, 0)),
    ],
)
def test_row_reduced_form(rows, degrees):
    """Reduce the rows until their degrees add up to that of the determinant."""
    form = row_reduced_form(rows)
    assert sorted(form.row_degrees) == sorted(degrees)
    determinant = sympy.Matrix(rows).applyfunc(sympy.sympify).det()
    assert sum(degrees) == sympy.degree(sympy.expand(determinant), sympy.Symbol("s"))


def test_minimal_basis_of_a_row():
    """The degrees of a minimal basis of the null space of (1, s, s^2)."""
    basis = minimal_basis([[1, "s", "s**2"]])
    assert basis.indices == (1, 1)  # (-s, 1, 0) and (0, -s, 1)
    assert equal(sympy.Matrix([[1, "s", "s**2"]]) * sympy.Matrix(basis.basis.as_matrix()), [[0, 0]])
