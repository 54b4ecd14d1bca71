"""Rational matrices in python-flint with the interface of SymPy."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import flint
from sympy import QQ, Expr, ImmutableMatrix, Integer, Matrix, Rational, Symbol, Tuple
from sympy.polys.matrices import DomainMatrix
from sympy.polys.matrices.sdm import SDM

from compensator_theory.matrices._flint_backed import OF_SYMPY, FlintBackedMatrix


class RationalMatrix(FlintBackedMatrix):
    """A SymPy matrix of rational numbers, stored in python-flint.

    Sums, products, transposes and ranks of such matrices stay in python-flint.

    Attributes
    ----------
    flint_form : flint.fmpq_mat
        Must not be modified.
    """

    flint_form: flint.fmpq_mat

    @classmethod
    def _of_flint_form(cls, raw: flint.fmpq_mat) -> RationalMatrix:
        matrix: RationalMatrix = cls._of_shape(int(raw.nrows()), int(raw.ncols()))
        matrix.flint_form = raw
        return matrix

    @classmethod
    def _fromrep(cls, rep: DomainMatrix) -> ImmutableMatrix:
        if rep.domain.is_ZZ or rep.domain.is_QQ:
            return cls._of_flint_form(_in_flint(rep))
        return ImmutableMatrix._fromrep(rep)

    @cached_property
    def _rep(self) -> DomainMatrix:
        """SymPy's form for computing, sparse as in all its matrices."""
        rows: list[list[Any]] = self.flint_form.tolist() if self._rows and self._cols else []
        if QQ.dtype is not flint.fmpq:  # SymPy's ground types are python-flint's where it found it
            rows = [[QQ(int(entry.p), int(entry.q)) for entry in row] for row in rows]
        nonzero = {i: {j: e for j, e in enumerate(row) if e} for i, row in enumerate(rows)}
        by_row = {i: row for i, row in nonzero.items() if row}
        return DomainMatrix.from_rep(SDM(by_row, (self._rows, self._cols), QQ))

    @cached_property
    def _args(self) -> tuple[Integer, Integer, Tuple]:
        flat = [entry for row in self._eval_tolist() for entry in row]
        return Integer(self._rows), Integer(self._cols), Tuple(*flat, sympify=False)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, RationalMatrix):
            return bool(self.flint_form == other.flint_form)
        return super().__eq__(other)

    __hash__ = FlintBackedMatrix.__hash__

    @property
    def is_zero_matrix(self) -> bool:
        """Whether every entry is zero, which is always known here."""
        return not any(self.flint_form.entries())

    @property
    def free_symbols(self) -> set[Symbol]:
        """No symbols."""
        return set()

    def _entry(self, row: int, column: int) -> Rational:
        return rational(self.flint_form[row, column])

    def _right_of(self, left: Matrix, operation: str) -> ImmutableMatrix:
        return OF_SYMPY[operation](left, self)

    def _eval_tolist(self) -> list[list[Rational]]:
        if not (self._rows and self._cols):
            return [[] for _ in range(self._rows)]
        return [[rational(entry) for entry in row] for row in self.flint_form.tolist()]

    def _eval_transpose(self) -> RationalMatrix:
        return self._of_flint_form(self.flint_form.transpose())

    def __neg__(self) -> RationalMatrix:
        return self._of_flint_form(-self.flint_form)

    def _eval_add(self, other: Matrix) -> ImmutableMatrix:
        raw = rational_in_flint(other)
        return (
            self._delegate("add", other)
            if raw is None
            else self._of_flint_form(self.flint_form + raw)
        )

    def _eval_matrix_mul(self, other: Matrix) -> ImmutableMatrix:
        raw = rational_in_flint(other)
        return (
            self._delegate("multiply", other)
            if raw is None
            else self._of_flint_form(self.flint_form * raw)
        )

    def _eval_scalar_mul(self, other: Expr) -> ImmutableMatrix:
        if not isinstance(other, Rational):
            return super()._eval_scalar_mul(other)
        return self._of_flint_form(self.flint_form * flint.fmpq(int(other.p), int(other.q)))

    _eval_scalar_rmul = _eval_scalar_mul

    def _eval_row_join(self, other: Matrix) -> ImmutableMatrix:
        if (raw := rational_in_flint(other)) is None:
            return self._delegate("beside", other)
        return self._of_flint_form(
            _joined(self.flint_form.transpose(), raw.transpose()).transpose()
        )

    def _eval_col_join(self, other: Matrix) -> ImmutableMatrix:
        if (raw := rational_in_flint(other)) is None:
            return self._delegate("below", other)
        return self._of_flint_form(_joined(self.flint_form, raw))

    def _eval_extract(self, rows: Sequence[int], columns: Sequence[int]) -> RationalMatrix:
        entries, width = self.flint_form.entries(), self._cols
        chosen = [entries[i * width + j] for i in rows for j in columns]
        return self._of_flint_form(flint.fmpq_mat(len(rows), len(columns), chosen))


