"""Canonical forms of what was built from them and disguised, and against ranks and Jordan forms."""

import random

import flint
import pytest
import sympy
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from sympy import Matrix, Poly

from compensator_theory import CompensatorError, budget, polynomial, polynomial_matrix
from compensator_theory.errors import BudgetError
from compensator_theory.forms import (
    frobenius_form,
    hermite_form,
    kronecker_form,
    popov_form,
    smith_form,
)
from compensator_theory.matrices._linear_algebra import rank
from compensator_theory.strategies import matrices
from compensator_theory.strategies.plants import unimodular_matrices
from tests.support.structure_cases import fewer, polynomial_matrices
from tests.support.work import at_most

s = sympy.Symbol("s")


def companion(p):
    p = Poly(p, s)
    n = p.degree()
    return Matrix(
        n, n, lambda i, j: int(i == j + 1) - (p.coeff_monomial(s**i) if j == n - 1 else 0)
    )


@st.composite
def invariant_lists(draw):
    """Monic polynomials, each a divisor of the next, of degrees 1 or more."""
    factors = st.sampled_from([s, s - 1, s + 2, s**2 + 1])
    result, last = [], sympy.Integer(1)
    for _ in range(draw(st.integers(1, 3))):
        last = sympy.expand(last * draw(factors if not result else factors | st.just(1)))
        if sum(Poly(p, s).degree() for p in [*result, last]) <= 6:
            result.append(last)
    return result


@fewer(2)
@given(invariant_lists(), st.data())
def test_frobenius_form_of_what_was_disguised(invariants, data):
    blocks = sympy.diag(*map(companion, invariants))
    S = Matrix(data.draw(unimodular_matrices(blocks.rows)))
    A = S * blocks * S.inv()
    form = frobenius_form(A)
    assert [p.as_expr() for p in form.invariant_polynomials] == invariants
    assert form.form == blocks
    assert form.T.det() != 0 and form.T * form.form == A * form.T
    assert form.is_cyclic == (len(invariants) == 1)


@fewer(2)
@given(st.integers(1, 3).flatmap(lambda n: matrices(n, n)))
def test_frobenius_form_against_ranks_and_smith(A):
    """The minimal polynomial is the shortest relation between powers of A."""
    result, n = frobenius_form(A), A.rows
    assert result.T * result.form == A * result.T and result.T.det() != 0
    powers = [Matrix(n * n, 1, list(A**k)) for k in range(n + 1)]
    degree = next(k for k in range(1, n + 1) if Matrix.hstack(*powers[: k + 1]).rank() <= k)
    assert result.minimal_polynomial.degree() == degree
    relation = sum(
        (c * A**k for k, c in enumerate(reversed(result.minimal_polynomial.all_coeffs()))),
        sympy.zeros(n),
    )
    assert relation.is_zero_matrix
    smith = smith_form(s * sympy.eye(n) - A).invariant_polynomials
    assert tuple(p for p in smith if p.degree()) == result.invariant_polynomials


def test_frobenius_form_with_symbols():
    a = sympy.Symbol("a")
    form = frobenius_form([[0, "a"], [0, 0]])
    assert form.is_cyclic and form.exceptional == (a,)
    assert len(frobenius_form([[0, 0], [0, 0]]).invariant_polynomials) == 2  # a = 0
    family = frobenius_form([["a", 0], [0, "a"]])
    assert not family.is_cyclic and family.exceptional == ()


def block_L(k):
    """k x (k + 1): E and A of the block."""
    return Matrix(k, k + 1, lambda i, j: int(i == j)), Matrix(
        k, k + 1, lambda i, j: int(j == i + 1)
    )


@st.composite
def pencils(draw):
    """Blocks of Kronecker's form with their invariants, in two bases that hide them."""
    right = draw(st.lists(st.integers(0, 2), max_size=2))
    left = draw(st.lists(st.integers(0, 2), max_size=2))
    finite = draw(st.lists(st.sampled_from([s, s - 2, s**2 + 1, s**2]), max_size=1))
    infinite = draw(st.lists(st.integers(1, 2), max_size=2))
    parts = [block_L(k) for k in right] + [tuple(m.T for m in block_L(k)) for k in left]
    parts += [(sympy.eye(companion(p).rows), companion(p)) for p in finite]
    parts += [(Matrix(k, k, lambda i, j: int(j == i + 1)), sympy.eye(k)) for k in infinite]
    E, A = (sympy.diag(*(part[k] for part in parts)) for k in (0, 1))
    if 0 in E.shape:
        E = A = sympy.ones(1, 1)
        right, left, finite, infinite = [], [], [s - 1], []
    P = Matrix(draw(unimodular_matrices(E.rows)))
    Q = Matrix(draw(unimodular_matrices(E.cols)))
    return P * A * Q, P * E * Q, sorted(right), sorted(left), finite, sorted(infinite)


@fewer(3)
@given(pencils())
def test_kronecker_form_of_what_was_disguised(case):
    A, E, right, left, finite, infinite = case
    form = kronecker_form(A, E)
    assert form.certificate.holds
    assert sorted(form.right_indices) == right and sorted(form.left_indices) == left
    assert [p.as_expr() for p in form.invariant_polynomials] == finite
    assert sorted(form.infinite_orders) == infinite
    assert form.right_basis.certificate.holds and form.left_basis.certificate.holds
    full = rank(sympy.Rational(7, 11) * E - A)
    assert sum(right) + sum(left) + form.finite_polynomial.degree() + sum(infinite) == full
    assert form.is_regular == (not right and not left)


