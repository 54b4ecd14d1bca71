"""Left and right coprime fractions of a transfer matrix, and the Bezout identity of both."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless
from compensator_theory.forms._equivalence import differences
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    denominators,
    joint_ring,
    read_into,
    written,
)
from compensator_theory.matrices._certificates import Certified, Residuals, proven
from compensator_theory.matrices._elimination import Elimination
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._rings import Grid, Ring, identity, multiply
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._poly import monic
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_matrices import TransferMatrix


@dataclass(frozen=True)
class CoprimeFractions(Certified, ExactValue):
    r"""A transfer matrix as fractions of polynomial matrices without common factors.

    .. math:: G = N_r D_r^{-1} = D_l^{-1} N_l, \qquad
              \begin{bmatrix} X_r & Y_r \\ -N_l & D_l \end{bmatrix}
              \begin{bmatrix} D_r & -Y_l \\ N_r & X_l \end{bmatrix} = I

    Attributes
    ----------
    source : TransferMatrix
        G, p x m.
    D_r, N_r : PolynomialMatrix
        m x m and p x m, right coprime; D_r is in Hermite form by columns, lower triangular.
    D_l, N_l : PolynomialMatrix
        p x p and p x m, left coprime; D_l is in Hermite form by rows, upper triangular.
    X_r, Y_r : PolynomialMatrix
        m x m and m x p, X_r D_r + Y_r N_r = I; entries of Y_r are of lower degree than the pivot
        of D_l in their column.
    X_l, Y_l : PolynomialMatrix
        p x p and m x p, N_l Y_l + D_l X_l = I.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    """

    identity = "[[X_r, Y_r], [-N_l, D_l]] [[D_r, -Y_l], [N_r, X_l]] = I, G D_r = N_r, D_l G = N_l"

    source: TransferMatrix
    D_r: PolynomialMatrix
    N_r: PolynomialMatrix
    D_l: PolynomialMatrix
    N_l: PolynomialMatrix
    X_r: PolynomialMatrix
    Y_r: PolynomialMatrix
    X_l: PolynomialMatrix
    Y_l: PolynomialMatrix
    exceptional: tuple[Expr, ...]

    def _residuals(self) -> Residuals:
        numerators = PolynomialMatrix(self.source.numerators)
        below = PolynomialMatrix(((self.source.denominator,),))
        right, left = (
            (self.D_r, self.N_r, self.X_l, self.Y_l),
            (self.D_l, self.N_l, self.X_r, self.Y_r),
        )
        ring = joint_ring(numerators, below, *right, *left)
        N, d = read_into(ring, numerators), read_into(ring, below)[0][0]
        D_r, N_r, X_l, Y_l = (read_into(ring, part) for part in right)
        D_l, N_l, X_r, Y_r = (read_into(ring, part) for part in left)
        first = _joined_rows(X_r, Y_r) + _joined_rows(_negated(N_l), D_l)
        second = _joined_rows(D_r, _negated(Y_l)) + _joined_rows(N_r, X_l)
        scaled = [[[d * entry for entry in row] for row in grid] for grid in (N_r, N_l)]
        pairs = [
            (multiply(ring, first, second), identity(ring, len(first))),
            (multiply(ring, N, D_r), scaled[0]),
            (multiply(ring, D_l, N), scaled[1]),
        ]
        return differences(ring, pairs)

    @property
    def pole_polynomial(self) -> Poly:
        """The monic determinant of D_l, which is that of D_r: the finite poles."""
        return monic(self.D_l.determinant())

    @property
    def order(self) -> int:
        """Number of finite poles with multiplicity."""
        return sum(int(self.D_l[i, i].degree()) for i in range(self.D_l.shape[0]))

    def __str__(self) -> str:
        return f"({self.N_r}) ({self.D_r})^-1 = ({self.D_l})^-1 ({self.N_l})"

    def _repr_latex_(self) -> str:
        right = rf"{latex(self.N_r)} {latex(self.D_r)}^{{-1}}"
        left = rf"{latex(self.D_l)}^{{-1}} {latex(self.N_l)}"
        return displayed(
            rf"G = N_r D_r^{{-1}} = {right} = D_l^{{-1}} N_l = {left}", unless(self.exceptional)
        )


@carrying()
def coprime_fractions(
    G: TransferMatrixLike, variable: str | Symbol | None = None
) -> CoprimeFractions:
    r"""Write a transfer matrix as a right and a left coprime fraction, with Bezout identities.

    .. math:: U \begin{bmatrix} d\,I \\ N \end{bmatrix} = \begin{bmatrix} R \\ 0 \end{bmatrix},
              \qquad U = \begin{bmatrix} X_r & Y_r \\ -N_l & D_l \end{bmatrix}, \quad
              U^{-1} = \begin{bmatrix} D_r & -Y_l \\ N_r & X_l \end{bmatrix}, \qquad G = \frac Nd

    Parameters
    ----------
    G : transfer matrix
        Anything :func:`transfer_matrix` reads, of any shape, improper ones too.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Raises
    ------
    InputError, BudgetError
        If it cannot be read, or is too large.

    Notes
    -----
    One elimination gives all eight matrices; the fractions are then put into Hermite form, in which
    they are unique. Every other coprime fraction is (N_r Z)(D_r Z)^-1 with Z unimodular, and every
    stabilising compensator comes from the eight (Youla and Kucera). Source: M. Vidyasagar, Control
    System Synthesis (1985), Section 4.1; T. Kailath, Linear Systems (1980), Section 6.3.

    Examples
    --------
    >>> from compensator_theory import coprime_fractions
    >>> G = [["1/(s + 1)", "2/(s + 1)"], ["-1/((s + 1)*(s + 2))", "1/(s + 2)"]]
    >>> fractions = coprime_fractions(G)
    >>> print(fractions.D_l, fractions.N_l, fractions.order)
    [[s + 1, 0], [0, s**2 + 3*s + 2]] [[1, 2], [-1, s + 1]] 3
    >>> print(fractions.X_r @ fractions.D_r + fractions.Y_r @ fractions.N_r)
    [[1, 0], [0, 1]]
    """
    source = transfer_matrix(G, variable)
    inputs = source.shape[1]
    numerators = PolynomialMatrix(source.numerators)
    ring = joint_ring(numerators, PolynomialMatrix(((source.denominator,),)))
    N, d = read_into(ring, numerators), ring.read(source.denominator)
    top = [[d * entry for entry in row] for row in identity(ring, inputs)]
    stacked = Elimination(ring, top + N)
    stacked.triangulate()
    X_r, Y_r = _columns(stacked.U[:inputs], inputs)
    minus_N_l, D_l = _columns(stacked.U[inputs:], inputs)
    D_r, minus_Y_l = _columns(stacked.U_inverse[:inputs], inputs)
    N_r, X_l = _columns(stacked.U_inverse[inputs:], inputs)
    # D_l to Hermite form by rows: W [-N_l D_l], and W^-1 from the right on the opposite blocks.
    left = Elimination(ring, D_l)
    left.triangulate()
    D_l, minus_N_l = left.matrix, multiply(ring, left.U, minus_N_l)
    minus_Y_l, X_l = (multiply(ring, x, left.U_inverse) for x in (minus_Y_l, X_l))
    # D_r to Hermite form by columns, which are the rows of its transpose.
    right = Elimination(ring, _transposed(D_r))
    right.triangulate()
    Z, Z_inverse = _transposed(right.U), _transposed(right.U_inverse)
    D_r, N_r = (multiply(ring, x, Z) for x in (D_r, N_r))
    X_r, Y_r = (multiply(ring, Z_inverse, x) for x in (X_r, Y_r))
    # [X_r Y_r] + K [-N_l D_l] is as good; K divides Y_r by the triangular D_l.
    K = _quotient(ring, Y_r, D_l)
    X_r, Y_r = (_sum(x, multiply(ring, K, y)) for x, y in ((X_r, minus_N_l), (Y_r, D_l)))
    minus_Y_l, X_l = (
        _sum(x, _negated(multiply(ring, y, K))) for x, y in ((minus_Y_l, D_r), (X_l, N_r))
    )
    blocks = (D_r, N_r, D_l, _negated(minus_N_l), X_r, Y_r, X_l, _negated(minus_Y_l))
    results = [written(ring, block) for block in blocks]
    exceptional = exceptional_factors(denominators(*results))
    a, b, c, e, f, g, h, i = results
    fractions = CoprimeFractions(source, a, b, c, e, f, g, h, i, exceptional)
    proven(fractions.certificate, "fraction")
    return fractions


def _joined_rows(a: Grid, b: Grid) -> Grid:
    return [x + y for x, y in zip(a, b, strict=True)]


def _columns(rows: Grid, at: int) -> tuple[Grid, Grid]:
    return [row[:at] for row in rows], [row[at:] for row in rows]


def _transposed(grid: Grid) -> Grid:
    return [list(column) for column in zip(*grid, strict=True)]


def _negated(grid: Grid) -> Grid:
    return [[-entry for entry in row] for row in grid]


def _sum(a: Grid, b: Grid) -> Grid:
    return [[x + y for x, y in zip(r, q, strict=True)] for r, q in zip(a, b, strict=True)]


def _quotient(ring: Ring, Y: Grid, D: Grid) -> Grid:
    """Return K such that each entry of Y + K D is of lower degree than the pivot in its column."""
    work = [list(row) for row in Y]
    K = [[ring.zero] * len(D) for _ in Y]
    for i, row in enumerate(work):
        for j in range(len(D)):
            factor = -ring.divide(row[j], D[j][j])[0]
            K[i][j] = factor
            row[j:] = [x + factor * y for x, y in zip(row[j:], D[j][j:], strict=True)]
    return K
