"""Lemma 1 and the Sylvester resultants, for rational polynomials and formal degrees."""

from hypothesis import strategies as st
from sympy import Poly, Symbol

from compensator_theory.bezout import sylvester_m1, sylvester_m2
from compensator_theory.matrices._linear_algebra import determinant, rank
from compensator_theory.strategies import polynomials, rationals

from ..ledger.checks import for_all

s = Symbol("s")
with_zero = st.one_of(polynomials(max_degree=3), st.just(Poly(0, s)))


@st.composite
def unequal_degrees(draw: st.DrawFn) -> tuple[Poly, Poly]:
    """Draw (p, q) with deg p < deg q; p may be 0, both may have common roots, q is any."""
    q = draw(polynomials(min_degree=1, max_degree=4))
    return draw(st.one_of(polynomials(max_degree=int(q.degree()) - 1), st.just(Poly(0, s)))), q


@st.composite
def pairs(draw: st.DrawFn, degrees: tuple[Poly, Poly]) -> tuple[Poly, Poly]:
    """Draw (a, b), every other time with bq + ap = 0: a multiple of (q, -p) without its gcd."""
    if draw(st.booleans()):
        return draw(with_zero), draw(with_zero)
    p, q = degrees
    common, factor = p.gcd(q), draw(with_zero)
    return factor * q.quo(common), -factor * p.quo(common)


@for_all(
    case=unequal_degrees().flatmap(lambda degrees: st.tuples(st.just(degrees), pairs(degrees)))
)
def lemma_1(case: tuple[tuple[Poly, Poly], tuple[Poly, Poly]]) -> bool:
    """For deg a <= deg b and deg p < deg q, bq + ap = 0 only if a = b = 0, p = 0 included; half of
    the pairs (a, b) satisfy the equation.
    """
    (p, q), (a, b) = case
    vanishes = (b * q + a * p).is_zero
    if a.is_zero and b.is_zero:
        return bool(vanishes)
    return not (vanishes and a.degree() <= b.degree())


@for_all(
    a=polynomials(max_degree=3),
    b=st.one_of(polynomials(max_degree=3), st.just(Poly(0, s))),
    shared=polynomials(max_degree=2),
    padding=st.integers(0, 3),
)
def rank_of_m1(a: Poly, b: Poly, shared: Poly, padding: int) -> bool:
    """The degree of gcd(a, b) is k + l - rank M_1(a, b) for a_k not 0 and every formal degree l of
    b, above and below k, leading zeros and b = 0 included.
    """
    a, b = a * shared, b * shared
    k, l = int(a.degree()), max(int(b.degree()) if not b.is_zero else 0, 0) + padding  # noqa: E741
    if k + l == 0:
        return True
    return bool(k + l - rank(sylvester_m1(a, b, k, l)) == a.gcd(b).degree())


@for_all(a=polynomials(min_degree=1, max_degree=3), b=with_zero, shared=polynomials(max_degree=2))
def rank_of_m2(a: Poly, b: Poly, shared: Poly) -> bool:
    """The degree of gcd(a, b) is 2k - rank M_2(a, b) for deg a = k >= deg b."""
    a, b = a * shared, b * shared
    a, b = (a, b) if a.degree() >= b.degree() else (b, a)
    k, coefficients = int(a.degree()), b.all_coeffs()
    matrix = sylvester_m2(a.all_coeffs(), [0] * (k + 1 - len(coefficients)) + coefficients)
    return bool(2 * k - rank(matrix) == a.gcd(b).degree())


@for_all(
    a=polynomials(min_degree=1, max_degree=5),
    b=st.lists(rationals(), min_size=1, max_size=6),
)
def determinants(a: Poly, b: list[object]) -> bool:
    """det M_2(a, b) = a_k^(k - l) det M_1(a, b) for l <= k."""
    k, l = int(a.degree()), min(len(b) - 1, int(a.degree()))  # noqa: E741
    b = b[: l + 1]
    m1 = sylvester_m1(a.all_coeffs(), b, k, l)
    m2 = sylvester_m2(a.all_coeffs(), [0] * (k - l) + b)
    return bool(determinant(m2) == a.LC() ** (k - l) * determinant(m1))
