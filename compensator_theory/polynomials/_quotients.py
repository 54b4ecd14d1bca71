"""Quotients of polynomials in several symbols, multiplied out under a budget, never cancelled."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import comb
from typing import TypeAlias

import flint
import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol
from sympy.functions.elementary.trigonometric import TrigonometricFunction
from sympy.polys.polyclasses import DMP

from compensator_theory.errors import InputError
from compensator_theory.libraries import roots_in_sympy
from compensator_theory.polynomials._budget import ask, decimal_digits

Tree: TypeAlias = "Leaf | Addition | Product | Power"


@dataclass(frozen=True)
class Leaf:
    """A rational number, a symbol, or an irrational number that is kept as it is."""

    value: Expr


@dataclass(frozen=True)
class Addition:
    """A sum of any number of terms; a difference has the term -1 times the subtrahend."""

    terms: Sequence[Tree]


@dataclass(frozen=True)
class Product:
    """A product of factors, divided by the divisors."""

    factors: Sequence[Tree]
    divisors: Sequence[Tree] = ()


@dataclass(frozen=True)
class Power:
    """A power with an integer exponent."""

    base: Tree
    exponent: int


@dataclass(frozen=True)
class Quotient:
    """Numerator and denominator over the ring of the generators.

    Attributes
    ----------
    numerator, denominator : flint.fmpq_mpoly
    generators : tuple of sympy.Expr
        Symbols, and irrational numbers that count as unknowns until the end.
    """

    numerator: flint.fmpq_mpoly
    denominator: flint.fmpq_mpoly
    generators: tuple[Expr, ...]

    @property
    def is_plain(self) -> bool:
        """Whether it contains symbols and rational numbers alone."""
        return all(generator.is_Symbol for generator in self.generators)

    @property
    def free_symbols(self) -> set[Symbol]:
        """The symbols that occur, without those that cancelled in a sum."""
        if not self.is_plain:
            return set().union(*(side.free_symbols for side in self.sides()))
        degrees = zip(self.numerator.degrees(), self.denominator.degrees(), strict=True)
        occurs = zip(self.generators, degrees, strict=True)
        return {symbol for symbol, powers in occurs if max(powers) > 0}

    def sides(self) -> tuple[Expr, Expr]:
        """Return both as SymPy expressions; a constant denominator divides the numerator."""
        if self.denominator.is_constant():
            return self._expression(self.numerator / self.denominator), sympy.Integer(1)
        top, bottom = self._expression(self.numerator), self._expression(self.denominator)
        if bottom.is_number:
            return sympy.expand(sympy.expand(top) * _inverse_of_number(bottom)), sympy.Integer(1)
        return top, bottom

    @roots_in_sympy()
    def value(self) -> Expr:
        """Return the quotient in lowest terms as one SymPy expression."""
        top, bottom = self.reduced().sides()
        return top / bottom

    def reduced(self) -> Quotient:
        """Return it without common factors."""
        if self.denominator.is_constant():
            return self
        factor = self.numerator.gcd(self.denominator)
        top, bottom = self.numerator / factor, self.denominator / factor
        leading = bottom.leading_coefficient()
        return Quotient(top / leading, bottom / leading, self.generators)

    def polynomials(self, variable: Symbol) -> tuple[Poly, Poly] | None:
        """Return both sides as polynomials; None unless the coefficients are rational numbers."""
        if set(self.generators) - {variable}:
            return None
        return self._poly(self.numerator, variable), self._poly(self.denominator, variable)

    def _poly(self, side: flint.fmpq_mpoly, variable: Symbol) -> Poly:
        terms = side.to_dict().items() if self.generators else [((0,), _constant(side))]
        powers = {(int(power),): QQ(int(c.p), int(c.q)) for (power,), c in terms if c}
        return Poly.new(DMP.from_dict(powers, 0, QQ), variable)

    def _expression(self, side: flint.fmpq_mpoly) -> Expr:
        if not self.generators:
            return _rational(_constant(side))
        terms = (
            (_rational(c), zip(self.generators, map(int, powers), strict=True))
            for powers, c in side.to_dict().items()
        )
        return sympy.Add(*(sympy.Mul(c, *(g**e for g, e in factors)) for c, factors in terms))


def multiplied_out(tree: Tree, *, least_denominators: bool = False) -> Quotient:
    """Evaluate a tree; sums use the product of two different denominators, or the least common one.

    Denominators that differ by a number are one denominator.
    """
    factors: set[Expr] = set()
    _collect(tree, factors)
    generators = tuple(sorted(factors, key=sympy.default_sort_key))
    names = [f"x{i}" for i in range(len(generators))]
    ring = _Ring(generators, flint.fmpq_mpoly_ctx.get(names, flint.Ordering.lex))
    quotient = ring.evaluated(tree, least_denominators)
    if len(generators) > 1 or not all(g.is_Symbol for g in generators):  # slow in SymPy
        for side in filter(len, (quotient.numerator, quotient.denominator)):
            size = len(side) * (1 + decimal_digits(_bits(side)) // 100)
            ask("terms", size, "the expression, a hundred digits counted as one,")
    return quotient


_Side: TypeAlias = flint.fmpq_mpoly
_Sides: TypeAlias = tuple[_Side, _Side]


@dataclass(frozen=True)
class _Ring:
    generators: tuple[Expr, ...]
    context: flint.fmpq_mpoly_ctx

    def evaluated(self, tree: Tree, least: bool) -> Quotient:
        return Quotient(*self._sides(tree, least), self.generators)

    def _sides(self, tree: Tree, least: bool) -> _Sides:
        one = self.context.constant(1)
        match tree:
            case Leaf(value) if value.is_Rational:
                return self.context.constant(flint.fmpq(int(value.p), int(value.q))), one
            case Leaf(value):
                return self.context.gens()[self.generators.index(value)], one
            case Power(base, exponent):
                up, down = self._sides(base, least)
                if exponent < 0:
                    self._require_not_zero(up)
                    up, down = down, up
                return _power(up, abs(exponent)), _power(down, abs(exponent))
            case Addition(terms):
                pairs = [self._sides(term, least) for term in terms]
                return _in_pairs(pairs, lambda a, b: _added(a, b, least))
            case Product(factors, divisors):
                sides = [self._sides(factor, least) for factor in factors]
                for divisor in divisors:
                    up, down = self._sides(divisor, least)
                    self._require_not_zero(up)
                    sides.append((down, up))
                return _in_pairs(sides, lambda a, b: (_product(a[0], b[0]), _product(a[1], b[1])))

    def _require_not_zero(self, side: _Side) -> None:
        if side.is_zero() or (
            any(not g.is_Symbol for g in self.generators)
            and sympy.expand(Quotient(side, self.context.constant(1), self.generators).sides()[0])
            == 0
        ):
            raise InputError("the expression divides by zero")


def _collect(tree: Tree, leaves: set[Expr]) -> None:
    match tree:
        case Leaf(value):
            if not value.is_Rational:
                leaves.add(value)
        case Power(base, _):
            _collect(base, leaves)
        case Addition(terms):
            for term in terms:
                _collect(term, leaves)
        case Product(factors, divisors):
            for factor in (*factors, *divisors):
                _collect(factor, leaves)


def _in_pairs(items: list[_Sides], join: Callable[[_Sides, _Sides], _Sides]) -> _Sides:
    """Join a list in a balanced tree, so that the factors of each product are alike in size."""
    while len(items) > 1:
        items = [
            join(*items[i : i + 2]) if i + 1 < len(items) else items[i]
            for i in range(0, len(items), 2)
        ]
    return items[0]


def _added(left: _Sides, right: _Sides, least: bool) -> _Sides:
    (n_1, d_1), (n_2, d_2) = left, right
    ratio = d_1.leading_coefficient() / d_2.leading_coefficient()
    if d_1 == d_2 * ratio:
        return n_1 + n_2 * ratio, d_1
    if least:
        common = d_1.gcd(d_2)
        first, second = d_1 / common, d_2 / common
        return _product(n_1, second) + _product(n_2, first), _product(d_1, second)
    return _product(n_1, d_2) + _product(n_2, d_1), _product(d_1, d_2)


def _product(a: _Side, b: _Side) -> _Side:
    if a.is_constant() or b.is_constant():
        if len(a) and len(b):
            ask("digits", decimal_digits(_bits(a) + _bits(b)), "a coefficient")
        return a * b
    kinds = len(a.degrees())
    degree = int(a.total_degree()) + int(b.total_degree())
    ask("degree", degree, "the expression, multiplied out,")
    ask("terms", min(len(a) * len(b), comb(degree + kinds, kinds)), "the expression, at most,")
    bits = _bits(a) + _bits(b) + min(len(a), len(b)).bit_length()
    ask("digits", decimal_digits(bits), "a coefficient")
    return a * b


def _power(base: _Side, exponent: int) -> _Side:
    if base.is_zero():
        return base if exponent else base + 1
    ask("degree", int(base.total_degree()) * exponent, "the expression, multiplied out,")
    kinds, degree = len(base.degrees()), int(base.total_degree()) * exponent
    if len(base) > 1:
        terms = comb(len(base) + exponent - 1, min(exponent, len(base) - 1))
        ask("terms", min(terms, comb(degree + kinds, kinds)), "the expression, at most,")
    bits = exponent * (_bits(base) + len(base).bit_length() - 1)
    if bits > exponent:  # powers of 1 and -1 are short
        ask("digits", decimal_digits(bits), "a coefficient")
    return base ** (exponent % 2 if bits <= exponent and degree == 0 else exponent)


def _bits(side: _Side) -> int:
    return max(max(int(c.p).bit_length(), int(c.q).bit_length()) for c in side.coeffs())


def _constant(side: _Side) -> flint.fmpq:
    return side.coeffs()[0] if len(side) else flint.fmpq(0)


def _rational(value: flint.fmpq) -> Rational:
    return Rational(int(value.p), int(value.q))


def _inverse_of_number(number: Expr) -> Expr:
    """Return 1/number, square roots in the numerator; of a + jb (a - jb)/(a**2 + b**2).

    Roots of irrational numbers have conjugates that are roots of their own: each pass would bring
    in more of them, and no form be the last.
    """
    if any(
        not root.base.is_Rational and not root.exp.is_Integer for root in number.atoms(sympy.Pow)
    ):
        return 1 / number
    if number.atoms(sympy.I):
        real, imaginary = sympy.expand(number).as_real_imag()
        if real.has(TrigonometricFunction) or imaginary.has(TrigonometricFunction):
            return 1 / number  # of a root of a complex number, which SymPy writes by its angle
        return (real - sympy.I * imaginary) / sympy.expand(real**2 + imaginary**2)
    top, bottom = sympy.Integer(1), sympy.expand(number)
    for root in sorted(bottom.atoms(sympy.Pow), key=sympy.default_sort_key):
        conjugate = bottom.xreplace({root: -root})
        if root.base.is_Rational and root.exp.q == 2 and conjugate != 0:
            top, bottom = sympy.expand(top * conjugate), sympy.expand(bottom * conjugate)
    return top / bottom