def _joined(above: flint.fmpq_mat, below: flint.fmpq_mat) -> flint.fmpq_mat:
    height = above.nrows() + below.nrows()
    return flint.fmpq_mat(height, above.ncols(), above.entries() + below.entries())


def is_rational_matrix(matrix: Matrix) -> bool:
    """Tell whether every entry is a rational number."""
    if isinstance(matrix, FlintBackedMatrix):  # a rational matrix never has the symbolic type
        return isinstance(matrix, RationalMatrix)
    if rational_representation(matrix) is not None:
        return True
    # SymPy's conversion is slow where it fails: it evaluates roots
    return all(entry.is_Rational for entry in matrix.todok().values())


def rational_in_flint(matrix: Matrix) -> flint.fmpq_mat | None:
    """Return a matrix in python-flint if every entry is a rational number, else None."""
    return to_flint(matrix) if is_rational_matrix(matrix) else None


def to_flint(matrix: Matrix) -> flint.fmpq_mat:
    """Return a rational matrix as one of python-flint."""
    if isinstance(matrix, RationalMatrix):
        return matrix.flint_form
    rational = rational_representation(matrix)
    return _in_flint(matrix.to_DM(domain=QQ) if rational is None else rational)


def _in_flint(rational: DomainMatrix) -> flint.fmpq_mat:
    entries = rational.to_list_flat()
    if QQ.dtype is not flint.fmpq:
        entries = [flint.fmpq(int(entry.numerator), int(entry.denominator)) for entry in entries]
    return flint.fmpq_mat(*rational.shape, entries)


def rational_representation(matrix: Matrix) -> DomainMatrix | None:
    """Return SymPy's DomainMatrix of a rational matrix, None where a conversion would be needed."""
    if isinstance(matrix, FlintBackedMatrix) and not isinstance(matrix, RationalMatrix):
        return None  # without converting the entries
    domain_matrix = getattr(matrix, "_rep", None)
    if isinstance(domain_matrix, DomainMatrix) and (
        domain_matrix.domain.is_ZZ or domain_matrix.domain.is_QQ
    ):
        return domain_matrix
    return None


def symbols_in(matrix: Matrix) -> set[Symbol]:
    """Return the symbols of a matrix; one of numbers only is not looked through."""
    is_free = (
        not isinstance(matrix, FlintBackedMatrix) and rational_representation(matrix) is not None
    )
    return set() if is_free else set(matrix.free_symbols)


def from_flint(matrix: flint.fmpq_mat) -> RationalMatrix:
    """Return a python-flint matrix as one of SymPy; it is not copied and must not change."""
    return RationalMatrix._of_flint_form(matrix)


def of_rows(rows: Sequence[Sequence[Expr]], shape: tuple[int, int]) -> ImmutableMatrix:
    """Return the matrix of computed entries, in python-flint where they are rational."""
    flat = [entry for row in rows for entry in row]
    if not all(isinstance(entry, int | Rational) for entry in flat):
        return ImmutableMatrix(*shape, flat)
    entries = [flint.fmpq(int(entry.numerator), int(entry.denominator)) for entry in flat]
    return from_flint(flint.fmpq_mat(*shape, entries))


def stacked(rows: Sequence[ImmutableMatrix]) -> ImmutableMatrix:
    """Return matrices one below the other; each is copied once for a halving of their number."""
    if len(rows) < 3:
        return ImmutableMatrix.vstack(*rows)
    half = len(rows) // 2
    return stacked(rows[:half]).col_join(stacked(rows[half:]))


def identity_matrix(size: int) -> RationalMatrix:
    """Return the identity matrix."""
    ones = [int(i == j) for i in range(size) for j in range(size)]
    return from_flint(flint.fmpq_mat(size, size, ones))


def zero_matrix(rows: int, columns: int) -> RationalMatrix:
    """Return a matrix of zeros."""
    return from_flint(flint.fmpq_mat(rows, columns))


def rational(value: flint.fmpq) -> Rational:
    """Return a rational number of python-flint as one of SymPy."""
    return Rational.from_coprime_ints(int(value.p), int(value.q))
