"""Arithmetic of transfer matrices over one denominator that never cancels anything."""

from __future__ import annotations

from collections.abc import Callable
from typing import Self, TypeAlias, cast

import sympy
from sympy import Expr, Matrix, MatrixBase, Poly, Rational
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import InputError
from compensator_theory.matrices.exact_matrices import MatrixLike, exact_matrix
from compensator_theory.polynomials.budget import ask
from compensator_theory.polynomials.numbers import NumberLike
from compensator_theory.polynomials.poly import canonical, from_expression
from compensator_theory.polynomials.reading import polynomial
from compensator_theory.transfer_functions.adjugates import adjugate_and_determinant
from compensator_theory.transfer_functions.arithmetic import (
    QuotientArithmetic,
    constant_one,
    product,
    sides_of,
)
from compensator_theory.transfer_functions.sample_times import shared_sample_time

Rows: TypeAlias = tuple[tuple[Poly, ...], ...]
Scalar: TypeAlias = QuotientArithmetic | NumberLike | Poly
"""What a transfer matrix is multiplied by, entry by entry."""
Operand: TypeAlias = "MatrixArithmetic | MatrixLike"
"""What is added to a transfer matrix, or multiplied with it as a matrix."""


class MatrixArithmetic:
    """The operators + - * @ of a class with a matrix of numerators over one denominator.

    Two matrices over one denominator are added over it, those over two different ones over their
    product; a product is over the product of both, and nothing cancels. ``@`` multiplies matrices
    (constant ones of SymPy or nested lists included), ``*`` does so too between two transfer
    matrices, and by a number, text or transfer function it multiplies every entry.

    Examples
    --------
    >>> from compensator_theory import transfer_matrix
    >>> G = transfer_matrix([["1/(s + 1)", 2]])
    >>> print(G + G, "a" * G, sep=", ")
    [[2, 4*s + 4]]/(s + 1), [[a, 2*a*s + 2*a]]/(s + 1)
    >>> print(G @ [[1], ["b"]], G - [[0, 2]], sep=", ")
    [[2*b*s + (2*b + 1)]]/(s + 1), [[1, 0]]/(s + 1)
    """

    numerators: Rows
    denominator: Poly

    sample_time: Rational | None

    def __init__(
        self, numerators: Rows, denominator: Poly, *, sample_time: Rational | None = None
    ) -> None:
        """Every class that derives from this one is made of these."""
        raise NotImplementedError

    __array_ufunc__ = None  # an array times a transfer matrix comes to __rmatmul__, not to a loop
    _op_priority = 30.0  # so does a matrix of SymPy

    def __add__(self, other: Operand) -> Self:
        return self._join(other, lambda a, b: _added(a, b, 1))

    def __radd__(self, other: Operand) -> Self:
        return self._join(other, lambda a, b: _added(b, a, 1))

    def __sub__(self, other: Operand) -> Self:
        return self._join(other, lambda a, b: _added(a, b, -1))

    def __rsub__(self, other: Operand) -> Self:
        return self._join(other, lambda a, b: _added(b, a, -1))

    def __neg__(self) -> Self:
        return self._with(tuple(tuple(-n for n in row) for row in self.numerators))

    def __pos__(self) -> Self:
        return self

    def __matmul__(self, other: Operand) -> Self:
        return self._join(other, _multiplied)

    def __rmatmul__(self, other: Operand) -> Self:
        return self._join(other, lambda a, b: _multiplied(b, a))

    def __mul__(self, other: Operand | Scalar) -> Self:
        if _is_matrix(other):
            return self._join(cast(Operand, other), _multiplied)
        return self._scaled(cast(Scalar, other))

    def __rmul__(self, other: Operand | Scalar) -> Self:
        if _is_matrix(other):
            return self._join(cast(Operand, other), lambda a, b: _multiplied(b, a))
        return self._scaled(cast(Scalar, other))

    @property
    def T(self) -> Self:
        """The transpose."""
        return self._with(tuple(zip(*self.numerators, strict=True)))

    def reduced(self) -> Self:
        """Return the same matrix without the factor that all entries share with the denominator."""
        common = self.denominator
        for entry in (entry for row in self.numerators for entry in row):
            common = common.gcd(entry)
        if common.degree() < 1:
            return self
        rows = tuple(tuple(_quotient(e, common) for e in row) for row in self.numerators)
        return self._with(rows, _quotient(self.denominator, common))

    def inverse(self) -> Self:
        """Return the inverse of a square matrix, reduced; InputError if it is singular."""
        rows, columns = len(self.numerators), len(self.numerators[0])
        if rows != columns:
            raise InputError(f"a {rows} x {columns} transfer matrix is not square")
        s = self.denominator.gen
        entries = [[entry.as_expr() for entry in row] for row in self.numerators]
        square = DomainMatrix.from_Matrix(Matrix(entries))
        adjugate, determinant = adjugate_and_determinant(square)
        domain = adjugate.domain
        below = from_expression(domain.to_sympy(determinant), s)
        if below.is_zero:
            raise InputError("the transfer matrix is singular; it has no inverse")
        top = [[from_expression(domain.to_sympy(e), s) for e in r] for r in adjugate.to_list()]
        found = tuple(tuple(product(entry, self.denominator) for entry in row) for row in top)
        return self._with(found, below).reduced()

    def _scaled(self, factor: Scalar) -> Self:
        sides = sides_of(factor, self.denominator.gen)
        if sides is None:
            return cast(Self, NotImplemented)
        rows = tuple(tuple(product(entry, sides[0]) for entry in row) for row in self.numerators)
        period = shared_sample_time(self, factor)
        return type(self)(rows, product(self.denominator, sides[1]), sample_time=period)

    def _join(
        self, other: Operand, operation: Callable[[MatrixSides, MatrixSides], MatrixSides]
    ) -> Self:
        sides = _matrix_sides(other, self.denominator)
        if sides is None:
            return cast(Self, NotImplemented)  # Python then asks the other operand
        joined = operation((self.numerators, self.denominator), sides)
        return type(self)(*joined, sample_time=shared_sample_time(self, other))

    def _with(self, numerators: Rows, denominator: Poly | None = None) -> Self:
        below = self.denominator if denominator is None else denominator
        return type(self)(numerators, below, sample_time=self.sample_time)


