"""The real values of a parameter at which a root may lie on the boundary of stability."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import flint
import sympy
from sympy import QQ, Expr, Poly, Rational, Symbol

from compensator_theory.matrices._flint_polynomials import to_flint_polynomial
from compensator_theory.polynomials._ball_precision import at_growing_precision
from compensator_theory.roots._certified import decided_balls
from compensator_theory.roots._enclosures import Enclosure, enclosure_of_ball
from compensator_theory.stability._half_plane import half_plane_polynomial


@dataclass(frozen=True)
class CriticalValue:
    """A real algebraic number, exact and between two rational numbers.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.stability._critical_values import real_roots
    >>> [str(root.value) for root in real_roots([polynomial("k**2 - 2")])]
    ['-sqrt(2)', 'sqrt(2)']
    """

    value: Expr
    enclosure: Enclosure


def critical_polynomials(poly: Poly, parameter: Symbol, *, discrete: bool) -> list[Poly] | None:
    r"""Return polynomials in the parameter that vanish where a root is on the boundary.

    With q(s) = E(s^2) + s O(s^2) they are q(0), the leading coefficient and the resultant
    :math:`\mathrm{Res}_t(E, O)`: Hurwitz's determinant :math:`\Delta_{n-1}` up to powers of the
    other two (Orlando).

    Parameters
    ----------
    poly : sympy.Poly
        In s or z, its coefficients polynomials in the parameter.
    parameter : Symbol
    discrete : bool
        Whether the boundary is the unit circle.

    Returns
    -------
    list of sympy.Poly, or None
        None where there is a root on the boundary, or one on each side, for every value.

    Examples
    --------
    >>> from sympy.abc import k
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.stability._critical_values import critical_polynomials
    >>> found = critical_polynomials(polynomial("s**2 + k*s + 2 - k", "s"), k, discrete=False)
    >>> [p.as_expr() for p in found]
    [1, 2 - k, k]
    """
    q = half_plane_polynomial(poly) if discrete else poly
    found = [_in(poly.LC(), parameter)]
    for factor, _ in Poly(q.as_expr(), q.gen, parameter, domain=QQ).factor_list()[1]:
        part = Poly(factor.as_expr(), q.gen)
        even, odd = even_and_odd(part)
        if part.degree() > 0 and (even.is_zero or odd.is_zero):
            return None  # its roots come in pairs that are symmetric about 0, or it is s
        found += [_in(part.LC(), parameter), _in(part.TC(), parameter)]
        if part.degree() > 1:
            found.append(_in(even.resultant(odd), parameter))
    if discrete and q.degree() < poly.degree():
        return None  # -1 is a root for every value
    return list(dict.fromkeys(found))


def even_and_odd(poly: Poly) -> tuple[Poly, Poly]:
    """Return E and O of q(s) = E(s^2) + s O(s^2).

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.stability._critical_values import even_and_odd
    >>> [p.as_expr() for p in even_and_odd(polynomial("s**3 + 2*s**2 + 3*s + 4"))]
    [2*s + 4, s + 3]
    """
    ascending = list(reversed(poly.all_coeffs()))
    even, odd = (Poly(list(reversed(ascending[k::2])) or [0], poly.gen) for k in (0, 1))
    return even, odd


def real_roots(polys: list[Poly]) -> list[CriticalValue]:
    """Return the distinct real roots of rational polynomials in ascending order.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.stability._critical_values import real_roots
    >>> [str(r.value) for r in real_roots([polynomial("k**3 - 2"), polynomial("3*k - 1")])]
    ['1/3', 'CRootOf(k**3 - 2, 0)']
    """
    factors = {
        factor.monic() for poly in polys if not poly.is_zero for factor, _ in poly.factor_list()[1]
    }

    def attempt(bits: int) -> list[CriticalValue] | None:
        found = [root for factor in factors for root in _roots_of_factor(factor, bits)]
        found.sort(key=lambda root: root.enclosure.lower)
        apart = all(a.enclosure.upper < b.enclosure.lower for a, b in pairwise(found))
        return found if apart else None

    return at_growing_precision(attempt, 64, "the order of real roots")  # distinct: irreducible


def signs_at_real_roots(poly: Poly, factor: Poly) -> list[int]:
    """Return the signs of a polynomial at the real roots, ascending, of an irreducible one.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.stability._critical_values import signs_at_real_roots
    >>> signs_at_real_roots(polynomial("k + 1"), polynomial("k**2 - 2"))
    [-1, 1]
    """
    rest = to_flint_polynomial(poly.rem(factor))

    def decide(ball: flint.acb) -> int | None:
        if ball.imag != 0 or not rest:
            return 0
        there = flint.arb_poly(rest)(ball.real)  # at the precision of the ball
        return 1 if there > 0 else -1 if there < 0 else None

    decided = [(b.real, sign) for b, _, sign in decided_balls(factor, decide) if b.imag == 0]
    return [sign for _, sign in sorted(decided, key=lambda pair: pair[0].mid())]


def cells_between(ends: list[CriticalValue]) -> list[tuple[Expr, Expr, Rational]]:
    """Return the open intervals that ascending end points leave of the line, each with a sample.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.stability._critical_values import cells_between, real_roots
    >>> cells_between(real_roots([polynomial("2*k - 1")]))
    [(-oo, 1/2, 0), (1/2, oo, 1)]
    """
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
    """Return a short rational number between two others.

    Examples
    --------
    >>> from sympy import Rational
    >>> from compensator_theory.stability._critical_values import number_between
    >>> number_between(Rational(0), Rational(3, 10))
    1/4
    """
    bits = 0
    while True:  # a multiple of 2**-bits
        number = Rational(sympy.floor(lower * 2**bits) + 1, 2**bits)
        if number < upper:
            return number
        bits += 1


def _roots_of_factor(factor: Poly, precision: int) -> list[CriticalValue]:
    decided = decided_balls(factor, lambda ball: bool(ball.imag == 0), precision)
    found = [enclosure_of_ball(ball.real) for ball, _, is_real in decided if is_real]
    ascending = sorted(found, key=lambda enclosure: enclosure.lower)
    return [CriticalValue(real_root(factor, i), place) for i, place in enumerate(ascending)]


def real_root(factor: Poly, index: int) -> Expr:
    """Return a real root, counted from the least, of a monic irreducible polynomial.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.stability._critical_values import real_root
    >>> real_root(polynomial("k**2 - 2"), 1)
    sqrt(2)
    """
    if factor.degree() > 2:
        return sympy.CRootOf(factor, index)
    if factor.degree() == 1:
        return -factor.TC() / factor.LC()
    b, c = (sympy.sympify(value) for value in factor.all_coeffs()[1:])
    sign = -1 if index == 0 else 1
    return sympy.expand((-b + sign * sympy.sqrt(b**2 - 4 * c)) / 2)


def _in(value: Expr, parameter: Symbol) -> Poly:
    return Poly(value, parameter, domain=QQ)
