"""Polynomials in one variable over the field of their coefficients: python-flint, or SymPy's."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from typing import Any, TypeAlias

import flint
from sympy import Expr, Poly, Symbol
from sympy.polys.domains.domain import Domain
from sympy.polys.rings import PolyRing

from compensator_theory.errors import InputError
from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.matrices._function_rings import FunctionRing
from compensator_theory.polynomials._budget import ask, decimal_digits
from compensator_theory.polynomials._poly import canonical, monic

Element: TypeAlias = Any
"""A polynomial of python-flint (rational coefficients) or of a ring of SymPy; both compute."""
Grid: TypeAlias = list[list[Element]]
"""A matrix of elements by rows."""


class RationalRing:
    """Polynomials with rational coefficients, by python-flint."""

    def __init__(self, variable: Symbol) -> None:
        self.variable = variable
        self.zero, self.one = flint.fmpq_poly(), flint.fmpq_poly([1])

    def read(self, poly: Poly) -> Element:
        """Return an element."""
        return to_flint_polynomial(poly)

    def write(self, element: Element) -> Poly:
        """Return a polynomial of SymPy."""
        return from_flint_polynomial(element, self.variable)

    def degree(self, element: Element) -> int:
        """Return the degree, -1 for zero."""
        return int(element.degree())

    def divide(self, a: Element, b: Element) -> tuple[Element, Element]:
        """Return quotient and remainder."""
        half = (
            self._digits(a, b) // 2
        )  # numbers of 8000 digits take seconds; their growth cannot be predicted
        ask("digits", half, "each half of a coefficient in the elimination of a polynomial matrix")
        quotient, remainder = divmod(a, b)
        return quotient, remainder

    def effort(self, a: Element, b: Element) -> int:
        """Return how many digits a division works on; those of long numbers count more."""
        digits, degree = self._digits(a, b), max(self.degree(a), self.degree(b))
        return (degree + 1) * digits * (1000 + digits) // 1000

    def _digits(self, a: Element, b: Element) -> int:
        return decimal_digits(max(a.numer().height_bits(), b.numer().height_bits()))

    def reciprocal_of_leading(self, element: Element) -> Element:
        """Return 1 over the leading coefficient, as a constant polynomial."""
        return flint.fmpq_poly([1 / element.coeffs()[-1]])

    def coefficient(self, element: Element, power: int) -> Element:
        """Return one coefficient, as a constant polynomial."""
        return flint.fmpq_poly([element[power]])

    def power(self, exponent: int) -> Element:
        """Return a power of the variable."""
        return flint.fmpq_poly([0] * exponent + [1])


class SymbolicRing:
    """Polynomials over a field that contains irrational numbers, by SymPy."""

    def __init__(self, variable: Symbol, field: Domain) -> None:
        self.variable, self.field = variable, field
        self.ring = PolyRing([variable], field, "lex")
        self.zero, self.one = self.ring.zero, self.ring.one
        self.has_fractions = bool(field.is_FractionField)

    def read(self, poly: Poly) -> Element:
        """Return an element."""
        return self.ring.from_dict(poly.set_domain(self.field).rep.to_dict())

    def write(self, element: Element) -> Poly:
        """Return a polynomial of SymPy."""
        return canonical(Poly.from_dict(dict(element), self.variable, domain=self.field))

    def degree(self, element: Element) -> int:
        """Return the degree, -1 for zero."""
        return int(element.degree()) if element else -1

    def divide(self, a: Element, b: Element) -> tuple[Element, Element]:
        """Return quotient and remainder."""
        ask("terms", self._terms(a) + self._terms(b), "a division between polynomial matrices")
        quotient, remainder = a.div(b)
        return quotient, remainder

    def effort(self, a: Element, b: Element) -> int:
        """Return 0: the terms are counted at each division."""
        return 0

    def _terms(self, element: Element) -> int:
        """Return the number of terms of the coefficients, whose growth cannot be predicted."""
        if not self.has_fractions:
            return len(element)
        return sum(len(c.numer) + len(c.denom) for c in element.values())

    def reciprocal_of_leading(self, element: Element) -> Element:
        """Return 1 over the leading coefficient, as a constant polynomial."""
        return self.ring.ground_new(self.field.quo(self.field.one, element.LC))

    def coefficient(self, element: Element, power: int) -> Element:
        """Return one coefficient, as a constant polynomial."""
        return self.ring.ground_new(element.get((power,), self.field.zero))

    def power(self, exponent: int) -> Element:
        """Return a power of the variable."""
        return self.ring.gens[0] ** exponent


Ring: TypeAlias = RationalRing | FunctionRing | SymbolicRing


def ring_of(polynomials: Iterable[Poly]) -> Ring:
    """Return the ring over the smallest field that has all coefficients."""
    listed = list(polynomials)
    field = reduce(lambda a, b: a.unify(b), (p.domain for p in listed)).get_field()
    if field.is_QQ:
        return RationalRing(listed[0].gen)
    if field.is_EX or not field.is_Exact:
        raise InputError(
            "the coefficients span no supported number field; write symbols in place of "
            "irrational numbers"
        )
    kind = FunctionRing if FunctionRing.serves(field) else SymbolicRing
    return kind(listed[0].gen, field)


def multiply(ring: Ring, left: Sequence[Sequence[Element]], right: Grid) -> Grid:
    """Multiply two matrices of elements."""
    columns = list(zip(*right, strict=True))
    if isinstance(ring, FunctionRing):
        for row in (*left, *columns):
            ask("terms", sum(map(ring.terms, row)), "a product of polynomial matrices")
        return [
            [ring.combined(zip(row, column, strict=True)) for column in columns] for row in left
        ]
    return [
        [
            sum((x * y for x, y in zip(row, column, strict=True) if x and y), ring.zero)
            for column in columns
        ]
        for row in left
    ]


def identity(ring: Ring, size: int) -> Grid:
    """Return the identity matrix."""
    return [[ring.one if i == j else ring.zero for j in range(size)] for i in range(size)]


def in_lowest_terms(top: Poly, bottom: Poly) -> tuple[Poly, Poly]:
    """Return numerator and denominator monic and without common factors; neither is zero."""
    ring = ring_of([top, bottom])
    if isinstance(ring, FunctionRing):
        sides = ring.lowest_terms(ring.read(top), ring.read(bottom))
        return ring.write(sides[0]), ring.write(sides[1])
    p, q = ring.read(top), ring.read(bottom)
    p, q = (ring.divide(side, p.gcd(q))[0] for side in (p, q))
    return monic(ring.write(p)), monic(ring.write(q))


def resultant_of_monic(a: Poly, b: Poly) -> Expr:
    """Return the resultant of two monic polynomials."""
    ring = ring_of([a, b])
    if isinstance(ring, FunctionRing):
        return ring.resultant(ring.read(a), ring.read(b))
    return a.resultant(b)  # an expression, as both have one variable
