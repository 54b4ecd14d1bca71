"""Rational functions of symbols as fractions of python-flint's polynomials: read, and written."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import lru_cache
from math import comb, lcm, prod
from typing import TypeAlias

import flint
import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol
from sympy.polys.polyclasses import DMP
from sympy.polys.polyutils import expr_from_dict
from sympy.polys.rings import PolyElement, PolyRing

from compensator_theory.polynomials._formatting import composite_domain
from compensator_theory.polynomials._poly import canonical

Fraction: TypeAlias = tuple[flint.fmpz_mpoly, flint.fmpz_mpoly]
"""Numerator and denominator, not in lowest terms."""
LARGEST_POWER = 200
MOST_TERMS = 1_000_000
SMALL_POWERS = range(1, LARGEST_POWER)
REMEMBERED = 100_000
"""Terms of fractions that were read or written, for each set of symbols."""


def factored(
    poly: flint.fmpz_mpoly,
) -> tuple[flint.fmpz, list[tuple[flint.fmpz_mpoly, int]]]:
    """Return content and irreducible factors with their powers, as python-flint's ``factor``.

    Python-flint sorts them, and python-flint 0.9 fails to where two factors of the same monomials
    differ in numbers of more than 31 bits. It sorts those with rational coefficients by another
    rule, and gives them without denominators.
    """
    try:
        content, factors = poly.factor()
    except OverflowError:
        context = poly.context()
        rational = flint.fmpq_mpoly_ctx.get(context.names(), context.ordering())
        content, primitive = rational.from_dict(poly.to_dict()).factor()
        factors = [
            (context.from_dict({k: c.p for k, c in f.to_dict().items()}), power)
            for f, power in primitive
        ]
        content = content.p
    return content, [(factor, int(power)) for factor, power in factors]


class NotRationalError(Exception):
    """An expression that is no rational function of symbols over QQ, or one with large powers."""


class RationalFunctions:
    """Reads expressions in some symbols as fractions of polynomials with whole coefficients."""

    def __init__(self, symbols: Iterable[Symbol]) -> None:
        """Create a reader; `in_symbols` returns cached ones."""
        domain = composite_domain(frozenset(symbols), divides=False)
        self.rational: PolyRing = domain.ring
        self.symbols: tuple[Symbol, ...] = domain.symbols  # in SymPy's order, which decides signs
        names = [f"x{i}" for i in range(len(self.symbols))]
        self.context = flint.fmpz_mpoly_ctx.get(names, flint.Ordering.lex)
        self.zero, self.one = self.context.constant(0), self.context.constant(1)
        self.known: dict[Expr, Fraction] = {}
        self.size = 0
        self.variables = dict(zip(self.symbols, self.context.gens(), strict=True))

    def read(self, expression: Expr) -> Fraction:
        """Return an expression as a fraction; parts that occur again are read once."""
        known = self.known.get(expression)
        return self._remembered(expression, *self._computed(expression)) if known is None else known

    def _remembered(
        self, expression: Expr, above: flint.fmpz_mpoly, below: flint.fmpz_mpoly
    ) -> Fraction:
        """Cache the fraction of an expression for the next matrix that contains it."""
        self.size += 1 + len(above) + len(below)
        if self.size > REMEMBERED:
            self.known, self.size = {}, 0
        self.known[expression] = above, below
        return above, below

    def _computed(self, expression: Expr) -> Fraction:
        if (x := self.variables.get(expression)) is not None:
            return x, self.one
        if expression.is_Rational:
            return self.one * int(expression.p), self.one * int(expression.q)
        if expression.is_Add:
            above, below, others = self._monomials(expression)
            for term in others:
                top, under = self.read(term)
                shared = below if below == under else below.gcd(under)
                above = above * (under / shared) + top * (below / shared)
                below = below * (under / shared)
            return above, below
        if expression.is_Mul:
            tops, unders = zip(*map(self.read, expression.args), strict=True)
            _require_few(prod(map(len, tops)), prod(map(len, unders)))
            return prod(tops, start=self.one), prod(unders, start=self.one)
        if expression.is_Pow and expression.exp.is_Integer and abs(expression.exp) < LARGEST_POWER:
            above, below = self.read(expression.base)
            power = abs(int(expression.exp))
            _require_few(*(comb(len(p) + power - 1, power) for p in (above, below)))
            if expression.exp < 0:
                above, below = below, above
            if not below.is_zero():
                return above**power, below**power
        raise NotRationalError

    def _monomials(self, total: Expr) -> tuple[flint.fmpz_mpoly, flint.fmpz_mpoly, list[Expr]]:
        """Return the sum of those terms that are monomials as one fraction, and the others."""
        terms: dict[tuple[int, ...], Rational] = {}
        others: list[Expr] = []
        for term in total.args:
            powers, coefficient = dict.fromkeys(self.symbols, 0), Rational(1)
            for factor in term.args if term.is_Mul else (term,):
                x, power = factor.args if factor.is_Pow else (factor, 1)
                if factor.is_Rational:
                    coefficient = factor
                elif x in powers and power in SMALL_POWERS:
                    powers[x] = int(power)
                else:
                    others.append(term)
                    break
            else:
                terms[tuple(powers.values())] = coefficient
        below = lcm(*(int(c.q) for c in terms.values()))
        whole = {powers: int(c.p) * (below // int(c.q)) for powers, c in terms.items()}
        return self.context.from_dict(whole), self.one * below, others

    def over_one(self, entries: Sequence[Expr]) -> tuple[list[flint.fmpz_mpoly], flint.fmpz_mpoly]:
        """Return numerators over a least common denominator, and that denominator."""
        pairs, common = [], self.one
        for entry in entries:
            above, below = self.read(entry)
            if below != self.one:
                shared = above.gcd(below)
                above, below = above / shared, below / shared
                common = common * (below / common.gcd(below))
            pairs.append((above, below))
        return [above * (common / below) for above, below in pairs], common

    def write(self, above: flint.fmpz_mpoly, below: flint.fmpz_mpoly) -> Expr:
        """Return a fraction in lowest terms, as SymPy's fields write it."""
        if above.is_zero():
            return sympy.Integer(0)
        above, below = self.lowest(above, below)
        quotient = self.expression(above) / self.expression(below)
        self._remembered(quotient, above, below)
        return quotient

    def lowest(self, above: flint.fmpz_mpoly, below: flint.fmpz_mpoly) -> Fraction:
        """Return a fraction in lowest terms, its denominator with a positive leading one."""
        if below.is_one():
            return above, below
        shared = above.gcd(below)
        if below.leading_coefficient() < 0:
            shared = -shared
        return above / shared, below / shared

    def expression(self, poly: flint.fmpz_mpoly, over: int = 1) -> Expr:
        """Return a polynomial as an expression, over a number."""
        terms = {tuple(map(int, p)): Rational(int(c), over) for p, c in poly.to_dict().items()}
        return expr_from_dict(terms, *self.symbols)

    def polynomial(self, descending: Sequence[Fraction], variable: Symbol) -> Poly:
        """Return the polynomial with these coefficients, the first of them not zero."""
        lowest = [self.lowest(*pair) for pair in descending]
        if not all(below.is_constant() for _, below in lowest):
            field = self.rational.to_field()
            fractions = [field.raw_new(*(self._in_ring(p, 1) for p in pair)) for pair in lowest]
            return canonical(Poly.new(DMP(fractions, field.to_domain(), 0), variable))
        values = [self._in_ring(p, int(q.leading_coefficient())) for p, q in lowest]
        return canonical(Poly.new(DMP(values, self.rational.to_domain(), 0), variable))

    def _in_ring(self, poly: flint.fmpz_mpoly, over: int) -> PolyElement:
        terms = {tuple(map(int, p)): QQ(int(c), over) for p, c in poly.to_dict().items()}
        return self.rational.from_dict(terms)

    def symbols_of(self, polynomials: Iterable[flint.fmpz_mpoly]) -> set[Symbol]:
        """Return the symbols that occur in some of these polynomials."""
        degrees = zip(*(poly.degrees() for poly in polynomials), strict=True)
        return {x for x, powers in zip(self.symbols, degrees, strict=False) if any(powers)}


def _require_few(*terms: int) -> None:
    """Refuse an expression that has too many terms when multiplied out."""
    if max(terms) > MOST_TERMS:
        raise NotRationalError


@lru_cache(maxsize=8)
def in_symbols(symbols: frozenset[Symbol]) -> RationalFunctions:
    """Return the reader for these symbols, cached with the expressions that it has read."""
    return RationalFunctions(symbols)


def vanish(expressions: Iterable[Expr]) -> list[bool | None]:
    """Return for each expression whether it is zero for all values of its symbols."""
    list_of_expressions = list(expressions)
    symbols = {
        x
        for x in set().union(*(e.free_symbols for e in list_of_expressions))
        if isinstance(x, Symbol)
    }
    work = in_symbols(frozenset(symbols)) if symbols else None
    answers: list[bool | None] = []
    for expression in list_of_expressions:
        known: bool | None = None
        if expression.is_Rational:
            known = bool(expression == 0)
        elif work is not None:
            with suppress(NotRationalError):
                known = bool(work.read(expression)[0].is_zero())
        answers.append(known)
    return answers
