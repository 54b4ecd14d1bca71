"""The matrices of a regulator problem, read once, and their balls."""

from __future__ import annotations

import flint
import sympy
from sympy import ImmutableMatrix, Matrix

from compensator_theory._latex import table
from compensator_theory.errors import InputError
from compensator_theory.matrices._exact_matrices import MatrixLike, exact_matrix
from compensator_theory.matrices._flint_matrices import is_rational_matrix, zero_matrix
from compensator_theory.polynomials._budget import repr_of
from compensator_theory.roots._enclosures import Enclosure, ball_of_number, enclosure_of_ball
from compensator_theory.systems._standard_problems import StandardProblem

EnclosedMatrix = tuple[tuple[Enclosure, ...], ...]
RegulatorData = tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]
Weights = tuple[ImmutableMatrix, ImmutableMatrix, ImmutableMatrix, ImmutableMatrix, ImmutableMatrix]
"""(A, B, Q, R, N)."""

_weights_of_a_signal = (
    "; for z = E_1 x + E_2 u the weights are Q = E_1'E_1, R = E_2'E_2 and N = E_1'E_2"
)


def regulator_data(
    A: MatrixLike,
    B: MatrixLike,
    E_1: MatrixLike,
    E_2: MatrixLike | None,
    *,
    symbols: bool = False,
) -> RegulatorData:
    r"""Read the data of a regulator, :math:`z = E_1 x + E_2 u`, rational or with symbols."""
    a, b, e_1 = exact_matrix(A, "A"), exact_matrix(B, "B"), exact_matrix(E_1, "E_1")
    e_2 = zero_matrix(e_1.rows, b.cols) if E_2 is None else exact_matrix(E_2, "E_2")
    shapes = {"A": (a.rows, a.rows), "B": (a.rows, b.cols)}
    shapes |= {"E_1": (e_1.rows, a.rows), "E_2": (e_1.rows, b.cols)}
    for (name, shape), matrix in zip(shapes.items(), (a, b, e_1, e_2), strict=True):
        if matrix.shape != shape or 0 in shape:
            raise InputError(
                f"{name} is {matrix.rows} x {matrix.cols} but must be {shape[0]} x {shape[1]}, as "
                "the other matrices show, and not empty"
            )
        if not symbols:
            _require_rational(matrix, name)
    return a, b, e_1, e_2


def read_weights(
    A: MatrixLike,
    B: MatrixLike,
    Q: MatrixLike | None = None,
    R: MatrixLike | None = None,
    N: MatrixLike | None = None,
    E_1: MatrixLike | None = None,
    E_2: MatrixLike | None = None,
    *,
    symbols: bool = False,
    names: tuple[str, ...] = ("A", "B", "Q", "R", "N"),
) -> Weights:
    """Read the data of a regulator as (A, B, Q, R, N), from a signal z or from weights.

    The names are those that errors use, which an estimator has of its own.
    """
    if (E_1 is None) == (Q is None) or (E_1 is not None and not (R is None is N)):
        raise InputError(
            "give the weights either as Q, R and N, or as E_1 and E_2, with z = E_1 x + E_2 u"
        )
    if E_1 is not None:
        a, b, e_1, e_2 = regulator_data(A, B, E_1, E_2, symbols=symbols)
        return a, b, e_1.T * e_1, e_2.T * e_2, e_1.T * e_2
    if E_2 is not None:
        raise InputError("E_2 goes with E_1; with Q give R and N")
    assert Q is not None
    a, b = exact_matrix(A, names[0]), exact_matrix(B, names[1])
    n, m = int(a.rows), int(b.cols)
    read = [a, b, exact_matrix(Q, names[2])]
    read.append(zero_matrix(m, m) if R is None else exact_matrix(R, names[3]))
    read.append(zero_matrix(n, m) if N is None else exact_matrix(N, names[4]))
    shapes = ((n, n), (n, m), (n, n), (m, m), (n, m))
    for name, shape, matrix in zip(names, shapes, read, strict=True):
        if matrix.shape != shape or 0 in shape:
            raise InputError(
                f"{name} is {matrix.rows} x {matrix.cols} but must be {shape[0]} x {shape[1]}, as "
                "the other matrices show, and not empty"
                + _weights_of_a_signal
                * (name in ("Q", "R"))
            )
        if not symbols:
            _require_rational(matrix, name)
        if name in (names[2], names[3]) and matrix != matrix.T:
            raise InputError(
                f"{name} = {matrix.tolist()} is not symmetric; give ({name} + {name}')/2"
            )
    return tuple(read)


def _require_rational(matrix: ImmutableMatrix, name: str) -> None:
    if not is_rational_matrix(matrix):
        raise InputError(
            f"{name} has entries that are not rational numbers; substitute rational numbers for "
            "the symbols (riccati_formula takes them for orders 1 and 2)"
        )


def regulator_and_estimator(plant: object) -> tuple[RegulatorData, RegulatorData]:
    """Return the data of both problems of a plant, that of the estimator in its dual form."""
    if not isinstance(plant, StandardProblem):
        raise InputError(
            f"{repr_of(plant)} is not a StandardProblem: a plant alone defines neither "
            "disturbance nor cost. Give lqg_problem(plant, Q, R, W, V), or standard_problem(G), "
            "where the measurement is weighed and the disturbance is matched. In float64, "
            "rcac_numeric.lqg_controller takes a plant"
        )
    return (
        (plant.A, plant.B, plant.E_1, plant.E_2),
        (plant.A.T, plant.C.T, plant.D_1.T, plant.D_2.T),
    )


def ball_matrix(matrix: Matrix) -> flint.arb_mat:
    """Return a rational matrix in balls, at python-flint's working precision."""
    return flint.arb_mat([[ball_of_number(entry) for entry in row] for row in matrix.tolist()])


def enclosed_rows(matrix: flint.arb_mat) -> EnclosedMatrix:
    """Return a matrix of balls as enclosures."""
    return tuple(tuple(enclosure_of_ball(entry) for entry in row) for row in matrix.tolist())


def approximately(matrix: EnclosedMatrix) -> str:
    r"""Write the centres of an enclosed matrix in LaTeX, to eight digits."""
    return table([[sympy.N(entry.centre, 8) for entry in row] for row in matrix])
