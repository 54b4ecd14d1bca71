"""Difference equations of a compensator in state space, by deadbeat observers of its state."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rcac_numeric.arrays.array_types import Array

Coefficients = tuple[Array, Array]
# Singular values below these shares of the largest count as zero; each is tried.
TOLERANCES = (1e-13, 1e-11, 1e-9, 1e-7, 1e-5)


def difference_equations(
    A: Array, B: Array, C: Array, D: Array
) -> Iterator[tuple[Coefficients, Array]]:
    """Coefficients (P, Q) of (2.28) for a compensator, and a basis of the states that they keep.

    With A - F W'C nilpotent, x(k) is a combination of the last few u and y, and so is u(k):

    P_i = C (A - F W'C)^(i-1) F W',  Q_i = C (A - F W'C)^(i-1) (B - F W'D),  Q_0 = D

    Whatever W is, the poles of P are those of A and zeros. Which outputs W'u the observer reads,
    and which singular values count as zero, float64 cannot decide by itself: every choice is
    given, for the caller to judge by its response.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.h2.deadbeat import difference_equations
    >>> parts = np.diag([0.5, 0.2]), np.ones((2, 1)), np.eye(2), np.zeros((2, 1))
    >>> (P, Q), kept = next(difference_equations(*parts))
    >>> P.shape, np.linalg.eigvals(P[0]).real.round(6).tolist()
    ((1, 2, 2), [0.5, 0.2])
    """
    for W in _readings(C):
        for tolerance in TOLERANCES:
            F, kept, steps = deadbeat_gain(A, W.T @ C, tolerance)
            if not steps:
                continue
            own, inputs, outputs, gain = kept.T @ A @ kept, kept.T @ B, C @ kept, kept.T @ F @ W.T
            row, P, Q = outputs, [], [D]
            nilpotent = own - gain @ outputs
            for _ in range(steps):
                P.append(row @ gain)
                Q.append(row @ (inputs - gain @ D))
                row = row @ nilpotent
            yield (np.array(P), np.array(Q)), kept


def deadbeat_gain(A: Array, C: Array, tolerance: float) -> tuple[Array, Array, int]:
    """F with A - FC nilpotent on the modes that C shows, a basis of these, and the steps it takes.

    Of the dual pair (A', C') the states that a control brings to zero in k steps make up S_k,

    S_(k+1) = {x : A'x in S_k + im C'},

    and a feedback with (A' - C'F') S_(k+1) in S_k is one least-squares problem for each k, in
    orthonormal bases throughout. The chain ends before it spans everything where modes do not
    show in C.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.h2.deadbeat import deadbeat_gain
    >>> A, C = np.array([[0.0, 1.0], [-0.5, 1.5]]), np.array([[1.0, 0.0]])
    >>> F, kept, steps = deadbeat_gain(A, C, 1e-12)
    >>> steps, bool(np.abs(np.linalg.matrix_power(A - F @ C, 2)).max() < 1e-14)
    (2, True)
    """
    n = len(A)
    sizes = np.linalg.norm(C, axis=1)
    sizes = np.where(sizes > 0, sizes, 1.0)
    inputs = (C / sizes[:, None]).T
    size = float(np.linalg.norm(A, 2)) or 1.0
    reached, feedback, steps = np.zeros((n, 0)), np.zeros((len(C), 0)), 0
    while reached.shape[1] < n:
        outside = _complement(np.hstack([reached, inputs]), tolerance)
        rest = _complement(reached, 0.5)  # orthonormal columns: their rank is no question
        _, values, right = np.linalg.svd(outside.T @ A.T @ rest / size)
        new = rest @ right[int((values > tolerance).sum()) :].T
        if not new.shape[1]:
            break
        beyond = np.eye(n) - reached @ reached.T
        moves = np.linalg.lstsq(beyond @ inputs, -beyond @ A.T @ new, rcond=tolerance)[0]
        feedback, reached = np.hstack([feedback, moves]), np.hstack([reached, new])
        steps += 1
    return -(feedback @ reached.T / sizes[:, None]).T, reached, steps


def _readings(C: Array) -> Iterator[Array]:
    """Combinations W'u of the outputs: all, the strongest few, each alone, all but one."""
    count = len(C)
    sizes = np.linalg.norm(C, axis=1, keepdims=True)
    strongest = np.linalg.svd(C / np.where(sizes > 0, sizes, 1.0))[0]
    yield np.eye(count)
    for rank in range(1, count):
        yield strongest[:, :rank]
    if count > 1:
        yield from (np.eye(count)[:, [i]] for i in range(count))
    if count > 2:
        yield from (np.delete(np.eye(count), i, axis=1) for i in range(count))


def _complement(columns: Array, tolerance: float) -> Array:
    """An orthonormal basis of what is orthogonal to the columns."""
    left, values, _ = np.linalg.svd(columns)
    rank = int((values > tolerance * values.max(initial=0.0)).sum())
    return np.asarray(left[:, rank:])
