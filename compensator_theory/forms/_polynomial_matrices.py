"""Matrices of exact polynomials in one variable."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Number
from typing import TypeAlias

import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol

from compensator_theory._latex import displayed, table
from compensator_theory._terminal import matrix_repr
from compensator_theory.errors import InputError
from compensator_theory.matrices._linear_algebra import determinant
from compensator_theory.matrices._rings import Grid, Ring, multiply, ring_of
from compensator_theory.polynomials._budget import ask, quoted
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._generic_answers import holds_where_defined
from compensator_theory.polynomials._numbers import NumberLike
from compensator_theory.polynomials._poly import canonical, from_expression
from compensator_theory.polynomials._reading import PolynomialLike, polynomial
from compensator_theory.polynomials._substitution import Substitutions, with_values
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix


@dataclass(frozen=True, repr=False)
class PolynomialMatrix(ExactValue):
    r"""A p x m matrix of exact polynomials in one variable.

    .. math:: P(s) = P_k s^k + \cdots + P_1 s + P_0

    Parameters
    ----------
    rows : tuple of tuples of sympy.Poly
        p rows of m entries in one variable; at least one of each.

    Raises
    ------
    InputError
        If the rows have different lengths, there are none, or the variables differ.

    Examples
    --------
    >>> from compensator_theory import polynomial_matrix
    >>> P = polynomial_matrix([["s + 1", "a"], [0, "s"]])
    >>> print(P @ P, P.determinant(), sep=", ")
    [[s**2 + 2*s + 1, 2*a*s + a], [0, s**2]], Poly(s**2 + s, s, domain='QQ')
    """

    _CARRIES = True

    rows: tuple[tuple[Poly, ...], ...]

    def __post_init__(self) -> None:
        if not self.rows or not self.rows[0] or len({len(row) for row in self.rows}) != 1:
            raise InputError("a polynomial matrix needs rows of one and the same nonzero length")
        rows = tuple(tuple(polynomial(entry) for entry in row) for row in self.rows)
        if len({entry.gen for row in rows for entry in row}) != 1:
            raise InputError("the entries of a polynomial matrix need one variable")
        object.__setattr__(self, "rows", rows)

    @property
    def variable(self) -> Symbol:
        """Variable of all entries."""
        return self.rows[0][0].gen

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and of columns."""
        return len(self.rows), len(self.rows[0])

    @property
    def degree(self) -> int:
        """Largest degree of an entry; -1 if all are zero."""
        return max(-1 if e.is_zero else int(e.degree()) for row in self.rows for e in row)

    @property
    def T(self) -> PolynomialMatrix:
        """The transpose."""
        return PolynomialMatrix(tuple(zip(*self.rows, strict=True)))

    def __getitem__(self, index: tuple[int, int]) -> Poly:
        row, column = index
        return self.rows[row][column]

    def __call__(self, point: Expr) -> ImmutableMatrix:
        """Return the value at a number or an expression."""
        value = sympy.sympify(point)
        return ImmutableMatrix([[entry.eval(value) for entry in row] for row in self.rows])

    def as_matrix(self) -> ImmutableMatrix:
        """Return a SymPy matrix of expressions."""
        return ImmutableMatrix([[entry.as_expr() for entry in row] for row in self.rows])

    def evalf(self, digits: int = 15) -> ImmutableMatrix:
        """Return a SymPy matrix with floats of so many digits, to look at.

        Examples
        --------
        >>> from compensator_theory import polynomial_matrix
        >>> polynomial_matrix([["s + 1/3", "sqrt(2)"]], "s").evalf(4)
        Matrix([[s + 0.3333, 1.414]])
        """
        return self.as_matrix().evalf(digits)

    def subs(self, values: Substitutions, value: NumberLike | None = None) -> PolynomialMatrix:
        """Give values to symbols of the coefficients, as :meth:`TransferFunction.subs` does."""
        return with_values(self, values, value, self.variable)

    def determinant(self) -> Poly:
        """Return the determinant of a square matrix."""
        return from_expression(determinant(self.as_matrix()), self.variable)

    def __add__(self, other: PolynomialMatrix) -> PolynomialMatrix:
        return self._entrywise(other, 1)

    def __sub__(self, other: PolynomialMatrix) -> PolynomialMatrix:
        return self._entrywise(other, -1)

    def __neg__(self) -> PolynomialMatrix:
        return PolynomialMatrix(tuple(tuple(-entry for entry in row) for row in self.rows))

    def __matmul__(self, other: PolynomialMatrix) -> PolynomialMatrix:
        if not isinstance(other, PolynomialMatrix):
            return NotImplemented
        if self.shape[1] != other.shape[0]:
            raise InputError(f"matrices of shapes {self.shape} and {other.shape} have no product")
        ring = joint_ring(self, other)
        return written(ring, multiply(ring, read_into(ring, self), read_into(ring, other)))

    def __mul__(self, other: PolynomialMatrix | PolynomialLike) -> PolynomialMatrix:
        """The product, as in SymPy; of a number or a polynomial, of every entry."""
        if isinstance(other, PolynomialMatrix):
            return self @ other
        if not isinstance(other, Poly | Expr | Number | str):
            return NotImplemented
        factor = polynomial(other, self.variable)
        return PolynomialMatrix(
            tuple(tuple(canonical(factor * entry) for entry in row) for row in self.rows)
        )

    def __rmul__(self, other: PolynomialLike) -> PolynomialMatrix:
        return self * other

    def __pow__(self, exponent: int) -> PolynomialMatrix:
        """A product of so many equal square matrices; I for 0."""
        if not isinstance(exponent, int) or exponent < 0 or self.shape[0] != self.shape[1]:
            raise InputError(
                f"a power of a {self.shape[0]} x {self.shape[1]} matrix to {exponent} is not "
                "polynomial; square matrices have powers 0, 1, 2, ..."
            )
        ask("degree", self.degree * exponent, "the power of a polynomial matrix")
        size = range(self.shape[0])
        result = PolynomialMatrix(
            tuple(tuple(polynomial(int(i == j), self.variable) for j in size) for i in size)
        )
        for _ in range(exponent):
            result = result @ self
        return result

    def _entrywise(self, other: PolynomialMatrix, sign: int) -> PolynomialMatrix:
        if not isinstance(other, PolynomialMatrix):
            return NotImplemented
        if self.shape != other.shape:
            raise InputError(f"matrices of shapes {self.shape} and {other.shape} have no sum")
        rows = zip(self.rows, other.rows, strict=True)
        return PolynomialMatrix(
            tuple(
                tuple(canonical(a + sign * b) for a, b in zip(r, q, strict=True)) for r, q in rows
            )
        )

    def __str__(self) -> str:
        rows = ["[" + ", ".join(map(format_polynomial, row)) + "]" for row in self.rows]
        return f"[{', '.join(rows)}]"

    def __repr__(self) -> str:
        return matrix_repr("PolynomialMatrix", str(self), self.shape)

    def _repr_latex_(self) -> str:
        return displayed(table(self.rows))


