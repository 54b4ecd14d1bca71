"""Rational functions of symbols by python-flint: elimination and products without fractions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import lru_cache, reduce
from math import prod
from typing import TypeAlias

import flint
import sympy
from sympy import QQ, Expr, ImmutableMatrix, Matrix, Poly, Symbol
from sympy.polys.polyclasses import DMP
from sympy.polys.rings import PolyElement

from compensator_theory.polynomials.poly import canonical, from_coefficients

Fraction: TypeAlias = tuple[flint.fmpz_mpoly, flint.fmpz_mpoly]
"""Numerator and denominator, not in lowest terms."""
LARGEST_POWER = 200
REMEMBERED = 100_000
"""Terms of fractions that were read or written, for each set of symbols."""


class NotRationalError(Exception):
    """An expression that is no rational function of symbols over QQ, or one with large powers."""


class RationalFunctions:
    """Reads expressions in some symbols as fractions of polynomials with whole coefficients.

    Examples
    --------
    >>> from sympy.abc import a, b
    >>> from compensator_theory.matrices.fraction_free import RationalFunctions
    >>> work = RationalFunctions({a, b})
    >>> work.write(*work.read(1 / a + 1 / b))
    (a + b)/(a*b)
    """

    def __init__(self, symbols: Iterable[Symbol]) -> None:
        """Make one; `in_symbols` has those of the last computations, with what they read."""
        ordered = Poly(sympy.Add(*symbols), domain=QQ).gens  # SymPy's order, which decides signs
        self.rational = QQ.poly_ring(*ordered).ring
        names = [f"x{i}" for i in range(len(ordered))]
        self.context = flint.fmpz_mpoly_ctx.get(names, flint.Ordering.lex)
        self.zero, self.one = self.context.constant(0), self.context.constant(1)
        self.known: dict[Expr, Fraction] = {}
        self.size = 0
        self.variables = dict(zip(ordered, self.context.gens(), strict=True))

    @classmethod
    def of(cls, *matrices: Matrix) -> RationalFunctions | None:
        """Return what reads these matrices; None where they hold no symbols, or something else."""
        symbols = set().union(*(matrix.free_symbols for matrix in matrices))
        if not symbols or not all(isinstance(symbol, Symbol) for symbol in symbols):
            return None
        found = in_symbols(frozenset(symbols))
        try:
            for matrix in matrices:
                for entry in matrix.todok().values():
                    found.read(entry)
        except NotRationalError:
            return None
        return found

    def read(self, expression: Expr) -> Fraction:
        """Return an expression as a fraction; parts that occur again are read once."""
        found = self.known.get(expression)
        return self._remembered(expression, *self._computed(expression)) if found is None else found

    def _remembered(
        self, expression: Expr, above: flint.fmpz_mpoly, below: flint.fmpz_mpoly
    ) -> Fraction:
        """Keep what an expression is, so that the next matrix with it is read at once."""
        self.size += 1 + len(above) + len(below)
        if self.size > REMEMBERED:
            self.known, self.size = {}, 0
        self.known[expression] = above, below
        return above, below

    def _computed(self, expression: Expr) -> Fraction:
        if (x := self.variables.get(expression)) is not None:
            return x, self.one
        if expression.is_Rational:
            return self.one * int(expression.p), self.one * int(expression.q)
        if expression.is_Add:
            above, below = self.zero, self.one
            for term in expression.args:
                top, under = self.read(term)
                shared = below if below == under else below.gcd(under)
                above = above * (under / shared) + top * (below / shared)
                below = below * (under / shared)
            return above, below
        if expression.is_Mul:
            tops, unders = zip(*map(self.read, expression.args), strict=True)
            return prod(tops, start=self.one), prod(unders, start=self.one)
        if expression.is_Pow and expression.exp.is_Integer and abs(expression.exp) < LARGEST_POWER:
            above, below = self.read(expression.base)
            if expression.exp < 0:
                above, below = below, above
            if not below.is_zero():
                return above ** abs(int(expression.exp)), below ** abs(int(expression.exp))
        raise NotRationalError

    def over_one(self, entries: Sequence[Expr]) -> tuple[list[flint.fmpz_mpoly], flint.fmpz_mpoly]:
        """Return numerators over a least common denominator, and that denominator."""
        pairs, common = [], self.one
        for entry in entries:
            above, below = self.read(entry)
            if below != self.one:
                shared = above.gcd(below)
                above, below = above / shared, below / shared
                common = common * (below / common.gcd(below))
            pairs.append((above, below))
        return [above * (common / below) for above, below in pairs], common

    def write(self, above: flint.fmpz_mpoly, below: flint.fmpz_mpoly) -> Expr:
        """Return a fraction in lowest terms, as SymPy's fields write it."""
        if above.is_zero():
            return sympy.Integer(0)
        above, below = self.lowest(above, below)
        found = self.expression(above) / self.expression(below)
        self._remembered(found, above, below)
        return found

    def lowest(self, above: flint.fmpz_mpoly, below: flint.fmpz_mpoly) -> Fraction:
        """Return a fraction in lowest terms, its denominator with a positive leading one."""
        if below.is_one():
            return above, below
        shared = above.gcd(below)
        if below.leading_coefficient() < 0:
            shared = -shared
        return above / shared, below / shared

    def expression(self, poly: flint.fmpz_mpoly, over: int = 1) -> Expr:
        """Return a polynomial as an expression, over a number."""
        return self._in_ring(poly, over).as_expr()

    def polynomial(self, descending: Sequence[Fraction], variable: Symbol) -> Poly:
        """Return the polynomial with these coefficients, the first of them not zero."""
        lowest = [self.lowest(*pair) for pair in descending]
        if not all(below.is_constant() for _, below in lowest):
            return from_coefficients([self.write(*pair) for pair in lowest], variable)
        values = [self._in_ring(p, int(q.leading_coefficient())) for p, q in lowest]
        return canonical(Poly.new(DMP(values, self.rational.to_domain(), 0), variable))

    def _in_ring(self, poly: flint.fmpz_mpoly, over: int) -> PolyElement:
        terms = {tuple(map(int, p)): QQ(int(c), over) for p, c in poly.to_dict().items()}
        return self.rational.from_dict(terms)


