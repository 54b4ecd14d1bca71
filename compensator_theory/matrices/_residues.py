"""Matrices modulo large primes, and whole numbers from their residues."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from math import isqrt

import flint

WORD = 62 if sys.maxsize > 2**32 else 31
"""Bits of a prime: python-flint's go up to a word, which has 32 bits under Pyodide and on ARM."""


def primes() -> Iterator[int]:
    """Yield large primes of one word, the largest first."""
    candidate = 2**WORD - 1
    while True:
        if flint.fmpz(candidate).is_prime():
            yield candidate
        candidate -= 2


def large_prime() -> int:
    """Return the largest prime of one word."""
    return next(primes())


def pivots(matrix: flint.nmod_mat | flint.fmpz_mat) -> list[int]:
    """Return the first columns that span the column space, modulo a prime."""
    if isinstance(matrix, flint.fmpz_mat):
        matrix = flint.nmod_mat(matrix, large_prime())
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
