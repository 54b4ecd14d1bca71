"""Resolvents (zI - A)^{-1} at many points z, in the Hessenberg form of A."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import hessenberg

from rcac_numeric.arrays._array_types import Array, ComplexArray

# From this order on LAPACK is slower, since its threads synchronise at each point; below this
# order LAPACK is faster.
MANY_STATES = 48
POINTS_AT_ONCE = 64


class ShiftedHessenberg:
    """The LU factors of zI - H for an upper Hessenberg H and points z, rows exchanged as needed.

    Arrays have the points last: (n, points).
    """

    def __init__(self, H: Array, z: ComplexArray) -> None:
        n, self.points = len(H), len(z)
        self.upper: list[ComplexArray] = []
        self.factors: list[ComplexArray] = []
        self.swapped: list[Array] = []
        row = np.repeat(-H[0][:, None], len(z), axis=1).astype(np.complex128)
        row[0] += z
        for k in range(n - 1):
            below = np.repeat(-H[k + 1, k:][:, None], len(z), axis=1).astype(np.complex128)
            below[1] += z
            swap = np.abs(below[0]) > np.abs(row[0])
            if swap.any():
                pivot, below = np.where(swap, below, row), np.where(swap, row, below)
            else:
                pivot = row
            factor = below[0] / pivot[0]
            self.upper.append(pivot)
            self.factors.append(factor)
            self.swapped.append(swap)
            row = below[1:] - factor * pivot[1:]
        self.upper.append(row)

    def solve(self, right: ComplexArray) -> ComplexArray:
        """(zI - H)^{-1} right."""
        x = right.astype(np.complex128)
        for k, (factor, swap) in enumerate(zip(self.factors, self.swapped, strict=True)):
            if swap.any():
                x[k], x[k + 1] = np.where(swap, x[k + 1], x[k]), np.where(swap, x[k], x[k + 1])
            x[k + 1] -= factor * x[k]
        for k in range(len(x) - 1, -1, -1):
            x[k] -= (self.upper[k][1:] * x[k + 1 :]).sum(axis=0)
            x[k] /= self.upper[k][0]
        return x

    def solve_adjoint(self, right: ComplexArray) -> ComplexArray:
        """Solve with the conjugate transpose of zI - H."""
        x = right.astype(np.complex128)
        for k, upper in enumerate(self.upper):
            x[k] /= upper[0].conj()
            x[k + 1 :] -= upper[1:].conj() * x[k]
        for k in range(len(x) - 2, -1, -1):
            x[k] -= self.factors[k].conj() * x[k + 1]
            swap = self.swapped[k]
            if swap.any():
                x[k], x[k + 1] = np.where(swap, x[k + 1], x[k]), np.where(swap, x[k], x[k + 1])
        return x


def in_parts(H: Array, z: ComplexArray) -> Iterator[ShiftedHessenberg]:
    """Yield the factors for a few points at a time, so that they fit the processor's cache."""
    for start in range(0, len(z), POINTS_AT_ONCE):
        yield ShiftedHessenberg(H, z[start : start + POINTS_AT_ONCE])


def hessenberg_form(A: Array, B: Array, C: Array) -> tuple[Array, Array, Array]:
    """Return an equivalent system with a Hessenberg matrix."""
    if not np.tril(A, -2).any():
        return A, B, C
    H, Q = hessenberg(A, calc_q=True)
    return np.triu(H, -1), Q.T @ B, C @ Q


def inverse_norms(H: Array, z: ComplexArray) -> Array:
    """Return lower estimates of the 1-norms of (zI - H)^{-1}, by LAPACK's method.

    Source: N. J. Higham, ACM Transactions on Mathematical Software 14 (1988) 381-396.
    """
    n, norms = len(H), [np.zeros(0)]
    ends = (-1.0) ** np.arange(n) * (1 + np.arange(n) / max(n - 1, 1))
    for part in in_parts(H, z):
        x = np.full((n, part.points), 1.0 / n, dtype=np.complex128)
        best = np.zeros(part.points)
        for _ in range(3):
            y = part.solve(x)
            sizes = np.abs(y)
            best = np.maximum(best, sizes.sum(axis=0))  # infinite at a pole
            signs = np.where(sizes > 0, y / np.where(sizes > 0, sizes, 1.0), 1.0)
            largest = np.abs(part.solve_adjoint(signs)).argmax(axis=0)
            x = np.zeros((n, part.points), dtype=np.complex128)
            x[largest, np.arange(part.points)] = 1.0
        sizes = np.abs(part.solve(np.repeat(ends[:, None], part.points, axis=1))).sum(axis=0)
        best = np.maximum(best, 2 * sizes / (3 * n))
        norms.append(np.where(np.isfinite(best), best, np.inf))
    return np.concatenate(norms)


def responses(
    H: Array, B: Array, C: Array, z: ComplexArray, *, slopes: bool = False
) -> ComplexArray:
    """Return C (zI - H)^{-1} B or its derivative, (points, outputs, inputs); inf at a pole."""
    values = [np.zeros((0, len(C), B.shape[1]), np.complex128)]
    with np.errstate(all="ignore"):  # a pole among the points
        for part in in_parts(H, z):
            columns = []
            for column in B.T:
                states = part.solve(np.repeat(column[:, None], part.points, axis=1))
                states = -part.solve(states) if slopes else states
                # einsum instead of BLAS: its threads are slow for many small products
                columns.append([(row[:, None] * states).sum(axis=0) for row in C])
            values.append(np.array(columns).T)
    result = np.concatenate(values)
    result[~np.isfinite(result)] = np.inf
    return result