@given(pencils())
@fewer(3)
def test_indices_against_ranks_of_toeplitz_matrices(case):
    """The numbers of polynomial vectors of degree < k in the kernel, as a definition of indices."""
    A, E, *_ = case
    form = kronecker_form(A, E)
    assert form.certificate.holds
    rows, columns = A.shape
    for k in range(1, 4):
        wide = sympy.zeros((k + 1) * rows, k * columns)
        for j in range(k):
            wide[j * rows : (j + 1) * rows, j * columns : (j + 1) * columns] = -A
            wide[(j + 1) * rows : (j + 2) * rows, j * columns : (j + 1) * columns] = E
        assert wide.cols - rank(wide) == sum(max(0, k - e) for e in form.right_indices)


@fewer(3)
@given(polynomial_matrices(), st.data())
def test_popov_form_is_unique(P, data):
    form = popov_form(P)
    F, n = form.form, P.shape[0]
    assert (form.U @ P).as_matrix() == F.as_matrix()
    assert (form.U @ form.U_inverse).as_matrix() == sympy.eye(n)
    mixed = Matrix(data.draw(unimodular_matrices(n)))
    for i in range(1, n):
        mixed[i, :] += (s + data.draw(st.integers(-1, 1))) * mixed[0, :]
    other = polynomial_matrix((mixed * P.as_matrix()).applyfunc(sympy.expand), "s")
    assert popov_form(other).form == F  # whatever basis the rows are given in
    assert hermite_form(F).form == hermite_form(P).form  # the same module
    degrees = [[-1 if e.is_zero else e.degree() for e in row] for row in F.rows]
    assert form.rank == P.as_matrix().rank() == sum(max(row) >= 0 for row in degrees)
    for i, p in enumerate(form.pivots):
        assert F[i, p].LC() == 1 and degrees[i][p] == max(degrees[i]) == form.row_degrees[i]
        assert all(degrees[j][p] < degrees[i][p] for j in range(n) if j != i)
    if P.shape[0] == P.shape[1] == form.rank:
        assert sum(form.row_degrees) == P.determinant().degree()


def test_popov_form_with_symbols():
    form = popov_form([["a*s", 1], ["s", "s"]], "s")
    assert form.certificate.holds and sympy.Symbol("a") in form.exceptional
    assert popov_form([["s", 1]]).form == polynomial_matrix([["s", 1]])


@pytest.mark.parametrize(
    "call",
    [lambda: frobenius_form([[1, 2]]), lambda: frobenius_form([]),
     lambda: frobenius_form([["s"]], "s"), lambda: frobenius_form("A"),
     lambda: frobenius_form(sympy.eye(60)), lambda: kronecker_form([[1]], [[1, 2]]),
     lambda: kronecker_form([], []), lambda: kronecker_form([["s"]], [[1]], variable="s"),
     lambda: popov_form([["1/s"]]), lambda: popov_form([]), lambda: popov_form([["s**1001"]])],
)  # fmt: skip
def test_bad_input(call):
    with pytest.raises(CompensatorError):
        call()


def test_the_examples_of_the_notes():
    form = frobenius_form([[3, -1, 2, -1], [1, 1, 2, -1], [-1, 1, 1, 1], [-2, 2, -2, 4]])
    assert form.invariant_polynomials == (
        polynomial("s - 2"), polynomial("(s - 2)**2*(s - 3)"),
    )  # fmt: skip


@given(st.integers(0, 10**6))
@settings(max_examples=2)
def test_frobenius_form_of_a_large_cyclic_matrix(seed):
    n, drawn = 80, random.Random(seed)
    A = flint.fmpz_mat(n, n, [drawn.randint(-3, 3) for _ in range(n * n)])
    minimal = A.minpoly()
    assume(minimal.degree() == n)
    with at_most(400_000):
        form = frobenius_form([[int(entry) for entry in row] for row in A.tolist()])
    assert form.certificate.holds and form.is_cyclic
    assert form.minimal_polynomial.all_coeffs() == [int(c) for c in reversed(minimal.coeffs())]
    T = flint.fmpz_mat(n, n, [int(entry) for entry in form.T])
    companion_matrix = flint.fmpz_mat(n, n, [int(entry) for entry in form.form])
    assert T.rank() == n and T * companion_matrix == A * T


def test_a_large_basis_is_refused_before_it_is_computed():
    n = 100
    A = Matrix(n, n, lambda i, j: 10**90 * (i == j + 1) + (j == n - 1))
    with at_most(300_000), pytest.raises(BudgetError, match="numbers of 512 bits"):
        frobenius_form(A)


@pytest.mark.slow
def test_symbols_that_would_fill_the_basis_are_refused():
    A = Matrix(6, 6, lambda i, j: sympy.sympify(f"{i + j}*a + {i * j + 1}*b + {(i - 2 * j) % 5}"))
    with pytest.raises(BudgetError, match="Frobenius form with symbols"):
        frobenius_form(A)
    with budget(terms=10), pytest.raises(BudgetError):
        frobenius_form(A[:3, :3])
    assert frobenius_form(A[:3, :3]).certificate.holds
