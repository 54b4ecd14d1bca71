"""Equality of answers: as expressions, however they are written."""

import sympy

from compensator_theory import TransferFunction, TransferMatrix
from compensator_theory.results import Enclosure, PolynomialMatrix


def as_matrix(answer):
    """A number, a text, a polynomial, a transfer function, a matrix or rows: as a matrix."""
    if isinstance(answer, PolynomialMatrix | TransferMatrix):
        return sympy.Matrix(answer.as_matrix())
    if isinstance(answer, sympy.MatrixBase):
        return sympy.Matrix(answer)
    if isinstance(answer, sympy.Poly | TransferFunction):
        return sympy.Matrix([[answer.as_expr()]])
    if isinstance(answer, list | tuple):
        rows = [row if isinstance(row, list | tuple) else [row] for row in answer]
        return sympy.Matrix([[as_matrix(entry)[0, 0] for entry in row] for row in rows])
    return sympy.Matrix([[sympy.sympify(answer)]])


def equal(answer, expected):
    """Whether they are the same matrix of expressions."""
    answer, expected = as_matrix(answer), as_matrix(expected)
    return answer.shape == expected.shape and all(
        sympy.simplify(entry) == 0 for entry in answer - expected
    )


def encloses(enclosure: Enclosure, expected):
    """Whether a certified number holds this one, and is known to fifteen digits."""
    value = sympy.N(sympy.sympify(expected), 60)
    return abs(value - enclosure.centre) <= enclosure.radius <= 1e-15 * abs(value)
