"""Critical values of a parameter: a root may lie on the boundary of stability."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass
from itertools import count, pairwise

import flint
import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    interpolated,
    to_flint_polynomial,
)
from compensator_theory.polynomials._ball_precision import at_growing_precision
from compensator_theory.polynomials._multivariate import to_flint
from compensator_theory.roots._certified import EASY, decided_balls
from compensator_theory.roots._descartes import real_root_balls
from compensator_theory.roots._enclosures import Enclosure, enclosure_of_ball
from compensator_theory.roots._half_plane import half_plane_polynomial


@dataclass(frozen=True)
class CriticalValue:
    """A real algebraic number, exact and between two rational numbers."""

    value: Expr
    enclosure: Enclosure


def critical_polynomials(poly: Poly, parameter: Symbol, *, discrete: bool) -> list[Poly] | None:
    r"""Return polynomials in the parameter that vanish where a root is on the boundary.

    With q(s) = E(s^2) + s O(s^2) they are q(0), the leading coefficient and the resultant
    :math:`\mathrm{Res}_t(E, O)`: Hurwitz's determinant :math:`\Delta_{n-1}` up to powers of the
    other two (Orlando).
    """
    q = half_plane_polynomial(poly) if discrete else poly
    polynomials = [_in(poly.LC(), parameter)]
    for part in _factors(q, parameter):
        even, odd = part[0::2], part[1::2]
        if len(part) > 1 and not (any(even) and any(odd)):
            return None  # its roots come in pairs that are symmetric about 0, or it is s
        polynomials += [from_flint_polynomial(c, parameter) for c in (part[-1], part[0])]
        if len(part) > 2:
            polynomials.append(from_flint_polynomial(resultant_in_parameter(even, odd), parameter))
    if discrete and q.degree() < poly.degree():
        return None  # -1 is a root for every value
    return list(dict.fromkeys(polynomials))


def _factors(poly: Poly, parameter: Symbol) -> list[list[flint.fmpq_poly]]:
    """Return the irreducible factors as ascending coefficients, polynomials in the parameter."""
    (whole,) = to_flint(QQ[parameter], poly)
    factors = []
    for factor, _ in whole.factor()[1]:
        rows: list[dict[int, flint.fmpq]] = [{} for _ in range(int(factor.degrees()[0]) + 1)]
        scale = flint.fmpq(int(factor.leading_coefficient().q))
        for (power, k), c in factor.to_dict().items():
            rows[int(power)][int(k)] = c * scale
        factors.append([
            flint.fmpq_poly([row.get(k, 0) for k in range(max(row, default=-1) + 1)])
            for row in rows
        ])  # fmt: skip
    return factors


def resultant_in_parameter(
    first: list[flint.fmpq_poly], second: list[flint.fmpq_poly]
) -> flint.fmpq_poly:
    """Return the resultant of polynomials in t, whose coefficients are polynomials in a parameter.

    It is interpolated from resultants of numbers, which flint finds modulo primes.
    """
    sides = []
    for side in (first, second):
        coefficients = list(side)
        while not coefficients[-1]:
            coefficients.pop()
        sides.append(coefficients)
    sizes = [max(int(c.degree()) for c in side) for side in sides]
    degree = sum(
        size * (len(other) - 1) for size, other in zip(sizes, reversed(sides), strict=True)
    )
    points: list[flint.fmpq] = []
    values: list[flint.fmpq] = []
    for point in map(flint.fmpq, (k // 2 if k % 2 else -(k // 2) for k in count(1))):
        rows = [[c(point) for c in side] for side in sides]
        if rows[0][-1] == 0 or rows[1][-1] == 0:
            continue  # a degree drops, so that the resultant differs
        points.append(point)
        values.append(flint.fmpq_poly(rows[0]).resultant(flint.fmpq_poly(rows[1])))
        if len(points) > degree:
            return flint.fmpq_poly(interpolated(points, values))
    raise AssertionError


def even_and_odd(poly: Poly) -> tuple[Poly, Poly]:
    """Return E and O of q(s) = E(s^2) + s O(s^2)."""
    ascending = list(reversed(poly.all_coeffs()))
    even, odd = (Poly(list(reversed(ascending[k::2])) or [0], poly.gen) for k in (0, 1))
    return even, odd


def positive_roots(poly: Poly) -> list[Enclosure]:
    """Return disjoint enclosures of the distinct positive roots of a rational polynomial."""
    factors = {factor.monic() for factor, _ in poly.factor_list()[1]}

    def attempt(bits: int) -> list[Enclosure] | None:
        real = [r for f in factors for r in _enclosures_of_roots(f, bits, positive=True)]
        roots = sorted((r for r in real if r.upper > 0), key=lambda root: root.lower)
        ends = [sympy.Integer(0), *(root.upper for root in roots)]
        apart = all(end < root.lower for end, root in zip(ends, roots, strict=False))
        return roots if apart else None

    return at_growing_precision(attempt, 64, "the order of positive roots")


def real_roots(polys: list[Poly]) -> list[CriticalValue]:
    """Return the distinct real roots of rational polynomials in ascending order."""
    return roots_of_irreducible({
        factor.monic() for poly in polys if not poly.is_zero for factor, _ in poly.factor_list()[1]
    })  # fmt: skip


def roots_of_irreducible(factors: Set[Poly]) -> list[CriticalValue]:
    """Return the real roots of monic irreducible polynomials in ascending order."""

    def attempt(bits: int) -> list[CriticalValue] | None:
        roots = [root for factor in factors for root in _roots_of_factor(factor, bits)]
        roots.sort(key=lambda root: root.enclosure.lower)
        apart = all(a.enclosure.upper < b.enclosure.lower for a, b in pairwise(roots))
        return roots if apart else None

    return at_growing_precision(attempt, 64, "the order of real roots")  # distinct: irreducible


def signs_at_real_roots(poly: Poly, factor: Poly) -> list[int]:
    """Return the signs of a polynomial at the real roots, ascending, of an irreducible one."""
    rest = to_flint_polynomial(poly.rem(factor))

    def decide(ball: flint.acb) -> int | None:
        if ball.imag != 0 or not rest:
            return 0
        there = flint.arb_poly(rest)(ball.real)  # at the precision of the ball
        return 1 if there > 0 else -1 if there < 0 else None

    decided = [(b.real, sign) for b, _, sign in decided_balls(factor, decide) if b.imag == 0]
    return [sign for _, sign in sorted(decided, key=lambda pair: pair[0].mid())]


def is_less(first: Expr, second: Expr) -> bool:
    """Compare real numbers, one of them at most a multiple of an indexed root.

    SymPy would isolate all real roots of its polynomial, in Python.
    """
    for value, number, above in ((first, second, False), (second, first, True)):
        factor, root = value.as_coeff_Mul()  # SymPy takes common powers out of the polynomial
        if not isinstance(root, sympy.CRootOf):
            continue
        if number in (-sympy.oo, sympy.oo):
            return bool(number < 0) == above
        if number.is_Rational:
            gap = Poly(root.poly.gen - number / factor, root.poly.gen, domain=QQ)
            sign = signs_at_real_roots(gap, root.poly)[root.index]
            return bool(sign * factor > 0) == above  # not 0: of degree 3 or more, and irreducible
    return bool(first < second)


def approximation(value: Expr) -> Rational:
    """Return a rational number in place of the real roots in a value, 30 digits as good as each."""
    roots = value.atoms(sympy.CRootOf)
    places = {poly: _enclosures_of_roots(poly, 128) for poly in {root.poly for root in roots}}
    return value.xreplace({root: places[root.poly][root.index].centre for root in roots})


def cells_between(ends: list[CriticalValue]) -> list[tuple[Expr, Expr, Rational]]:
    """Return the open intervals that ascending end points leave of the line, each with a sample."""
    bounds: list[CriticalValue | None] = [None, *ends, None]
    return [
        (
            -sympy.oo if below is None else below.value,
            sympy.oo if above is None else above.value,
            _sample(below, above),
        )
        for below, above in pairwise(bounds)
    ]


def _sample(below: CriticalValue | None, above: CriticalValue | None) -> Rational:
    if below is not None and above is not None:
        return number_between(below.enclosure.upper, above.enclosure.lower)
    if below is not None:
        return sympy.floor(below.enclosure.upper) + 1
    return sympy.Integer(0) if above is None else sympy.ceiling(above.enclosure.lower) - 1


def number_between(lower: Rational, upper: Rational) -> Rational:
    """Return a short rational number between two others."""
    bits = 0
    while True:  # a multiple of 2**-bits
        number = Rational(sympy.floor(lower * 2**bits) + 1, 2**bits)
        if number < upper:
            return number
        bits += 1


def _roots_of_factor(factor: Poly, precision: int) -> list[CriticalValue]:
    places = _enclosures_of_roots(factor, precision)
    values = _real_values(factor, len(places))
    return [CriticalValue(value, place) for value, place in zip(values, places, strict=True)]


def _enclosures_of_roots(
    factor: Poly, precision: int, *, positive: bool = False
) -> list[Enclosure]:
    """Return the enclosures of the real roots, ascending; of the positive ones at least."""
    if factor.degree() > EASY:  # it has many more complex roots
        real = real_root_balls(to_flint_polynomial(factor).numer(), precision, positive=positive)
        if real is not None:
            return [enclosure_of_ball(ball) for ball in real]
    decided = decided_balls(factor, lambda ball: bool(ball.imag == 0), precision)
    roots = [enclosure_of_ball(ball.real) for ball, _, is_real in decided if is_real]
    return sorted(roots, key=lambda enclosure: enclosure.lower)


def _real_values(factor: Poly, count: int) -> list[Expr]:
    """Return so many real roots, ascending; SymPy factors the polynomial for the first alone."""
    values: list[Expr] = [real_root(factor, 0)] if count else []
    if not count:
        return values
    scale, first = values[0].as_coeff_Mul()
    for index in range(1, count):
        indexed = isinstance(first, sympy.CRootOf)
        values.append(
            scale * sympy.CRootOf._new(first.poly, index) if indexed else real_root(factor, index)
        )
    return values


def real_root(factor: Poly, index: int) -> Expr:
    """Return a real root, counted from the least, of a monic irreducible polynomial."""
    if factor.degree() > 2:
        return sympy.CRootOf(factor, index)
    if factor.degree() == 1:
        return -factor.TC() / factor.LC()
    b, c = (sympy.sympify(value) for value in factor.all_coeffs()[1:])
    sign = -1 if index == 0 else 1
    return sympy.expand((-b + sign * sympy.sqrt(b**2 - 4 * c)) / 2)


def _in(value: Expr, parameter: Symbol) -> Poly:
    return Poly(value, parameter, domain=QQ)
