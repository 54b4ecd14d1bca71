"""Where certified roots lie: left of, on or right of the imaginary axis; inside the unit circle."""

from collections.abc import Callable
from typing import Any

import flint
from sympy import QQ, Poly

from .reciprocals import reciprocal_polynomial
from .root_counts import RootCount, require_rational
from .roots import root_balls
from .unit_circle import fold_palindrome


def locate_half_plane_roots(poly: Poly) -> RootCount:
    r"""Locate every root by its certified ball, relative to the imaginary axis.

    Parameters
    ----------
    poly : sympy.Poly
        Rational coefficients, not zero.

    Raises
    ------
    InputError
        If the polynomial is zero or has symbolic coefficients.

    Notes
    -----
    Balls of growing precision decide, after the roots that come in pairs :math:`\pm\lambda`, among
    them all roots on the axis, have been separated in :math:`\gcd(a(s), a(-s)) = s^j h(s^2)`: a
    root of h is on the axis if it is real and negative. The route shares nothing with
    :func:`count_half_plane_roots` but this gcd.

    Examples
    --------
    >>> from compensator_theory import locate_half_plane_roots, polynomial
    >>> print(locate_half_plane_roots(polynomial("(s + 1)**2*(s**2 + 2)*s")))
    2 stable, 3 on the boundary, 0 unstable
    """
    require_rational(poly)
    s = poly.gen
    symmetric = poly.gcd(poly.compose(Poly(-s, s, domain=QQ)))
    others = decided_balls(poly.exquo(symmetric), lambda ball: ball.real < 0 or ball.real > 0)
    stable = sum(m for ball, m in others if ball.real < 0)
    at_origin, rest = _without_origin(symmetric)
    squares = Poly(rest.all_coeffs()[::2], s, domain=QQ)
    pairs = decided_balls(squares, lambda t: t.imag != 0 or t.real < 0 or t.real > 0)
    on_axis = sum(m for t, m in pairs if t.imag == 0 and t.real < 0)
    each_side = int(squares.degree()) - on_axis
    degree = int(poly.degree())
    stable, boundary = stable + each_side, at_origin + 2 * on_axis
    return RootCount(stable, boundary, degree - stable - boundary)


def locate_unit_disk_roots(poly: Poly) -> RootCount:
    r"""Locate every root by its certified ball, relative to the unit circle.

    Parameters
    ----------
    poly : sympy.Poly
        Rational coefficients, not zero.

    Raises
    ------
    InputError
        If the polynomial is zero or has symbolic coefficients.

    Notes
    -----
    Balls of growing precision decide, after the roots that come in pairs
    :math:`\lambda, 1/\lambda`, among them all roots on the circle, have been separated in
    :math:`\gcd(a, a^*)` and folded by :math:`t = z + 1/z`: a root t is on the circle if it is real
    and :math:`|t| \le 2`.

    Examples
    --------
    >>> from compensator_theory import locate_unit_disk_roots, polynomial
    >>> print(locate_unit_disk_roots(polynomial("q*(q + 1)**2*(q - 3)")))
    1 stable, 2 on the boundary, 1 unstable
    """
    require_rational(poly)
    degree = int(poly.degree())
    at_origin, rest = _without_origin(poly)
    symmetric = rest.gcd(reciprocal_polynomial(rest))
    others = decided_balls(rest.exquo(symmetric), lambda ball: abs(ball) < 1 or abs(ball) > 1)
    stable = at_origin + sum(m for ball, m in others if abs(ball) < 1)
    boundary = 0
    for root in (1, -1):
        multiplicity, symmetric = _divided(symmetric, Poly([1, -root], poly.gen, domain=QQ))
        boundary += multiplicity
    folded = fold_palindrome(symmetric)
    pairs = decided_balls(folded, lambda t: t.imag != 0 or abs(t.real) < 2 or abs(t.real) > 2)
    on_circle = sum(m for t, m in pairs if t.imag == 0 and abs(t.real) < 2)
    stable += int(folded.degree()) - on_circle
    boundary += 2 * on_circle
    return RootCount(stable, boundary, degree - stable - boundary)


def decided_balls(
    poly: Poly, is_decided: Callable[[Any], bool], precision: int = 64
) -> list[tuple[Any, int]]:
    """Isolate the roots with growing precision until each ball answers a question.

    Parameters
    ----------
    poly : sympy.Poly
        Rational coefficients, not zero.
    is_decided : callable
        Of a python-flint complex ball; must become true for small enough balls around every root.
    precision : int
        Bits to begin with.

    Returns
    -------
    list of (flint.acb, int)
        Balls and multiplicities.

    Examples
    --------
    >>> from compensator_theory import polynomial
    >>> from compensator_theory.root_regions import decided_balls
    >>> len(decided_balls(polynomial("q**2 - 2"), lambda ball: ball.real > 0 or ball.real < 0))
    2
    """
    while True:
        with flint.ctx.workprec(precision):
            balls = root_balls(poly, precision)
            if all(is_decided(ball) for ball, _ in balls):
                return balls
        precision *= 2


def _without_origin(poly: Poly) -> tuple[int, Poly]:
    return _divided(poly, Poly([1, 0], poly.gen, domain=QQ))


def _divided(poly: Poly, factor: Poly) -> tuple[int, Poly]:
    multiplicity = 0
    while True:
        quotient, remainder = poly.div(factor)
        if not remainder.is_zero:
            return multiplicity, poly
        multiplicity, poly = multiplicity + 1, quotient
