"""The equation a x + b y = c of coprime polynomials, without its Sylvester matrix."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, islice
from math import isqrt

import flint
from sympy import Poly

from compensator_theory.matrices._flint_polynomials import (
    from_flint_polynomial,
    to_flint_polynomial,
)
from compensator_theory.matrices._residues import primes

TALL = 100
"""Bits of the resultant per degree above which remainder sequences grow too long (measured)."""
LONG = 10_000
"""Bits of a modulus above which a resultant takes less than rational reconstruction (measured)."""

Pair = tuple[flint.fmpz_poly, flint.fmpz_poly]


def solve_coprime_equation(a: Poly, b: Poly, c: Poly) -> tuple[Poly, Poly] | None:
    r"""Solve for the multiplier of least degree, exactly and verified.

    .. math:: a\,x + b\,y = c, \qquad \deg y < \deg a

    Notes
    -----
    With small coefficients y is c times the inverse of b modulo a, by the extended Euclidean
    algorithm. Where the resultant is long (integer roots 1, ..., n for instance) that inverse
    swells far beyond the answer, which is computed p-adically: one inverse modulo a prime of 61
    bits, one small product for each 61 bits of x and y. A short common denominator is reconstructed
    from the residues; a long one divides the resultant (Cramer's rule), with half as many residues.
    The returned polynomials are verified in the equation.
    """
    first, second, goal = (to_flint_polynomial(p) for p in (a, b, c))
    equation = None
    if first.degree() > 1 and _is_tall(first, second):
        if first.gcd(second).degree() > 0:
            return None
        equation = _p_adic(first, second, goal)
    equation = _euclidean(first, second, goal) if equation is None else equation
    if equation is None:
        return None
    x, y = equation
    return from_flint_polynomial(x, a.gen), from_flint_polynomial(y, a.gen)


def _is_tall(a: flint.fmpq_poly, b: flint.fmpq_poly) -> bool:
    """Return whether Hadamard's bound of the resultant is large compared with the degree."""
    m, n = a.degree(), b.degree()
    heights = (abs(p.numer().height_bits()) for p in (a, b))
    return bool(sum(d * h for d, h in zip((n, m), heights, strict=True)) > TALL * (m + n))


def _euclidean(
    a: flint.fmpq_poly, b: flint.fmpq_poly, c: flint.fmpq_poly
) -> tuple[flint.fmpq_poly, flint.fmpq_poly] | None:
    gcd, inverse, _ = b.xgcd(a)
    if gcd.degree() > 0:
        return None
    y = (c * inverse) % a
    return (c - b * y) // a, y


def _p_adic(
    a: flint.fmpq_poly, b: flint.fmpq_poly, c: flint.fmpq_poly
) -> tuple[flint.fmpq_poly, flint.fmpq_poly] | None:
    """Return the solution, or None where three primes divide a leading coefficient or resultant."""
    integers = [p.numer() for p in (a, b, c)]
    for prime in islice(primes(), 3):
        if int(integers[0].leading_coefficient()) % prime == 0:
            continue
        modulus, inverted = (flint.nmod_poly(p, prime) for p in integers[:2])
        gcd, inverse, _ = inverted.xgcd(modulus)
        if not gcd.is_one():
            continue
        x, y, denominator = _lifted(integers, modulus, inverted, inverse, prime)
        scale = [flint.fmpq(p.denom()) for p in (a, b, c)]
        return tuple(
            flint.fmpq_poly(part) * (scale_of / scale[2] / denominator)
            for part, scale_of in ((x, scale[0]), (y, scale[1]))
        )
    return None


def _lifted(
    integers: Sequence[flint.fmpz_poly],
    a_p: flint.nmod_poly,
    b_p: flint.nmod_poly,
    inverse: flint.nmod_poly,
    p: int,
) -> tuple[flint.fmpz_poly, flint.fmpz_poly, flint.fmpz]:
    """Return x, y and d with a x + b y = d c."""
    a, b, c = integers
    left, digits = c, ([], [])  # type: tuple[flint.fmpz_poly, tuple[list[flint.fmpz_poly], ...]]
    exponent, multiple = 4, None
    while True:
        while len(digits[0]) < exponent:
            residue = flint.nmod_poly(left, p)
            product = residue * inverse
            y_p = product - (product // a_p) * a_p
            x_p = (residue - b_p * y_p) // a_p
            x, y = (flint.fmpz_poly([int(value) for value in q.coeffs()]) for q in (x_p, y_p))
            rest = left - a * x - b * y
            left = flint.fmpz_poly([value // p for value in rest.coeffs()])
            digits[0].append(x)
            digits[1].append(y)
        modulus = flint.fmpz(p) ** exponent
        if multiple is None and modulus.bit_length() > LONG:
            multiple = _multiple_of_denominator(a, b, c)
        residues = [_value(part, flint.fmpz(p)) for part in digits]
        candidate = _reconstructed(residues, modulus, multiple)
        if candidate is not None:
            (x, y), d = candidate
            if a * x + b * y == c * d:
                return x, y, d
        exponent += exponent // 4 + 2


def _value(digits: Sequence[flint.fmpz_poly], base: flint.fmpz) -> flint.fmpz_poly:
    """Return the sum of digits times powers of the base, by halves."""
    parts = list(digits)
    while len(parts) > 1:
        pairs = [*zip(parts[::2], parts[1::2], strict=False)]
        odd = parts[-1:] if len(parts) % 2 else []
        parts = [low + base * high for low, high in pairs] + odd
        base = base * base
    return parts[0]


def _multiple_of_denominator(
    a: flint.fmpz_poly, b: flint.fmpz_poly, c: flint.fmpz_poly
) -> flint.fmpz:
    """Return the determinant of the linear equations for the coefficients of x and y."""
    more = max(0, c.degree() + 1 - a.degree() - b.degree())  # coefficients of x: leading a below
    return a.resultant(b) * a.leading_coefficient() ** more


def _reconstructed(
    residues: Sequence[flint.fmpz_poly], modulus: flint.fmpz, multiple: flint.fmpz | None
) -> tuple[Pair, flint.fmpz] | None:
    """Reconstruct polynomials over one denominator from residues modulo p^k, or return None."""
    room = 3 * modulus.bit_length() // 4  # a share: v w = u modulo p^k is then v w = u
    d = flint.fmpz(1) if multiple is None else multiple
    for value in chain.from_iterable(q.coeffs() for q in residues):
        if _centred(value * d, modulus).bit_length() > room:
            if multiple is not None:
                return None
            d *= _denominator(int(value * d % modulus), int(modulus))
            if d.bit_length() + _centred(value * d, modulus).bit_length() > room:
                return None
    return tuple(_scaled(q, d, modulus) for q in residues), d


def _scaled(poly: flint.fmpz_poly, d: flint.fmpz, modulus: flint.fmpz) -> flint.fmpz_poly:
    return flint.fmpz_poly([_centred(value * d, modulus) for value in poly.coeffs()])


def _centred(value: flint.fmpz, modulus: flint.fmpz) -> flint.fmpz:
    residue = value % modulus
    return residue - modulus if 2 * residue > modulus else residue


def _denominator(value: int, modulus: int) -> int:
    """Return the v of the fraction u/v = value modulo the modulus with small u and v."""
    bound = isqrt(modulus // 2)
    *_, denominator = _remainders(value, modulus, bound)
    return denominator


def _remainders(value: int, modulus: int, bound: int) -> Iterator[int]:
    before, now, last, factor = modulus, value, 0, 1
    yield 1
    while now > bound:
        quotient = before // now
        before, now = now, before - quotient * now
        last, factor = factor, last - quotient * factor
        yield abs(factor)
