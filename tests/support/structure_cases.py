"""Transfer matrices and realisations with hidden modes, and the definitions they are held to."""

import itertools

import sympy
from hypothesis import settings
from hypothesis import strategies as st
from sympy import Matrix, Poly, Rational

import compensator_theory as exact
from compensator_theory.strategies import matrices
from compensator_theory.strategies.plants import disguised, unimodular_matrices

s = sympy.Symbol("s")
POLES = [(), (1,), (2,), (1, 2), (1, 1), (2, 2, 3), (-1,)]
# Smith-McMillan form, zeros, fractions and realisations of it are in the literature's exercises.
G_OF_THE_NOTES = [["1/(s + 1)", "2/(s + 1)"], ["-1/((s + 1)*(s + 2))", "1/(s + 2)"]]


@st.composite
def transfer_matrices(draw, max_size=2, extra=0):
    """Matrices whose entries share poles; with `extra` their numerators may be of higher degree."""
    p, m = draw(st.integers(1, max_size)), draw(st.integers(1, max_size))
    rows = []
    for _ in range(p):
        row = []
        for _ in range(m):
            poles = draw(st.sampled_from(POLES))
            size = len(poles) + 1 + extra
            top = draw(st.lists(st.integers(-2, 2), min_size=size, max_size=size))
            row.append((Poly(top, s), Poly(sympy.prod(s + pole for pole in poles), s)))
        rows.append(row)
    return exact.transfer_matrix(rows, "s")


@st.composite
def polynomial_matrices(draw, max_size=3):
    """Products of small factors, so that invariant polynomials repeat and share roots."""
    p, m = draw(st.integers(1, max_size)), draw(st.integers(1, max_size))
    factor = st.sampled_from([0, 1, s, s + 1, s - 1, s * (s + 1), s**2 + 1, 2, s / 2])
    entries = st.builds(
        lambda x, y, k: sympy.expand(x * y + k * x), factor, factor, st.integers(-1, 1)
    )
    listed = draw(st.lists(entries, min_size=p * m, max_size=p * m))
    return exact.polynomial_matrix(Matrix(p, m, listed), "s")


@st.composite
def realisations(draw, max_block=2, max_signals=2):
    """Realisations in a basis that hides their Kalman form, with drawn blocks."""
    sizes = [draw(st.integers(0, max_block)) for _ in range(4)]
    if not sum(sizes):
        sizes[1] = 1
    n, m, p = sum(sizes), draw(st.integers(1, max_signals)), draw(st.integers(1, max_signals))
    where = [index for index, size in enumerate(sizes) for _ in range(size)]
    A, B, C = (Matrix(draw(matrices(*shape))) for shape in ((n, n), (n, m), (p, n)))
    zero = {(1, 0), (1, 2), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)}
    for i, j in itertools.product(range(n), repeat=2):
        if (where[i], where[j]) in zero:
            A[i, j] = 0
    for i in range(n):
        if where[i] > 1:
            B[i, :] = sympy.zeros(1, m)
        if where[i] in (0, 2):
            C[:, i] = sympy.zeros(p, 1)
    D = draw(matrices(p, m))
    return exact.Realisation(*disguised(A, B, C, draw(unimodular_matrices(n))), D)


def fewer(share):
    """Settings with a part of the profile's examples, for what takes long."""
    return settings(max_examples=max(5, settings.default.max_examples // share))


def minors(matrix, size):
    """All minors of a matrix of expressions."""
    rows, columns = matrix.shape
    return [
        sympy.expand(matrix.extract(list(i), list(j)).det(method="berkowitz"))
        for i in itertools.combinations(range(rows), size)
        for j in itertools.combinations(range(columns), size)
    ]


def pole_polynomial(G):
    """The least common denominator of all minors: the definition of poles with multiplicity."""
    N, d = G.numerator_matrix(), G.denominator.as_expr()
    common = Poly(1, s)
    for size in range(1, min(G.shape) + 1):
        for minor in minors(N, size):
            bottom = sympy.fraction(sympy.cancel(minor / d**size))[1]
            common = common.lcm(Poly(bottom, s))
    return exact.polynomial(common.monic().as_expr(), "s")


def divisors(matrix):
    """The monic gcds of all minors of one size, for each size: what defines the Smith form."""
    result = []
    for size in range(1, min(matrix.shape) + 1):
        common = Poly(0, s)
        for minor in minors(matrix, size):
            common = common.gcd(Poly(minor, s))
        if common.is_zero:
            break
        result.append(exact.polynomial(common.monic().as_expr(), "s"))
    return result


def nonzero_point(*polynomials):
    """A rational number at which none of the polynomials is zero."""
    for k in range(100):
        point = Rational(2 * k + 1, 7)
        if all(p.eval(point) != 0 for p in polynomials):
            return point
    raise AssertionError("no such point")
