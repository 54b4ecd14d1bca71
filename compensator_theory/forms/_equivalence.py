"""What row and column operations made of a polynomial matrix, with proof."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sympy import Expr, S

from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    denominators,
    joint_ring,
    read_into,
    written,
)
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._elimination import Elimination
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._rings import Grid, Ring, identity, multiply


@dataclass(frozen=True)
class Equivalence:
    """Unimodular matrices and what they make of a polynomial matrix, U P V = F.

    Attributes
    ----------
    form : PolynomialMatrix
        F.
    U, V, U_inverse, V_inverse : PolynomialMatrix
        After row operations alone V is the identity.
    exceptional : tuple of sympy.Expr
        Irreducible factors of what they are divided by.
    certificate : Certificate
        The products, multiplied out anew.
    """

    form: PolynomialMatrix
    U: PolynomialMatrix
    V: PolynomialMatrix
    U_inverse: PolynomialMatrix
    V_inverse: PolynomialMatrix
    exceptional: tuple[Expr, ...]
    certificate: Certificate


def elimination_of(matrix: PolynomialMatrix) -> Elimination:
    """Return a polynomial matrix ready for elementary operations."""
    ring = joint_ring(matrix)
    return Elimination(ring, read_into(ring, matrix))


def by_rows(work: Elimination, law: str) -> Equivalence:
    """Return what row operations made, with the certificate of U P = F and U U^-1 = I.

    Examples
    --------
    >>> from compensator_theory import polynomial_matrix
    >>> from compensator_theory.forms._equivalence import by_rows, elimination_of
    >>> work = elimination_of(polynomial_matrix([["s"], ["s**2 + 1"]]))
    >>> rank = work.triangulate()
    >>> print(by_rows(work, "U P = F, U U^-1 = I").form)
    [[1], [0]]
    """
    return _equivalence(work, law, _row_products(work, multiply(work.ring, work.U, work.given)))


def by_rows_and_columns(work: Elimination, law: str) -> Equivalence:
    """Return what operations made, with the certificate of U P V = F and of both inverses.

    Examples
    --------
    >>> from compensator_theory import polynomial_matrix
    >>> from compensator_theory.forms._equivalence import (
    ...     by_rows_and_columns, elimination_of)
    >>> work = elimination_of(polynomial_matrix([["s", 1]]))
    >>> work.swap_columns(0, 1)
    >>> print(by_rows_and_columns(work, "U P V = F, U U^-1 = I, V V^-1 = I").form)
    [[1, s]]
    """
    ring = work.ring
    product = multiply(ring, multiply(ring, work.U, work.given), work.V)
    inverses = (multiply(ring, work.V, work.V_inverse), identity(ring, work.columns))
    return _equivalence(work, law, [*_row_products(work, product), inverses])


def certificate_of_products(
    ring: Ring, law: str, pairs: Iterable[tuple[Grid, Grid]], what: str = "form"
) -> Certificate:
    """Compare matrices pair by pair, entry by entry.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.forms._equivalence import certificate_of_products
    >>> from compensator_theory.matrices._rings import ring_of
    >>> ring = ring_of([polynomial("s")])
    >>> certificate_of_products(ring, "1 = 1", [([[ring.one]], [[ring.one]])]).holds
    True
    """
    left = [
        [S.Zero if x == y else ring.write(x - y).as_expr() for x, y in zip(row, other, strict=True)]
        for a, b in pairs
        for row, other in zip(a, b, strict=True)
    ]
    return certificate_of(law, left, what)


def _row_products(work: Elimination, product: Grid) -> list[tuple[Grid, Grid]]:
    inverses = multiply(work.ring, work.U, work.U_inverse)
    return [(product, work.matrix), (inverses, identity(work.ring, work.rows))]


def _equivalence(work: Elimination, law: str, pairs: Sequence[tuple[Grid, Grid]]) -> Equivalence:
    grids = (work.matrix, work.U, work.V, work.U_inverse, work.V_inverse)
    form, U, V, U_inverse, V_inverse = (written(work.ring, grid) for grid in grids)
    exceptional = exceptional_factors(denominators(form, U, V, U_inverse, V_inverse))
    certificate = certificate_of_products(work.ring, law, pairs)
    return Equivalence(form, U, V, U_inverse, V_inverse, exceptional, certificate)
