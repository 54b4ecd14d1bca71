"""Location of certified roots: stable, on the boundary, or unstable."""

from __future__ import annotations

import flint
from sympy import QQ, Poly, Symbol

from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._reading import (
    PolynomialOrSystem,
    polynomial_in_time,
)
from compensator_theory.polynomials._variables import Time
from compensator_theory.roots._certified import decided_balls
from compensator_theory.roots._counts import require_rational
from compensator_theory.roots._reflections import reciprocal_polynomial
from compensator_theory.roots._root_counts import RootCount
from compensator_theory.roots._unit_circle import fold_palindrome, is_inside


@refusing
def locate_roots(
    poly: PolynomialOrSystem, variable: str | Symbol | None = None, *, time: Time | None = None
) -> RootCount:
    r"""Locate every root by its certified ball, relative to the boundary of stability.

    Parameters
    ----------
    poly : polynomial, or a Realisation or TransferFunction
        Rational coefficients, not zero.
    time : {"continuous", "discrete"}, optional
        Whether the boundary is the imaginary axis or the unit circle; default as for
        :func:`decide_stability`.
    variable : str or Symbol, optional
        Default: evident; of a list of coefficients s, in discrete time q.

    Raises
    ------
    InputError
        If the polynomial is zero or has symbolic coefficients, or `time` is missing or not that
        of the variable.

    Notes
    -----
    Balls of growing precision decide, after the roots that come in pairs :math:`\pm\lambda` or
    :math:`\lambda, 1/\lambda`, among them all roots on the boundary, have been separated: in
    :math:`\gcd(a(s), a(-s)) = s^j h(s^2)`, where a root of h is on the axis if it is real and
    negative, and in :math:`\gcd(a, a^*)`, folded by :math:`t = z + 1/z`, where a root t is on the
    circle if it is real and :math:`|t| \le 2`. In continuous time the route is independent of
    :func:`count_roots` but this gcd.

    Examples
    --------
    >>> from compensator_theory import locate_roots
    >>> print(locate_roots("(s + 1)**2*(s**2 + 2)*s"))
    2 stable, 3 on the boundary, 0 unstable
    >>> print(locate_roots("q*(q + 1)**2*(q - 3)"))
    1 stable, 2 on the boundary, 1 unstable
    """
    poly, time = polynomial_in_time(poly, time, variable)
    poly = require_rational(poly)
    s, discrete = poly.gen, time == "discrete"
    mirrored = reciprocal_polynomial(poly) if discrete else poly.compose(Poly(-s, s, domain=QQ))
    paired = poly.gcd(mirrored)
    others = decided_balls(poly.exquo(paired), is_inside if discrete else is_left_of_axis)
    stable = sum(m for _, m, is_stable in others if is_stable)
    boundary = 0
    for orientation in (1, -1) if discrete else (0,):
        multiplicity, paired = _divided(paired, Poly([1, -orientation], s, domain=QQ))
        boundary += multiplicity
    folded = fold_palindrome(paired) if discrete else Poly(paired.all_coeffs()[::2], s, domain=QQ)

    def is_on_boundary(t: flint.acb) -> bool | None:
        if t.imag != 0:
            return False
        return _less(abs(t.real), 2) if discrete else _less(t.real, 0)

    pairs = decided_balls(folded, is_on_boundary)
    on_boundary = sum(m for _, m, is_on in pairs if is_on)
    stable += int(folded.degree()) - on_boundary
    boundary += 2 * on_boundary
    return RootCount(stable, boundary, int(poly.degree()) - stable - boundary)


def is_left_of_axis(ball: flint.acb) -> bool | None:
    """Return whether a complex ball lies left of the imaginary axis; None if it meets the axis."""
    return _less(ball.real, 0)


def _divided(poly: Poly, factor: Poly) -> tuple[int, Poly]:
    multiplicity = 0
    while True:
        quotient, remainder = poly.div(factor)
        if not remainder.is_zero:
            return multiplicity, poly
        multiplicity, poly = multiplicity + 1, quotient


def _less(value: flint.arb, bound: int) -> bool | None:
    return True if value < bound else False if value > bound else None
