"""What solves a linear equation for a matrix: one solution, all of them, and where that holds."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import sympy
from sympy import Expr, ImmutableMatrix, Matrix

from compensator_theory.errors import NoSolutionError
from compensator_theory.matrices.certificates import Certificate
from compensator_theory.polynomials.budget import ask
from compensator_theory.polynomials.values import ExactValue
from compensator_theory.structure.echelon import echelon, exceptional_factors


@dataclass(frozen=True)
class MatrixSolution(ExactValue):
    """Every solution of a linear equation for a matrix X.

    Attributes
    ----------
    X : sympy.ImmutableMatrix
        One solution.
    homogeneous : tuple of sympy.ImmutableMatrix
        A basis of what can be added to it; empty where X is the only solution.
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero. For
        values where one is, solve again with these values: there may be no solution or a family.
    certificate : Certificate
        The equation, evaluated anew for X and for the basis.
    """

    X: ImmutableMatrix
    homogeneous: tuple[ImmutableMatrix, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    @property
    def is_unique(self) -> bool:
        """Whether X is the only solution."""
        return not self.homogeneous

    def __str__(self) -> str:
        count = len(self.homogeneous)
        return f"X = {self.X.tolist()}" + (f", one of a family of dimension {count}" * bool(count))


def solve_by_columns(
    image: Callable[[Matrix], Sequence[Expr]],
    shape: tuple[int, int],
    right: Sequence[Expr],
    *,
    contradiction: str,
    sources: Iterable[Matrix] = (),
) -> tuple[ImmutableMatrix, tuple[ImmutableMatrix, ...], list[Expr]]:
    """Solve a linear equation for a matrix as one system of n m unknowns (Kronecker).

    Parameters
    ----------
    image : callable
        The linear map, from a matrix of that shape to a list of expressions.
    shape : tuple of int
        Of the unknown.
    right : sequence of sympy.Expr
        What the image is to be.
    contradiction : str
        What to say where there is no solution.
    sources : iterable of sympy.Matrix
        Data whose denominators count as divisors.

    Returns
    -------
    tuple
        A solution, a basis of the homogeneous ones, and what was divided by.

    Examples
    --------
    >>> from compensator_theory.matrix_equations.solutions import solve_by_columns
    >>> X, more, _ = solve_by_columns(lambda X: [X[0, 0] + X[0, 1]], (1, 2), [3], contradiction="")
    >>> X, len(more)
    (Matrix([[3, 0]]), 1)
    """
    rows, columns = shape
    ask("entries", len(right) * (rows * columns + 1), "the linear system of the matrix equation")
    units = []
    for k in range(rows * columns):
        unit = Matrix.zeros(rows, columns)
        unit[k // columns, k % columns] = 1
        units.append(list(image(unit)))
    table = Matrix(len(right), len(units), lambda i, j: units[j][i])
    found = echelon(table.row_join(Matrix(len(right), 1, list(right))))
    size = len(units)
    divisors = [found.divided_by, *denominators_of(sources)]
    if size in found.pivots:
        raise NoSolutionError(contradiction)
    particular = Matrix.zeros(size, 1)
    for row, pivot in enumerate(found.pivots):
        particular[pivot] = found.matrix[row, size]
    kernel = found.kernel()[:size, :-1]  # the last column belongs to the right side
    basis = [kernel[:, k] for k in range(kernel.cols)]
    X, *more = (ImmutableMatrix(rows, columns, list(v)) for v in (particular, *basis))
    return X, tuple(more), divisors


def denominators_of(matrices: Iterable[Matrix]) -> list[Expr]:
    """Return the denominators of all entries that have symbols in them.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrix_equations.solutions import denominators_of
    >>> denominators_of([Matrix([["1/a", "2*b"]])])
    [a]
    """
    bottoms = (
        sympy.fraction(sympy.cancel(entry))[1]
        for matrix in matrices
        for entry in matrix
        if entry.free_symbols
    )
    return [bottom for bottom in dict.fromkeys(bottoms) if bottom.free_symbols]


def certified(
    identity: str,
    residuals: Iterable[Matrix],
    X: ImmutableMatrix,
    homogeneous: tuple[ImmutableMatrix, ...],
    divisors: Iterable[Expr],
) -> MatrixSolution:
    """Put a solution together with what is left of its equation; refuse a wrong one.

    Raises
    ------
    NoSolutionError
        If something is left: then the computation before was wrong.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from compensator_theory.matrix_equations.solutions import certified
    >>> zero = ImmutableMatrix([[0]])
    >>> certified("0 = 0", [zero], zero, (), []).certificate.holds
    True
    """
    certificate = certificate_of(identity, residuals)
    return MatrixSolution(X, homogeneous, exceptional_factors(divisors), certificate)


def certificate_of(identity: str, residuals: Iterable[Matrix]) -> Certificate:
    """Return the certificate of matrices that must vanish.

    Raises
    ------
    NoSolutionError
        If one does not.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.matrix_equations.solutions import certificate_of
    >>> certificate_of("0 = 0", [Matrix([[0]])]).holds
    True
    """
    entries = (entry for matrix in residuals for entry in matrix)
    left = [entry if entry.is_Rational else sympy.cancel(entry) for entry in entries]
    certificate = Certificate(identity, ImmutableMatrix(1, len(left), left))
    if not certificate.holds:
        raise NoSolutionError(f"{certificate}; the result is wrong, please report it")
    return certificate
