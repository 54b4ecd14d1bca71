"""Real roots of integer polynomials by Descartes' rule of signs and bisection."""

from __future__ import annotations

from itertools import pairwise

import flint

STEPS = 4
"""Bisections per degree after which roots count as too close for bisection."""

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
    coefficients = poly.coeffs()
    variations = _variations(coefficients)
    if variations < 2:
        return variations
    exponent = _bound(coefficients)
    return _roots_in_unit_interval(_stretched(poly, exponent))


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


def _roots_in_unit_interval(poly: flint.fmpz_poly) -> int | None:
    intervals, waiting = 0, [poly]
    for _ in range(STEPS * poly.degree() + 40):
        if not waiting:
            return intervals
        poly = waiting.pop()
        variations = _variations(flint.fmpz_poly(poly.coeffs()[::-1])(_ONE_MORE).coeffs())
        if variations < 2:
            intervals += variations
            continue
        lower = _stretched(poly, -1)
        upper = lower(_ONE_MORE)
        if upper[0] == 0:  # the midpoint itself
            intervals, upper = intervals + 1, flint.fmpz_poly(upper.coeffs()[1:])
        waiting += [lower, upper]
    return None if waiting else intervals


def _variations(coefficients: list[flint.fmpz]) -> int:
    signs = [c > 0 for c in coefficients if c != 0]
    return sum(a != b for a, b in pairwise(signs))
