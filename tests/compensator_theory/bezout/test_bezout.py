"""Bezout matrices, subresultants and null spaces, against resultants, Sturm's count and gcd."""

import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import Poly

from compensator_theory import InputError, bezout_identity, polynomial, resultant
from compensator_theory.bezout import (
    bezout_matrix,
    cauchy_index,
    gcd_from_null_space,
    subresultants,
)
from compensator_theory.errors import BudgetError
from compensator_theory.matrices._linear_algebra import determinant, rank
from compensator_theory.roots import number_of_real_roots
from compensator_theory.strategies import polynomials, rationals

s, x, y, a, b = sympy.symbols("s x y a b")


@given(polynomials(min_degree=1), polynomials())
def test_the_bezout_matrix_is_the_quotient(p, q):
    B = bezout_matrix(p, q)
    n = B.rows
    powers = [sympy.Matrix([v**k for k in range(n)]) for v in (x, y)]
    form = (powers[0].T * B * powers[1])[0, 0]
    left = p.as_expr().subs(s, x) * q.as_expr().subs(s, y)
    right = p.as_expr().subs(s, y) * q.as_expr().subs(s, x)
    assert sympy.expand(form * (x - y) - left + right) == 0


@given(polynomials(min_degree=1), polynomials(max_degree=2), polynomials(max_degree=2))
def test_its_rank_and_its_determinant(p, q, factor):
    p, q = p * factor, q * factor
    B = bezout_matrix(p, q)
    assert B == B.T and rank(B) == B.rows - sympy.gcd(p, q).degree()
    n, l = p.degree(), q.degree()
    if n >= l:
        sign = -1 if (n * (n - 1) // 2) % 2 else 1
        assert determinant(B) == sign * p.LC() ** (n - l) * resultant(p, q)


@given(polynomials(min_degree=1, max_degree=6))
def test_the_cauchy_index_of_a_logarithmic_derivative_counts_real_roots(p):
    distinct = p.quo(p.gcd(p.diff()))
    assert cauchy_index(p.diff(), p) == number_of_real_roots(distinct)
    assert cauchy_index(-p.diff() + p * Poly(s, s), p) == -number_of_real_roots(distinct)


@given(rationals(), rationals(), rationals(), rationals())
def test_the_cauchy_index_adds_the_signs_of_residues(p, q, r, t):
    function = sympy.cancel(sum(
        c / (s - pole) for c, pole in zip((r, t), (p, p + 1 + q**2), strict=True)
    ))  # fmt: skip
    top, bottom = sympy.fraction(sympy.together(function))
    assert cauchy_index(top, bottom, variable="s") == sympy.sign(r) + sympy.sign(t)


@given(polynomials(), polynomials(), polynomials(max_degree=2))
def test_subresultants(p, q, factor):
    p, q = sorted((p * factor, q * factor), key=lambda e: -e.degree())
    result = subresultants(p, q)
    g = p.gcd(q)
    nonzero = [k for k, c in enumerate(result.principal_coefficients) if c != 0]
    assert nonzero[0] == g.degree()
    assert result.gcd.monic() == g.monic()
    if p.degree() > 0:
        assert result.principal_coefficients[0] == (
            resultant(p, q) if q.degree() or p.degree() else 1
        )
    for k, chain in enumerate(result.chain):  # S_k = u a + v b with deg v < deg a - k
        assert chain.is_zero or chain.degree() <= k or k == q.degree()
        assert chain.rem(g).is_zero


@given(polynomials(min_degree=1), polynomials(), polynomials(max_degree=2))
def test_the_subresultants_of_sympy_up_to_a_factor(p, q, factor):
    """SymPy's remainder sequence holds the regular ones, by another normalisation."""
    p, q = sorted((p * factor, q * factor), key=lambda e: -e.degree())
    chain = subresultants(p, q)
    for theirs in p.subresultants(q)[2:]:
        k = theirs.degree()
        if k < q.degree() and chain.principal_coefficients[k] != 0:
            assert chain.chain[k].monic() == theirs.monic()


@given(polynomials(min_degree=1), polynomials(), polynomials(max_degree=3))
def test_the_gcd_from_the_null_space(p, q, factor):
    p, q = p * factor, q * factor
    gcd = gcd_from_null_space(p, q)
    assert gcd.gcd == p.gcd(q).monic() and gcd.nullity == gcd.gcd.degree()
    assert (gcd.cofactors[0] * gcd.gcd, gcd.cofactors[1] * gcd.gcd) == (p, q)


def test_the_examples_of_the_notes():
    D, N = "s**2 + 3*s + 2", "s + 5"
    assert bezout_matrix(D, N) == sympy.Matrix([[13, 5], [5, 1]])
    assert bezout_matrix(D, N).det() == -12 and resultant(D, N) == 12
    assert cauchy_index(N, D) == 0
    p, q = "(s - 1)*(s - 2)*(s - 3)*(s + 1)", "(s - 1)*(s - 2)*(s + 4)"
    chain = subresultants(p, q)
    assert chain.principal_coefficients == (0, 0, 21, 1)
    assert chain.chain[2] == polynomial("21*s**2 - 63*s + 42")
    null = gcd_from_null_space(p, q)
    assert null.nullity == 2 and null.gcd == polynomial("s**2 - 3*s + 2")


def test_symbols():
    B = bezout_matrix("s**2 + a", "s + b", variable="s")
    assert sympy.expand(B.det() + resultant("s**2 + a", "s + b", variable="s")) == 0
    chain = subresultants("s**2 + a", "s + b", variable="s")
    assert chain.principal_coefficients[0] == a + b**2
    assert gcd_from_null_space("(s + a)*(s + b)", "(s + a)*s", variable="s").gcd == polynomial(
        "s + a", "s"
    )


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda: bezout_matrix("1", "2", variable="s"), InputError),
        (lambda: bezout_matrix("s", "z"), InputError),
        (lambda: bezout_matrix("s**900", "s"), BudgetError),
        (lambda: subresultants("s", "0"), InputError),
        (lambda: subresultants("s", "s**2"), InputError),
        (lambda: subresultants("s**90", "s**80 + 1"), BudgetError),
        (lambda: gcd_from_null_space("0", "s"), InputError),
        (lambda: gcd_from_null_space("1", "2", variable="s"), InputError),
        (lambda: cauchy_index("1", "0", variable="s"), InputError),
        (lambda: cauchy_index("1", "s + a", variable="s"), InputError),
    ],
)
def test_bad_input(call, error):
    with pytest.raises(error):
        call()