@lru_cache(maxsize=8)
def in_symbols(symbols: frozenset[Symbol]) -> RationalFunctions:
    """Return the reader for these symbols, the same one again with what it has read.

    Examples
    --------
    >>> from sympy.abc import a
    >>> from compensator_theory.matrices.fraction_free import in_symbols
    >>> in_symbols(frozenset({a})) is in_symbols(frozenset({a}))
    True
    """
    return RationalFunctions(symbols)


class SymbolicRows:
    """Matrices of one height side by side, each row times its least common denominator.

    Attributes
    ----------
    rows : list of lists of flint.fmpz_mpoly
    scales : list of flint.fmpz_mpoly
        What each row was multiplied by.
    last : flint.fmpz_mpoly
        The minor that the reduced rows have as their common factor.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.fraction_free import SymbolicRows
    >>> system = SymbolicRows.of(Matrix([["1/a", 1], [0, "b"]]), Matrix([1, "b"]))
    >>> system.reduce(2)
    [0, 1]
    >>> system.quotients(range(2), [2])
    Matrix([
    [0],
    [1]])
    """

    def __init__(self, work: RationalFunctions, rows: Sequence[Sequence[Expr]]) -> None:
        self.work, self.last, self.sign = work, work.one, 1
        self.rows, self.scales = map(list, zip(*map(work.over_one, rows), strict=True))

    @classmethod
    def of(cls, *matrices: Matrix) -> SymbolicRows | None:
        """Read matrices of rational functions of symbols over QQ; None where they hold others."""
        if 0 in matrices[0].shape or (work := RationalFunctions.of(*matrices)) is None:
            return None
        grids = zip(*(matrix.tolist() for matrix in matrices), strict=True)
        return cls(work, [[entry for part in row for entry in part] for row in grids])

    def reduce(self, columns: int, *, shortest: bool = True) -> list[int]:
        """Bring the first columns to reduced echelon form, times `last`; return the pivots.

        With `shortest` the pivot of a column is its shortest entry, else its first.
        """
        pivots: list[int] = []
        for column in range(columns):
            k = len(pivots)
            below = [i for i in range(k, len(self.rows)) if not self.rows[i][column].is_zero()]
            if not below:
                continue
            place = min(below, key=lambda i: len(self.rows[i][column])) if shortest else below[0]
            if place != k:
                self.rows[k], self.rows[place] = self.rows[place], self.rows[k]
                self.sign = -self.sign
            self._clear_column(k, column)
            pivots.append(column)
            if len(pivots) == len(self.rows):
                break
        return pivots

    def _clear_column(self, k: int, column: int) -> None:
        """Bareiss's step: every entry stays a minor of the matrix, so that the division is exact.

        A row that is zero in the column is multiplied all the same, so that all have one factor.
        """
        chosen, pivot, before = self.rows[k], self.rows[k][column], self.last
        for i, row in enumerate(self.rows):
            if i != k:
                head = row[column]
                if not head.is_zero():
                    self.rows[i] = [
                        (pivot * x - head * y) / before for x, y in zip(row, chosen, strict=True)
                    ]
                elif pivot != before:
                    self.rows[i] = [x if x.is_zero() else pivot * x / before for x in row]
        self.last = pivot

    def quotients(self, rows: Sequence[int], columns: Sequence[int]) -> ImmutableMatrix:
        """Return entries of the reduced form, in lowest terms."""
        entries = [self.work.write(self.rows[i][j], self.last) for i in rows for j in columns]
        return ImmutableMatrix(len(rows), len(columns), entries)

    def minor(self) -> Expr:
        """The minor of the rows without denominators by which the reduced form was multiplied."""
        return self.work.expression(self.last)

    def determinant(self) -> Expr:
        """Return the determinant of a square matrix whose rows have all been reduced."""
        below, above = prod(self.scales, start=self.work.one), self.last * self.sign
        if below.is_constant():
            return self.work.expression(above, int(below.leading_coefficient()))
        return self.work.write(above, below)


