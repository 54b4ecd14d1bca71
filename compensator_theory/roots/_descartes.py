"""Real roots of integer polynomials by Descartes' rule of signs and bisection."""

from __future__ import annotations

from itertools import pairwise
from typing import TypeAlias

import flint

from compensator_theory.polynomials._ball_precision import ball_precision

Interval: TypeAlias = tuple[flint.fmpq, flint.fmpq]

STEPS = 4
"""Bisections per degree after which roots count as too close for bisection."""

PRECISIONS = (128, 512, 2048)
"""Bits in which the sign of a value is decided before it is computed exactly."""

_ONE_MORE = flint.fmpz_poly([1, 1])


def distinct_real_roots(poly: flint.fmpz_poly) -> int | None:
    r"""Count the real roots of a square-free polynomial.

    .. math:: \mathrm{var}\,(1 + x)^d\,p\!\left(\frac{1}{1+x}\right) \in \{0, 1\}
              \;\Rightarrow\; \text{as many roots in } (0, 1)

    Notes
    -----
    The number of variations exceeds that of the roots by an even number, so 0 and 1 decide; other
    intervals are halved. Source: G. E. Collins and A. G. Akritas, SYMSAC (1976).
    """
    at_origin = 0
    if poly[0] == 0:
        at_origin, poly = 1, flint.fmpz_poly(poly.coeffs()[1:])
    mirrored = [-c if k % 2 else c for k, c in enumerate(poly.coeffs())]
    right, left = distinct_positive_roots(poly), distinct_positive_roots(flint.fmpz_poly(mirrored))
    return None if right is None or left is None else at_origin + right + left


def distinct_positive_roots(poly: flint.fmpz_poly) -> int | None:
    """Count the positive roots of a square-free polynomial; None where bisection takes too long."""
    intervals = positive_root_intervals(poly)
    return None if intervals is None else len(intervals)


def positive_root_intervals(poly: flint.fmpz_poly) -> list[Interval] | None:
    """Return an open interval for each positive root, or the root itself as both ends, ascending.

    The polynomial is square-free; None where bisection takes too long.
    """
    coefficients = poly.coeffs()
    variations = _variations(coefficients)
    if not variations:
        return []
    exponent = _bound(coefficients)
    top = flint.fmpq(2) ** exponent
    if variations == 1:
        return [(flint.fmpq(0), top)]
    octaves = exponent + _bound(coefficients[::-1])  # between the bounds of largest and least
    intervals = _unit_intervals(_stretched(poly, exponent), 2 * octaves)
    return None if intervals is None else [(top * a, top * b) for a, b in intervals]


def real_root_balls(
    poly: flint.fmpz_poly, precision: int, *, positive: bool = False
) -> list[flint.arb] | None:
    """Return balls of relative radius 2**-precision around the real roots, ascending.

    With `positive` around the positive ones. The polynomial is square-free and not 0 at 0; None
    where bisection takes too long. No complex root is isolated.
    """
    mirrored = flint.fmpz_poly([-c if k % 2 else c for k, c in enumerate(poly.coeffs())])
    right = positive_root_intervals(poly)
    left = [] if positive else positive_root_intervals(mirrored)
    if right is None or left is None:
        return None
    with ball_precision(precision + 8):
        above = [_narrowed(poly, interval, precision) for interval in right]
        below = [-_narrowed(mirrored, interval, precision) for interval in left]
    return below[::-1] + above


def _narrowed(poly: flint.fmpz_poly, interval: Interval, precision: int) -> flint.arb:
    """Bisect an interval in which a polynomial changes its sign once."""
    lower, upper = interval
    rises = (poly(lower) or poly.derivative()(lower)) < 0
    balls = flint.arb_poly(poly)
    while lower != upper and (upper - lower) * 2**precision > lower:
        middle = (lower + upper) / 2
        sign = _sign(poly, balls, middle)
        if sign == 0:
            lower = upper = middle
        elif (sign < 0) == rises:
            lower = middle
        else:
            upper = middle
    return flint.arb((lower + upper) / 2, (upper - lower) / 2)


def _sign(poly: flint.fmpz_poly, balls: flint.arb_poly, place: flint.fmpq) -> int:
    """Return the sign of a value; exact values have degree times as many bits as the place."""
    for bits in PRECISIONS:
        with ball_precision(bits):
            value = balls(flint.arb(place))
        if not value.contains(0):
            return 1 if value > 0 else -1
    exact = poly(place)
    return int(exact > 0) - int(exact < 0)


def _bound(coefficients: list[flint.fmpz]) -> int:
    """Return a k such that every positive root is below 2**k (Kioustelidis)."""
    degree, leading = len(coefficients) - 1, coefficients[-1]
    bits = abs(int(leading)).bit_length() - 1
    return 1 + max(
        -((bits - abs(int(c)).bit_length()) // (degree - k))
        for k, c in enumerate(coefficients)
        if c != 0 and (c > 0) != (leading > 0)
    )


def _stretched(poly: flint.fmpz_poly, exponent: int) -> flint.fmpz_poly:
    """Return p(2**k x) times a power of 2 that leaves it integer."""
    degree = poly.degree()
    shifts = (exponent * k if exponent > 0 else exponent * (k - degree) for k in range(degree + 1))
    return flint.fmpz_poly([c << n for c, n in zip(poly.coeffs(), shifts, strict=True)])


def _unit_intervals(poly: flint.fmpz_poly, more: int) -> list[Interval] | None:
    intervals: list[Interval] = []
    waiting = [(poly, flint.fmpq(0), flint.fmpq(1))]
    for _ in range(STEPS * poly.degree() + 40 + more):
        if not waiting:
            return sorted(intervals)
        poly, start, width = waiting.pop()
        variations = _variations(flint.fmpz_poly(poly.coeffs()[::-1])(_ONE_MORE).coeffs())
        if variations < 2:
            intervals += [(start, start + width)] * variations
            continue
        lower, middle = _stretched(poly, -1), start + width / 2
        upper = lower(_ONE_MORE)
        if upper[0] == 0:
            intervals.append((middle, middle))
            upper = flint.fmpz_poly(upper.coeffs()[1:])
        waiting += [(lower, start, width / 2), (upper, middle, width / 2)]
    return None if waiting else sorted(intervals)


def _variations(coefficients: list[flint.fmpz]) -> int:
    signs = [c > 0 for c in coefficients if c != 0]
    return sum(a != b for a, b in pairwise(signs))
