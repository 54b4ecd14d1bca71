"""Matrices modulo large primes, and whole numbers from their residues."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isqrt

import flint

PRIMES_BELOW = 2**62
"""The largest prime below comes first; python-flint's go up to 2^64."""


def primes() -> Iterator[int]:
    """Yield large primes, the largest first."""
    candidate = PRIMES_BELOW - 1
    while True:
        if flint.fmpz(candidate).is_prime():
            yield candidate
        candidate -= 2


def pivots(matrix: flint.nmod_mat | flint.fmpz_mat) -> list[int]:
    """Return the first columns that span the column space, modulo a prime."""
    if isinstance(matrix, flint.fmpz_mat):
        matrix = flint.nmod_mat(matrix, next(primes()))
    reduced, rank = matrix.rref()
    return [next(j for j, e in enumerate(row) if int(e)) for row in reduced.tolist()[:rank]]


def whole(values: Sequence[int], modulus: int) -> list[int] | None:
    """Return whole numbers without a common factor that are a multiple of residues, if short."""
    bound, common = isqrt(modulus // 2), 1
    for value in values:
        numerator, previous = value * common % modulus, modulus
        if min(numerator, modulus - numerator) <= bound:
            continue
        denominator, before = 1, 0  # Euclid's algorithm, stopped half way
        while numerator > bound:
            quotient = previous // numerator
            previous, numerator = numerator, previous - quotient * numerator
            before, denominator = denominator, before - quotient * denominator
        common *= abs(denominator)
        if common > bound:
            return None
    half = modulus // 2
    result = [(value * common + half) % modulus - half for value in values]
    content = int(flint.fmpz_poly(result).content()) if any(result) else 1
    return [x // content for x in result]
