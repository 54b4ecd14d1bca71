"""Hermite and row-reduced forms, coprime fractions and Bezout identities, against minors."""

from itertools import accumulate
from operator import mul

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Matrix, Poly, eye

import compensator_theory as ct
import compensator_theory as exact
from compensator_theory.errors import BudgetError
from compensator_theory.forms import hermite_form, popov_form, row_reduced_form, smith_form
from compensator_theory.strategies import coprime_pairs
from tests.support.structure_cases import (
    G_OF_THE_NOTES,
    divisors,
    minors,
    nonzero_point,
    pole_polynomial,
    polynomial_matrices,
    transfer_matrices,
)

s, a, b = sympy.symbols("s a b")


def expanded(matrix):
    return matrix.applyfunc(sympy.expand)


def is_unimodular(matrix):
    """Whether a matrix of rational functions is polynomial, with a constant determinant."""
    entries = matrix.applyfunc(sympy.cancel)
    determinant = sympy.cancel(entries.det())
    return all(e.is_polynomial(s) for e in entries) and determinant.is_number and determinant != 0


@pytest.mark.costly
@given(polynomial_matrices())
def test_the_hermite_form(P):
    form = hermite_form(P)
    U, H = form.U.as_matrix(), form.form.as_matrix()
    assert expanded(U * P.as_matrix() - H).is_zero_matrix
    assert expanded(U * form.U_inverse.as_matrix()) == eye(P.shape[0])
    assert form.rank == len(divisors(P.as_matrix())) and form.certificate.holds
    last = -1
    for i, row in enumerate(form.form.rows):
        columns = [j for j, entry in enumerate(row) if not entry.is_zero]
        assert bool(columns) == (i < form.rank)
        if columns:
            assert columns[0] > last and row[columns[0]].is_monic
            last = columns[0]
            for above in range(i):
                degree = form.form[above, last].degree()
                assert form.form[above, last].is_zero or degree < row[last].degree()


@given(polynomial_matrices(), st.lists(st.integers(-2, 2), min_size=3, max_size=3))
def test_the_hermite_form_is_unique(P, numbers):
    """Any unimodular matrix from the left leads to the same form."""
    p = P.shape[0]
    lower, upper = eye(p), eye(p)
    for i in range(1, p):
        lower[i, 0], upper[0, i] = numbers[0] * s + numbers[1], numbers[2]
    disguised = expanded(Matrix(lower) * Matrix(upper) * P.as_matrix())
    assert hermite_form(disguised, "s").form == hermite_form(P).form


@given(polynomial_matrices())
def test_row_degrees_add_up_to_the_largest_degree_of_a_minor(P):
    form = row_reduced_form(P)
    assert expanded(form.U.as_matrix() * P.as_matrix() - form.form.as_matrix()).is_zero_matrix
    assert is_unimodular(form.U.as_matrix())
    assert form.rank == len(divisors(P.as_matrix()))
    assert form.leading_matrix.rank() == form.rank
    if form.rank:
        top = form.form.as_matrix()[: form.rank, :]
        largest = max(Poly(m, s).degree() for m in minors(top, form.rank) if m != 0)
        assert sum(form.row_degrees) == largest
    if form.rank == P.shape[0] == P.shape[1]:
        assert sum(form.row_degrees) == Poly(P.as_matrix().det(), s).degree()


@given(polynomial_matrices())
def test_every_form_has_the_invariants_of_its_matrix(P):
    right = divisors(P.as_matrix())
    for form in (smith_form, hermite_form, row_reduced_form, popov_form):
        result = form(P)
        assert list(accumulate(result.invariant_polynomials, mul)) == right
        assert result.is_verified and result.rank == len(right)


@given(transfer_matrices(extra=1))
def test_both_fractions_are_the_transfer_matrix(G):
    fractions = ct.coprime_fractions(G)
    poles = pole_polynomial(G)
    point = nonzero_point(G.denominator, poles)
    value = Matrix(G.numerator_matrix().subs(s, point)) / G.denominator.eval(point)
    D_r, N_r, D_l, N_l = (
        Matrix(x(point)) for x in (fractions.D_r, fractions.N_r, fractions.D_l, fractions.N_l)
    )
    assert N_r * D_r.inv() == value == D_l.inv() * N_l
    N, d = G.numerator_matrix(), G.denominator.as_expr()
    assert expanded(N * fractions.D_r.as_matrix() - d * fractions.N_r.as_matrix()).is_zero_matrix
    assert expanded(fractions.D_l.as_matrix() * N - d * fractions.N_l.as_matrix()).is_zero_matrix


@pytest.mark.costly
@given(transfer_matrices(extra=1))
def test_they_are_coprime_and_of_least_degree(G):
    fractions = ct.coprime_fractions(G)
    right = fractions.D_r.as_matrix().col_join(fractions.N_r.as_matrix())
    left = fractions.D_l.as_matrix().row_join(fractions.N_l.as_matrix())
    assert divisors(right)[-1] == divisors(left)[-1] == ct.polynomial(1, "s")
    poles = pole_polynomial(G)
    for D in (fractions.D_r, fractions.D_l):
        assert exact.monic(D.determinant()) == poles
    assert fractions.pole_polynomial == poles and fractions.order == poles.degree()