def symbolic_product(*factors: Matrix) -> ImmutableMatrix | None:
    """Multiply matrices of rational functions over QQ; None where they hold something else.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrices.fraction_free import symbolic_product
    >>> symbolic_product(Matrix([["1/a", "b"]]), Matrix(["a", 0]))
    Matrix([[1]])
    """
    if (work := RationalFunctions.of(*factors)) is None:
        return None
    grids, below = [], work.one
    for factor in factors:
        numerators, common = work.over_one(list(factor))
        width = int(factor.cols)
        grids.append([numerators[k : k + width] for k in range(0, len(numerators), width)])
        below = below * common
    found = reduce(lambda left, right: _multiplied(work, left, right), grids)
    entries = [work.write(entry, below) for row in found for entry in row]
    return ImmutableMatrix(len(found), len(found[0]), entries)


def symbolic_characteristic_polynomial(matrix: Matrix, variable: Symbol) -> Poly | None:
    r"""Return det(sI - A) by Faddeev and LeVerrier; None for other than rational functions over QQ.

    .. math:: M_1 = I, \quad c_k = -\mathrm{tr}(A M_k)/k, \quad M_{k+1} = A M_k + c_k I

    Examples
    --------
    >>> from sympy import Matrix
    >>> from sympy.abc import s
    >>> from compensator_theory.matrices.fraction_free import symbolic_characteristic_polynomial
    >>> symbolic_characteristic_polynomial(Matrix([["1/a", 1], [0, "b"]]), s).as_expr().factor()
    (-b + s)*(a*s - 1)/a
    """
    if (work := RationalFunctions.of(matrix)) is None:
        return None
    n = int(matrix.rows)
    flat, common = work.over_one(list(matrix))
    A = [flat[k : k + n] for k in range(0, n * n, n)]
    found, below, product = [(work.one, work.one)], work.one, [list(row) for row in A]
    for k in range(1, n + 1):
        below = below * common
        c = -sum((product[i][i] for i in range(n)), start=work.zero) / k
        found.append((c, below))
        for i in range(n):
            product[i][i] = product[i][i] + c
        if k < n:
            product = _multiplied(work, A, product)
    return work.polynomial(found, variable)


Grid: TypeAlias = list[list[flint.fmpz_mpoly]]


def _multiplied(work: RationalFunctions, left: Grid, right: Grid) -> Grid:
    columns = list(zip(*right, strict=True))
    rows = [[(k, x) for k, x in enumerate(row) if not x.is_zero()] for row in left]
    return [[sum((x * c[k] for k, x in row), start=work.zero) for c in columns] for row in rows]


def vanish(expressions: Iterable[Expr]) -> list[bool | None]:
    """Tell of expressions whether they are zero for all values of their symbols.

    Returns
    -------
    list
        None for what is neither a rational number nor a rational function of symbols over QQ.

    Examples
    --------
    >>> from sympy.abc import a, b
    >>> from compensator_theory.matrices.fraction_free import vanish
    >>> vanish([1 / a + 1 / b - (a + b) / (a * b), a - b])
    [True, False]
    """
    given = list(expressions)
    symbols = {x for x in set().union(*(e.free_symbols for e in given)) if isinstance(x, Symbol)}
    work = in_symbols(frozenset(symbols)) if symbols else None
    found: list[bool | None] = []
    for expression in given:
        known: bool | None = None
        if expression.is_Rational:
            known = bool(expression == 0)
        elif work is not None:
            with suppress(NotRationalError):
                known = bool(work.read(expression)[0].is_zero())
        found.append(known)
    return found
