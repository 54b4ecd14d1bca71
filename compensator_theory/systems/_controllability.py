"""Exact controllability and observability, with the hidden modes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import combinations, islice
from typing import Any, Literal

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory.errors import InputError
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._flint_matrices import from_flint, rational_in_flint, zero_matrix
from compensator_theory.matrices._linear_algebra import (
    characteristic_polynomial,
    determinant,
    multiplied,
    rank,
)
from compensator_theory.matrices._residues import large_prime
from compensator_theory.matrices._symbolic_matrices import SymbolicMatrix, symbolic_matrix
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._generic_answers import generic_answer_of, holds_where_defined
from compensator_theory.polynomials._letters import variable_for_matrix
from compensator_theory.polynomials._poly import canonical, exact_quotient
from compensator_theory.polynomials._variables import require_one_symbol_a_name

_NO_ASSUMPTIONS = sympy.Dummy().assumptions0
MINORS = 24  # that are looked at before a wide controllability matrix counts as undecided


@holds_where_defined
@carrying()
def controllability_matrix(A: MatrixLike, B: MatrixLike) -> ImmutableMatrix:
    r"""Return Kalman's controllability matrix.

    .. math:: \mathcal C(A, B) = \begin{bmatrix} B & AB & \cdots & A^{n-1}B \end{bmatrix}

    Parameters
    ----------
    A, B : sympy.Matrix
        n x n and n x m, exact.

    Returns
    -------
    sympy.ImmutableMatrix
        n x nm; the observability matrix of (A, C) is the transpose of that of (A', C').

    Raises
    ------
    InputError
        If the shapes do not fit.

    Notes
    -----
    Source: below (7.27).

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory import controllability_matrix
    >>> controllability_matrix(Matrix([[-1, 4], [0, -3]]), Matrix([0, 1]))
    Matrix([
    [0,  4],
    [1, -3]])
    """
    A, B = exact_matrix(A, "A"), exact_matrix(B, "B")
    _require_pair(A.shape, B.shape)
    require_one_symbol_a_name(A.free_symbols | B.free_symbols)
    if not A.rows:
        return zero_matrix(0, 0)
    if (pair := rational_pair(A, B)) is not None:
        return from_flint(krylov(*pair).transpose())
    blocks = [B]
    for _ in range(A.rows - 1):
        blocks.append(multiplied(A, blocks[-1]))
    return ImmutableMatrix.hstack(*blocks)


def rational_pair(A: MatrixLike, B: MatrixLike) -> tuple[flint.fmpq_mat, flint.fmpq_mat] | None:
    """Read a pair of rational matrices; None where there are symbols or no states."""
    a, b = (rational_in_flint(exact_matrix(M, name)) for M, name in ((A, "A"), (B, "B")))
    if a is None or b is None or not a.nrows():
        return None
    _require_pair((a.nrows(), a.ncols()), (b.nrows(), b.ncols()))
    return a, b


def _require_pair(first: tuple[int, int], second: tuple[int, int]) -> None:
    if first[0] != first[1] or second[0] != first[0]:
        raise InputError(
            f"A is {first[0]} x {first[1]} and B is {second[0]} x {second[1]}; A must be square "
            "and B have as many rows"
        )


@carrying()
def is_controllable(A: MatrixLike, B: MatrixLike) -> bool | None:
    r"""Return whether (A, B) is controllable, :math:`\mathrm{rank}\,\mathcal C(A,B) = n`.

    Parameters
    ----------
    A, B : sympy.Matrix
        n x n and n x m, exact.

    Returns
    -------
    bool or None
        None if it depends on the values of symbols, or, for several inputs, if none of the minors
        that are tried settles it (:func:`exceptional_cases` tells for which values it holds); False
        if it fails for all values.

    Raises
    ------
    InputError
        If the shapes do not fit.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory import is_controllable
    >>> is_controllable(Matrix([[-1, 4], [0, -3]]), Matrix([0, 1]))
    True
    """
    if (pair := rational_pair(A, B)) is not None:
        return _reaches_all(*pair)
    A, B = exact_matrix(A, "A"), exact_matrix(B, "B")
    kalman = controllability_matrix(A, B)
    reached = any(int(sample.rank()) == A.rows for sample in _samples(kalman))
    if not reached and rank(kalman) < A.rows:
        return False
    if not kalman.free_symbols:
        return True
    return _has_full_rank(kalman)


def _reaches_all(A: flint.fmpq_mat, B: flint.fmpq_mat) -> bool:
    """Tell whether [B AB ...] has full rank: it does where it does modulo a prime."""
    n = int(A.nrows())
    whole, prime = (A.numer_denom()[0], B.numer_denom()[0]), large_prime()
    # vectors that are independent modulo a prime are independent
    if krylov(*(flint.nmod_mat(m, prime) for m in whole)).rank() == n:
        return True
    return bool(krylov(*whole).rank() == n)


def krylov(A: Any, B: Any) -> Any:
    """Return the transpose of [B AB ...], in whichever ring of python-flint."""
    block, entries = B, B.transpose().entries()
    for _ in range(int(A.nrows()) - 1):
        block = A * block
        entries += block.transpose().entries()
    height = len(entries) // int(A.nrows())
    modulus = [A.modulus()] if isinstance(A, flint.nmod_mat) else []
    return type(A)(height, int(A.nrows()), entries, *modulus)


@generic_answer_of(is_controllable)
def _generic_controllability(A: MatrixLike, B: MatrixLike) -> tuple[bool, list[Expr]]:
    """A rank is largest for generic values, so that a loss holds for all of them."""
    kalman = controllability_matrix(A, B)
    reduced = echelon(kalman)
    if len(reduced.pivots) < kalman.rows:
        return False, []
    return True, [reduced.divided_by, *_denominators(kalman)]


def _denominators(matrix: ImmutableMatrix) -> list[Expr]:
    return [sympy.fraction(sympy.cancel(entry))[1] for entry in matrix if entry.free_symbols]


def _has_full_rank(kalman: ImmutableMatrix) -> Literal[True] | None:
    """Tell whether some minor of full size is not zero, whatever the values; None if unknown.

    The rank is full for some values, so False would be wrong.
    """
    n = kalman.rows
    columns = [kalman[:, j] for j in range(kalman.cols)]
    occupied = [j for j, c in enumerate(columns) if c.free_symbols or not c.is_zero_matrix]
    kalman = kalman[:, occupied]
    numbers = [j for j in range(kalman.cols) if not kalman[:, j].free_symbols]
    if len(numbers) >= n and rank(kalman[:, numbers]) == n:
        return True
    minors, samples = [], _samples(kalman)
    for chosen in islice(combinations(range(kalman.cols), n), MINORS):
        values = {_minor(sample, chosen) for sample in samples}
        if len(values) > 1 or 0 in values:
            continue  # a function of symbols without assumptions, or no constant but 0
        minor = determinant(kalman[:, list(chosen)])
        if minor.is_nonzero:
            return True
        minors.append(minor)
    symbol, *others = kalman.free_symbols
    if others:
        return None
    tops = [sympy.fraction(sympy.cancel(minor))[0] for minor in minors]
    if not all(top.is_polynomial(symbol) for top in tops):
        return None
    shared = reduce(lambda a, b: a.gcd(b), [Poly(top, symbol) for top in tops])
    # Where all minors vanish, so does their gcd. It is zero if none of those tried is another.
    return True if shared.as_expr().is_nonzero else None


def _samples(kalman: ImmutableMatrix) -> list[flint.fmpq_mat]:
    """Return a matrix of rational functions of several symbols at two points; else nothing.

    No minor that differs there is known to be real and not zero where no symbol has assumptions.
    """
    matrix = symbolic_matrix(kalman)
    if not isinstance(matrix, SymbolicMatrix) or len(matrix.free_symbols) < 2:
        return []
    symbols, numerators = matrix.work.symbols, matrix.flint_form
    if any(x.assumptions0 != _NO_ASSUMPTIONS for x in symbols):
        return []
    points = [[first + 6 * k + k**2 for k in range(len(symbols))] for first in (3, 11)]
    samples = []
    for point in points:
        below = int(numerators.below(*point))
        if below == 0:
            return []
        entries = [flint.fmpq(int(top(*point)), below) for top in numerators.flat]
        samples.append(flint.fmpq_mat(*map(int, matrix.shape), entries))
    return samples


def _minor(sample: flint.fmpq_mat, columns: Sequence[int]) -> flint.fmpq:
    n = int(sample.nrows())
    return flint.fmpq_mat(n, n, [sample[i, j] for i in range(n) for j in columns]).det()


@carrying()
def uncontrollable_polynomial(
    A: MatrixLike, B: MatrixLike, *, variable: str | Symbol | None = None
) -> Poly:
    r"""Return the monic polynomial of the modes that the input does not reach.

    .. math:: u(s) = \det(sI - A)\,/\det(sI - A|_{\mathrm{im}\,\mathcal C(A,B)})

    Parameters
    ----------
    A, B : matrix
        n x n and n x m; with symbols, for generic values of them, and
        :func:`exceptional_cases` gives it for the others.
    variable : str or Symbol, optional
        Variable of the polynomial; default: s, or lambda where the matrices have a symbol s.

    Returns
    -------
    sympy.Poly
        1 if (A, B) is controllable; for the unobservable modes of (A, C) give A' and C'.

    Raises
    ------
    InputError
        If the shapes do not fit.

    Examples
    --------
    >>> from compensator_theory import uncontrollable_polynomial
    >>> uncontrollable_polynomial([[-1, 0], [0, -3]], [[0], [1]])
    Poly(s + 1, s, domain='QQ')
    """
    A, B = exact_matrix(A, "A"), exact_matrix(B, "B")
    s = variable_for_matrix(variable, A, B)
    reduced = echelon(controllability_matrix(A, B).T)
    whole, size = characteristic_polynomial(A, s), len(reduced.pivots)
    if size in (0, A.rows):
        return whole if size == 0 else canonical(Poly(1, s))
    # The rows are a basis V' that is the identity in its pivots: A V = V X shows X there.
    moved = multiplied(A[list(reduced.pivots), :], reduced.matrix.T)
    return exact_quotient(whole, characteristic_polynomial(moved, s))


@generic_answer_of(uncontrollable_polynomial)
def _generic_polynomial(
    A: MatrixLike, B: MatrixLike, *, variable: str | Symbol | None = None
) -> tuple[Poly, list[Expr]]:
    kalman = controllability_matrix(A, B)
    polynomial = uncontrollable_polynomial(A, B, variable=variable)
    return polynomial, [echelon(kalman).divided_by, *_denominators(kalman)]