@given(transfer_matrices(extra=1))
def test_the_bezout_identities_multiplied_out_by_sympy(G):
    fractions = ct.coprime_fractions(G)
    D_r, N_r, D_l, N_l, X_r, Y_r, X_l, Y_l = (
        getattr(fractions, name).as_matrix()
        for name in ("D_r", "N_r", "D_l", "N_l", "X_r", "Y_r", "X_l", "Y_l")
    )
    p, m = G.shape
    left = Matrix(sympy.BlockMatrix([[X_r, Y_r], [-N_l, D_l]]))
    right = Matrix(sympy.BlockMatrix([[D_r, -Y_l], [N_r, X_l]]))
    assert expanded(left * right) == eye(p + m) == expanded(right * left)
    for i in range(m):
        for j in range(p):
            assert (
                fractions.Y_r[i, j].is_zero
                or fractions.Y_r[i, j].degree() < fractions.D_l[j, j].degree()
            )


@given(transfer_matrices())
def test_what_numerator_and_denominator_share_does_not_matter(G):
    factor = ct.polynomial("s + 5")
    rows = tuple(tuple(entry * factor for entry in row) for row in G.numerators)
    first, second = (
        ct.coprime_fractions(G),
        ct.coprime_fractions(ct.TransferMatrix(rows, G.denominator * factor)),
    )
    for name in ("D_r", "N_r", "D_l", "N_l"):
        assert getattr(first, name) == getattr(second, name)


def test_the_example_of_the_notes():
    fractions = ct.coprime_fractions(G_OF_THE_NOTES)
    D_r = Matrix([[s**2 + 3 * s + 2, -s - 1], [0, s + 1]])
    N_r = Matrix([[s + 2, 1], [-1, 1]])
    Z = (fractions.D_r.as_matrix().inv() * D_r).applyfunc(sympy.cancel)
    assert is_unimodular(Z) and expanded(fractions.N_r.as_matrix() * Z - N_r).is_zero_matrix
    D_l, N_l = Matrix([[-s - 1, 0], [0, s**2 + 3 * s + 2]]), Matrix([[-1, -2], [-1, s + 1]])
    W = (D_l * fractions.D_l.as_matrix().inv()).applyfunc(sympy.cancel)
    assert is_unimodular(W) and expanded(W * fractions.N_l.as_matrix() - N_l).is_zero_matrix
    assert fractions.order == 3
    # The Bezout identity there, X D_r + Y N_r = I, with our class.
    X, Y = (
        ct.polynomial_matrix([[0, "-1/2"], [0, "-1/2"]], "s"),
        ct.polynomial_matrix([["1/2", "s/2"], ["1/2", "(s + 2)/2"]], "s"),
    )
    assert X @ ct.polynomial_matrix(D_r) + Y @ ct.polynomial_matrix(N_r) == ct.polynomial_matrix(
        eye(2), "s"
    )


def test_symbols_say_where_they_hold():
    fractions = ct.coprime_fractions("(s - a)/(s*(s - b))", "s")
    assert set(fractions.exceptional) == {a, a - b} and fractions.certificate.holds
    assert ct.coprime_fractions("(s - a)/(s*(s - a))", "s").order == 1
    row = row_reduced_form([["a*s", "s"], ["b*s + 1", "s"]], "s")
    assert row.exceptional == (a - b,) and row.row_degrees == (1, 1)


def test_scalars_agree_with_the_scalar_identity():
    fractions = ct.coprime_fractions("(s + 5)/(s**2 + 3*s + 2)")
    scalar = exact.bezout_identity("s**2 + 3*s + 2", "s + 5")
    assert fractions.X_r[0, 0] == scalar.x and fractions.Y_r[0, 0] == scalar.y
    assert ct.coprime_fractions([[2, "s"]], "s").order == 0


@given(coprime_pairs())
def test_the_scalar_identity_is_that_of_the_matrix(pair):
    """And SymPy's: what is of least degree is unique."""
    D, N = pair
    scalar = exact.bezout_identity(D, N)
    x, y, gcd = sympy.gcdex(D, N)
    assert gcd == 1 and scalar.gcd == gcd and (scalar.x, scalar.y) == (x, y)
    fractions = ct.coprime_fractions([[(N, D)]], "s")
    assert (fractions.X_r[0, 0], fractions.Y_r[0, 0]) == (x, y)


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: ct.coprime_fractions(None), ct.InputError),
        (lambda: ct.coprime_fractions([["1/s", "1/z"]]), ct.InputError),
        (lambda: ct.coprime_fractions([["1/0"]]), ct.InputError),
        (lambda: ct.coprime_fractions([["1/(s**900 + 1)", 1]]), BudgetError),
        (lambda: hermite_form([["1/s"]]), ct.InputError),
        (lambda: hermite_form([]), ct.InputError),
        (lambda: row_reduced_form([["s"], [1, 2]]), ct.InputError),
        (lambda: row_reduced_form([["exp(s)"]]), ct.InputError),
    ],
)
def test_bad_input(call, error):
    with pytest.raises(error):
        call()
