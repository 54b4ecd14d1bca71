"""Exact linear algebra: python-flint for rational matrices, polynomial rings for symbolic ones."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from operator import mul

import sympy
from sympy import Expr, ImmutableMatrix, Matrix, Poly, Symbol
from sympy.polys.domains.domainelement import DomainElement
from sympy.polys.matrices import DomainMatrix
from sympy.polys.matrices.exceptions import DMNonInvertibleMatrixError

from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._domain_matrices import divided_by, domain_matrices
from compensator_theory.matrices._echelon import echelon, has_full_rank
from compensator_theory.matrices._flint_matrices import (
    from_flint,
    rational,
    rational_in_flint,
    symbols_in,
    zero_matrix,
)
from compensator_theory.matrices._flint_polynomials import from_flint_polynomial
from compensator_theory.matrices._fraction_free import (
    SymbolicRows,
    symbolic_characteristic_polynomial,
)
from compensator_theory.matrices._symbolic_matrices import (
    product_with_symbols,
    symbolic_matrix,
)
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue


@dataclass(frozen=True)
class AffineSolution(ExactValue):
    """Every solution of a linear system: one of them plus the span of a basis.

    Attributes
    ----------
    particular : sympy.ImmutableMatrix
        Column; its free components are 0.
    nullspace : tuple of sympy.ImmutableMatrix
        Basis columns; empty if the solution is unique.
    """

    particular: ImmutableMatrix
    nullspace: tuple[ImmutableMatrix, ...]


def determinant(matrix: Matrix) -> Expr:
    """Return the determinant, expanded."""
    _require_square(matrix)
    if (raw := rational_in_flint(matrix)) is not None:
        return rational(raw.det())
    if (symbolic := SymbolicRows.of(matrix)) is not None:
        full = len(symbolic.reduce(matrix.cols)) == matrix.rows
        return symbolic.determinant() if full else sympy.Integer(0)
    (domain_matrix,) = domain_matrices(matrix)
    constant_term = domain_matrix.charpoly()[-1]  # division-free
    sign = -1 if matrix.rows % 2 else 1
    return domain_matrix.domain.to_sympy(sign * constant_term)


def rank(matrix: Matrix) -> int:
    """Return the rank; with symbols, the rank for generic values of the symbols."""
    if 0 in matrix.shape:
        return 0
    if (raw := rational_in_flint(matrix)) is not None:
        if has_full_rank(raw.numer_denom()[0]):
            return int(min(matrix.shape))
        return int(raw.rref()[1])
    if (symbolic := SymbolicRows.of(matrix)) is not None:
        if has_full_rank(symbolic.at_a_point()):  # the rank at a point is never larger
            return int(min(matrix.shape))
        return len(symbolic.reduce(matrix.cols))
    return len(domain_matrices(matrix)[0].rref_den()[2])


def characteristic_polynomial(matrix: Matrix, variable: Symbol) -> Poly:
    r"""Return the monic characteristic polynomial :math:`\det(sI - A)`."""
    _require_square(matrix)
    if matrix.rows == 0:
        return canonical(Poly(1, variable))
    if (raw := rational_in_flint(matrix)) is not None:
        return from_flint_polynomial(raw.charpoly(), variable)
    if variable in matrix.free_symbols:
        raise InputError(
            f"the matrix contains {variable}, the variable of its characteristic polynomial; name "
            "another one, as in variable='x'"
        )
    if (symbolic := symbolic_characteristic_polynomial(matrix, variable)) is not None:
        return symbolic
    (domain_matrix,) = domain_matrices(matrix)
    domain = domain_matrix.domain
    return canonical(Poly([domain.to_sympy(c) for c in domain_matrix.charpoly()], variable))


def solve(matrix: Matrix, right_side: Matrix) -> ImmutableMatrix:
    """Solve a square system with exactly one solution."""
    _require_square(matrix)
    _require_rows(matrix, right_side)
    singular = f"the {matrix.rows} x {matrix.cols} matrix is singular; use solve_affine"
    raw, column = rational_in_flint(matrix), rational_in_flint(right_side)
    if raw is not None and column is not None:
        try:
            return from_flint(raw.solve(column))
        except ZeroDivisionError as error:
            raise NoSolutionError(singular) from error
    if (symbolic := SymbolicRows.of(matrix, right_side)) is not None:
        if len(symbolic.reduce(matrix.cols)) < matrix.rows:
            raise NoSolutionError(singular)
        columns = range(matrix.cols, matrix.cols + right_side.cols)
        return symbolic.quotients(range(matrix.rows), columns)
    left, right = domain_matrices(matrix, right_side)
    try:
        numerator, denominator = left.solve_den(right)
    except DMNonInvertibleMatrixError as error:
        raise NoSolutionError(singular) from error
    return _quotient(numerator, denominator)


def solve_affine(matrix: Matrix, right_side: Matrix) -> AffineSolution:
    """Solve a system of any shape: one solution and a basis of the homogeneous ones."""
    _require_rows(matrix, right_side)
    if matrix.rows == matrix.cols:
        try:
            return AffineSolution(solve(matrix, right_side), ())
        except NoSolutionError:
            pass
    reduced = echelon(matrix.row_join(right_side))
    if matrix.cols in reduced.pivots:
        raise NoSolutionError(
            f"the {matrix.rows} equations for {matrix.cols} unknowns contradict each other"
        )
    return AffineSolution(*reduced.solutions())


def in_lowest_terms(matrix: Matrix) -> ImmutableMatrix:
    """Return the same matrix with every rational function of symbols in lowest terms."""
    if (symbolic := symbolic_matrix(matrix)) is not None:
        return symbolic
    return ImmutableMatrix(matrix.applyfunc(sympy.cancel) if symbols_in(matrix) else matrix)


def multiplied(*factors: Matrix) -> ImmutableMatrix:
    """Return a product of matrices, with symbols in lowest terms, without SymPy's expansion."""
    if any(0 in factor.shape for factor in factors):
        return zero_matrix(factors[0].rows, factors[-1].cols)
    raw = [rational_in_flint(factor) for factor in factors]
    if all(factor is not None for factor in raw):
        return from_flint(reduce(mul, raw))
    if (product := product_with_symbols(*factors)) is not None:
        return product
    fields = [factor.to_field() for factor in domain_matrices(*factors)]
    return ImmutableMatrix(reduce(mul, fields).to_Matrix())


def _quotient(numerator: DomainMatrix, denominator: DomainElement) -> ImmutableMatrix:
    return ImmutableMatrix(divided_by(numerator, denominator).to_Matrix())


def _require_square(matrix: Matrix) -> None:
    if matrix.rows != matrix.cols:
        raise InputError(f"the matrix is {matrix.rows} x {matrix.cols}; it must be square")


def _require_rows(matrix: Matrix, right_side: Matrix) -> None:
    if matrix.rows != right_side.rows:
        raise InputError(
            f"the matrix has {matrix.rows} rows and the right side has {right_side.rows}; "
            "they must agree"
        )
