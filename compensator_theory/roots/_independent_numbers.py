"""Polynomials with exponentials as coefficients: decided as if they were symbols, signs by balls.

By the theorem of Lindemann and Weierstrass exp(-1/10) is no root of a rational polynomial, and so a
rational function of it is zero only if it is zero for a symbol. What is not zero has a sign, which
balls of growing precision show. So every question about roots is decided, ties included.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import gcd, lcm
from typing import Any, TypeAlias

import flint
import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory.errors import InputError
from compensator_theory.polynomials._ball_precision import at_growing_precision
from compensator_theory.polynomials._budget import ask, repr_of
from compensator_theory.polynomials._carrying import has_functions
from compensator_theory.polynomials._letters import fresh
from compensator_theory.polynomials._poly import (
    canonical,
    common_divisor,
    exact_quotient,
    from_coefficients,
)
from compensator_theory.polynomials._reading import polynomial_in_time
from compensator_theory.polynomials._variables import Time
from compensator_theory.roots._enclosures import ball_of_number
from compensator_theory.roots._half_plane import half_plane_polynomial
from compensator_theory.roots._root_counts import RootCount

_EXPONENTIAL = re.compile(r"(?<!\w)exp\s*\(")

Meaning: TypeAlias = tuple[tuple[Symbol, Expr], ...]
"""Symbols with the numbers that they stand for, as `exponentials` of a sampled plant."""


@dataclass(frozen=True)
class IndependentNumbers:
    """Algebraically independent numbers, each with its symbol.

    Attributes
    ----------
    meaning : tuple of (Symbol, Expr)
        (x, exp(-1/10)), and tangents of frequencies, as sampled plants have them.
    """

    meaning: Meaning

    def ball(self, expression: Expr) -> flint.arb:
        """Return a ball, at the working precision, of a rational function of the symbols."""
        if expression.is_Rational:
            return ball_of_number(expression)
        values = [ball_of(value) for _, value in self.meaning]
        sides = []
        for terms in _sides(expression, tuple(x for x, _ in self.meaning)):
            total = flint.arb(0)
            for powers, coefficient in terms:
                term = ball_of_number(coefficient)
                for value, power in zip(values, powers, strict=True):
                    term *= value ** int(power)
                total += term
            sides.append(total)
        return sides[0] / sides[1]

    def polynomial_ball(self, poly: Poly) -> flint.arb_poly:
        """Return a polynomial with balls as coefficients."""
        return _polynomial_ball(self, poly, flint.ctx.prec)

    def _roots(self, poly: Poly, precision: int) -> list[flint.acb]:
        """Isolate the roots of a square-free polynomial; ValueError where balls are too large."""
        tolerance = flint.arb(2) ** (-precision // 2)
        return list(flint.acb_poly(self.polynomial_ball(poly)).roots(tol=tolerance))

    def sign(self, expression: Expr) -> int:
        """Return the sign of a rational function of the symbols, exactly."""
        reduced = sympy.cancel(expression)
        if reduced == 0:
            return 0

        def attempt(_: int) -> int | None:
            ball = self.ball(reduced)
            return 1 if ball > 0 else -1 if ball < 0 else None

        return at_growing_precision(attempt, 128, "a sign")

    def distinct_roots(
        self, poly: Poly, decide: Callable[[flint.acb], Any], bits: int = 128
    ) -> list[tuple[flint.acb, Any]]:
        """Isolate the roots of a square-free polynomial until each ball answers a question."""
        if poly.degree() < 1:
            return []

        def attempt(precision: int) -> list[tuple[flint.acb, Any]] | None:
            try:
                balls = self._roots(poly, precision)
            except ValueError:  # balls of the coefficients are too large
                return None
            answers = [(ball, decide(ball)) for ball in balls]
            return None if any(answer is None for _, answer in answers) else answers

        return at_growing_precision(attempt, bits, "a question about each root")

    def real_roots(self, poly: Poly, bits: int = 128) -> list[flint.arb]:
        """Isolate the real roots of a square-free polynomial, ascending.

        A ball that holds one root and meets no other root's conjugate holds a real one.
        """
        return list(_real_roots(self, poly, bits))

    def _isolate_real_roots(self, poly: Poly, bits: int) -> list[flint.arb]:
        if poly.degree() < 1:
            return []

        def attempt(precision: int) -> list[flint.arb] | None:
            try:
                balls = self._roots(poly, precision)
            except ValueError:
                return None
            real = []
            for k, ball in enumerate(balls):
                if not ball.imag.contains(0):
                    continue
                mirrored = ball.conjugate()
                if any(j != k and mirrored.overlaps(other) for j, other in enumerate(balls)):
                    return None
                real.append(ball.real)
            return sorted(real, key=lambda ball: ball.mid())

        return at_growing_precision(attempt, bits, "the real roots")

    def count(self, poly: Poly, time: Time) -> RootCount:
        """Count the roots on both sides of the boundary of stability, and on it, exactly."""
        degree = int(poly.degree())
        ask("degree", 4 * degree, "the roots of a polynomial with exponentials")
        image = half_plane_polynomial(poly) if time == "discrete" else poly
        at_infinity = degree - int(image.degree())  # the root -1 of discrete time
        symmetric = common_divisor(image, mirrored(image))
        unstable = 0
        for factor, multiplicity in square_free(exact_quotient(image, symmetric)):
            sides = self.distinct_roots(factor, _side)
            unstable += multiplicity * sum(side > 0 for _, side in sides)
        boundary = at_infinity
        squares, zeros = _in_squares(symmetric)
        boundary += zeros
        for factor, multiplicity in square_free(squares):
            negative = [root for root in self.real_roots(factor) if root < 0]
            boundary += 2 * multiplicity * len(negative)
        unstable += (int(symmetric.degree()) - (boundary - at_infinity)) // 2
        return RootCount(degree - boundary - unstable, boundary, unstable)


@lru_cache(maxsize=256)
def _real_roots(numbers: IndependentNumbers, poly: Poly, bits: int) -> tuple[flint.arb, ...]:
    """Remember the real roots, which each crossover of a loop needs again."""
    return tuple(numbers._isolate_real_roots(poly, bits))


@lru_cache(maxsize=256)
def _polynomial_ball(numbers: IndependentNumbers, poly: Poly, precision: int) -> flint.arb_poly:
    return flint.arb_poly([numbers.ball(c) for c in reversed(poly.all_coeffs())])


@lru_cache(maxsize=4096)
def _sides(expression: Expr, symbols: tuple[Symbol, ...]) -> tuple[tuple[Any, ...], ...]:
    """Return the terms of the numerator and the denominator of a rational function."""
    sides = sympy.fraction(sympy.together(expression))
    return tuple(tuple(Poly(side, *symbols, domain=QQ).terms()) for side in sides)


def _side(ball: flint.acb) -> int | None:
    return 1 if ball.real > 0 else -1 if ball.real < 0 else None


def ball_of(number: Expr) -> flint.arb:
    """Return a ball of a number of exponentials, tangents and square roots."""
    if number.is_Rational:
        return ball_of_number(number)
    if isinstance(number, sympy.Add | sympy.Mul):
        parts = [ball_of(part) for part in number.args]
        total = parts[0]
        for part in parts[1:]:
            total = total + part if number.is_Add else total * part
        return total
    if isinstance(number, sympy.Pow) and number.exp.is_Rational and number.base.is_Rational:
        return ball_of_number(number.base) ** ball_of_number(number.exp)
    if isinstance(number, sympy.exp):
        return ball_of(number.args[0]).exp()
    if isinstance(number, sympy.tan):
        return ball_of(number.args[0]).tan()
    if isinstance(number, sympy.tanh):
        return ball_of(number.args[0]).tanh()
    if number is sympy.E:
        return flint.arb(1).exp()
    raise InputError(f"{repr_of(number)} is no exponential of a rational number")


def mirrored(poly: Poly) -> Poly:
    """Return p(-s)."""
    return Poly({k: c * (-1) ** k[0] for k, c in poly.terms()}, poly.gen, domain=poly.domain)


def square_free(poly: Poly) -> Iterator[tuple[Poly, int]]:
    """Return the square-free factors with multiplicity, by Yun's algorithm."""
    if poly.degree() < 1:
        return
    slope = canonical(poly.diff())
    repeated = common_divisor(poly, slope)
    rest, derivative = exact_quotient(poly, repeated), exact_quotient(slope, repeated)
    multiplicity = 1
    while rest.degree() > 0:
        remainder = canonical(derivative - rest.diff())
        factor = rest if remainder.is_zero else common_divisor(rest, remainder)
        if factor.degree() > 0:
            yield factor, multiplicity
        rest = exact_quotient(rest, factor)
        if not remainder.is_zero:
            derivative = exact_quotient(remainder, factor)
        multiplicity += 1


