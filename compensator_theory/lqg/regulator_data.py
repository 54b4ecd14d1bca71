"""The matrices of a regulator problem, read once, and their balls."""

import flint
import sympy
from sympy import ImmutableMatrix, Matrix, Poly, Rational, Symbol

from compensator_theory.errors import InputError, NotControllableError
from compensator_theory.latex import table
from compensator_theory.matrices.exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices.flint_matrices import is_rational_matrix
from compensator_theory.matrices.linear_algebra import rank
from compensator_theory.polynomials.budget import shown
from compensator_theory.roots.enclosures import Enclosure, ball_of_number, enclosure_of_ball
from compensator_theory.systems.standard_problems import StandardProblem
from compensator_theory.systems.state_space import transfer_matrix_of_realisation

EnclosedMatrix = tuple[tuple[Enclosure, ...], ...]
RegulatorData = tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]


def regulator_data(
    A: MatrixLike, B: MatrixLike, E_1: MatrixLike, E_2: MatrixLike | None
) -> RegulatorData:
    r"""Read the data of a regulator, :math:`z = E_1 x + E_2 u`, whose entries are rational.

    Raises
    ------
    InputError
        If a shape does not fit or an entry is symbolic.

    Examples
    --------
    >>> from compensator_theory.lqg.regulator_data import regulator_data
    >>> regulator_data([[2]], [[1]], [[3]], None)[3]
    Matrix([[0]])
    """
    a, b, e_1 = exact_matrix(A, "A"), exact_matrix(B, "B"), exact_matrix(E_1, "E_1")
    e_2 = ImmutableMatrix.zeros(e_1.rows, b.cols) if E_2 is None else exact_matrix(E_2, "E_2")
    shapes = {"A": (a.rows, a.rows), "B": (a.rows, b.cols)}
    shapes |= {"E_1": (e_1.rows, a.rows), "E_2": (e_1.rows, b.cols)}
    for (name, shape), matrix in zip(shapes.items(), (a, b, e_1, e_2), strict=True):
        if matrix.shape != shape or 0 in shape:
            raise InputError(
                f"{name} is {matrix.rows} x {matrix.cols} but must be {shape[0]} x {shape[1]}, as "
                "the other matrices show, and not empty"
            )
        if not is_rational_matrix(matrix):
            raise InputError(f"{name} has entries that are not rational numbers; substitute them")
    return a, b, e_1, e_2


def regulator_and_estimator(plant: object) -> tuple[RegulatorData, RegulatorData]:
    """Return the data of both problems of a plant, that of the estimator in its dual form.

    Raises
    ------
    InputError
        If it is no StandardProblem.

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.lqg.regulator_data import regulator_and_estimator
    >>> regulator_and_estimator(standard_problem("2/(q - 3)"))[0][:2]
    (Matrix([[3]]), Matrix([[1]]))
    """
    if not isinstance(plant, StandardProblem):
        raise InputError(f"{shown(plant)} is not a StandardProblem; see standard_problem()")
    return (
        (plant.A, plant.B, plant.E_1, plant.E_2),
        (plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T),
    )


def state_numerators(
    A: ImmutableMatrix, B: ImmutableMatrix, variable: Symbol
) -> tuple[Poly, ImmutableMatrix]:
    r"""Return det(sI - A), and W with adj(sI - A) B = W' (s^(n-1), ..., 1)' for one input.

    The gain K that moves the first to another polynomial solves W K' = their difference.

    Raises
    ------
    NotControllableError
        If W is singular, so that the closed-loop polynomial does not determine the gain.

    Examples
    --------
    >>> from sympy import ImmutableMatrix
    >>> from sympy.abc import q
    >>> from compensator_theory.lqg.regulator_data import state_numerators
    >>> A, B = ImmutableMatrix([[0, 1], [-2, -3]]), ImmutableMatrix([[0], [1]])
    >>> print(*state_numerators(A, B, q))
    Poly(q**2 + 3*q + 2, q, domain='QQ') Matrix([[0, 1], [1, 0]])
    """
    n = A.rows
    states = transfer_matrix_of_realisation(A, B, sympy.eye(n), sympy.zeros(n, 1), variable)
    W = ImmutableMatrix(
        n, n, lambda i, j: states[j, 0].numerator.coeff_monomial(variable ** (n - 1 - i))
    )
    if rank(W) < n:
        raise NotControllableError(
            f"(A, B) has {n - rank(W)} uncontrollable mode(s), so the closed-loop polynomial does "
            "not determine the gain; remove them from the realisation first"
        )
    return states.denominator, W


def ball_matrix(matrix: Matrix) -> flint.arb_mat:
    """Return a rational matrix in balls, at python-flint's working precision.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.lqg.regulator_data import ball_matrix
    >>> ball_matrix(Matrix([["1/2"]]))[0, 0]
    0.500000000000000
    """
    return flint.arb_mat([[ball_of_number(entry) for entry in row] for row in matrix.tolist()])


def enclosed_rows(matrix: flint.arb_mat) -> EnclosedMatrix:
    """Return a matrix of balls as enclosures.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.lqg.regulator_data import ball_matrix, enclosed_rows
    >>> enclosed_rows(ball_matrix(Matrix([["1/2"]])))
    ((1/2,),)
    """
    return tuple(tuple(enclosure_of_ball(entry) for entry in row) for row in matrix.tolist())


def exact_rows(matrix: Matrix) -> EnclosedMatrix:
    """Return a rational matrix as enclosures of radius 0.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.lqg.regulator_data import exact_rows
    >>> exact_rows(Matrix([["1/2"]]))
    ((1/2,),)
    """
    return tuple(tuple(Enclosure(entry, Rational(0)) for entry in row) for row in matrix.tolist())


def approximately(matrix: EnclosedMatrix) -> str:
    r"""Write the centres of an enclosed matrix in LaTeX, to eight digits.

    Examples
    --------
    >>> from sympy import Matrix
    >>> from compensator_theory.lqg.regulator_data import approximately, exact_rows
    >>> print(approximately(exact_rows(Matrix([["1/3"]]))))
    \left[\begin{matrix}0.33333333\end{matrix}\right]
    """
    return table([[sympy.N(entry.centre, 8) for entry in row] for row in matrix])
