"""Square-root method for Riccati equations: weights are not squared, P has no cancellation.

With weights [E_1 E_2]'[E_1 E_2] and P = S'S the recursion of the discrete-time regulator is one
least-squares problem,

    K = argmin norm([E_2; S B] K + [E_1; S A]),   S+ = the triangle of its residual,

so that a weight R_2 = E_2'E_2 of 1e-28 enters as 1e-14. The stationary P is the limit of
Kleinman's iteration (IEEE Trans. Automatic Control 13, 1968), Newton's method on the Riccati
equation: P of a stable loop A + BK from its Lyapunov equation, by doubling of its factor, then the
best K for that P. From any stabilising K it converges, monotonically and in the end quadratically.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.linalg import lapack

from rcac_numeric.arrays._array_types import Array

STEPS = 60  # largest number of Kleinman iterations: twenty from far away, five from near
SETTLED = 1e-15  # relative change of the gain, as z sees it
DOUBLINGS = 60  # 2^60 steps: enough for every spectral radius in float64


def triangle(rows: Array) -> Array:
    """Return an upper triangular S with S'S = rows'rows, of the same width."""
    n = rows.shape[1]
    if not rows.size:
        return np.zeros((n, n))
    # Householder's method is accurate row by row where the large rows come first.
    order = np.argsort(-np.abs(rows).max(axis=1, initial=0.0), kind="stable")
    S = np.zeros((n, n))
    # LAPACK itself: SciPy's function takes longer than these small matrices.
    triangular = lapack.dgeqrf(rows[order])[0][:n]
    S[: len(triangular)] = triangular
    S[_below(n)] = 0.0
    return S


@lru_cache(maxsize=64)
def _below(n: int) -> NDArray[np.bool_]:
    """Where a triangle of n rows has zeros."""
    return np.tri(n, k=-1, dtype=bool)


def stein_factor(A: Array, E: Array) -> Array:
    """Return S with S'S = sum over i of A'^i E'E A^i, for a spectral radius below 1."""
    with np.errstate(over="ignore", invalid="ignore"):
        return _doubled(triangle(E), A)


def _doubled(S: Array, power: Array) -> Array:
    for _ in range(DOUBLINGS):
        added = S @ power
        if not np.isfinite(added).all():
            raise np.linalg.LinAlgError("the sum overflows float64")
        S = triangle(np.vstack([S, added]))
        # Column by column, since the scales of the states may differ.
        is_small = np.abs(added).max(axis=0) <= 1e-18 * np.linalg.norm(S, axis=0)
        if is_small.all() and np.abs(power).max(initial=0.0) < 1e-9:
            return S
        power = power @ power
    raise np.linalg.LinAlgError("the sum does not converge")


def least_squares(X: Array, Y: Array) -> Array:
    """Return the K that minimises norm(X K + Y), X of full column rank, rows of any scale.

    Householder's QR with rows and columns interchanged: in each pivot column the largest row leads
    (M. J. D. Powell and J. K. Reid, IFIP Congress 1968), so that no row loses its own accuracy to a
    larger one. LAPACK's pivots columns alone, and rows that are sorted beforehand are not enough:
    where a large row has a small entry in the pivot column it mixes into all others.
    """
    columns = np.linalg.norm(X, axis=0)
    if not (columns > 0).all():
        raise np.linalg.LinAlgError("a column of zeros")
    scale = np.exp2(-np.round(np.log2(columns)))
    R, Z, size = X * scale, np.array(Y, dtype=np.float64), X.shape[1]
    if len(R) < size:
        raise np.linalg.LinAlgError("dependent columns")
    pivots = np.arange(size)
    for k in range(size):
        lead = k + int(np.argmax(np.linalg.norm(R[k:, k:], axis=0)))
        R[:, [k, lead]], pivots[[k, lead]] = R[:, [lead, k]], pivots[[lead, k]]
        row = k + int(np.argmax(np.abs(R[k:, k])))
        R[[k, row]], Z[[k, row]] = R[[row, k]], Z[[row, k]]
        if R[k, k] == 0:
            raise np.linalg.LinAlgError("dependent columns")
        v = R[k:, k].copy()
        v[0] += np.copysign(np.linalg.norm(v), v[0])
        twice = 2 / (v @ v)
        R[k:, k:] -= twice * np.outer(v, v @ R[k:, k:])
        Z[k:] -= twice * np.outer(v, v @ Z[k:])
    K = np.zeros((size, Y.shape[1]))
    K[pivots] = -linalg.solve_triangular(R[:size], Z[:size], check_finite=False)
    return np.asarray(K * scale[:, None])


def best_gain(A: Array, B: Array, E_1: Array, E_2: Array, S: Array) -> Array:
    """Return the gain that minimises the cost of one step plus the cost S'S of later steps."""
    return least_squares(np.vstack([E_2, S @ B]), np.vstack([E_1, S @ A]))