def _in_squares(poly: Poly) -> tuple[Poly, int]:
    """Return q and j of p = s^j q(s^2), for p(-s) = +p(s) or -p(s)."""
    least = min(int(k) for (k,), _ in poly.terms())
    terms = {((int(k) - least) // 2,): c for (k,), c in poly.terms()}
    return Poly(terms, poly.gen, domain=poly.domain), least


def is_sampled(obj: object) -> bool:
    """Whether an object brings the meaning of its symbols, all of them numbers."""
    meaning: Meaning = getattr(obj, "exponentials", ())
    return bool(meaning) and not any(value.free_symbols for _, value in meaning)


def may_have_exponentials(*objects: object) -> bool:
    """Whether objects may have exponentials of numbers as coefficients."""
    return any(is_sampled(obj) or has_functions(obj) or _has_e(obj) for obj in objects)


def _has_e(obj: object) -> bool:
    """Whether a power of Euler's number is in a text, a polynomial or a transfer function."""
    if isinstance(obj, str):
        return _EXPONENTIAL.search(obj) is not None
    if isinstance(obj, Expr):
        return bool(obj.has(sympy.E, sympy.exp))
    parts = [getattr(obj, "numerator", obj), getattr(obj, "denominator", obj)]
    return any(
        isinstance(part, Poly) and not (part.domain.is_QQ or part.domain.is_ZZ)
        and bool(part.has(sympy.E, sympy.exp)) for part in parts
    )  # fmt: skip


def meaning_of(obj: object) -> Meaning:
    """Return the numbers that the symbols of a sampled plant stand for."""
    return obj.exponentials if is_sampled(obj) else ()  # type: ignore[attr-defined]


def independent_numbers(
    parts: Sequence[tuple[Sequence[Expr], Meaning]], variables: Iterable[Symbol]
) -> tuple[list[list[Expr]], IndependentNumbers] | None:
    """Write expressions with exponentials of rational numbers by powers of one symbol.

    Each part comes with the meaning of its symbols. Tangents keep their symbols. None where there
    is no such number, or another one, or a symbol without a meaning.
    """
    tangents: dict[Symbol, Expr] = {}
    written: list[list[Expr]] = []
    for expressions, meaning in parts:
        values = {x: value for x, value in meaning if not isinstance(value, sympy.exp)}
        if values and tangents and values != tangents:
            raise InputError(
                "two sampled plants have different frequencies, and no test decides whether their "
                "tangents are independent; give one of them with rational numbers close to its own"
            )
        tangents |= values
        known = {x: value for x, value in meaning if isinstance(value, sympy.exp)}
        written.append([e.xreplace(known) for e in expressions])
    allowed = set(variables) | set(tangents)
    everything = [e for row in written for e in row]
    if not all(set(e.free_symbols) <= allowed for e in everything):
        return None
    atoms = set()
    for expression in everything:
        if (more := _exponentials(expression)) is None:
            return None
        atoms |= more
    if not (atoms or tangents):
        return None
    meaning_now: dict[Symbol, Expr] = {}
    if atoms:
        exponents = [_exponent(atom) for atom in atoms]
        unit = Rational(gcd(*(int(r.p) for r in exponents)), lcm(*(int(r.q) for r in exponents)))
        unit = -unit if all(r < 0 for r in exponents) else unit
        ask("degree", int(max(abs(r / unit) for r in exponents)), "the powers of one exponential")
        x = fresh({symbol.name for symbol in allowed}, "x")
        powers = {atom: x ** (_exponent(atom) / unit) for atom in atoms}
        written = [[sympy.cancel(e.xreplace(powers)) for e in row] for row in written]
        meaning_now[x] = sympy.exp(unit)
    return written, IndependentNumbers(tuple({**meaning_now, **tangents}.items()))


def polynomial_with_exponentials(
    obj: object, variable: str | Symbol | None, time: object
) -> tuple[Poly, Time, IndependentNumbers] | None:
    """Read a polynomial, or that of a system, with exponentials of numbers; None of another one."""
    if not may_have_exponentials(obj):
        return None
    poly, domain = polynomial_in_time(obj, time, variable)
    coefficients = poly.all_coeffs()
    rewritten = independent_numbers([(coefficients, meaning_of(obj))], ())
    if rewritten is None or poly.is_zero:
        return None
    ((written,), numbers) = rewritten
    return from_coefficients(written, poly.gen), domain, numbers


def _exponentials(expression: Expr) -> set[Expr] | None:
    """Return the exponentials of rational numbers; None where there is another irrational one."""
    waiting, atoms = [expression], set()
    while waiting:
        part = waiting.pop()
        if part is sympy.E or (isinstance(part, sympy.exp) and part.args[0].is_Rational):
            atoms.add(part)
        elif isinstance(part, sympy.Add | sympy.Mul):
            waiting += part.args
        elif isinstance(part, sympy.Pow) and part.exp.is_Integer:
            waiting.append(part.base)
        elif not (part.is_Rational or part.is_Symbol):
            return None
    return atoms


def _exponent(atom: Expr) -> Rational:
    return sympy.Integer(1) if atom is sympy.E else atom.args[0]
