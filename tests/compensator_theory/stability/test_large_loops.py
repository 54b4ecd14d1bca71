"""Loops of 24 to 40 poles, and what they rest on, against SymPy's algorithms at small sizes."""

import random

import flint
import pytest
import sympy
from hypothesis import assume, example, given
from hypothesis import strategies as st
from sympy import QQ, CRootOf, Poly, Rational

from compensator_theory import root_locus, stabilising_gains, stability_margins
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.roots._enclosures import ball_of_enclosure
from compensator_theory.stability._critical_values import (
    approximation,
    critical_polynomials,
    even_and_odd,
    is_less,
    resultant_in_parameter,
)
from compensator_theory.stability._margins import value_at_root
from compensator_theory.stability._root_locus import _gain_polynomial
from compensator_theory.strategies import polynomials, rationals
from tests.support.work import at_most

s, z, k = sympy.symbols("s z k")


def in_both(first, second):
    """p + k q."""
    return Poly(first.as_expr() + k * second.as_expr(), s, domain=QQ[k])


def irreducible(polys):
    return {f.monic() for p in polys if not p.is_zero for f, _ in p.factor_list()[1]}


pairs = st.tuples(polynomials(max_degree=4), polynomials(max_degree=4))


@given(pairs, pairs)
def test_resultants_are_those_of_sympy(first, second):
    p, q = in_both(*first), in_both(*second)
    assume(p.degree() > 0 and q.degree() > 0)
    rows = [
        [to_flint_polynomial(Poly(c, k, domain=QQ)) for c in reversed(side.all_coeffs())]
        for side in (p, q)
    ]
    expected = to_flint_polynomial(Poly(p.resultant(q), k, domain=QQ))
    assert resultant_in_parameter(*rows) in (expected, -expected)  # SymPy 1.14 errs in the sign


@given(polynomials(min_degree=1, max_degree=5), polynomials(max_degree=5))
@example(Poly(s**3 + s, s), Poly(s**2 + 1, s))  # a common factor on the axis
@example(Poly(s**2, s), Poly(1, s))
def test_critical_values_are_those_by_sympys_factors(first, second):
    poly = in_both(first, second)
    assume(poly.degree() > 0)
    expected, is_nowhere = [Poly(poly.LC(), k, domain=QQ)], False
    for factor, _ in Poly(poly.as_expr(), s, k, domain=QQ).factor_list()[1]:
        part = Poly(factor.as_expr(), s)
        even, odd = even_and_odd(part)
        is_nowhere |= part.degree() > 0 and (even.is_zero or odd.is_zero)
        expected += [Poly(c, k, domain=QQ) for c in (part.LC(), part.TC())]
        if part.degree() > 1 and not is_nowhere:
            expected.append(Poly(even.resultant(odd), k, domain=QQ))
    result = critical_polynomials(poly, k, discrete=False)
    if is_nowhere:
        assert result is None
    else:
        assert irreducible(result) == irreducible(expected)


@given(polynomials(min_degree=3, max_degree=5), st.integers(0, 4), rationals(), rationals())
def test_indexed_roots_are_compared_as_by_sympy(poly, index, number, factor):
    assume(poly.is_irreducible and index < poly.count_roots() and factor)
    root = factor * CRootOf(poly, index)
    assert is_less(root, number) == bool(root < number)
    assert is_less(number, root) == bool(number < root)
    assert is_less(-sympy.oo, root) and is_less(root, sympy.oo)
    assert not is_less(root, -sympy.oo) and not is_less(sympy.oo, root)
    assert abs(approximation(root) - root.evalf(30)) <= abs(root) * Rational(1, 10**25)


@given(polynomials(min_degree=3, max_degree=5), polynomials(max_degree=4), rationals())
def test_values_at_roots_are_those_that_sympy_expands(poly, inside, number):
    assume(poly.is_irreducible)
    for root in (CRootOf(poly, 0), 2 * CRootOf(poly, 0), sympy.sqrt(2) - 1, number):
        assert value_at_root(inside, root) == sympy.expand(inside.as_expr().subs(s, root))


