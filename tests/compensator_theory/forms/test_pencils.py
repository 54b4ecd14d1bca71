"""Rational pencils by Krylov chains and residues, against Smith forms and hidden blocks."""

import random

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Matrix

from compensator_theory import budget
from compensator_theory.errors import BudgetError
from compensator_theory.forms import kronecker_form, minimal_basis, smith_form
from compensator_theory.matrices._residues import primes, whole
from tests.support.structure_cases import fewer

s = sympy.Symbol("s")


def block_L(k):
    """E and A of a block of k x (k + 1)."""
    return Matrix(k, k + 1, lambda i, j: int(i == j)), Matrix(
        k, k + 1, lambda i, j: int(j == i + 1)
    )


def jordan(size, value):
    return Matrix(size, size, lambda i, j: value if i == j else int(j == i + 1))


def hidden(rng, right, left, finite, infinite):
    """Blocks of Kronecker's form between two random matrices."""
    parts = [block_L(k) for k in right] + [tuple(m.T for m in block_L(k)) for k in left]
    parts += [(sympy.eye(size), jordan(size, value)) for size, value in finite]
    parts += [(jordan(size, 0), sympy.eye(size)) for size in infinite]
    E, A = (sympy.diag(*(part[k] for part in parts)) for k in (0, 1))

    def mixed(size):
        lower = Matrix(size, size, lambda i, j: rng.randint(-2, 2) if i > j else int(i == j))
        return lower * lower.T  # of determinant 1

    P, Q = mixed(E.rows), mixed(E.cols)
    return P * A * Q, P * E * Q


def dense(rows, columns, seed=0):
    rng = random.Random(seed)
    return [
        [[rng.choice([-1, 1]) * rng.randint(1, 9) for _ in range(columns)] for _ in range(rows)]
        for _ in range(2)
    ]


rationals = st.sampled_from([0, 0, 0, 1, 1, -1, 2, sympy.Rational(-3, 2)])
sizes = st.tuples(st.integers(1, 4), st.integers(1, 4))
pairs = sizes.flatmap(
    lambda shape: st.tuples(
        *[st.lists(rationals, min_size=shape[0] * shape[1], max_size=shape[0] * shape[1])] * 2
    ).map(lambda entries: [Matrix(*shape, e) for e in entries])
)


@fewer(2)
@given(pairs)
def test_invariants_are_those_of_both_smith_forms(pair):
    A, E = pair
    form = kronecker_form(A, E)
    assert form.certificate.holds
    finite = smith_form(s * E - A, "s").invariant_polynomials
    assert tuple(p for p in finite if p.degree()) == form.invariant_polynomials
    infinite = smith_form(E - s * A, "s").invariant_polynomials
    powers = [min(m[0] for m, _ in p.terms()) for p in infinite]
    assert tuple(k for k in powers if k) == form.infinite_orders
    assert len(form.right_indices) == A.cols - len(finite)
    assert len(form.left_indices) == A.rows - len(finite)


@fewer(2)
@given(pairs)
def test_bases_are_minimal_and_have_left_inverses(pair):
    """Independent leading coefficients, and no loss of rank anywhere, are Forney's definition."""
    form = kronecker_form(*pair)
    for basis in (form.right_basis, form.left_basis):
        if basis.basis is None:
            continue
        P, M, W = (m.as_matrix() for m in (basis.matrix, basis.basis, basis.left_inverse))
        assert (P * M).applyfunc(sympy.expand).is_zero_matrix
        assert (W * M).applyfunc(sympy.expand) == sympy.eye(M.cols)
        leading = Matrix(
            [
                [
                    sympy.Poly(e, s).coeff_monomial(s**k)
                    for e, k in zip(row, basis.indices, strict=True)
                ]
                for row in M.tolist()
            ]
        )
        assert leading.rank() == M.cols and list(basis.indices) == sorted(basis.indices)


