"""Complex coefficients: planted roots, NumPy's roots, SymPy's sums, and refusals by name."""

import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st
from sympy import QQ_I, I, Poly, Rational, Symbol, symbols

import compensator_theory as exact
from compensator_theory import (
    certified_roots,
    count_roots,
    decide_stability,
    partial_fractions,
    stability_conditions,
)
from compensator_theory.errors import InputError
from tests.support.structure_cases import fewer

s, z = symbols("s z")
PARTS = st.builds(Rational, st.integers(-4, 4), st.integers(1, 3))
ROOTS = st.lists(st.tuples(PARTS, PARTS), min_size=1, max_size=4)


def planted(roots, variable, leading=1):
    return sympy.expand(leading * sympy.prod(variable - a - I * b for a, b in roots))


@fewer(2)
@given(ROOTS, st.sampled_from([1, I, 2 - I]))
def test_planted_roots_are_counted_and_enclosed(roots, leading):
    p = planted(roots, s, leading)
    count = count_roots(p, "s")
    signs = [sympy.sign(a) for a, _ in roots]
    assert (count.stable, count.boundary, count.unstable) == tuple(map(signs.count, (-1, 0, 1)))
    assert decide_stability(p, "s").is_stable == (set(signs) == {-1})
    answer = certified_roots(p, "s")
    assert sum(root.multiplicity for root in answer) == len(roots)
    for a, b in set(roots):
        (near,) = [r for r in answer if abs(r.value - complex(a, b)) <= r.radius + 1e-14]
        assert near.multiplicity == roots.count((a, b)) and near.is_real == (b == 0)


@fewer(2)
@given(ROOTS)
def test_the_unit_circle(roots):
    count = count_roots(planted(roots, z), "z")
    sizes = [sympy.sign(a**2 + b**2 - 1) for a, b in roots]
    assert (count.stable, count.boundary, count.unstable) == tuple(map(sizes.count, (-1, 0, 1)))


@fewer(2)
@given(st.lists(st.tuples(PARTS, PARTS), min_size=1, max_size=4))
def test_roots_are_numpys(coefficients):
    values = [1, *(a + I * b for a, b in coefficients)]
    theirs = np.roots([complex(v) for v in values])
    mine = certified_roots([str(v) for v in values], "s")
    assert sum(root.multiplicity for root in mine) == len(theirs)
    for root in mine:
        bound = 1e-12 ** (1 / root.multiplicity) * 1e2
        near = sum(abs(theirs - root.value) <= bound * (1 + abs(root.value)))
        assert near >= root.multiplicity


@fewer(2)
@given(PARTS, PARTS, PARTS, PARTS)
def test_conditions_decide(a, b, c, d):
    """s**2 + (a + jb) s + c + jd with symbols: at numbers its conditions are the decision."""
    at = dict(zip(symbols("a b c d"), (a, b, c, d), strict=True))
    conditions = [x.subs(at) for x in stability_conditions("s**2 + (a + b*I)*s + c + d*I", "s")]
    p = s**2 + (a + I * b) * s + c + I * d
    assert all(x > 0 for x in conditions) == decide_stability(p, "s").is_stable


def test_a_known_condition():
    """Frank's example by hand: s + a + jw is stable if and only if a > 0."""
    conditions = stability_conditions("s + a + w*I", "s")
    a, w = symbols("a w")
    assert set(conditions) == {a, a**2 + w**2}
    assert decide_stability("L*s + R + w*L*I", "s").is_stable is None


@pytest.mark.costly
@fewer(2)
@given(ROOTS, ROOTS)
def test_partial_fractions_sum_up(poles, zeros):
    assume(len(set(poles)) > 0)
    N, D = planted(zeros, s), planted(poles, s)
    assume(any(c.has(I) for c in Poly(N, s).all_coeffs() + Poly(D, s).all_coeffs()))
    answer = partial_fractions(N / D, "s")
    assert answer.certificate.holds
    for point in (Rational(7, 3), 5 + I):
        total = answer.polynomial.as_expr().subs(s, point) + sum(
            (t.numerator.as_expr() / t.factor.as_expr() ** t.power).subs(s, point)
            for t in answer.terms
        )
        assert sympy.simplify(total - (N / D).subs(s, point)) == 0
    assert all(t.factor.degree() == 1 for t in answer.terms)


def test_what_cancels_to_real_is_real():
    assert str(partial_fractions("1/((s - I)*(s + I))")) == "(1)/(s**2 + 1)"
    assert count_roots("(s + 1 - 2*I)*(s + 1 + 2*I)").stable == 2
    assert certified_roots("(s + 1 - 2*I)*(s + 1 + 2*I)") == certified_roots("s**2 + 2*s + 5")


@pytest.mark.parametrize(
    "p", ["s + 1 - 2*I", "s + 1 - 2j", s + 1 - 2 * I, Poly(s + 1 - 2 * I, s, domain=QQ_I)]
)
def test_one_polynomial_in_every_form(p):
    (root,) = certified_roots(p)
    assert root.value == -1 + 2j and not root.is_real
    assert decide_stability(p).is_stable and count_roots(p).stable == 1


def test_lists():
    for coefficients in ([1, 1 - 2j], [1, "1 - 2*I"], np.array([1, 1 - 2j])):
        assert decide_stability(coefficients, "s").is_stable
    assert decide_stability([1, 1 - 2j], time="continuous").is_stable
    assert str(partial_fractions(("1", "s + 1 - 2*I"), "s")) == "(1)/(s + (1 - 2*I))"


@pytest.mark.parametrize(
    "function",
    [exact.transfer_function, exact.realisation, exact.routh_array, exact.polynomial,
     exact.step_response, exact.h_infinity_norm],
)  # fmt: skip
def test_others_refuse_by_name(function):
    with pytest.raises(InputError, match=r"complex coefficients.*certified_roots"):
        function("s + 1 - 2*I" if function is exact.polynomial else "1/(s + 1 - 2*I)")


def test_symbols_are_refused_where_numbers_are_needed():
    for function in (certified_roots, count_roots):
        with pytest.raises(InputError, match="substitute"):
            function("s + a - I", Symbol("s"))
    with pytest.raises(InputError, match="give values"):
        partial_fractions("1/(s + a - I)", "s")
