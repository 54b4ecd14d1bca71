"""A polynomial matrix and its form under unimodular row and column operations."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from sympy import Expr, ImmutableMatrix, Poly, S

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    denominators,
    joint_ring,
    read_into,
    written,
)
from compensator_theory.matrices._certificates import (
    Certificate,
    Certified,
    Residuals,
    certificate_of,
    proven,
)
from compensator_theory.matrices._diagonalisation import diagonalise
from compensator_theory.matrices._elimination import Elimination
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._rings import Grid, Ring, identity, multiply
from compensator_theory.polynomials._values import ExactValue


@dataclass(frozen=True)
class Equivalence(Certified, ExactValue):
    r"""A form F of a polynomial matrix P, and the unimodular matrices that lead to it.

    .. math:: U P V = F

    Attributes
    ----------
    matrix, form : PolynomialMatrix
        P and F, both p x m; rows of zeros come last.
    U, V, U_inverse, V_inverse : PolynomialMatrix
        p x p and m x m, unimodular: their inverses are polynomial too. V is the identity after row
        operations alone. F of Smith, Hermite and Popov is unique; U and V need not be.
    rank : int
        The normal rank, the number of rows of F that are not zero.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; F is the form where none of them is zero, and there
        may be another one where one is. Empty without symbols.

    Examples
    --------
    >>> from compensator_theory.forms import popov_form
    >>> form = popov_form([["s**2", "s**2 + 1"], ["s", "s"]])
    >>> print(form, form.row_degrees, form.pivots)
    [[0, 1], [s, 0]] (0, 1) (1, 0)
    >>> print(form.certificate)
    U P V = F, U U^-1 = I, V V^-1 = I: holds exactly
    """

    identity: ClassVar[str] = "U P V = F, U U^-1 = I, V V^-1 = I"

    matrix: PolynomialMatrix
    form: PolynomialMatrix
    U: PolynomialMatrix
    V: PolynomialMatrix
    U_inverse: PolynomialMatrix
    V_inverse: PolynomialMatrix
    rank: int
    exceptional: tuple[Expr, ...]

    @property
    def row_degrees(self) -> tuple[int, ...]:
        """The largest degree in each row of F that is not zero."""
        rows = self.form.rows[: self.rank]
        return tuple(max(int(e.degree()) for e in row if not e.is_zero) for row in rows)

    @property
    def pivots(self) -> tuple[int, ...]:
        """The column of the last entry of largest degree in each row of F that is not zero.

        In Popov's form they differ, and each pivot is monic and of larger degree than all other
        entries of its column.
        """
        rows = zip(self.form.rows, self.row_degrees, strict=False)
        return tuple(
            max(k for k, e in enumerate(row) if not e.is_zero and e.degree() == degree)
            for row, degree in rows
        )

    @property
    def leading_matrix(self) -> ImmutableMatrix:
        """The coefficients of the powers `row_degrees` in F, row by row."""
        s = self.form.variable
        return ImmutableMatrix(
            self.rank,
            self.form.shape[1],
            [
                entry.coeff_monomial(s**degree)
                for row, degree in zip(self.form.rows, self.row_degrees, strict=False)
                for entry in row
            ],
        )

    @property
    def invariant_polynomials(self) -> tuple[Poly, ...]:
        """The monic invariant polynomials of P, each a divisor of the next: Smith's diagonal."""
        diagonal = _diagonal(self.form)
        if diagonal is None:
            work = elimination_of(self.form)
            diagonalise(work)
            diagonal = _diagonal(written(work.ring, work.matrix)) or ()
        return diagonal

    @property
    def elementary_divisors(self) -> tuple[tuple[Poly, int], ...]:
        """Powers of irreducible polynomials: all factors of all invariant polynomials."""
        return tuple(
            (factor.monic(), power)
            for invariant in self.invariant_polynomials
            for factor, power in invariant.factor_list()[1]
        )

    def _residuals(self) -> Residuals:
        matrices = self.matrix, self.form, self.U, self.V, self.U_inverse, self.V_inverse
        ring = joint_ring(*matrices)
        P, F, U, V, U_inverse, V_inverse = (read_into(ring, matrix) for matrix in matrices)
        inverses = [(multiply(ring, U, U_inverse), U), (multiply(ring, V, V_inverse), V)]
        units = [(product, identity(ring, len(grid))) for product, grid in inverses]
        return differences(ring, [(multiply(ring, multiply(ring, U, P), V), F), *units])

    def __str__(self) -> str:
        return str(self.form)

    def _repr_latex_(self) -> str:
        by_rows = self.V.as_matrix().is_Identity
        factors = [latex(self.U_inverse), latex(self.form)]
        factors += [] if by_rows else [latex(self.V_inverse)]
        law = "U^{-1} F" if by_rows else r"U^{-1} F\, V^{-1}"
        return displayed(
            rf"P = {latex(self.matrix)} = {law} = {''.join(factors)}", unless(self.exceptional)
        )


def elimination_of(matrix: PolynomialMatrix) -> Elimination:
    """Return a polynomial matrix ready for elementary operations."""
    ring = joint_ring(matrix)
    return Elimination(ring, read_into(ring, matrix))


def equivalence_of(source: PolynomialMatrix, work: Elimination, rank: int) -> Equivalence:
    """Return the form after elementary operations, with its certificate checked."""
    grids = (work.matrix, work.U, work.V, work.U_inverse, work.V_inverse)
    form, U, V, U_inverse, V_inverse = (written(work.ring, grid) for grid in grids)
    exceptional = exceptional_factors(denominators(form, U, V, U_inverse, V_inverse))
    result = Equivalence(source, form, U, V, U_inverse, V_inverse, rank, exceptional)
    proven(result.certificate, "form")
    return result


def certificate_of_products(
    ring: Ring, law: str, pairs: Iterable[tuple[Grid, Grid]]
) -> Certificate:
    """Compare matrices pair by pair, entry by entry."""
    return certificate_of(law, differences(ring, pairs), "form")


def differences(ring: Ring, pairs: Iterable[tuple[Grid, Grid]]) -> list[list[Expr]]:
    """Return the differences of pairs of matrices, row by row."""
    return [
        [S.Zero if x == y else ring.write(x - y).as_expr() for x, y in zip(row, other, strict=True)]
        for a, b in pairs
        for row, other in zip(a, b, strict=True)
    ]


def _diagonal(form: PolynomialMatrix) -> tuple[Poly, ...] | None:
    """The invariant polynomials on the diagonal of a Smith form; None of another matrix."""
    rows, columns = form.shape
    places = [(i, j) for i in range(rows) for j in range(columns) if not form[i, j].is_zero]
    entries = tuple(form[i, j] for i, j in places)
    if places != [(i, i) for i in range(len(places))] or any(e.LC() != 1 for e in entries):
        return None
    return entries if all(b.rem(a).is_zero for a, b in pairwise(entries)) else None
