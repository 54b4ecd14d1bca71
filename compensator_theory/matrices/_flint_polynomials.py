"""Rational polynomials of SymPy as those of python-flint, and back."""

from __future__ import annotations

import flint
from sympy import QQ, Poly, Symbol
from sympy.polys.polyclasses import DMP, DUP_Flint

from compensator_theory.polynomials._reading import PolynomialLike


def flint_polynomial_pair(
    a: PolynomialLike, b: PolynomialLike
) -> tuple[flint.fmpq_poly, flint.fmpq_poly] | None:
    """Return the python-flint polynomials of two SymPy polynomials in one variable, else None.

    That they are rational and in canonical form then needs no further look.
    """
    if isinstance(a, Poly) and isinstance(b, Poly) and a.gens == b.gens and a.gen.is_Symbol:
        first, second = getattr(a.rep, "_rep", None), getattr(b.rep, "_rep", None)
        if type(first) is flint.fmpq_poly and type(second) is flint.fmpq_poly:
            return first, second
    return None


def to_flint_polynomial(poly: Poly) -> flint.fmpq_poly:
    """Return a rational polynomial as one of python-flint.

    SymPy keeps rational polynomials and numbers as python-flint's where it found it, and then
    nothing is converted.
    """
    dense = getattr(poly.rep, "_rep", None)
    if isinstance(dense, flint.fmpq_poly):
        return dense
    ascending = poly.rep.to_list()[::-1]
    if QQ.dtype is not flint.fmpq:
        ascending = [flint.fmpq(int(c.numerator), int(c.denominator)) for c in ascending]
    return flint.fmpq_poly(ascending)


def from_flint_polynomial(poly: flint.fmpq_poly, variable: Symbol) -> Poly:
    """Return a polynomial of python-flint as a rational one of SymPy."""
    if QQ.dtype is flint.fmpq:
        return Poly.new(DUP_Flint.from_rep(poly, QQ), variable)
    descending = [QQ(int(c.p), int(c.q)) for c in reversed(poly.coeffs())]
    return Poly.new(DMP(descending, QQ, 0), variable)


def interpolated(points: list[flint.fmpq], values: list[flint.fmpq]) -> list[flint.fmpq]:
    """Return ascending coefficients through the points, by Newton's divided differences."""
    table = list(values)
    for order in range(1, len(points)):
        for i in range(len(points) - 1, order - 1, -1):
            table[i] = (table[i] - table[i - 1]) / (points[i] - points[i - order])
    result = flint.fmpq_poly([table[-1]])
    for i in range(len(points) - 2, -1, -1):
        result = result * flint.fmpq_poly([-points[i], 1]) + table[i]
    return list(result.coeffs())
