"""Smith and Smith-McMillan forms against the gcds of all minors and against SymPy."""

import itertools

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import QQ, Matrix, Poly, eye
from sympy.matrices.normalforms import smith_normal_form

import compensator_theory as ct
import compensator_theory as exact
from compensator_theory.errors import BudgetError
from compensator_theory.forms import smith_form, smith_mcmillan_form
from compensator_theory.forms._equivalence import elimination_of
from compensator_theory.forms._polynomial_matrices import written
from compensator_theory.matrices._diagonalisation import by_euclid
from tests.support.structure_cases import (
    G_OF_THE_NOTES,
    divisors,
    fewer,
    minors,
    pole_polynomial,
    polynomial_matrices,
    transfer_matrices,
)

s, a, b = sympy.symbols("s a b")


@given(polynomial_matrices())
def test_invariant_polynomials_are_quotients_of_gcds_of_minors(P):
    form = smith_form(P)
    expected = divisors(P.as_matrix())
    assert form.rank == len(expected)
    product = ct.polynomial(1, "s")
    for invariant, divisor in zip(form.invariant_polynomials, expected, strict=True):
        product = product * invariant
        assert exact.polynomial(product) == divisor
    for lower, higher in itertools.pairwise(form.invariant_polynomials):
        assert higher.rem(lower).is_zero
    off = [form.form[i, j] for i in range(P.shape[0]) for j in range(P.shape[1])
           if i != j or i >= form.rank]  # fmt: skip
    assert all(entry.is_zero for entry in off)


@pytest.mark.costly
@given(polynomial_matrices())
def test_the_unimodular_matrices_multiplied_out_by_sympy(P):
    form = smith_form(P)
    U, V, S = (x.as_matrix() for x in (form.U, form.V, form.form))
    assert (U * P.as_matrix() * V - S).applyfunc(sympy.expand).is_zero_matrix
    for x, inverse in ((form.U, form.U_inverse), (form.V, form.V_inverse)):
        product = (x.as_matrix() * inverse.as_matrix()).applyfunc(sympy.expand)
        assert product == eye(x.shape[0])
        assert x.determinant().degree() == 0
    assert form.certificate.holds and form.exceptional == ()


@fewer(2)
@given(polynomial_matrices())
def test_sympy_agrees(P):
    theirs = smith_normal_form(P.as_matrix(), domain=QQ[s])
    size = min(P.shape)
    diagonal = [Poly(theirs[i, i], s, domain=QQ) for i in range(size)]
    monic = [p if p.is_zero else p.monic() for p in diagonal]
    assert monic == [smith_form(P).form[i, i] for i in range(size)]


@given(transfer_matrices(extra=1))
def test_poles_and_zeros_by_minors(G):
    """Poles: the least common denominator of all minors. Zeros: gcd of the largest ones over it."""
    form = smith_mcmillan_form(G)
    poles = pole_polynomial(G)
    assert form.pole_polynomial == poles
    N, d = G.numerator_matrix(), G.denominator.as_expr()
    if form.rank:
        tops = [sympy.cancel(m / d**form.rank * poles.as_expr()) for m in minors(N, form.rank)]
        common = Poly(0, s)
        for top in tops:
            common = common.gcd(Poly(top, s))
        assert form.zero_polynomial == exact.monic(ct.polynomial(common.as_expr(), "s"))
    for e, p in zip(form.numerators, form.denominators, strict=True):
        assert e.gcd(p).degree() == 0
    for i in range(form.rank - 1):
        assert form.numerators[i + 1].rem(form.numerators[i]).is_zero
        assert form.denominators[i].rem(form.denominators[i + 1]).is_zero


@given(transfer_matrices(extra=1))
def test_the_degree_by_hankel_matrices(G):
    form = smith_mcmillan_form(G)
    assert form.mcmillan_degree == ct.mcmillan_degree(G)
    if form.rank == G.shape[0] == G.shape[1]:  # the orders add up to that of the determinant
        top = Poly(G.numerator_matrix().det(), s)
        assert sum(form.orders_at_infinity) == (form.rank * G.denominator.degree() - top.degree())
    assert list(form.orders_at_infinity) == sorted(form.orders_at_infinity)
    assert len(form.orders_at_infinity) == form.rank
    if min(form.orders_at_infinity, default=0) >= 0:
        assert ct.minimal_realisation(G).order == form.pole_polynomial.degree()


@given(transfer_matrices(extra=1))
def test_orders_at_infinity_by_a_move_of_the_point(G):
    """G(1/w) has at w = 0 the structure of G at infinity: the powers of w in its finite form."""
    moved = G.as_matrix().subs(s, 1 / s).applyfunc(sympy.cancel)
    there = smith_mcmillan_form(exact.transfer_matrix(moved, "s"))
    orders = [e.monoms()[-1][0] - p.monoms()[-1][0]
              for e, p in zip(there.numerators, there.denominators, strict=True)]  # fmt: skip
    assert sorted(orders) == list(smith_mcmillan_form(G).orders_at_infinity)