PolynomialMatrixLike: TypeAlias = PolynomialMatrix | TransferMatrixLike
"""Input types of :func:`polynomial_matrix`."""


@holds_where_defined
@carrying()
def polynomial_matrix(
    rows: PolynomialMatrixLike, variable: str | Symbol | None = None
) -> PolynomialMatrix:
    """Make an exact polynomial matrix out of rows of polynomials.

    Parameters
    ----------
    rows : nested sequences, sympy.Matrix, TransferMatrix over 1, or PolynomialMatrix
        Entries are anything :func:`transfer_function` reads that is a polynomial.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Raises
    ------
    InputError
        If an entry is no polynomial, the rows are not of one length, or the variable is not
        evident.

    Examples
    --------
    >>> from compensator_theory import polynomial_matrix
    >>> polynomial_matrix([["s", 1], [0, "2*s + 1"]]).determinant()
    Poly(2*s**2 + s, s, domain='QQ')
    """
    if isinstance(rows, PolynomialMatrix):
        return rows
    read = transfer_matrix(rows, variable)
    if read.denominator.degree() > 0:
        raise InputError(
            f"this is no polynomial matrix: it has the denominator {quoted(read.denominator)}"
        )
    return PolynomialMatrix(read.numerators)


def denominators(*matrices: PolynomialMatrix) -> list[Expr]:
    """Return the denominators of the coefficients, polynomials in the symbols.

    An identity between polynomial matrices holds for all values of the symbols where none of these
    is zero, whatever was divided by on the way to it.
    """
    factors: dict[Expr, None] = {}
    for poly in (entry for matrix in matrices for row in matrix.rows for entry in row):
        if poly.domain.is_FractionField:
            for coefficient in poly.rep.to_list():
                bottom = poly.domain.denom(coefficient)
                factors[poly.domain.get_ring().to_sympy(bottom)] = None
    return [bottom for bottom in factors if bottom.free_symbols]


def joint_ring(*matrices: PolynomialMatrix) -> Ring:
    """Return the ring that has the entries of all matrices."""
    if len({matrix.variable for matrix in matrices}) != 1:
        raise InputError("the matrices are in different variables; both need one variable")
    return ring_of(entry for matrix in matrices for row in matrix.rows for entry in row)


def read_into(ring: Ring, matrix: PolynomialMatrix) -> Grid:
    """Return the entries as elements of a ring."""
    ask("degree", max(matrix.shape) * max(1, matrix.degree), "the polynomial matrix")
    return [[ring.read(entry) for entry in row] for row in matrix.rows]


def written(ring: Ring, grid: Grid) -> PolynomialMatrix:
    """Return a matrix of elements as one of SymPy's polynomials."""
    return PolynomialMatrix(tuple(tuple(ring.write(entry) for entry in row) for row in grid))
