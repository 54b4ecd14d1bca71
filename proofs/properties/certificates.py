"""What the witnesses of certificates decide: traces of a recursion, rounded factors."""

from hypothesis import strategies as st
from sympy import Matrix, eye

from compensator_theory.certificates._signs import definite_factor
from compensator_theory.strategies import matrices

from ..ledger.checks import for_all

steps = st.sampled_from([0, 0, 0, 1, -2])


@for_all(A=matrices(3, 3), changes=st.tuples(steps, steps, steps))
def traces(A: Matrix, changes: tuple[int, int, int]) -> bool:
    """The traces agree, and the last matrix is 0, for the coefficients of det(sI - A) alone."""
    characteristic = Matrix(A).charpoly().all_coeffs()[1:]
    coefficients = [c + step for c, step in zip(characteristic, changes, strict=True)]
    B, last, agree = eye(3), 1, True
    for k, c in zip((2, 1, 0), coefficients, strict=True):
        agree = agree and B.trace() == (k + 1) * last
        B, last = Matrix(A) * B + c * eye(3), c
    return bool((agree and B.is_zero_matrix) == (coefficients == characteristic))


whole = st.integers(-9, 9)


@for_all(rows=st.lists(st.tuples(whole, whole, whole), min_size=2, max_size=4), step=whole)
def rounded_factor(rows: list[tuple[int, int, int]], step: int) -> bool:
    """M > 0 where s W M W - F'F is strictly diagonally dominant, and F exists where M > 0."""
    M = Matrix(rows).T * Matrix(rows) - step * eye(3)
    positive = all(M[:k, :k].det() > 0 for k in (1, 2, 3))
    factor = definite_factor([[int(e) for e in M.row(i)] for i in range(3)])
    if factor is None:
        return not positive
    scale, weights, F = factor
    W = Matrix.diag(*weights)
    rest = scale * W * M * W - Matrix(F).T * Matrix(F)
    dominant = all(rest[i, i] > sum(abs(rest[i, j]) for j in range(3) if j != i) for i in range(3))
    return bool(positive and dominant)