def test_the_examples_of_the_notes():
    assert str(smith_form([["s*(s + 1)", 0], [0, "s*(s + 2)"]])) == (
        "[[s, 0], [0, s**3 + 3*s**2 + 2*s]]"
    )
    kailath = Matrix([[s, s * (s + 1) ** 2], [-s * (s + 2) ** 2, -s * (s + 2) ** 2]])
    form = smith_mcmillan_form(kailath / ((s + 1) ** 2 * (s + 2) ** 2))
    assert form.numerators == (ct.polynomial("s"), ct.polynomial("s**2*(s + 2)"))
    assert form.denominators == (ct.polynomial("(s+1)**2*(s+2)**2"), ct.polynomial("(s + 1)**2"))
    assert form.mcmillan_degree == 6
    assert form.pole_polynomial == ct.polynomial("(s + 1)**4*(s + 2)**2")
    assert sorted(root.multiplicity for root in form.poles) == [2, 4]
    mine = smith_mcmillan_form(G_OF_THE_NOTES)
    assert str(mine) == "diag((1)/(s**2 + 3*s + 2), (s + 3)/(s + 1))"
    assert mine.mcmillan_degree == ct.hankel_matrix(G_OF_THE_NOTES, 3, 3).rank() == 3
    frobenius = Matrix([[3, -1, 2, -1], [1, 1, 2, -1], [-1, 1, 1, 1], [-2, 2, -2, 4]])
    invariants = smith_form(s * eye(4) - frobenius, "s").invariant_polynomials
    assert [p.as_expr().factor() for p in invariants] == [1, 1, s - 2, (s - 3) * (s - 2) ** 2]
    assert smith_form(s * eye(4) - frobenius).elementary_divisors == (
        (ct.polynomial("s - 2"), 1), (ct.polynomial("s - 3"), 1), (ct.polynomial("s - 2"), 2),
    )  # fmt: skip


def test_the_trap_of_symbols_is_named():
    form = smith_form([["s", "a"], [0, "s"]])
    assert str(form) == "[[1, 0], [0, s**2]]" and form.exceptional == (a,)
    assert str(smith_form([["s", 0], [0, "s"]])) == "[[s, 0], [0, s]]"
    assert smith_mcmillan_form("(s - a)/((s - 1)*(s - 2))", "s").exceptional == (a - 1, a - 2)


@fewer(4)
@given(st.integers(-3, 3), st.integers(-3, 3))
def test_off_the_exceptional_set_the_form_specialises(x, y):
    P = Matrix([[s + a, 1, b], [0, s + b, s * a], [b * s, 0, a - 1]])
    form = smith_form(P[:2, :], "s")
    values = {a: x, b: y}
    if all(sympy.sympify(f).subs(values) != 0 for f in form.exceptional):
        special = smith_form(P[:2, :].subs(values), "s")
        assert form.form.as_matrix().subs(values) == special.form.as_matrix()


def test_irrational_coefficients():
    form = smith_form([["s**2 - 2", "s - sqrt(2)"], [0, "s + sqrt(2)"]], "s")
    assert form.rank == 2 and form.exceptional == ()
    assert form.certificate.holds


def test_matrices_compute():
    P = ct.polynomial_matrix([["s", 1], [0, "s + 1"]])
    assert (P + P - P) == P and (P - P).degree == -1 and P.T.T == P
    assert (P @ P)(3) == P(3) * P(3) and (-P)[0, 0] == ct.polynomial("-s")


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: smith_form([["1/s"]]), ct.InputError),
        (lambda: smith_form([["s"], ["s", 1]]), ct.InputError),
        (lambda: smith_form([["s", "z"]]), ct.InputError),
        (lambda: smith_form([]), ct.InputError),
        (lambda: smith_form("sin(s)"), ct.InputError),
        (lambda: smith_form([["s**900", 1], [1, "s**900"]]), BudgetError),
        (lambda: smith_form([["s**100000"]]), BudgetError),
        (lambda: smith_mcmillan_form([["1/0"]]), ct.InputError),
        (lambda: smith_mcmillan_form(None), ct.InputError),
        (lambda: exact.results.PolynomialMatrix(()), ct.InputError),
        (
            lambda: exact.results.PolynomialMatrix(((ct.polynomial("s"), ct.polynomial("z")),)),
            ct.InputError,
        ),
        (lambda: ct.polynomial_matrix([["s"]]) @ ct.polynomial_matrix([["s"], [1]]), ct.InputError),
        (lambda: ct.polynomial_matrix([["s"]]) + ct.polynomial_matrix([["s"], [1]]), ct.InputError),
        (lambda: ct.polynomial_matrix([["s"]]) @ ct.polynomial_matrix([["z"]]), ct.InputError),
    ],
)
def test_bad_input(call, error):
    with pytest.raises(error):
        call()


def test_a_sum_with_something_else():
    P = ct.polynomial_matrix([["s"]])
    for operation in (lambda: P + 1, lambda: P @ 1, lambda: P - "s"):
        with pytest.raises(TypeError):
            operation()


SMALL_ENTRIES = st.sampled_from(
    ["0", "1", "s", "a", "s + a", "b*s + 1", "s*(s + b)", "a*s", "s**2 + b", "(s + a)/b"]
)


@given(st.lists(st.lists(SMALL_ENTRIES, min_size=2, max_size=2), min_size=2, max_size=3))
def test_one_gcd_a_step_and_euclid_reach_the_same_form(rows):
    P = ct.polynomial_matrix(rows, "s")
    form = smith_form(P)
    work = elimination_of(P)
    assert by_euclid(work) == form.rank
    assert written(work.ring, work.matrix) == form.form and form.certificate.holds
