"""Plants, matrices and standard problems for Hypothesis."""

from __future__ import annotations

from collections.abc import Callable
from math import prod

from hypothesis import strategies as st
from sympy import Expr, ImmutableMatrix, Poly, Rational, Symbol, diag, expand

from compensator_theory.strategies.polynomials import (
    coprime_pairs,
    nonzero_rationals,
    rationals,
)
from compensator_theory.strategies.spectra import hurwitz_spectra, schur_spectra
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._standard_problems import StandardProblem
from compensator_theory.systems._state_space import controllable_canonical_form
from compensator_theory.systems._transfer_functions import TransferFunction

_S = Symbol("s")


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
def matrices(
    draw: st.DrawFn,
    rows: int,
    columns: int,
    *,
    elements: st.SearchStrategy[Expr] | None = None,
) -> ImmutableMatrix:
    """Draw matrices of the given shape, rational ones unless their elements are given.

    Parameters
    ----------
    rows, columns : int
    elements : strategy for numbers, optional
        Strategy of the entries; by default rational numbers.

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
    each = rationals(3, 3) if elements is None else elements
    return ImmutableMatrix(rows, columns, draw(st.lists(each, min_size=size, max_size=size)))


@st.composite
def symmetric_matrices(
    draw: st.DrawFn, size: int, *, elements: st.SearchStrategy[Expr] | None = None
) -> ImmutableMatrix:
    """Draw symmetric matrices.

    Parameters
    ----------
    size : int
    elements : strategy for numbers, optional
        Strategy of the entries on and above the diagonal; by default rational numbers.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import symmetric_matrices
    >>> @given(symmetric_matrices(3))
    ... def check(matrix):
    ...     assert matrix == matrix.T
    >>> check()
    """
    drawn = draw(matrices(size, size, elements=elements))
    return ImmutableMatrix(size, size, lambda i, j: drawn[min(i, j), max(i, j)])


@st.composite
def semidefinite_matrices(
    draw: st.DrawFn, size: int, *, is_definite: bool = False
) -> ImmutableMatrix:
    """Draw rational positive semidefinite matrices E'E, of every rank.

    Parameters
    ----------
    size : int
    is_definite : bool
        Whether they are positive definite: E is then unit upper triangular, and scaled.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import semidefinite_matrices
    >>> @given(semidefinite_matrices(2))
    ... def check(matrix):
    ...     assert matrix == matrix.T and min(matrix[0, 0], matrix[1, 1], matrix.det()) >= 0
    >>> check()
    """
    if is_definite:
        above = draw(matrices(size, size))
        scale = [abs(draw(nonzero_rationals(3, 3))) for _ in range(size)]
        E = ImmutableMatrix(size, size, lambda i, j: above[i, j] if i < j else int(i == j))
        return ImmutableMatrix(E.T * diag(*scale) * E) if size else E
    rank = draw(st.sampled_from(range(size + 1)))
    E = draw(matrices(rank, size))
    return ImmutableMatrix(E.T * E)


def hurwitz_matrices(size: int) -> st.SearchStrategy[ImmutableMatrix]:
    """Draw matrices whose eigenvalues have negative real parts, exact numbers all of them.

    Two in five have a multiple eigenvalue by choice, with one Jordan block or with several.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory import decide_stability
    >>> from compensator_theory.strategies import hurwitz_matrices
    >>> @given(hurwitz_matrices(2))
    ... def check(matrix):
    ...     assert decide_stability(matrix.charpoly("s"), time="continuous").is_stable
    >>> check()
    """
    return _with_spectrum(size, hurwitz_spectra)


def schur_matrices(size: int) -> st.SearchStrategy[ImmutableMatrix]:
    """Draw matrices whose eigenvalues have modulus below 1, exact numbers all of them.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory import decide_stability
    >>> from compensator_theory.strategies import schur_matrices
    >>> @given(schur_matrices(2))
    ... def check(matrix):
    ...     assert decide_stability(matrix.charpoly("q"), time="discrete").is_stable
    >>> check()
    """
    return _with_spectrum(size, schur_spectra)


@st.composite
def _with_spectrum(
    draw: st.DrawFn, size: int, spectrum: Callable[..., st.SearchStrategy[tuple[Expr, ...]]]
) -> ImmutableMatrix:
    """Draw real matrices with a spectrum: a companion matrix, or blocks with one eigenvalue."""
    if size == 0:
        return ImmutableMatrix(0, 0, [])
    kind = draw(st.sampled_from(["any", "any", "any", "multiple", "blocks"]))
    if kind == "any":
        roots = draw(spectrum(size))
        coefficients = prod((_S - root for root in roots), start=Poly(1, _S)).all_coeffs()
        A = ImmutableMatrix(
            size, size,
            lambda i, j: -coefficients[size - j] if i == size - 1 else int(j == i + 1),
        )  # fmt: skip
        A = ImmutableMatrix(A.applyfunc(expand))
    else:
        (root,) = draw(spectrum(1, real_roots=True))
        ones = draw(st.lists(st.integers(0, 1), min_size=size - 1, max_size=size - 1))
        couple = [1] * (size - 1) if kind == "multiple" else ones
        A = ImmutableMatrix(
            size, size, lambda i, j: root if i == j else couple[i] if j == i + 1 else 0
        )
    # one basis in three is plain; the others stretch what couples the states, one way or the other
    kind = draw(st.sampled_from(["plain", "stretched", "stretched"]))
    if kind == "plain":
        S = draw(unimodular_matrices(size))
        return ImmutableMatrix(S * A * S.inv())
    powers = [Rational(draw(st.sampled_from([4, 16]))) ** i for i in range(size)]
    T = diag(*(powers if draw(st.booleans()) else reversed(powers)))
    A = ImmutableMatrix(T * A * T.inv())
    return A.T if draw(st.booleans()) else A


@st.composite
def minimal_plants(draw: st.DrawFn, max_order: int = 4, variable: str = "s") -> Realisation:
    """Draw minimal SISO realisations, in coordinates that hide the canonical form.

    Examples
    --------
    >>> from hypothesis import given
    >>> from compensator_theory.strategies import minimal_plants
    >>> @given(minimal_plants(3))
    ... def check(plant):
    ...     assert plant.is_minimal and plant.C.shape == (1, plant.n)
    >>> check()
    """
    plant = draw(strictly_proper_plants(max_order=max_order))
    A, B, C, _ = controllable_canonical_form(plant)
    matrices = disguised(A, B, C, draw(unimodular_matrices(A.rows)))
    return Realisation(*matrices, variable=Symbol(variable))


@st.composite
def unimodular_matrices(draw: st.DrawFn, size: int) -> ImmutableMatrix:
    """Draw integer matrices of determinant 1, products of a lower and an upper triangular one."""
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
    """Change the coordinates of a realisation by a unimodular matrix S."""
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
