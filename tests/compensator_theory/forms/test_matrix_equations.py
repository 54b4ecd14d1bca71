"""Minimal bases and matrix Diophantine equations, against ranks of Toeplitz matrices."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import Matrix, Poly

import compensator_theory as ct
from compensator_theory.errors import NoSolutionError
from compensator_theory.forms import minimal_basis
from compensator_theory.matrices._linear_algebra import rank
from tests.support.structure_cases import (
    G_OF_THE_NOTES,
    divisors,
    fewer,
    minors,
    polynomial_matrices,
)

s, a, b = sympy.symbols("s a b")


def toeplitz(matrix, degree):
    """The map from the coefficients of x, up to a degree, to those of P x."""
    P = matrix.as_matrix()
    top = max(matrix.degree, 0)
    blocks = [P.applyfunc(lambda e, k=k: sympy.Poly(e, s).coeff_monomial(s**k))
              for k in range(top + 1)]  # fmt: skip
    p, m = P.shape
    whole = sympy.zeros(p * (top + degree + 1), m * (degree + 1))
    for j in range(degree + 1):
        for k, block in enumerate(blocks):
            whole[p * (j + k) : p * (j + k + 1), m * j : m * (j + 1)] = block
    return whole


def stacked(column, degree):
    """Coefficients of a polynomial vector, block by block in ascending powers."""
    entries = [Poly(e, s) for e in column]
    return Matrix([e.coeff_monomial(s**k) for k in range(degree + 1) for e in entries])


@fewer(2)
@given(polynomial_matrices())
def test_a_minimal_basis_spans_every_degree(P):
    basis = minimal_basis(P)
    for degree in range(max(basis.indices, default=0) + 2):
        system = toeplitz(P, degree)
        nullity = system.cols - rank(system)
        assert nullity == sum(max(0, degree - index + 1) for index in basis.indices)
    assert tuple(sorted(basis.indices)) == basis.indices


@fewer(2)
@given(polynomial_matrices(max_size=2))
def test_a_minimal_basis_loses_rank_nowhere(P):
    basis = minimal_basis(P)
    ranks = divisors(P.as_matrix())
    assert len(basis.indices) == P.shape[1] - len(ranks)
    if basis.basis is None:
        return
    M = basis.basis.as_matrix()
    assert (P.as_matrix() * M).applyfunc(sympy.expand).is_zero_matrix
    assert divisors(M)[-1] == ct.polynomial("1", "s")  # at no point, by the gcd of all minors
    if ranks:  # right and left indices add up to the degree of the minors without their gcd
        largest = max(Poly(m, s).degree() for m in minors(P.as_matrix(), len(ranks)) if m != 0)
        content = divisors(P.as_matrix())[-1].degree()
        left = minimal_basis(P.T).indices
        assert sum(basis.indices) + sum(left) == largest - content


@st.composite
def equations(draw):
    """A, B and a right side that has a solution."""
    p, k, m, q = (draw(st.integers(1, 2)) for _ in range(4))

    def matrix(rows, columns, degree):
        coefficients = st.lists(st.integers(-2, 2), min_size=degree + 1, max_size=degree + 1)
        entries = [Poly(draw(coefficients), s).as_expr() for _ in range(rows * columns)]
        return ct.polynomial_matrix(Matrix(rows, columns, entries), "s")

    A, B = matrix(p, k, 2), matrix(p, m, 1)
    return A, B, matrix(k, q, 1), matrix(m, q, 2)


@fewer(2)
@given(equations(), st.sampled_from(["right", "left"]))
def test_the_solution_of_least_degree(drawn, side):
    A, B, X, Y = drawn
    C = A @ X + B @ Y
    matrices = (A, B, C) if side == "right" else (A.T, B.T, C.T)
    solution = ct.solve_matrix_diophantine(*matrices, side=side)
    assert solution.certificate.holds
    x, y = (solution.X, solution.Y) if side == "right" else (solution.X.T, solution.Y.T)
    assert A @ x + B @ y == C
    joined = ct.polynomial_matrix(A.as_matrix().row_join(B.as_matrix()), "s")
    for j, degree in enumerate(solution.degrees):
        if degree > 0:
            system = toeplitz(joined, degree - 1)
            size = max(joined.degree, 0) + degree
            expected = C.as_matrix()[:, j]
            if max((Poly(e, s).degree() for e in expected if e != 0), default=0) < size:
                extended = system.row_join(stacked(expected, size - 1))
                assert rank(extended) > rank(system)  # nothing of a lower degree solves it
        system = toeplitz(joined, max(degree, 0))
        nullity = system.cols - rank(system)
        assert nullity == solution.number_of_parameters(max(degree, 0))


@fewer(3)
@given(equations())
def test_every_solution_is_a_member(drawn):
    A, B, X, Y = drawn
    solution = ct.solve_matrix_diophantine(A, B, A @ X + B @ Y)
    if solution.is_unique:
        assert (solution.X, solution.Y) == (X, Y)
        return
    difference = (X - solution.X).as_matrix().col_join((Y - solution.Y).as_matrix())
    T = solution.kernel.left_inverse @ ct.polynomial_matrix(difference, "s")
    assert solution.member(T) == (X, Y)


@given(polynomial_matrices(max_size=2), st.integers(-3, 3))
def test_what_has_no_solution_is_refused(P, factor):
    """The second half of the rows is a multiple of the first, and of the right side it is not."""
    A = P.as_matrix().col_join(P.as_matrix() * (s + factor))
    C = sympy.zeros(P.shape[0], 1).col_join(sympy.ones(P.shape[0], 1))
    with pytest.raises(NoSolutionError, match="no solution"):
        ct.solve_matrix_diophantine(A, A, ct.polynomial_matrix(C, "s"), variable="s")


def test_the_example_of_the_notes():
    """D_l D_c + N_l N_c = diag((s+3)^2, (s+4)^3): of degree 1 a line of answers for each column."""
    fractions = ct.coprime_fractions(G_OF_THE_NOTES)
    C = ct.polynomial_matrix([["-(s + 3)**2", 0], [0, "(s + 4)**3"]], "s")
    solution = ct.solve_matrix_diophantine(fractions.D_l, fractions.N_l, C)
    assert solution.degrees == (1, 1) and solution.number_of_parameters(1) == 1
    D_c = ct.polynomial_matrix([["-s - 3", "11/2"], [0, "s + 9"]])
    N_c = ct.polynomial_matrix([["-2*s - 2", "-(11*s + 65)/2"], [-2, "27/2"]])
    minus = ct.polynomial_matrix([[-1, 0], [0, 1]], "s")  # their D_l has the other sign in row 1
    right = minus @ ct.polynomial_matrix([["(s + 3)**2", 0], [0, "(s + 4)**3"]])
    assert fractions.D_l @ D_c + fractions.N_l @ N_c == right
    delta = (D_c - solution.X).as_matrix().col_join((N_c - solution.Y).as_matrix())
    T = solution.kernel.left_inverse @ ct.polynomial_matrix(delta, "s")
    assert solution.member(T) == (D_c, N_c)


def test_forneys_example():
    basis = minimal_basis([["s**2 + 1", "s", "s**3"]])
    assert basis.indices == (1, 2)
    assert minimal_basis([["s"]]).basis is None and str(minimal_basis([["s"]])) == "0"


def test_symbols_say_where_they_hold():
    solution = ct.solve_matrix_diophantine([["s - a"]], [["s - b"]], [["1"]], variable="s")
    assert a - b in solution.exceptional and solution.certificate.holds
    assert a - b in minimal_basis([["s - a", "s - b"]], "s").exceptional


@pytest.mark.parametrize(
    "call",
    [
        lambda: ct.solve_matrix_diophantine([["s"]], [["s"]], [["s", 1], [1, 1]]),
        lambda: ct.solve_matrix_diophantine([["s"]], [["s"]], [["s"]], side="top"),
        lambda: ct.solve_matrix_diophantine([["s"]], [["1/s"]], [["s"]]),
        lambda: ct.solve_matrix_diophantine([["s"]], [["s + 1"]], [["1"]]).member([["s", "1"]]),
        lambda: minimal_basis([]),
        lambda: minimal_basis([["exp(s)"]]),
    ],
)
def test_bad_input(call):
    with pytest.raises(ct.InputError):
        call()