NUMBERS_AND_FUNCTIONS = sympy.sympify([-2, -1, 0, 1, "a", "2*b/3", "a*b - 1", "(a + 1)/b", "1/a"])


@given(*[st.lists(st.sampled_from(NUMBERS_AND_FUNCTIONS), min_size=1, max_size=3)] * 3)
def test_the_identity_with_symbols_is_that_of_euclid(one, two, common):
    """The least degrees, in which x and y are unique, by SymPy's division over the fractions."""
    factors = [sympy.Poly(c, s) for c in (one, two, common)]
    assume(all(not p.is_zero for p in factors))
    p, q = (sympy.Poly(sympy.expand((f * factors[2]).as_expr()), s) for f in factors[:2])
    assume((p.free_symbols | q.free_symbols) - {s})
    identity = bezout_identity(p, q, variable="s")
    field = p.unify(q)[0].domain.get_field()
    expected = p.set_domain(field).gcdex(q.set_domain(field))
    scaled = [side.set_domain(field).quo_ground(expected[2].LC()) for side in expected]
    for ours, theirs in zip((identity.x, identity.y, identity.gcd), scaled, strict=True):
        assert sympy.cancel(ours.as_expr() - theirs.as_expr()) == 0
    assert identity.certificate.holds


def test_the_identity_with_four_symbols():
    a, b, c, d = sympy.symbols("a:d")
    p, q = s**4 + d * s**3 + c * s**2 + b * s + a + 7, s**3 + c * s**2 + b * s + a + d
    identity = bezout_identity(p, q, variable="s")
    at = {a: 2, b: -1, c: 3, d: 5}
    there = bezout_identity(p.subs(at), q.subs(at), variable="s")
    assert [identity.x.as_expr().subs(at), identity.y.as_expr().subs(at)] == [
        there.x.as_expr(), there.y.as_expr()
    ]  # fmt: skip