def kleinman(A: Array, B: Array, E_1: Array, E_2: Array, K: Array) -> tuple[Array, Array]:
    """Return (K, S) of the stabilising solution, from a stabilising K."""
    best: tuple[float, Array, Array] | None = None
    for _ in range(STEPS):
        if not is_stable(A + B @ K):
            break
        S = stein_factor(A + B @ K, E_1 + E_2 @ K)
        new = best_gain(A, B, E_1, E_2, S)
        # Change of the gain, measured by its effect on z.
        change = np.vstack([E_2, S @ B]) @ (new - K)
        whole = np.vstack([E_1 + E_2 @ K, S @ (A + B @ K)])
        relative_change = np.linalg.norm(change, axis=0) / np.maximum(
            np.linalg.norm(whole, axis=0), 1e-300
        )
        moved = float(relative_change.max(initial=0.0))
        if best is not None and moved >= 0.5 * best[0] and best[0] < 1e-8:
            break  # converged to rounding
        if best is None or moved < best[0]:
            best = moved, new, S
        if moved <= SETTLED:
            break
        K = new
    if best is None or not is_stable(A + B @ best[1]):
        raise np.linalg.LinAlgError("no stabilising gain")
    return best[1], best[2]


def starting_gains(A: Array, B: Array, E_1: Array, E_2: Array) -> Iterator[Array]:
    """Yield candidates of stabilising gains: structured pencil, larger weights of u."""
    yield from _attempt(A, B, E_1, E_2)
    size = max(np.abs(E_1).max(initial=0.0), np.abs(E_2).max(initial=0.0)) or 1.0
    for share in (1e-6, 1e-3, 1.0):
        more = share * size * np.eye(B.shape[1])
        rows = np.vstack([E_1, np.zeros((len(more), len(A))), 1e-3 * share * size * np.eye(len(A))])
        weighed = np.vstack([E_2, more, np.zeros((len(A), B.shape[1]))])
        yield from _attempt(A, B, rows, weighed)


def _attempt(A: Array, B: Array, E_1: Array, E_2: Array) -> Iterator[Array]:
    for balanced in (True, False):
        try:
            K = pencil_gain(A, B, E_1, E_2, balanced=balanced)
        except (np.linalg.LinAlgError, ValueError):
            continue
        if is_stable(A + B @ K):
            yield K


def pencil_gain(A: Array, B: Array, E_1: Array, E_2: Array, *, balanced: bool) -> Array:
    """Return K from the stable deflating subspace of the pencil in (x, lambda, u, z).

    x+ = A x + B u,  lambda = A' lambda+ + E_1' z,  0 = B' lambda+ + E_2' z,  z = E_1 x + E_2 u.
    """
    n, m, p = len(A), B.shape[1], len(E_1)
    Z = np.zeros
    left = np.block([
        [A, Z((n, n)), B, Z((n, p))],
        [Z((n, n)), -np.eye(n), Z((n, m)), E_1.T],
        [Z((m, 2 * n)), Z((m, m)), E_2.T],
        [E_1, Z((p, n)), E_2, -np.eye(p)],
    ])  # fmt: skip
    right = np.block([
        [np.eye(n), Z((n, n + m + p))],
        [Z((n, n)), -A.T, Z((n, m + p))],
        [Z((m, n)), -B.T, Z((m, m + p))],
        [Z((p, 2 * n + m + p))],
    ])  # fmt: skip
    columns = np.ones(len(left))
    if balanced:
        left, right, columns = balanced_pair(left, right)
    # The algebraic variables u and z are eliminated by an orthogonal transformation.
    Q = linalg.qr(left[:, 2 * n :], check_finite=False)[0][:, m + p :].T
    H, J = Q @ left[:, : 2 * n], Q @ right[:, : 2 * n]
    vectors = linalg.ordqz(H, J, sort="iuc", output="real", check_finite=False)[5]
    x, costate = vectors[:n, :n], vectors[n:, :n]
    # A later lambda is that of x+ on the subspace; u and z from the rows that hold no other step.
    x_next = np.linalg.lstsq(J @ vectors[:, :n], H @ vectors[:, :n], rcond=None)[0]
    rest = right[:, : 2 * n] @ np.vstack([x, costate]) @ x_next - left[:, : 2 * n] @ np.vstack(
        [x, costate]
    )
    uz = np.linalg.lstsq(left[:, 2 * n :], rest, rcond=None)[0]
    state = x * columns[:n, None]
    if np.linalg.cond(state) > 1e15:
        raise np.linalg.LinAlgError("the subspace has no basis in x")
    u = uz[:m] * columns[2 * n : 2 * n + m, None]
    return np.asarray(np.linalg.solve(state.T, u.T).T)


def balanced_pair(left: Array, right: Array) -> tuple[Array, Array, Array]:
    """Balance rows and columns by powers of two."""
    columns = np.ones(left.shape[1])
    for _ in range(3):
        both = np.abs(left) + np.abs(right)
        rows = np.exp2(-np.round(np.log2(np.maximum(both.max(axis=1), 1e-300))))
        left, right = rows[:, None] * left, rows[:, None] * right
        both = np.abs(left) + np.abs(right)
        scale = np.exp2(-np.round(np.log2(np.maximum(both.max(axis=0), 1e-300))))
        left, right, columns = left * scale, right * scale, columns * scale
    return left, right, columns


def is_stable(A: Array) -> bool:
    """Whether all eigenvalues are inside the unit circle."""
    if not np.isfinite(A).all():
        return False
    return bool(np.abs(np.linalg.eigvals(A)).max(initial=0.0) < 1)
