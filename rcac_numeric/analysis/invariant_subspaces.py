"""Invariant subspaces of a closed loop in float64, and the ways to choose among them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from compensator_theory.polynomials.ball_precision import ball_precision
from compensator_theory.roots.certified import root_balls
from rcac_numeric.arrays.array_types import Array, ComplexArray

# For one root: the columns that the regulator may take, and those that are left for the observer.
Choice = list[tuple[list[int], list[int]]]


def rounded_roots(Dtilde: Any) -> list[tuple[complex, int]]:
    """Return real roots and those of the upper half plane, correctly rounded, with multiplicity."""
    found = []
    with ball_precision(128):
        for ball, multiplicity in root_balls(Dtilde, 128):
            if ball.imag == 0:
                found.append((complex(float(ball.real.mid()), 0.0), multiplicity))
            elif ball.imag > 0:
                found.append((complex(ball.real.mid(), ball.imag.mid()), multiplicity))
    return found


def kernel_bases(
    loop: Array, roots: list[tuple[complex, int]]
) -> tuple[Array, ComplexArray, list[Choice]]:
    """Return columns that span the kernels, the root of each, and what may be chosen per root.

    A choice is a pair of lists of columns: those of the kernel of the power e for the regulator,
    and as many others as are left for the observer (of these only the roots matter).
    """
    columns: list[Array] = []
    values: list[complex] = []
    choices: list[Choice] = []
    for root, multiplicity in roots:
        is_real = root.imag == 0
        shifted = loop - (root.real if is_real else root) * np.eye(len(loop))
        degree = 1 if is_real else 2
        powers: list[list[int]] = [[]]
        for exponent in range(1, multiplicity + 1):
            rows = np.linalg.svd(np.linalg.matrix_power(shifted, exponent))[2]
            basis = rows[len(loop) - exponent :].conj().T
            real = basis if is_real else np.hstack([basis.real, basis.imag])
            powers.append(list(range(len(values), len(values) + degree * exponent)))
            columns.append(real)
            values += [root, root.conjugate()] * exponent if degree == 2 else [root] * exponent
        whole = powers[-1]
        choices.append([(power, whole[len(power) :]) for power in powers])
    return np.hstack(columns), np.array(values), choices


def selections(
    choices: list[Choice], n: int, n_c: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """List the columns of every regulator of degree n, and of the observer that is left."""
    tables = {0: (np.zeros((1, 0), np.intp), np.zeros((1, 0), np.intp))}
    for choice in choices:
        grown: dict[int, list[tuple[Any, Any]]] = {}
        for degree, (inner, outer) in tables.items():
            for taken, left in choice:
                if degree + len(taken) <= n:
                    rows = len(inner)
                    grown.setdefault(degree + len(taken), []).append(
                        (
                            np.hstack([inner, np.tile(np.array(taken, np.intp), (rows, 1))]),
                            np.hstack([outer, np.tile(np.array(left, np.intp), (rows, 1))]),
                        )
                    )
        tables = {
            degree: (
                np.vstack([inner for inner, _ in parts]),
                np.vstack([outer for _, outer in parts]),
            )
            for degree, parts in grown.items()
        }
    empty = np.zeros((0, n), np.intp), np.zeros((0, n_c), np.intp)
    return tables.get(n, empty)


def solved(matrices: Array, right: Array) -> Array:
    """Solutions of many systems of equations; not a number where a matrix is singular."""
    try:
        return np.asarray(np.linalg.solve(matrices, right))
    except np.linalg.LinAlgError:
        found = np.full(right.shape, np.nan)
        for i, (matrix, column) in enumerate(zip(matrices, right, strict=True)):
            try:
                found[i] = np.linalg.solve(matrix, column)
            except np.linalg.LinAlgError:
                continue
        return found


def least_sines(blocks: Array) -> Array:
    """The least singular value of each block of orthonormal columns."""
    if not len(blocks):
        return np.zeros(0)
    return np.asarray(np.linalg.svd(blocks, compute_uv=False)[:, -1])


def norms(matrices: Array) -> Array:
    """The Frobenius norm of each matrix."""
    return np.asarray(np.sqrt((matrices**2).sum(axis=(1, 2))))
