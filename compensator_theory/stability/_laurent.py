"""Laurent expansions of transfer matrices about a point: principal parts, residues, moments."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import flint
import sympy
from sympy import Expr, ImmutableMatrix, Poly, Symbol
from sympy.polys.constructor import construct_domain

from compensator_theory._latex import displayed, latex, total, unless
from compensator_theory._printing import text
from compensator_theory.errors import InputError
from compensator_theory.matrices._certificates import Certificate, certificate_of
from compensator_theory.matrices._exceptional_factors import exceptional_factors
from compensator_theory.matrices._flint_matrices import rational, zero_matrix
from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials._budget import ask, decimal_digits, integer
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._decidable import irrational_constants
from compensator_theory.polynomials._numbers import NumberLike, exact_number
from compensator_theory.polynomials._poly import is_rational
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_matrices import TransferMatrix

IDENTITY = "D times the expansion = N, power by power"


@dataclass(frozen=True)
class LaurentExpansion(ExactValue):
    r"""A transfer matrix as a series about a point.

    .. math:: G(s) = \sum_{k \ge -\mathrm{order}} G_k\,(s - p)^k

    Attributes
    ----------
    point : sympy.Expr
        p.
    order : int
        Of the pole, 0 if there is none; with symbols, for generic values of them.
    coefficients : tuple of sympy.ImmutableMatrix
        :math:`G_{-\mathrm{order}}, G_{-\mathrm{order} + 1}, \ldots`
    exceptional : tuple of sympy.Expr
        Irreducible polynomials in the symbols; everything holds where none of them is zero.
    certificate : Certificate
        Multiplied with the denominator again.
    """

    point: Expr
    order: int
    coefficients: tuple[ImmutableMatrix, ...]
    exceptional: tuple[Expr, ...]
    certificate: Certificate

    def __getitem__(self, power: int) -> ImmutableMatrix:
        """Return the coefficient of (s - p)**power; InputError beyond the computed terms."""
        index = power + self.order
        if index < 0:
            return zero_matrix(*self.coefficients[0].shape)
        if index >= len(self.coefficients):
            raise InputError(
                f"the expansion ends with the power {len(self.coefficients) - 1 - self.order}; "
                "request more terms"
            )
        return self.coefficients[index]

    @property
    def residue(self) -> ImmutableMatrix:
        """The coefficient of 1/(s - p), zero where there is no pole."""
        return self[-1]

    def __str__(self) -> str:
        parts = [
            f"{text(c.tolist() if c.shape != (1, 1) else c[0, 0])} of power {k - self.order}"
            for k, c in enumerate(self.coefficients)
        ]
        return f"about {text(self.point)}: " + ", ".join(parts)

    def _repr_latex_(self) -> str:
        terms = [
            f"{latex(c[0, 0] if c.shape == (1, 1) else c)} h^{{{power}}}"
            for power, c in enumerate(self.coefficients, -self.order)
        ]
        series = f"G({latex(self.point)} + h) = {total(terms)} + \\cdots"
        return displayed(series, unless(self.exceptional))


@carrying()
def laurent_expansion(
    G: TransferMatrixLike, point: NumberLike, terms: int, *, variable: str | Symbol | None = None
) -> LaurentExpansion:
    r"""Expand a transfer matrix about a finite point.

    Parameters
    ----------
    G : transfer matrix
        Anything :func:`transfer_matrix` reads, improper ones too, symbols allowed.
    point : number
        p, rational, complex with rational parts, or with symbols.
    terms : int
        How many coefficients from the first one on, at least 1.
    variable : str or Symbol, optional
        As for :func:`transfer_matrix`.

    Raises
    ------
    InputError, BudgetError
        If the point contains the variable or an irrational number, or `terms` is no positive
        integer or too large.

    Notes
    -----
    Poles of the unreduced denominator that all entries cancel do not count. About infinity the
    coefficients are :func:`markov_parameters`.

    Examples
    --------
    >>> from compensator_theory.interpolation import laurent_expansion
    >>> expansion = laurent_expansion("(s + 5)/(s*(s + 1)**2)", -1, 3)
    >>> print(expansion, expansion.residue[0, 0])
    about -1: -4 of power -2, -5 of power -1, -5 of power 0 -5
    """
    source = transfer_matrix(G, variable)
    s, at = source.variable, sympy.expand(exact_number(point))
    integer(terms, "terms", at_least=1)
    ask("degree", terms + int(source.denominator.degree()), "the expansion")
    if s in at.free_symbols or irrational_constants([at]) - {sympy.I}:
        raise InputError(
            f"the point {at} must be rational, complex with rational parts, or another symbol than "
            f"{s}"
        )
    _ask(source, at, terms)
    below = _about(source.denominator, at)
    above = [[_about(entry, at) for entry in row] for row in source.numerators]
    lowest = next(k for k, c in enumerate(below) if c != 0)
    entries = [_first(entry) for row in above for entry in row]
    cancelled = min(entries)
    order = max(0, lowest - cancelled)
    shift = lowest - order  # powers of s - p that all entries share with D, and zeros of G
    bottom = below[lowest:]
    _ask_for_recursion(bottom, len(entries), terms)
    series, left = _series(above, bottom, source.shape, shift, terms)
    divisors = [bottom[0]]
    if order:
        divisors.append(next(c for c in series[0] if c != 0))
    return LaurentExpansion(
        at, order, tuple(series), exceptional_factors(divisors), certificate_of(IDENTITY, left)
    )


def _series(
    above: list[list[list[Expr]]],
    bottom: list[Expr],
    shape: tuple[int, int],
    shift: int,
    terms: int,
) -> tuple[list[ImmutableMatrix], list[ImmutableMatrix]]:
    """Divide the series; return the coefficients, and D times them minus N.

    In the field that the numbers span a fraction stays in lowest terms after each operation.
    """
    numbers = [*bottom, *(c for row in above for entry in row for c in entry)]
    field = construct_domain(numbers, field=True)[0]
    D = [field.from_sympy(c) for c in bottom]
    N = [[field.from_sympy(c) for c in entry] for row in above for entry in row]
    coefficients: list[list[Any]] = []
    left = []
    for k in range(terms):
        known = range(1, min(k + 1, len(D)))
        right = [e[k + shift] if 0 <= k + shift < len(e) else field.zero for e in N]
        coefficients.append(
            [
                (top - sum((coefficients[k - j][i] * D[j] for j in known), field.zero)) / D[0]
                for i, top in enumerate(right)
            ]
        )
        left.append(
            [
                sum((coefficients[k - j][i] * D[j] for j in (0, *known)), field.zero) - top
                for i, top in enumerate(right)
            ]
        )
    series, rest = (
        [ImmutableMatrix(*shape, [field.to_sympy(c) for c in grid]) for grid in grids]
        for grids in (coefficients, left)
    )
    return series, rest


def _ask(G: TransferMatrix, point: Expr, terms: int) -> None:
    """Check the budget for the shift to the point and for the terms with symbols."""
    size = int(G.denominator.degree())
    polys = [G.denominator, *(entry for row in G.numerators for entry in row)]
    if not (point.is_Rational and all(map(is_rational, polys))):
        largest = max(size, *(int(p.degree()) for p in polys if not p.is_zero))
        ask("entries", 10 * largest**2 * len(polys), "the shift to the point of the expansion")
    symbols = point.free_symbols.union(*(p.free_symbols_in_domain for p in polys))
    if symbols:  # the coefficient k is divided by D(p)^(k + 1)
        amount = terms * math.comb(size * terms + len(symbols), len(symbols))
        ask("terms", amount, "the expansion with symbols")


def _ask_for_recursion(bottom: list[Expr], entries: int, terms: int) -> None:
    """Check the budget for the products with powers of D(p)."""
    first = bottom[0]
    bits = max(int(first.p).bit_length(), int(first.q).bit_length()) if first.is_Rational else 1
    products = entries * terms * min(len(bottom), terms)
    amount = 10 * products * (1 + decimal_digits(bits) * terms // 1000)
    ask("entries", amount, "the recursion of the expansion")


def _about(poly: Poly, point: Expr) -> list[Expr]:
    """Return the coefficients in ascending powers of s - p, by repeated synthetic division."""
    if is_rational(poly) and point.is_Rational:
        root = flint.fmpq(int(point.p), int(point.q))
        shifted = to_flint_polynomial(poly)(flint.fmpq_poly([root, 1]))
        return [rational(c) for c in shifted.coeffs()] or [sympy.Integer(0)]
    numbers = [point, *map(sympy.sympify, poly.all_coeffs())]
    field, (root, *rest) = construct_domain(numbers, field=True)
    coefficients = []
    while rest:
        for k in range(1, len(rest)):
            rest[k] = rest[k] + root * rest[k - 1]
        coefficients.append(field.to_sympy(rest.pop()))
    return coefficients


def _first(ascending: list[Expr]) -> int:
    return next((k for k, c in enumerate(ascending) if c != 0), len(ascending) + 10**6)
