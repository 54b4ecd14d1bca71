"""Directions at a zero: numbers with rational real and imaginary parts, and eta' G(z0)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import sympy
from sympy import QQ_I, Expr, ImmutableMatrix, Matrix, Poly
from sympy.polys.domains.domainelement import DomainElement
from sympy.polys.matrices import DomainMatrix

from compensator_theory.errors import InputError
from compensator_theory.polynomials._budget import ask, listed, quoted, repr_of
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import is_rational, way_to_rational
from compensator_theory.systems._transfer_matrices import TransferMatrix


def rational_matrix(value: Sequence[Sequence[NumberLike]], name: str) -> Matrix:
    """Read a matrix of rationals from its rows."""
    try:
        entries = [listed(row, "degree", name) for row in listed(value, "degree", name)]
        ask("entries", sum(map(len, entries)), name)
        rows = [[exact_number(entry) for entry in row] for row in entries]
    except TypeError as error:
        raise InputError(
            f"{name} = {repr_of(value)} must be a matrix, a list of its rows"
        ) from error
    if not rows or not rows[0] or len({len(row) for row in rows}) != 1:
        raise InputError(f"{name} needs rows of one and the same nonzero length")
    if not all(entry.is_rational for row in rows for entry in row):
        raise InputError(f"{name} = {rows} must be rational")
    return Matrix(rows)


def gaussian(value: NumberLike, name: str) -> Expr:
    """Read a number with rational real and imaginary parts."""
    number = exact_number(value)
    if number.free_symbols or not all(part.is_rational for part in number.as_real_imag()):
        raise InputError(f"{name} is not rational; give a decimal of it")
    return sympy.expand(number)


def read_direction(eta: Sequence[NumberLike], size: int) -> ImmutableMatrix:
    """Read a direction, a column of that size that is not zero."""
    name = f"the direction {repr_of(eta)}"
    entries = [gaussian(entry, name) for entry in listed(eta, "degree", name)]
    if len(entries) != size:
        raise InputError(f"the direction {entries} has {len(entries)} entries; {size} are needed")
    if not any(entries):
        raise InputError("the direction is zero; give a nonzero vector")
    return ImmutableMatrix(entries)


def _value(G: TransferMatrix, z0: Expr) -> DomainMatrix:
    """G(z0) over the Gaussian rationals."""
    parts = (G.denominator, *chain(*G.numerators))
    if not all(map(is_rational, parts)):
        raise InputError(
            f"a direction at {z0} needs rational coefficients, and those of {quoted(G)} are not; "
            f"{way_to_rational(*parts)}"
        )
    point = QQ_I.from_sympy(z0)

    def at(polynomial: Poly) -> DomainElement:
        value = QQ_I.zero
        for coefficient in polynomial.all_coeffs():
            value = value * point + QQ_I.from_sympy(coefficient)
        return value

    bottom = at(G.denominator)
    if bottom == QQ_I.zero:
        raise InputError(f"z0 = {z0} is a pole of {G}; give a zero")
    values = [[at(entry) / bottom for entry in row] for row in G.numerators]
    return DomainMatrix(values, G.shape, QQ_I)


def residual(G: TransferMatrix, z0: Expr, W: Matrix, eta: Matrix) -> Matrix:
    """Return eta' W G(z0) for exact data."""
    left, weights = (DomainMatrix.from_Matrix(M).convert_to(QQ_I) for M in (eta.T, W))
    return (left * weights * _value(G, z0)).to_Matrix()
