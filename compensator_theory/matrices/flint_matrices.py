"""Rational matrices of SymPy as those of python-flint, and back."""

from __future__ import annotations

from typing import Any

import flint
from sympy import QQ, ImmutableMatrix, Matrix, Rational, Symbol
from sympy.polys.matrices import DomainMatrix
from sympy.polys.matrices.sdm import SDM


def is_rational_matrix(matrix: Matrix) -> bool:
    """Tell whether every entry is a rational number.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.flint_matrices import is_rational_matrix
    >>> is_rational_matrix(Matrix([[1, 2]])), is_rational_matrix(Matrix([["a"]]))
    (True, False)
    """
    if kept_rational(matrix) is not None:
        return True
    # SymPy's conversion would write down what it refuses, and look for the values of its roots
    return all(entry.is_Rational for entry in matrix.todok().values())


def rational_in_flint(matrix: Matrix) -> flint.fmpq_mat | None:
    """Return a matrix in python-flint if every entry is a rational number, else None.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.flint_matrices import rational_in_flint
    >>> rational_in_flint(Matrix([["a"]])) is None
    True
    """
    return to_flint(matrix) if is_rational_matrix(matrix) else None


def to_flint(matrix: Matrix) -> flint.fmpq_mat:
    """Return a rational matrix as one of python-flint.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.flint_matrices import to_flint
    >>> to_flint(Matrix([[1, 2], [3, 4]])).det()
    -2
    """
    kept = kept_rational(matrix)
    if kept is None:
        kept = matrix.to_DM(domain=QQ)
    by_row = kept.to_dod()  # Sylvester matrices are half zeros
    result = flint.fmpq_mat(matrix.rows, matrix.cols)
    is_flint = QQ.dtype is flint.fmpq  # SymPy's ground types are python-flint's where it found it
    for i, row in by_row.items():
        for j, entry in row.items():
            result[i, j] = entry if is_flint else _fraction(entry)
    return result


def kept_rational(matrix: Matrix) -> DomainMatrix | None:
    """Return SymPy's own form of rational numbers, None for others; a conversion takes longer.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.flint_matrices import kept_rational
    >>> kept_rational(Matrix([["a"]])) is None
    True
    """
    kept = getattr(matrix, "_rep", None)
    if isinstance(kept, DomainMatrix) and (kept.domain.is_ZZ or kept.domain.is_QQ):
        return kept
    return None


def symbols_in(matrix: Matrix) -> set[Symbol]:
    """Return the symbols of a matrix; one of numbers only is not looked through.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.flint_matrices import symbols_in
    >>> symbols_in(Matrix([["a", 1]])), symbols_in(Matrix([[1, 2]]))
    ({a}, set())
    """
    return set() if kept_rational(matrix) is not None else set(matrix.free_symbols)


def from_flint(matrix: flint.fmpq_mat) -> ImmutableMatrix:
    """Return a rational matrix of python-flint as one of SymPy.

    Examples
    --------
    >>> import flint
    >>> from compensator_theory.matrices.flint_matrices import from_flint
    >>> from_flint(flint.fmpq_mat(1, 2, [flint.fmpq(1, 2), flint.fmpq(3)]))
    Matrix([[1/2, 3]])
    """
    shape = matrix.nrows(), matrix.ncols()
    rows = matrix.tolist() if 0 not in shape else []
    if QQ.dtype is not flint.fmpq:
        rows = [[QQ(int(entry.p), int(entry.q)) for entry in row] for row in rows]
    if shape[1] == 1:
        by_row = {i: {0: row[0]} for i, row in enumerate(rows) if row[0]}
    else:
        nonzero = {i: {j: e for j, e in enumerate(row) if e} for i, row in enumerate(rows)}
        by_row = {i: row for i, row in nonzero.items() if row}
    # SymPy's public way, through a mutable matrix, takes twice as long for a column of 20.
    return ImmutableMatrix._fromrep(DomainMatrix.from_rep(SDM(by_row, shape, QQ)))


def _fraction(entry: Any) -> flint.fmpq:
    return flint.fmpq(int(entry.numerator), int(entry.denominator))


def rational(value: flint.fmpq) -> Rational:
    """Return a rational number of python-flint as one of SymPy.

    Examples
    --------
    >>> import flint
    >>> from compensator_theory.matrices.flint_matrices import rational
    >>> rational(flint.fmpq(2, 4))
    1/2
    """
    return Rational(int(value.p), int(value.q))
