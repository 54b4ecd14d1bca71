"""Whether a matrix of rational numbers or surds is nonsingular: exactly, or by certified balls."""

from __future__ import annotations

from functools import reduce
from operator import add, mul

import flint
import sympy
from sympy import Expr, Matrix, Rational

from compensator_theory.errors import InputError
from compensator_theory.matrices._flint_matrices import is_rational_matrix
from compensator_theory.matrices._linear_algebra import rank
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.polynomials._budget import quoted

PRECISIONS = tuple(128 * 4**k for k in range(5))


def is_proven_nonsingular(matrix: Matrix) -> bool:
    r"""Prove :math:`\det T \ne 0` for a square matrix of numbers.

    Rational entries are decided by the exact rank. With surds the determinant is enclosed in a
    ball, of growing precision; one without 0 is the proof. False with surds says that none was
    found up to 32768 bits, so that the determinant is 0 or smaller than any that is expected.
    """
    if matrix.rows != matrix.cols:
        raise InputError(f"a {matrix.rows} x {matrix.cols} matrix has no determinant")
    if is_rational_matrix(matrix):
        return bool(rank(matrix) == matrix.rows)
    for precision in PRECISIONS:
        with ball_precision(precision):
            entries = [[surd_ball(entry) for entry in row] for row in matrix.tolist()]
            if not flint.acb_mat(entries).det().contains(0):
                return True
    return False


def surd_ball(number: Expr) -> flint.acb:
    """Return a ball, at flint's working precision, that contains a number with square roots."""
    if isinstance(number, Rational):
        return flint.acb(flint.fmpq(int(number.p), int(number.q)))
    if number == sympy.I:
        return flint.acb(0, 1)
    if isinstance(number, sympy.Add | sympy.Mul):
        return reduce(add if number.is_Add else mul, map(surd_ball, number.args))
    if isinstance(number, sympy.Pow) and number.exp.is_Rational and number.exp.q <= 2:
        base = surd_ball(number.base)  # a positive number: SymPy takes I out of other roots
        return (base if number.exp.q == 1 else base.sqrt()) ** int(number.exp.p)
    raise InputError(f"{quoted(number)} contains numbers other than rationals and square roots")
