"""Eigenstructure assignment: state feedback from eigenvalues and eigenvectors, chains included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import sympy
from sympy import Expr, ImmutableMatrix, Matrix

from compensator_theory._latex import displayed, latex, unless
from compensator_theory._printing import text
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._certificates import Certificate, proven
from compensator_theory.matrices._echelon import echelon
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import identity_matrix, zero_matrix
from compensator_theory.matrices._linear_algebra import solve, solve_affine
from compensator_theory.polynomials._algebraic import algebraic
from compensator_theory.polynomials._budget import listed, repr_of
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._decidable import require_decidable
from compensator_theory.polynomials._generic_answers import generic_answer_of
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._substitution import denominators_in
from compensator_theory.polynomials._values import ExactValue

IDENTITY = "(A + B K) V = V Lambda"
Chain: TypeAlias = list[list[Expr]]


@dataclass(frozen=True)
class Eigenstructure(ExactValue):
    r"""A gain and the eigenvectors that it assigns.

    .. math:: (A + B K) V = V \Lambda, \qquad K = W V^{-1}, \quad B W = V \Lambda - A V

    Attributes
    ----------
    K : sympy.ImmutableMatrix
        m x n; the only one if the inputs are independent.
    V, Lambda : sympy.ImmutableMatrix
        Eigenvectors and chains as columns, and the Jordan matrix; a complex pair a + jb takes two
        columns, real and imaginary part, and a block [[a, b], [-b, a]].
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the gain exists where none of them is zero.
    certificate : Certificate
        The identity, evaluated.
    """

    K: ImmutableMatrix
    V: ImmutableMatrix
    Lambda: ImmutableMatrix
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __str__(self) -> str:
        return f"K = {text(self.K.tolist())}"

    def _repr_latex_(self) -> str:
        return displayed(
            rf"K = {latex(self.K)}",
            rf"(A + B K) V = V \Lambda, \quad V = {latex(self.V)}",
            rf"\Lambda = {latex(self.Lambda)}",
            unless(self.exceptional),
        )


@refusing
def reachable_eigenvectors(A: MatrixLike, B: MatrixLike, eigenvalue: NumberLike) -> ImmutableMatrix:
    r"""Return a basis of the eigenvectors that some feedback gives an eigenvalue.

    .. math:: \{v : (\lambda I - A) v \in \mathrm{im}\,B\}

    Parameters
    ----------
    A, B : matrix
        n x n and n x m.
    eigenvalue : number
        Rational, a symbol, or a + bj with rational parts; then vectors are complex, and their
        conjugates are those of the conjugate.

    Returns
    -------
    sympy.ImmutableMatrix
        Columns; as many as independent inputs where the eigenvalue is controllable, and one more
        for each way in which it is not.

    Raises
    ------
    InputError
        If the shapes do not fit or the eigenvalue is irrational.

    Notes
    -----
    Source: B. C. Moore, IEEE Transactions on Automatic Control 21 (1976).

    Examples
    --------
    >>> from compensator_theory import reachable_eigenvectors
    >>> reachable_eigenvectors([[0, 1], [0, 0]], [[0], [1]], -3).T
    Matrix([[1/9, -1/3]])
    >>> reachable_eigenvectors([[0, 1], [0, 0]], [[0], [1]], "-1 + j").T
    Matrix([[I/2, -1/2 - I/2]])
    """
    return _reachable(A, B, eigenvalue)[0]


@generic_answer_of(reachable_eigenvectors)
def _reachable(
    A: MatrixLike, B: MatrixLike, eigenvalue: NumberLike
) -> tuple[ImmutableMatrix, list[Expr]]:
    a, b = _pair(A, B)
    value = sympy.expand(exact_number(eigenvalue))
    require_decidable([value])
    parts = _parts(value)
    if any(part.is_number and not part.is_rational for part in parts):
        raise InputError(f"the eigenvalue {value} must have rational parts, or be a symbol")
    n = a.rows
    pencil = ImmutableMatrix((value * identity_matrix(n) - a).row_join(-b))
    rows = echelon(pencil)
    kernel = rows.kernel()[:n, :]
    nonzero = echelon(kernel)  # inputs without effect have v = 0
    basis = ImmutableMatrix.hstack(
        zero_matrix(n, 0), *(kernel[:, pivot] for pivot in nonzero.pivots)
    )
    return basis, [rows.divided_by, nonzero.divided_by, *denominators_in((a, b, basis))]


@refusing
def assign_eigenstructure(
    A: MatrixLike,
    B: MatrixLike,
    eigenvalues: Sequence[NumberLike],
    eigenvectors: Sequence[Sequence[NumberLike] | Sequence[Sequence[NumberLike]]],
) -> Eigenstructure:
    r"""Find the K that gives A + B K these eigenvalues with these eigenvectors.

    .. math:: (A + B K) v_1 = \lambda v_1, \qquad (A + B K) v_{k+1} = \lambda v_{k+1} + v_k

    Parameters
    ----------
    A, B : matrix
        n x n and n x m; symbols allowed.
    eigenvalues : sequence of numbers
        Rational, symbolic, or a + bj with rational parts, which stands for the pair: its conjugate
        may be given, too, with conjugate vectors.
    eigenvectors : sequence
        For each eigenvalue a vector of n numbers, or a chain of them, first the eigenvector; for a
        complex one complex vectors. Together n real vectors.

    Raises
    ------
    NoSolutionError
        If a vector cannot be reached, or the vectors are dependent; the message names which.
    InputError
        If sizes do not fit, or conjugate eigenvalues have vectors that are not conjugate.

    Notes
    -----
    Source: B. C. Moore, IEEE Transactions on Automatic Control 21 (1976); for chains, G. Klein and
    B. C. Moore, ibid. 22 (1977).

    Examples
    --------
    >>> from compensator_theory import assign_eigenstructure
    >>> A, B = [[0, 1, 0], [0, 0, 0], [0, 0, 1]], [[0, 0], [1, 0], [1, 1]]
    >>> assign_eigenstructure(A, B, [-1, -1, -2], [(1, -1, 0), (0, 0, 1), (1, -2, 1)]).K
    Matrix([
    [-2, -3,  0],
    [ 3,  4, -2]])
    """
    a, b = _pair(A, B)
    n = a.rows
    eigenvalues = listed(eigenvalues, "degree", "the list of eigenvalues")
    eigenvectors = listed(eigenvectors, "degree", "the list of eigenvectors")
    if len(eigenvalues) != len(eigenvectors):
        raise InputError(
            f"there are {len(eigenvalues)} eigenvalues and {len(eigenvectors)} eigenvectors or "
            "chains; each eigenvalue needs one"
        )
    columns: list[ImmutableMatrix] = []
    blocks: list[Matrix] = []
    pairs = [
        (_eigenvalue(value), _chain(vectors, n))
        for value, vectors in zip(eigenvalues, eigenvectors, strict=True)
    ]
    for value, chain in _one_of_each_pair(pairs):
        vectors, block = _block(value, chain)
        columns += vectors
        blocks.append(block)
    if len(columns) != n:
        raise InputError(
            f"these are {len(columns)} vectors (a complex one counts twice), but A + BK has {n}"
        )
    V, jordan = ImmutableMatrix.hstack(*columns), ImmutableMatrix(sympy.diag(*blocks))
    W = [_input(b, (V * jordan - a * V)[:, k], columns[k]) for k in range(n)]
    try:
        K = solve(V.T, ImmutableMatrix.hstack(*W).T).T
    except NoSolutionError as error:
        raise NoSolutionError(
            f"the eigenvectors {V.T.tolist()} are linearly dependent; choose independent ones"
        ) from error
    left = (a + b * K) * V - V * jordan
    certificate = proven(
        Certificate(IDENTITY, ImmutableMatrix(left.applyfunc(sympy.cancel))), "gain"
    )
    bottoms = [sympy.fraction(sympy.cancel(entry))[1] for entry in K]
    return Eigenstructure(
        ImmutableMatrix(K.applyfunc(sympy.cancel)),
        V,
        jordan,
        exceptional_factors(bottoms),
        certificate,
    )


def _pair(A: MatrixLike, B: MatrixLike) -> tuple[ImmutableMatrix, ImmutableMatrix]:
    a, b = exact_matrix(A, "A"), exact_matrix(B, "B")
    if a.rows != a.cols or b.rows != a.rows or not (a.rows and b.cols):
        raise InputError(
            f"A is {a.rows} x {a.cols} and B is {b.rows} x {b.cols}; A must be square and B have "
            "as many rows"
        )
    return a, b


def _eigenvalue(value_like: NumberLike) -> Expr:
    """Read one; a real algebraic number in the form that equal ones share."""
    value = sympy.expand(exact_number(value_like))
    require_decidable([value])
    if value.is_number and not value.is_Rational:
        number = algebraic(value)
        if number is not None and number.is_real:
            return number.expression()
    return value


def _chain(chain_like: object, n: int) -> Chain:
    """Read one vector or a chain of them."""
    if isinstance(chain_like, str) or not hasattr(chain_like, "__iter__"):
        raise InputError(f"{repr_of(chain_like)} is no eigenvector; write {n} numbers")
    entries = listed(chain_like, "degree", "the eigenvector")
    nested = bool(entries) and all(
        hasattr(entry, "__iter__") and not isinstance(entry, str) for entry in entries
    )
    vectors = [
        [sympy.expand(exact_number(e)) for e in v] for v in (entries if nested else [entries])
    ]
    for vector in vectors:
        require_decidable(vector)
        if len(vector) != n:
            raise InputError(f"the eigenvector {vector} has {len(vector)} entries; it needs {n}")
    return vectors


def _one_of_each_pair(pairs: list[tuple[Expr, Chain]]) -> list[tuple[Expr, Chain]]:
    """Eigenvalues with b >= 0 and their chains; of two that are conjugate, one."""
    representatives: list[tuple[Expr, Chain]] = []
    conjugates: list[tuple[Expr, Chain]] = []
    for value, chain in pairs:
        is_lower = _parts(value)[1].is_negative
        (conjugates if is_lower else representatives).append(
            (_conjugate(value), [[_conjugate(e) for e in v] for v in chain])
            if is_lower
            else (value, chain)
        )
    for value, chain in conjugates:
        if (value, chain) in representatives:
            continue
        if any(value == other for other, _ in representatives):
            raise InputError(
                f"{_conjugate(value)} and {value} have vectors that are not conjugate; give one "
                "of the two, or conjugate vectors"
            )
        representatives.append((value, chain))
    return representatives


def _block(value: Expr, vectors: Chain) -> tuple[list[ImmutableMatrix], Matrix]:
    """Return real columns and the real Jordan block of one eigenvalue, or of a pair."""
    real, imaginary = _parts(value)
    size = len(vectors)
    above = Matrix(size, size, lambda i, j: int(j == i + 1))
    if imaginary == 0:
        return [_column(vector) for vector in vectors], value * identity_matrix(size) + above
    columns = [_column([_parts(e)[k] for e in vector]) for vector in vectors for k in (0, 1)]
    pair = Matrix([[real, imaginary], [-imaginary, real]])
    kronecker = sympy.kronecker_product(above, identity_matrix(2))
    return columns, sympy.diag(*[pair] * size) + Matrix(kronecker)


def _parts(value: Expr) -> tuple[Expr, Expr]:
    """Real and imaginary part; symbols count as real."""
    return value.xreplace({sympy.I: sympy.S.Zero}), value.coeff(sympy.I)


def _conjugate(value: Expr) -> Expr:
    real, imaginary = _parts(value)
    return real - sympy.I * imaginary


def _column(entries: list[Expr]) -> ImmutableMatrix:
    return exact_matrix([[entry] for entry in entries], "the eigenvector")


def _input(b: ImmutableMatrix, target: ImmutableMatrix, vector: ImmutableMatrix) -> ImmutableMatrix:
    """Return w with B w = target; it exists if the vector is reachable."""
    try:
        return solve_affine(b, ImmutableMatrix(target.applyfunc(sympy.expand))).particular
    except NoSolutionError as error:
        raise NoSolutionError(
            f"no feedback makes {list(vector)} an eigenvector or a member of such a chain: "
            "A V - V Lambda must lie in the image of B. reachable_eigenvectors(A, B, eigenvalue) "
            "gives those that are in reach"
        ) from error