MatrixSides: TypeAlias = tuple[Rows, Poly]


def _is_matrix(obj: object) -> bool:
    return isinstance(obj, MatrixArithmetic | MatrixBase | list | tuple) or (
        hasattr(obj, "shape") and not isinstance(obj, Expr) and obj.shape != ()
    )


def _matrix_sides(operand: Operand, like: Poly) -> MatrixSides | None:
    if isinstance(operand, MatrixArithmetic):
        if operand.denominator.gen != like.gen:
            raise InputError(
                f"one transfer matrix is in {operand.denominator.gen} and the other in {like.gen}; "
                "both need one variable"
            )
        return operand.numerators, operand.denominator
    if not _is_matrix(operand):
        return None
    matrix = exact_matrix(operand, "the constant matrix")
    if like.gen in matrix.free_symbols:
        raise InputError(
            f"the matrix contains the variable {like.gen}; make it a transfer matrix first, with "
            "transfer_matrix(...)"
        )
    rows = [[polynomial(entry, like.gen) for entry in row] for row in matrix.tolist()]
    return tuple(map(tuple, rows)), constant_one(like)


def _added(a: MatrixSides, b: MatrixSides, sign: int) -> MatrixSides:
    shapes = [(len(rows), len(rows[0]) if rows else 0) for rows, _ in (a, b)]
    if shapes[0] != shapes[1]:
        (p, m), (k, l) = shapes  # noqa: E741
        raise InputError(f"a {p} x {m} matrix and a {k} x {l} matrix have no sum")
    one = constant_one(a[1])
    over_one = a[1] == b[1]
    left, right = (one, one) if over_one else (b[1], a[1])
    rows = tuple(
        tuple(
            canonical(product(x, left) + sign * product(y, right))
            for x, y in zip(r, q, strict=True)
        )
        for r, q in zip(a[0], b[0], strict=True)
    )
    return rows, a[1] if over_one else product(a[1], b[1])


def _multiplied(a: MatrixSides, b: MatrixSides) -> MatrixSides:
    inner = len(a[0][0]) if a[0] else 0
    if not b[0] or inner != len(b[0]):
        raise InputError(
            f"a {len(a[0])} x {inner} matrix and one with {len(b[0])} rows have no product"
        )
    ask("entries", len(a[0]) * len(b[0]) * len(b[0][0]), "the product")
    columns = list(zip(*b[0], strict=True))
    rows = tuple(
        tuple(
            canonical(sum((product(x, y) for x, y in zip(row, column, strict=True)), _zero(a[1])))
            for column in columns
        )
        for row in a[0]
    )
    return rows, product(a[1], b[1])


def _quotient(poly: Poly, divisor: Poly) -> Poly:
    top, bottom = poly.unify(divisor)
    field = top.domain.get_field()
    return canonical(top.set_domain(field).quo(bottom.set_domain(field)))


def _zero(like: Poly) -> Poly:
    return Poly(0, like.gen, domain=sympy.QQ)
