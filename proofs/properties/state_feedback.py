"""State feedback with several inputs: Heymann's lemma and placement."""

from hypothesis import assume
from hypothesis import strategies as st
from sympy import ImmutableMatrix, Matrix, Poly, Symbol

from compensator_theory import observer_gain_family, state_feedback_family
from compensator_theory.matrices._linear_algebra import characteristic_polynomial, rank
from compensator_theory.strategies import matrices, polynomials

from ..ledger.checks import for_all

s = Symbol("s")
Pair = tuple[ImmutableMatrix, ImmutableMatrix]


def controllability_matrix(A: Matrix, B: Matrix) -> Matrix:
    """Return [B AB ... A^(n-1)B]."""
    columns = [B]
    for _ in range(A.rows - 1):
        columns.append(A * columns[-1])
    return Matrix.hstack(*columns)


@st.composite
def controllable_pairs(draw: st.DrawFn) -> Pair:
    """Draw a controllable (A, B) of order 1 to 3, with one to three inputs, dependent or not."""
    n, m = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    A, B = Matrix(draw(matrices(n, n))), Matrix(draw(matrices(n, m)))
    assume(rank(controllability_matrix(A, B)) == n)
    return A.as_immutable(), B.as_immutable()


@st.composite
def pairs_and_columns(draw: st.DrawFn) -> tuple[Pair, Matrix]:
    """Draw a controllable pair and a combination v of its inputs with Bv not 0."""
    A, B = draw(controllable_pairs())
    v = Matrix(draw(matrices(B.cols, 1)))
    assume(not (B * v).is_zero_matrix)
    return (A, B), v


@for_all(case=pairs_and_columns())
def heymann(case: tuple[Pair, Matrix]) -> bool:
    """Inputs that lead out of the span of the states so far make n independent states from Bv, and
    the feedback that gives these inputs makes (A + BK, Bv) controllable.
    """
    (A, B), v = (Matrix(M) for M in case[0]), case[1]
    states, inputs = [B * v], []
    while len(states) < A.rows:
        choices = [Matrix.zeros(B.cols, 1), *(Matrix.eye(B.cols)[:, j] for j in range(B.cols))]
        reached = ((A * states[-1] + B * u, u) for u in choices)
        outside = ((x, u) for x, u in reached if rank(Matrix.hstack(*states, x)) > len(states))
        new = next(outside, None)
        if new is None:
            return False
        states.append(new[0])
        inputs.append(new[1])
    K = Matrix.hstack(*inputs, Matrix.zeros(B.cols, 1)) * Matrix.hstack(*states).inv()
    return bool(rank(controllability_matrix(A + B * K, B * v)) == A.rows)


@st.composite
def pairs_and_polynomials(draw: st.DrawFn) -> tuple[Pair, Poly]:
    """Draw a controllable pair and a monic polynomial of its degree."""
    A, B = draw(controllable_pairs())
    return (A, B), draw(polynomials("s", A.rows, A.rows, is_monic=True))


@for_all(case=pairs_and_polynomials())
def placement(case: tuple[Pair, Poly]) -> bool:
    """A controllable pair with any number of inputs reaches every monic polynomial of its degree,
    and so does its dual by output injection.
    """
    (A, B), p = (Matrix(M) for M in case[0]), case[1]
    K = Matrix(state_feedback_family(A, B, p).gain())
    F = Matrix(observer_gain_family(A.T, B.T, p).gain())
    return bool(
        characteristic_polynomial(A + B * K, s) == p
        and characteristic_polynomial(A.T - F * B.T, s) == p
    )


@st.composite
def pairs_with_a_fixed_part(draw: st.DrawFn) -> tuple[Matrix, Matrix, Matrix, int]:
    """Draw a pair whose last states no input moves, in another basis, and a feedback."""
    n, m = draw(st.integers(1, 3)), draw(st.integers(1, 2))
    fixed = draw(st.integers(1, n))
    A, B, K = (Matrix(draw(matrices(*size))) for size in ((n, n), (n, m), (m, n)))
    A[n - fixed :, : n - fixed] = Matrix.zeros(fixed, n - fixed)
    B[n - fixed :, :] = Matrix.zeros(fixed, m)
    return A, B, K, fixed


@for_all(case=pairs_with_a_fixed_part())
def fixed_part(case: tuple[Matrix, Matrix, Matrix, int]) -> bool:
    """What no input moves keeps its polynomial under every feedback: it divides det(sI - A - BK),
    so that another polynomial of degree n is out of reach.
    """
    A, B, K, fixed = case
    unmoved = characteristic_polynomial(A[A.rows - fixed :, A.rows - fixed :], s)
    whole = characteristic_polynomial(A + B * K, s)
    return bool(whole.rem(unmoved).is_zero and rank(controllability_matrix(A, B)) < A.rows)
