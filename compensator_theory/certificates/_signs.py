"""Witnesses of signs in whole numbers: rows of Routh and of Schur and Cohn, rounded factors."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

import flint

from compensator_theory.matrices._definiteness import is_positive_definite
from compensator_theory.polynomials._ball_precision import ball_precision

Rows: TypeAlias = list[tuple[int, list[int]]]
Factor: TypeAlias = tuple[int, list[int], list[list[int]]]


def hurwitz_rows(ascending: Sequence[int]) -> Rows | None:
    """Return Routh's array as polynomials, each with the factor that it is divided by; or None.

    Each row is b p - a s h(s), with a, b the first two coefficients of p, h its terms with the
    parity of the second: a positive multiple of the next polynomial of Routh's algorithm.
    """

    def row(p: list[int]) -> list[int] | None:
        n = len(p) - 2
        if p[n] <= 0:
            return None
        return [
            p[n] * c - (0 if i == 0 or i % 2 == n % 2 else p[n + 1] * p[i - 1])
            for i, c in enumerate(p[:-1])
        ]

    return _rows(ascending, row)


def schur_rows(ascending: Sequence[int]) -> Rows | None:
    """Return the table of Schur and Cohn, each row with the factor that divides it; or None."""

    def row(p: list[int]) -> list[int] | None:
        n = len(p) - 1
        if abs(p[0]) >= abs(p[n]):
            return None
        return [p[n] * p[i + 1] - p[0] * p[n - i - 1] for i in range(n)]

    return _rows(ascending, row)


def _rows(ascending: Sequence[int], step: Callable[[list[int]], list[int] | None]) -> Rows | None:
    p, rows = list(ascending), []
    if p[-1] <= 0:
        return None
    while len(p) > 1:
        following = step(p)
        if following is None:
            return None
        common = math.gcd(*following)
        p = [c // common for c in following]
        rows.append((common, p))
    return rows


def definite_factor(matrix: Sequence[Sequence[int]]) -> Factor | None:
    """Return s, w and F such that s W M W - F'F is strictly diagonally dominant; None if not M > 0.

    W = diag(w) are powers of 2 that make the diagonal about even, F a rounded factor of Cholesky of
    slightly less. Its entries have about half the bits of M, and more where M is ill conditioned.
    """
    n = len(matrix)
    if any(matrix[i][j] != matrix[j][i] for i in range(n) for j in range(i)):
        return None
    if not is_positive_definite(
        flint.fmpq_mat(n, n, [flint.fmpq(e) for row in matrix for e in row])
    ):
        return None
    sizes = [row[i].bit_length() for i, row in enumerate(matrix)]
    largest = max(sizes, default=0)
    weights = [1 << ((largest - size) // 2) for size in sizes]
    bits = 2 * n.bit_length() + 12
    while True:
        shift = max(0, 2 * bits - largest)
        scaled = [[(w * e * v) << shift for e, v in zip(row, weights, strict=True)]
                  for row, w in zip(matrix, weights, strict=True)]  # fmt: skip
        factor = _rounded_cholesky(
            scaled, 1 << max(0, largest + shift - bits + 2 * n.bit_length() + 2)
        )
        if factor is not None and _is_dominant(scaled, factor):
            return 1 << shift, weights, factor
        bits += bits // 2


def _rounded_cholesky(matrix: list[list[int]], less: int) -> list[list[int]] | None:
    """Return the rounded upper factor of M - less I; None if a pivot is not positive."""
    n = len(matrix)
    rows: list[list[flint.arb]] = []
    with ball_precision(2 * max((row[i].bit_length() for i, row in enumerate(matrix)), default=1)):
        for i in range(n):
            row = [flint.arb(0)] * n
            for j in range(i, n):
                entry = flint.arb(matrix[i][j] - (less if i == j else 0))
                for k in range(i):
                    entry -= rows[k][i] * rows[k][j]
                if j > i:
                    row[j] = entry / row[i]
                elif entry > 0:
                    row[i] = entry.sqrt()
                else:
                    return None
            rows.append(row)
        return [[_nearest(e) for e in row] for row in rows]


def _nearest(ball: flint.arb) -> int:
    mantissa, exponent = ball.mid().man_exp()
    return (
        int(mantissa) << int(exponent)
        if exponent >= 0
        else (int(mantissa) + (1 << int(-exponent - 1))) >> int(-exponent)
    )


def _is_dominant(matrix: list[list[int]], factor: list[list[int]]) -> bool:
    columns = list(zip(*factor, strict=True))
    for i, row in enumerate(matrix):
        rest = [e - sum(map(int.__mul__, columns[i], columns[j])) for j, e in enumerate(row)]
        if rest[i] <= sum(abs(r) for j, r in enumerate(rest) if j != i):
            return False
    return True
