"""Plants, matrices and standard problems for Hypothesis."""

from hypothesis import strategies as st
from sympy import ImmutableMatrix

from compensator_theory.strategies.polynomials import coprime_pairs, rationals
from compensator_theory.systems.standard_problems import StandardProblem
from compensator_theory.systems.state_space import controllable_canonical_form
from compensator_theory.transfer_functions.transfer_functions import TransferFunction


@st.composite
def strictly_proper_plants(
    draw: st.DrawFn, variable: str = "s", max_order: int = 4
) -> TransferFunction:
    """Draw strictly proper plants of order 1 or more with coprime numerator and denominator.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import strictly_proper_plants
    >>> @given(strictly_proper_plants())
    ... def check(plant):
    ...     assert plant.is_strictly_proper and plant.is_coprime
    >>> check()
    """
    denominator, numerator = draw(coprime_pairs(variable, max_order))
    return TransferFunction(numerator, denominator)


@st.composite
def matrices(draw: st.DrawFn, rows: int, columns: int) -> ImmutableMatrix:
    """Draw rational matrices of the given shape.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import matrices
    >>> @given(matrices(2, 3))
    ... def check(matrix):
    ...     assert matrix.shape == (2, 3)
    >>> check()
    """
    size = rows * columns
    entries = draw(st.lists(rationals(3, 3), min_size=size, max_size=size))
    return ImmutableMatrix(rows, columns, entries)


@st.composite
def minimal_plants(
    draw: st.DrawFn, max_order: int = 4
) -> tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]:
    """Draw minimal SISO realisations (A, B, C), in coordinates that hide the canonical form.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.matrices.linear_algebra import rank
    >>> from compensator_theory.strategies import minimal_plants
    >>> @given(minimal_plants(3))
    ... def check(plant):
    ...     A, B, C = plant
    ...     assert rank(ImmutableMatrix.hstack(*(A**k * B for k in range(A.rows)))) == A.rows
    ...     assert rank(ImmutableMatrix.vstack(*(C * A**k for k in range(A.rows)))) == A.rows
    >>> from sympy import ImmutableMatrix
    >>> check()
    """
    plant = draw(strictly_proper_plants(max_order=max_order))
    A, B, C, _ = controllable_canonical_form(plant)
    return disguised(A, B, C, draw(unimodular_matrices(A.rows)))


@st.composite
def unimodular_matrices(draw: st.DrawFn, size: int) -> ImmutableMatrix:
    """Draw integer matrices of determinant 1, products of a lower and an upper triangular one.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies.plants import unimodular_matrices
    >>> @given(unimodular_matrices(3))
    ... def check(matrix):
    ...     assert matrix.det() == 1
    >>> check()
    """
    count = size * (size - 1)
    entries = iter(draw(st.lists(st.integers(-1, 1), min_size=count, max_size=count)))
    lower, upper = [
        [[1 if i == j else 0 for j in range(size)] for i in range(size)] for _ in range(2)
    ]
    for i in range(size):
        for j in range(i):
            lower[i][j], upper[j][i] = next(entries), next(entries)
    return ImmutableMatrix(lower) * ImmutableMatrix(upper)


def disguised(
    A: ImmutableMatrix, B: ImmutableMatrix, C: ImmutableMatrix, S: ImmutableMatrix
) -> tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]:
    """Change the coordinates of a realisation by a unimodular matrix S.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from compensator_theory.strategies.plants import disguised
    >>> one = ImmutableMatrix([[1]])
    >>> disguised(2 * one, one, 3 * one, one)
    (Matrix([[2]]), Matrix([[1]]), Matrix([[3]]))
    """
    if not A.rows:
        return A, B, C
    inverse = S.inv()
    return (
        ImmutableMatrix(S * A * inverse),
        ImmutableMatrix(S * B),
        ImmutableMatrix(C * inverse),
    )


@st.composite
def standard_problems(
    draw: st.DrawFn, max_order: int = 3, max_signals: int = 2, has_direct_term: bool = False
) -> StandardProblem:
    """Draw rational standard problems; D_0 = 0 unless `has_direct_term`.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import standard_problems
    >>> @given(standard_problems(max_order=2))
    ... def check(problem):
    ...     assert problem.denominator.degree() == problem.n
    >>> check()
    """
    n = draw(st.integers(1, max_order))
    l_u, l_y, l_w, l_z = (draw(st.integers(1, max_signals)) for _ in range(4))
    return StandardProblem(
        A=draw(matrices(n, n)),
        B=draw(matrices(n, l_u)),
        C=draw(matrices(l_y, n)),
        D_1=draw(matrices(n, l_w)),
        D_0=draw(matrices(l_y, l_u)) if has_direct_term else None,
        D_2=draw(matrices(l_y, l_w)),
        E_1=draw(matrices(l_z, n)),
        E_2=draw(matrices(l_z, l_u)),
        E_0=draw(matrices(l_z, l_w)),
    )
