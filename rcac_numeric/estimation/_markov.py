"""The matrix H~ of Markov parameters of RCMR, and its solvability."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from compensator_theory.errors import IllConditionedError, InputError
from rcac_numeric.arrays._array_types import Array

# Singular values below this share of the largest are rounding errors of the Markov parameters.
ROUNDING = 1e-12


def retrospective_matrix(
    A: Array, B: Array, C: Array, delays: Sequence[int], stack: Sequence[int]
) -> Array:
    """H~ of (8.45): block (j, i) is H_{i-k_j} = C A^(i-k_j-1) B, zero before u^ can act."""
    powers, markov = C, []
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(max(delays)):
            markov.append(powers @ B)
            powers = powers @ A
    if not np.isfinite(markov).all():
        raise InputError(
            f"C A^{max(delays) - 1} B leaves float64; scale the states, or take smaller delays."
        )
    zero = np.zeros((C.shape[0], B.shape[1]))
    blocks = [[markov[i - k_j - 1] if i > k_j else zero for i in delays] for k_j in stack]
    return np.ascontiguousarray(np.block(blocks))


def require_solvable(H: Array, method: str, eta_bar: float, delays: Sequence[int]) -> None:
    """Raise an error if the reconstruction has no solution."""
    values = np.linalg.svd(H, compute_uv=False)
    rank = int((values > ROUNDING * values.max(initial=0.0)).sum())
    if not np.isfinite(H).all():
        raise IllConditionedError(
            f"the Markov parameters H_i of delays up to {max(delays)} leave the range of float64: "
            "the model is unstable. Use shorter delays."
        )
    if rank == 0:
        raise IllConditionedError(
            f"the Markov parameters of the delays {tuple(delays)} are zero: z does not depend on "
            "these outputs of the subsystem. Use longer delays, or another C."
        )
    columns = H.shape[1]
    if method == "smallest" and eta_bar == 0 and rank < columns:
        raise IllConditionedError(
            f"(8.56) is singular: H~ has {columns} columns and rank {rank}. Use "
            'method="nearest", fewer delays, more stacked steps, or eta_bar > 0.'
        )


def reconstruction(H: Array, R: Array, chosen: slice) -> tuple[Array, Array, Array]:
    """(lambda, V_d, W) with V_d (diag(lambda) + eta)^-1 W = the rows `chosen` of A(k)^-1 H~'R.

    H~'R H~ = V diag(lambda) V'. Its null space is left out: H~'R has no part in it.
    """
    root = np.linalg.cholesky(R)
    left, values, right = np.linalg.svd(root.T @ H, full_matrices=False)
    significant = values > ROUNDING * values.max()
    V, weights = right[significant].T, values[significant, None] * (left[:, significant].T @ root.T)
    return (
        values[significant] ** 2,
        np.ascontiguousarray(V[chosen]),
        np.ascontiguousarray(weights),
    )
