"""Diophantine equations between polynomial matrices: the least solution and all others."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Poly, Symbol

from compensator_theory._latex import displayed, latex, unless, words
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.forms._minimal_bases import MinimalBasis, minimal_basis
from compensator_theory.forms._polynomial_matrices import (
    PolynomialMatrix,
    PolynomialMatrixLike,
    denominators,
    joint_ring,
    polynomial_matrix,
    read_into,
    written,
)
from compensator_theory.matrices._certificates import (
    Certificate,
    Certified,
    Residuals,
    evaluated,
    proven,
)
from compensator_theory.matrices._elimination import Elimination
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._rings import Element, Grid, Ring, multiply
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._letters import fresh, names_in_all
from compensator_theory.polynomials._reading import is_one_of
from compensator_theory.polynomials._values import ExactValue

IDENTITY = {"right": "A X + B Y = C", "left": "X A + Y B = C"}  # keyed by the side of the unknowns


@dataclass(frozen=True)
class MatrixDiophantineSolution(Certified, ExactValue):
    r"""Every solution of A X + B Y = C, or of X A + Y B = C.

    .. math:: \begin{bmatrix} X \\ Y \end{bmatrix} + M T, \qquad
              \begin{bmatrix} A & B \end{bmatrix} M = 0, \quad T \text{ any polynomial matrix}

    Attributes
    ----------
    A, B, C : PolynomialMatrix
        As given.
    side : {"right", "left"}
        On which side of A and B the unknowns stand.
    X, Y : PolynomialMatrix
        The solution of which each column (each row, for the unknowns on the left) has the least
        degree that a solution can have.
    kernel : MinimalBasis
        Of [A B], or of the transpose of [A; B] for the unknowns on the left.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; the identity holds where none of them is zero.
    """

    _CARRIES = True

    A: PolynomialMatrix
    B: PolynomialMatrix
    C: PolynomialMatrix
    side: str
    X: PolynomialMatrix
    Y: PolynomialMatrix
    kernel: MinimalBasis
    exceptional: tuple[Expr, ...]

    @property
    def certificate(self) -> Certificate:
        """The equation, evaluated anew from the fields of this result."""
        return evaluated(IDENTITY[self.side], self._residuals())

    def _residuals(self) -> Residuals:
        A, B, X, Y = self.A, self.B, self.X, self.Y
        total = A @ X + B @ Y if self.side == "right" else X @ A + Y @ B
        return [(total - self.C).as_matrix()]

    @property
    def is_unique(self) -> bool:
        """Whether there is no other solution, of whatever degree."""
        return self.kernel.basis is None

    @property
    def degrees(self) -> tuple[int, ...]:
        """Least degree of each column (or row) of the unknowns, -1 for zero."""
        columns = _columns(self.X, self.side), _columns(self.Y, self.side)
        return tuple(
            max(-1 if e.is_zero else int(e.degree()) for e in (*x, *y))
            for x, y in zip(*columns, strict=True)
        )

    def number_of_parameters(self, degree: int) -> int:
        """Return how many free numbers each column (or row) has among solutions up to a degree."""
        return sum(max(0, degree - index + 1) for index in self.kernel.indices)

    def member(self, T: PolynomialMatrixLike) -> tuple[PolynomialMatrix, PolynomialMatrix]:
        """Return the solution for a parameter T, k x (columns of C), or (rows of C) x k.

        Raises
        ------
        InputError
            If the solution is unique, or the shape of T does not fit.
        """
        if self.kernel.basis is None:
            raise InputError("this solution is unique; it has no parameter")
        T_matrix = polynomial_matrix(T, self.A.variable)
        right = self.side == "right"
        width = self.C.shape[1 if right else 0]
        parameter = T_matrix if right else T_matrix.T
        needed = (self.kernel.basis.shape[1], width)
        if parameter.shape != needed:
            needed_shape = needed if right else needed[::-1]
            raise InputError(f"the parameter is {T_matrix.shape}; it must be {needed_shape}")
        added = self.kernel.basis @ parameter
        size = self.X.shape[0 if right else 1]
        parts = PolynomialMatrix(added.rows[:size]), PolynomialMatrix(added.rows[size:])
        x, y = parts if right else (parts[0].T, parts[1].T)
        return self.X + x, self.Y + y

    def __str__(self) -> str:
        return f"X = {self.X}\nY = {self.Y}"

    def _repr_latex_(self) -> str:
        equation = "A X + B Y = C" if self.side == "right" else "X A + Y B = C"
        solution = (f"X = {latex(self.X)}", f"Y = {latex(self.Y)}")
        more = ""
        if self.kernel.basis is not None:
            basis, T = self.kernel.basis, latex(fresh(names_in_all(self), "T"))
            more = (
                rf"{words('and')} \; {latex(basis)}\, {T}"
                if self.side == "right"
                else rf"{words('and')} \; {T}\, {latex(basis.T)}"
            )
        return displayed(equation, *solution, more, unless(self.exceptional))


@carrying()
def solve_matrix_diophantine(
    A: PolynomialMatrixLike,
    B: PolynomialMatrixLike,
    C: PolynomialMatrixLike,
    *,
    side: str = "right",
    variable: str | Symbol | None = None,
) -> MatrixDiophantineSolution:
    r"""Solve A X + B Y = C, or X A + Y B = C, for polynomial matrices X and Y.

    .. math:: A X + B Y = C \quad\text{(side = "right")}, \qquad
              X A + Y B = C \quad\text{(side = "left")}

    Parameters
    ----------
    A, B, C : polynomial matrix
        p x k, p x m and p x q for unknowns on the right; k x p, m x p and q x p for those on the
        left. With symbols, for generic values of them.
    variable : str or Symbol, optional
        As for :func:`polynomial_matrix`.
    side : {"right", "left"}
        On which side of A and B the unknowns stand.

    Returns
    -------
    MatrixDiophantineSolution
        With X, Y of least degree, column by column (row by row): a solution minus combinations of
        a minimal basis of the null space, until its leading coefficients are independent of theirs.

    Raises
    ------
    NoSolutionError
        If there is none: a common left (right) divisor of A and B does not divide C.
    InputError, BudgetError
        If the shapes do not fit, something is no polynomial matrix, or too large.

    Notes
    -----
    Source: T. Kailath, Linear Systems (1980), Section 6.3; for the least degrees, G. D. Forney,
    SIAM J. Control 13 (1975).

    Examples
    --------
    >>> from compensator_theory import solve_matrix_diophantine
    >>> D_l, N_l = [["s - 1", 0], [0, "s"]], [["1"], ["s + 1"]]
    >>> solution = solve_matrix_diophantine(D_l, N_l, [["s**2", 0], [0, "s**2"]], variable="s")
    >>> print(solution.X, solution.Y)
    [[s, 0], [-s - 1, s]] [[s, 0]]
    >>> solution.degrees, solution.kernel.indices, solution.number_of_parameters(2)
    ((1, 1), (2,), 1)
    """
    if not is_one_of(side, IDENTITY):
        raise InputError(f"side = {repr_of(side)} must be 'right' or 'left'")
    matrices = [polynomial_matrix(matrix, variable) for matrix in (A, B, C)]
    a, b, c = matrices if side == "right" else [matrix.T for matrix in matrices]
    if not a.shape[0] == b.shape[0] == c.shape[0]:
        lines = "rows" if side == "right" else "columns"
        raise InputError(
            f"A, B and C have the shapes {', '.join(str(m.shape) for m in matrices)}; for "
            f"unknowns on the {side} they need equally many {lines}"
        )
    joined = PolynomialMatrix(tuple(x + y for x, y in zip(a.rows, b.rows, strict=True)))
    ring = joint_ring(a, b, c)
    kernel = minimal_basis(joined)
    particular = _particular(ring, read_into(ring, joined.T), read_into(ring, c.T))
    if kernel.basis is not None:
        basis = read_into(ring, kernel.basis.T)
        particular = [_least(ring, row, basis, kernel.indices) for row in particular]
    member = written(ring, particular)
    size = a.shape[1]
    x = PolynomialMatrix(tuple(row[:size] for row in member.rows))
    y = PolynomialMatrix(tuple(row[size:] for row in member.rows))
    X, Y = (x.T, y.T) if side == "right" else (x, y)
    exceptional = exceptional_factors([*denominators(X, Y), *kernel.exceptional])
    one, two, right = matrices
    result = MatrixDiophantineSolution(one, two, right, side, X, Y, kernel, exceptional)
    proven(result.certificate, "solution")
    return result


def _particular(ring: Ring, stacked: Grid, target: Grid) -> Grid:
    """Return Z with Z [A B]' = C', row by row, from the Hermite form of [A B]'."""
    work = Elimination(ring, stacked)
    rank = work.triangulate()
    pivots = [
        next(j for j, e in enumerate(row) if ring.degree(e) >= 0) for row in work.matrix[:rank]
    ]
    weights = []
    for row in target:
        rest, factors = list(row), []
        for pivot, line in zip(pivots, work.matrix, strict=False):
            factor, remainder = ring.divide(rest[pivot], line[pivot])
            if ring.degree(remainder) >= 0:
                break
            factors.append(factor)
            rest = [x - factor * y for x, y in zip(rest, line, strict=True)]
        if len(factors) < rank or any(ring.degree(e) >= 0 for e in rest):
            divisor = written(ring, work.matrix[: max(rank, 1)])
            left = rest if len(factors) == rank else [remainder]
            parts = written(ring, [left]).rows[0]
            used = [written(ring, grid) for grid in (work.matrix, work.U, work.U_inverse, [left])]
            raise NoSolutionError(
                f"the equation has no solution: all combinations of A and B are multiples of the "
                f"Hermite form {divisor} of the two together, and C is not"
            ).holding([c for part in parts for c in part.all_coeffs()], denominators(*used))
        weights.append(factors)
    if not rank:
        return [[ring.zero] * len(stacked) for _ in target]
    return multiply(ring, weights, work.U[:rank])


def _least(ring: Ring, row: list[Element], basis: Grid, indices: tuple[int, ...]) -> list[Element]:
    """Reduce the degrees of the rows until their leading coefficients are independent."""
    while (degree := max(map(ring.degree, row))) >= 0:
        usable = [i for i, index in enumerate(indices) if index <= degree]
        leading = [[ring.coefficient(e, indices[i]) for e in basis[i]] for i in usable]
        work = Elimination(ring, [*leading, [ring.coefficient(e, degree) for e in row]])
        rank = work.triangulate()
        if rank > len(usable):
            break
        relation = work.U[rank]
        inverse = ring.reciprocal_of_leading(relation[-1])
        for i, weight in zip(usable, relation, strict=False):
            factor = ring.power(degree - indices[i]) * weight * inverse
            row = [x + factor * y for x, y in zip(row, basis[i], strict=True)]
    return row


def _columns(matrix: PolynomialMatrix, side: str) -> tuple[tuple[Poly, ...], ...]:
    return matrix.T.rows if side == "right" else matrix.rows
