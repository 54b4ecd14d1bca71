"""Answers compared with solutions, and written for a sentence."""

from __future__ import annotations

from typing import Any

from sympy import Expr, ImmutableMatrix, MatrixBase, Poly, simplify

from compensator_theory._printing import text
from compensator_theory.polynomials._expressions import parse_expression
from compensator_theory.polynomials._numbers import exact_number
from compensator_theory.polynomials._reading import polynomial
from compensator_theory.systems._dead_times import transfer_function
from compensator_theory.systems._realisations import Realisation
from compensator_theory.systems._transfer_functions import TransferFunction


def agree(value: Any, solution: Any) -> bool:
    """Whether a value, read as the type of the solution, equals the solution."""
    if value is None or solution is None:
        return value is solution
    if isinstance(solution, bool):
        return str(value) == str(solution)  # True of NumPy and SymPy, too; never 1
    if isinstance(solution, tuple):
        is_sequence = isinstance(value, list | tuple) and len(value) == len(solution)
        return is_sequence and all(map(agree, value, solution))
    if isinstance(solution, Poly):
        return bool((polynomial(value, solution.gen) - solution).is_zero)
    if isinstance(solution, TransferFunction):
        difference = transfer_function(value, solution.variable) - solution
        return bool(difference.numerator.is_zero)
    if isinstance(solution, MatrixBase):
        matrix = ImmutableMatrix(value)
        return matrix.shape == solution.shape and _is_zero_matrix(matrix - solution)
    return _is_zero(_expression(value) - _expression(solution))


def written(value: Any) -> str:
    """Write a value or a part of a case as a reader types it."""
    if isinstance(value, Poly):
        return text(value.as_expr())
    if isinstance(value, TransferFunction):
        return _quotient(value)
    if isinstance(value, MatrixBase):
        return text(value.tolist())
    if isinstance(value, Realisation):
        return written((value.A, value.B, value.C, value.D))
    if isinstance(value, tuple):
        return f"({', '.join(map(written, value))}{',' * (len(value) == 1)})"
    return " ".join(text(value).split())


def _quotient(G: TransferFunction) -> str:
    """Write a transfer function without brackets that are not needed."""
    top, bottom = (p.as_expr() for p in (G.numerator, G.denominator))
    over = text(bottom) if bottom.is_Atom and not bottom.is_Rational else f"({text(bottom)})"
    if bottom == 1:
        return text(top)
    return f"({text(top)})/{over}" if top.is_Add else f"{text(top)}/{over}"


def _expression(value: Any) -> Expr:
    if isinstance(value, Expr):
        return value
    return parse_expression(value) if isinstance(value, str) else exact_number(value)


def _is_zero_matrix(difference: ImmutableMatrix) -> bool:
    return all(map(_is_zero, difference))


def _is_zero(difference: Expr) -> bool:
    return bool(difference == 0 or simplify(difference) == 0)
