"""Where certified roots lie: left of, on or right of the imaginary axis; inside the unit circle."""

import flint
from sympy import QQ, Poly

from compensator_theory.polynomials.reading import PolynomialLike
from compensator_theory.roots.certified import decided_balls
from compensator_theory.roots.counts import RootCount, require_rational
from compensator_theory.roots.reflections import reciprocal_polynomial
from compensator_theory.roots.unit_circle import fold_palindrome, is_inside


def locate_half_plane_roots(poly: PolynomialLike) -> RootCount:
    r"""Locate every root by its certified ball, relative to the imaginary axis.

    Parameters
    ----------
    poly : polynomial
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
    poly = require_rational(poly)
    s = poly.gen
    symmetric = poly.gcd(poly.compose(Poly(-s, s, domain=QQ)))
    others = decided_balls(poly.exquo(symmetric), lambda ball: _sign(ball.real))
    stable = sum(m for _, m, sign in others if sign < 0)
    at_origin, rest = _without_origin(symmetric)
    squares = Poly(rest.all_coeffs()[::2], s, domain=QQ)
    pairs = decided_balls(squares, lambda t: False if t.imag != 0 else _less(t.real, 0))
    on_axis = sum(m for _, m, is_on_axis in pairs if is_on_axis)
    each_side = int(squares.degree()) - on_axis
    degree = int(poly.degree())
    stable, boundary = stable + each_side, at_origin + 2 * on_axis
    return RootCount(stable, boundary, degree - stable - boundary)


def locate_unit_disk_roots(poly: PolynomialLike) -> RootCount:
    r"""Locate every root by its certified ball, relative to the unit circle.

    Parameters
    ----------
    poly : polynomial
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
    poly = require_rational(poly)
    degree = int(poly.degree())
    at_origin, rest = _without_origin(poly)
    symmetric = rest.gcd(reciprocal_polynomial(rest))
    others = decided_balls(rest.exquo(symmetric), is_inside)
    stable = at_origin + sum(m for _, m, inside in others if inside)
    boundary = 0
    for root in (1, -1):
        multiplicity, symmetric = _divided(symmetric, Poly([1, -root], poly.gen, domain=QQ))
        boundary += multiplicity
    folded = fold_palindrome(symmetric)
    pairs = decided_balls(folded, lambda t: False if t.imag != 0 else _less(abs(t.real), 2))
    on_circle = sum(m for _, m, is_on_circle in pairs if is_on_circle)
    stable += int(folded.degree()) - on_circle
    boundary += 2 * on_circle
    return RootCount(stable, boundary, degree - stable - boundary)


def _without_origin(poly: Poly) -> tuple[int, Poly]:
    return _divided(poly, Poly([1, 0], poly.gen, domain=QQ))


def _divided(poly: Poly, factor: Poly) -> tuple[int, Poly]:
    multiplicity = 0
    while True:
        quotient, remainder = poly.div(factor)
        if not remainder.is_zero:
            return multiplicity, poly
        multiplicity, poly = multiplicity + 1, quotient


def _sign(value: flint.arb) -> int | None:
    return -1 if value < 0 else 1 if value > 0 else None


def _less(value: flint.arb, bound: int) -> bool | None:
    return True if value < bound else False if value > bound else None
