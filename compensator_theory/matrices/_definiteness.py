"""Positive definiteness of rational matrices, decided by LDL' in balls or in rationals."""

from __future__ import annotations

import flint

from compensator_theory.polynomials._ball_precision import ball_precision

PRECISIONS = (256, 1024, 4096)
"""Bits of the balls that are tried before rational numbers."""


def is_positive_definite(matrix: flint.fmpq_mat) -> bool:
    """Decide whether a symmetric rational matrix is positive definite.

    The pivots of LDL' are computed in balls: if every ball is above 0, so is every pivot, and if
    one is below 0, the matrix is not definite. A ball that holds 0 needs more bits, and at last
    rational numbers, which also decide a singular matrix.
    """
    for bits in PRECISIONS:
        with ball_precision(bits):
            decision = pivots_are_positive([[flint.arb(e) for e in row] for row in _rows(matrix)])
        if decision is not None:
            return decision
    decision = pivots_are_positive(_rows(matrix))
    assert decision is not None
    return decision


def _rows(matrix: flint.fmpq_mat) -> list[list[flint.fmpq]]:
    rows: list[list[flint.fmpq]] = matrix.tolist() if matrix.nrows() else []
    return rows


def pivots_are_positive(rows: list[list[flint.fmpq]] | list[list[flint.arb]]) -> bool | None:
    """Return the sign of all pivots by elimination in place; None where a ball holds 0."""
    for k, pivot_row in enumerate(rows):
        pivot = pivot_row[k]
        if not pivot > 0:
            return False if pivot < 0 or pivot == 0 else None
        for i in range(k + 1, len(rows)):
            factor = pivot_row[i] / pivot
            if factor == 0:
                continue
            row = rows[i]
            for j in range(i, len(rows)):
                row[j] -= factor * pivot_row[j]
    return True