@pytest.mark.parametrize(
    ("right", "left", "finite", "infinite"),
    [((0, 2, 3), (1, 2), [(2, 1), (2, 1), (3, 2)], (1, 2)),
     ((), (), [(3, 1), (3, 1), (2, 2), (2, 2), (1, 0)], (2, 1, 1)),
     ((4,), (), [(4, 0), (2, 0), (2, -1)], (3,)),
     ((), (3, 3), [(1, 0), (1, 1), (1, 2)], ()),
     ((6,), (5,), [], ())],
)  # fmt: skip
def test_hidden_blocks_are_found(right, left, finite, infinite):
    A, E = hidden(random.Random(str((right, left))), right, left, finite, infinite)
    form = kronecker_form(A, E)
    assert form.right_indices == tuple(sorted(right))
    assert form.left_indices == tuple(sorted(left))
    assert form.infinite_orders == tuple(sorted(infinite))
    sizes = {}
    for size, value in finite:
        sizes.setdefault(value, []).append(size)
    expected = []
    for k in range(max(map(len, sizes.values()), default=0)):
        powers = [(v, sorted(o)[::-1][k]) for v, o in sizes.items() if k < len(o)]
        expected.append(sympy.Poly(sympy.prod((s - v) ** o for v, o in powers), s, domain="QQ"))
    assert list(form.invariant_polynomials) == expected[::-1]


@pytest.mark.parametrize("shape", [(16, 17), (20, 21), (17, 16), (24, 24), (10, 14)])
def test_dense_pencils_are_generic(shape):
    rows, columns = shape
    A, E = dense(rows, columns)
    form = kronecker_form(A, E)
    more = abs(rows - columns)
    small = min(rows, columns)
    generic = tuple(sorted((small + k) // more for k in range(more))) if more else ()
    assert (form.right_indices if columns > rows else form.left_indices) == generic
    assert form.infinite_orders == ()
    point = sympy.Rational(3, 7)
    if not more:
        at_point = (point * Matrix(E) - Matrix(A)).det(method="domain-ge") / Matrix(E).det(
            method="domain-ge"
        )
        assert form.finite_polynomial.eval(point) == at_point
    else:
        assert form.right_basis.certificate.holds and form.left_basis.certificate.holds


def test_a_basis_is_the_vector_of_minors():
    """For one vector more than rows, all minors with signs are a null vector, the shortest one."""
    A, E = map(Matrix, dense(4, 5, seed=2))
    basis = minimal_basis(s * E - A, "s").basis.as_matrix()
    minors = [
        (-1) ** j * sympy.Poly((s * E - A)[:, [k for k in range(5) if k != j]].det(), s)
        for j in range(5)
    ]
    for i in range(1, 5):
        assert sympy.Poly(basis[i], s) * minors[0] == sympy.Poly(basis[0], s) * minors[i]
    assert max(sympy.Poly(e, s).degree() for e in basis) == 4


def test_the_budget_is_asked():
    A, E = dense(12, 13)
    with budget(entries=400), pytest.raises(BudgetError, match="a left inverse, three digits"):
        kronecker_form(A, E)
    A, E = dense(12, 12)
    with budget(entries=400), pytest.raises(BudgetError, match="the regular part"):
        kronecker_form(A, E)


@given(st.lists(st.fractions(max_denominator=10**6), min_size=1, max_size=6))
def test_numbers_from_their_residues(numbers):
    modulus = next(primes()) ** 8
    residues = [x.numerator * pow(x.denominator, -1, modulus) % modulus for x in numbers]
    result = whole(residues, modulus)
    for x, y in zip(numbers, result, strict=True):
        assert all(
            x * other == y * argument for argument, other in zip(numbers, result, strict=True)
        )


def test_a_residue_that_belongs_to_no_short_number():
    assert whole([1, 7**300, 5**400], 3**1001 + 2) is None


def test_an_elimination_that_swells_is_refused_on_the_way():
    A, E = map(Matrix, dense(9, 9))
    assert smith_form(s * E - A, "s").rank == 9
    with budget(entries=1000), pytest.raises(BudgetError, match="400 digits as an entry"):
        smith_form(s * E - A, "s")
