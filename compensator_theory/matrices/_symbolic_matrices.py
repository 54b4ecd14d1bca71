"""Matrices of rational functions in python-flint with the interface of SymPy."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import flint
from sympy import Expr, ImmutableMatrix, Integer, Matrix, Symbol, Tuple
from sympy.polys.matrices import DomainMatrix

from compensator_theory.matrices._flint_backed import OF_SYMPY, FlintBackedMatrix
from compensator_theory.matrices._flint_matrices import (
    RationalMatrix,
    from_flint,
    is_rational_matrix,
    symbols_in,
    to_flint,
)
from compensator_theory.matrices._rational_functions import (
    NotRationalError,
    RationalFunctions,
    in_symbols,
)

Grid: TypeAlias = list[list[flint.fmpz_mpoly]]


@dataclass(frozen=True)
class Numerators:
    """The entries of a matrix, row by row, over one denominator."""

    flat: Sequence[flint.fmpz_mpoly]
    below: flint.fmpz_mpoly
    rows: int
    columns: int

    def grid(self) -> Grid:
        """Return the numerators by rows."""
        width = self.columns
        return [list(self.flat[k * width : (k + 1) * width]) for k in range(self.rows)]


class SymbolicMatrix(FlintBackedMatrix):
    """A SymPy matrix of rational functions of symbols over QQ, stored in python-flint.

    Sums, products, joins, parts and transposes of such matrices, and of these with rational ones,
    stay in python-flint; entries are written in lowest terms, on demand.

    Attributes
    ----------
    work : RationalFunctions
        The ring that writes them.
    flint_form : Numerators
        Without a common factor, the denominator with a positive leading coefficient: equal
        matrices are kept alike. Must not be modified.
    """

    work: RationalFunctions
    flint_form: Numerators

    @classmethod
    def _of_flint_form(cls, work: RationalFunctions, numerators: Numerators) -> SymbolicMatrix:
        matrix: SymbolicMatrix = cls._of_shape(numerators.rows, numerators.columns)
        matrix.work, matrix.flint_form = work, numerators
        return matrix

    @classmethod
    def _fromrep(cls, rep: DomainMatrix) -> ImmutableMatrix:
        return ImmutableMatrix._fromrep(rep)

    @cached_property
    def _plain(self) -> ImmutableMatrix:
        """The equal ImmutableMatrix."""
        below = self.flint_form.below
        return ImmutableMatrix(
            *self.shape, [self.work.write(x, below) for x in self.flint_form.flat]
        )

    @property
    def _rep(self) -> DomainMatrix:
        return self._plain._rep

    @property
    def _args(self) -> tuple[Integer, Integer, Tuple]:
        arguments: tuple[Integer, Integer, Tuple] = self._plain.args
        return arguments

    def __eq__(self, other: object) -> bool:
        if isinstance(other, SymbolicMatrix) and self.work.symbols == other.work.symbols:
            return self.flint_form == other.flint_form
        return super().__eq__(other)

    __hash__ = FlintBackedMatrix.__hash__

    @cached_property
    def free_symbols(self) -> set[Symbol]:
        """The symbols that occur, which after a sum or a product may be fewer."""
        return self.work.symbols_of([*self.flint_form.flat, self.flint_form.below])

    def _entry(self, row: int, column: int) -> Expr:
        return self.work.write(
            self.flint_form.flat[row * self._cols + column], self.flint_form.below
        )

    def _of_entries(
        self, flat: Iterable[flint.fmpz_mpoly], rows: int, columns: int
    ) -> ImmutableMatrix:
        """Return a matrix of some of these entries."""
        return of_numerators(self.work, list(flat), self.flint_form.below, (rows, columns))

    def _eval_transpose(self) -> SymbolicMatrix:
        flat = [x for column in zip(*self.flint_form.grid(), strict=True) for x in column]
        transposed = Numerators(flat, self.flint_form.below, self._cols, self._rows)
        return self._of_flint_form(self.work, transposed)

    def __neg__(self) -> SymbolicMatrix:
        flat = [-x for x in self.flint_form.flat]
        return self._of_flint_form(self.work, Numerators(flat, self.flint_form.below, *self.shape))

    def _eval_extract(self, rows: Sequence[int], columns: Sequence[int]) -> ImmutableMatrix:
        flat = (self.flint_form.flat[i * self._cols + j] for i in rows for j in columns)
        return self._of_entries(flat, len(rows), len(columns))

    def _eval_scalar_mul(self, other: Expr) -> ImmutableMatrix:
        if (both := over_common_symbols(self, ImmutableMatrix([[other]]))) is None:
            return super()._eval_scalar_mul(other)
        work, (matrix, factor) = both
        flat = [x * factor.flat[0] for x in matrix.flat]
        return of_numerators(work, flat, matrix.below * factor.below, self.shape)

    _eval_scalar_rmul = _eval_scalar_mul

    def _eval_add(self, other: Matrix) -> ImmutableMatrix:
        return _together(self, other, "add")

    def _eval_matrix_mul(self, other: Matrix) -> ImmutableMatrix:
        return _together(self, other, "multiply")

    def _eval_row_join(self, other: Matrix) -> ImmutableMatrix:
        return _together(self, other, "beside")

    def _eval_col_join(self, other: Matrix) -> ImmutableMatrix:
        return _together(self, other, "below")

    def _right_of(self, left: Matrix, operation: str) -> ImmutableMatrix:
        return _together(left, self, operation)


def _together(left: Matrix, right: Matrix, operation: str) -> ImmutableMatrix:
    """Do an operation by its name, in python-flint where possible, else in SymPy."""
    if (read := over_common_symbols(left, right)) is None:
        return OF_SYMPY[operation](left, right)
    work, (one, two) = read
    if operation == "multiply":
        return _product(work, [one, two])
    (first, second), below = over_one(work, (one, two))
    if operation == "add":
        total = [x + y for x, y in zip(first, second, strict=True)]
        return of_numerators(work, total, below, left.shape)
    if operation == "below":
        return of_numerators(work, [*first, *second], below, (one.rows + two.rows, one.columns))
    m, k = one.columns, two.columns
    rows = [[*first[i * m : (i + 1) * m], *second[i * k : (i + 1) * k]] for i in range(one.rows)]
    return of_numerators(work, [x for row in rows for x in row], below, (one.rows, m + k))


def of_numerators(
    work: RationalFunctions,
    flat: Sequence[flint.fmpz_mpoly],
    below: flint.fmpz_mpoly,
    shape: tuple[int, int],
) -> RationalMatrix | SymbolicMatrix:
    """Return the matrix of numerators over a denominator, rational where no symbol is left."""
    if not below.is_one():
        shared = common_factor(below, flat)
        if below.leading_coefficient() < 0:
            shared = -shared
        if not shared.is_one():
            flat, below = [x / shared for x in flat], below / shared
    if below.is_constant() and all(x.is_constant() for x in flat):
        bottom = int(below.leading_coefficient())
        tops = [0 if x.is_zero() else int(x.leading_coefficient()) for x in flat]
        return from_flint(flint.fmpq_mat(*shape, [flint.fmpq(top, bottom) for top in tops]))
    return SymbolicMatrix._of_flint_form(
        work, Numerators(flat, below, int(shape[0]), int(shape[1]))
    )


def common_factor(
    below: flint.fmpz_mpoly, numerators: Iterable[flint.fmpz_mpoly]
) -> flint.fmpz_mpoly:
    """Return a greatest common divisor of a denominator and of numerators."""
    for above in numerators:
        if below.is_one():
            break
        if not above.is_zero():
            below = below.gcd(above)
    return below


def symbolic_matrix(matrix: Matrix) -> RationalMatrix | SymbolicMatrix | None:
    """Read a matrix of rational functions into python-flint; None for other entries."""
    if isinstance(matrix, FlintBackedMatrix):
        return matrix
    if is_rational_matrix(matrix):
        return from_flint(to_flint(matrix))
    symbols = symbols_in(matrix)
    if not symbols or not all(isinstance(symbol, Symbol) for symbol in symbols):
        return None
    work = in_symbols(frozenset(symbols))
    try:
        flat, below = work.over_one(list(matrix))
    except NotRationalError:
        return None
    return of_numerators(work, flat, below, matrix.shape)


def over_common_symbols(*matrices: Matrix) -> tuple[RationalFunctions, list[Numerators]] | None:
    """Return the numerators of all matrices in one ring with the symbols of all."""
    symbolic = []
    for matrix in matrices:
        if (read := symbolic_matrix(matrix)) is None:
            return None
        symbolic.append(read)
    works = [part.work for part in symbolic if isinstance(part, SymbolicMatrix)]
    if not works:
        return None
    work = works[0]
    if any(other.symbols != work.symbols for other in works):
        work = in_symbols(frozenset().union(*(other.symbols for other in works)))
    return work, [_in_ring_of(work, part) for part in symbolic]


def _in_ring_of(work: RationalFunctions, matrix: RationalMatrix | SymbolicMatrix) -> Numerators:
    if isinstance(matrix, RationalMatrix):
        above, below = matrix.flint_form.numer_denom()
        flat = [work.context.constant(int(x)) for x in above.entries()]
        return Numerators(flat, work.context.constant(int(below)), *map(int, matrix.shape))
    numerators = matrix.flint_form
    if matrix.work.symbols == work.symbols:
        return numerators
    moves = {f"x{i}": f"x{work.symbols.index(x)}" for i, x in enumerate(matrix.work.symbols)}
    flat = [x.project_to_context(work.context, moves) for x in numerators.flat]
    below = numerators.below.project_to_context(work.context, moves)
    return Numerators(flat, below, numerators.rows, numerators.columns)


def over_one(
    work: RationalFunctions, parts: Iterable[Numerators]
) -> tuple[list[Sequence[flint.fmpz_mpoly]], flint.fmpz_mpoly]:
    """Return the numerators of some matrices over one denominator, and that."""
    expressions = list(parts)
    common = work.one
    for part in expressions:
        if part.below != common:
            common = common * (part.below / common.gcd(part.below))
    factors = [common / part.below for part in expressions]
    return [
        part.flat if factor.is_one() else [x * factor for x in part.flat]
        for part, factor in zip(expressions, factors, strict=True)
    ], common


def product_with_symbols(*factors: Matrix) -> ImmutableMatrix | None:
    """Multiply matrices of rational functions; None if an entry is no rational function."""
    if (read := over_common_symbols(*factors)) is None:
        return None
    return _product(*read)


def _product(work: RationalFunctions, factors: Sequence[Numerators]) -> ImmutableMatrix:
    first, *others = factors
    rows, below = first.grid(), first.below
    for other in others:
        rows, below = multiplied_grids(work, rows, other.grid()), below * other.below
    flat = [x for row in rows for x in row]
    return of_numerators(work, flat, below, (first.rows, factors[-1].columns))


def multiplied_grids(work: RationalFunctions, left: Grid, right: Grid) -> Grid:
    """Multiply numerators."""
    columns = list(zip(*right, strict=True))
    rows = [[(k, x) for k, x in enumerate(row) if not x.is_zero()] for row in left]
    return [[sum((x * c[k] for k, x in row), start=work.zero) for c in columns] for row in rows]