@given(polynomials(min_degree=1, max_degree=3), polynomials(min_degree=1, max_degree=4))
def test_gains_of_breaks_are_eigenvalues_on_the_field_of_the_break(N, D):
    """The norm of k + D/N is the characteristic polynomial of its multiplication on Q[s]/w."""
    W = N * D.diff() - N.diff() * D
    for factor, _ in W.factor_list()[1] if not W.is_zero else []:
        if N.rem(factor).is_zero:
            continue
        gain, n = (-D * N.invert(factor)).rem(factor), int(factor.degree())
        rows = [(gain * Poly(s**i, s)).rem(factor) for i in range(n)]
        matrix = sympy.Matrix([[row.coeff_monomial(s**i) for i in range(n)] for row in rows])
        ((expected, _),) = matrix.charpoly(k).as_poly(k, domain=QQ).factor_list()[1]
        assert _gain_polynomial(N, D, factor).monic() == expected.monic()


def chain(n):
    return Poly(1, s), Poly(sympy.prod([s + i for i in range(n)]), s)


def lags(n):
    return Poly(2, s), Poly((s + 1) ** n, s)


def modes(n):
    """Lightly damped modes, driven and measured at one place: zeros between the poles."""
    N, D = Poly(1, s), Poly(s * (s + 1), s)
    for i in range((n - 2) // 2):
        w, c = Rational(10 + 7 * i, 5), Rational(1 + i % 9, 200)
        D *= Poly(s**2 + 2 * c * w * s + w**2, s)
        if i:
            w -= Rational(1, 2)
            N *= Poly(s**2 + 2 * c * w * s + w**2, s)
    return N, D


def decimals(n):
    drawn = random.Random(n)
    return tuple(
        Poly([1, *(Rational(drawn.randint(-(10**6), 10**6), 10**5) for _ in range(m))], s)
        for m in (n - 2, n)
    )


def delays(n):
    return Poly(Rational(1, 50), z), Poly((z - Rational(49, 50)) * z ** (n - 1), z)


FAMILIES = (chain, lags, modes, decimals, delays)
# Calls of Python and C functions, those that print the answer among them. SymPy takes 66 000 000 to
# isolate the roots of a chain of 24 poles, and 22 000 000 to expand polynomials of 40 delays.
MOST = 1_500_000


@pytest.mark.costly
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize(
    ("function", "poles"), [(stability_margins, 40), (root_locus, 24), (stabilising_gains, 40)]
)
def test_the_calls_that_a_large_loop_takes(family, function, poles):
    loop = family(poles)
    with at_most(MOST):
        str(function(loop, feedback=-1))


@pytest.mark.parametrize("family", [chain, lags, modes, decimals])
def test_crossovers_of_large_loops_at_their_frequencies(family):
    """L = -1/k at a phase crossover, and abs(L) = 1 at a gain crossover, in balls of 400 bits."""
    N, D = family(40)
    margins = stability_margins((N, D), feedback=-1)
    assert margins.gain_crossovers or margins.phase_crossovers
    with ball_precision(400):
        top, bottom = (flint.acb_poly(to_flint_polynomial(p.set_domain(QQ))) for p in (N, D))

        def L(crossover):
            point = flint.acb(0, ball_of_enclosure(crossover.frequency))
            return top(point) / bottom(point)

        for crossover in margins.gain_crossovers:
            size = abs(L(crossover))
            assert size.contains(1) and size.rad() < 1e-6
        for crossover in margins.phase_crossovers:
            if crossover.frequency is not None:
                value = L(crossover) * ball_of_enclosure(crossover.gain_enclosure)
                assert value.real.contains(-1) and value.imag.contains(0)
                assert value.real.rad() < 1e-6
