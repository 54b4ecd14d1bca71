"""The largest structured singular value over frequency, for one complex factor in each channel."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from rcac_numeric.arrays.array_types import Array, ComplexArray
from rcac_numeric.margins.peaks import Matrices, level_crossings, response_of

# Exponents of the Schatten norms that lead to the largest singular value, the last to 1e-7 of it.
EXPONENTS = (8, 64, 512, 4096, 2**15, 2**18, 2**22)
# Relative distance of the bound to the largest value found, and what it may grow to if a bound at
# every frequency needs more than that many scalings.
CLOSE, WIDER, SCALINGS = 1e-8, 10.0, 60


def structured_peak(system: Matrices) -> tuple[float, float]:
    """An upper bound of mu over the unit circle, for complex diagonal factors, and where it is.

    At each frequency mu(M) <= min over D of the largest singular value of D M D^{-1}, D diagonal
    and positive, with equality for up to three channels; it is the same in all units. A scaling
    that is best at one frequency bounds mu at all of them, and the frequencies where it exceeds
    a level are found as eigenvalues on the unit circle: more scalings are added where none stays
    below, until none is needed. So the bound holds at every frequency, not on a grid.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.margins.structured import structured_peak
    >>> shared = np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((2, 0))
    >>> round(structured_peak((*shared, np.array([[1.0, 100.0], [0.01, 1.0]])))[0], 6)
    2.0
    """
    A = system[0]
    omega = np.linspace(0, np.pi, 17) if len(A) else np.zeros(1)
    if len(A):
        omega = np.unique(np.concatenate([omega, np.abs(np.angle(np.linalg.eigvals(A)))]))
    best, where, scalings = 0.0, 0.0, []

    def tried(at: float) -> float:
        nonlocal best, where
        found, scaling = best_scaling(response_of(system, at))
        scalings.append(scaling)
        if found > best:
            best, where = found, at
        return found

    values = [tried(float(at)) for at in omega]
    if best == 0 or not len(A):
        return best, where
    i = int(np.argmax(values))
    low, high = omega[max(i - 1, 0)], omega[min(i + 1, len(omega) - 1)]
    from scipy.optimize import minimize_scalar  # a sixth of a second

    minimize_scalar(
        lambda at: -tried(float(at)), bounds=(low, high), method="bounded", options={"xatol": 1e-9}
    )
    scalings = [best_scaling(response_of(system, where))[1]]
    close = CLOSE
    while True:
        level = best * (1 + close)
        open_ = [(0.0, float(np.pi))]
        for scaling in scalings:
            open_ = _overlap(open_, _above(system, scaling, level))
        if not open_:
            return level, where
        if len(scalings) >= SCALINGS:
            close *= WIDER
            continue
        widest = max(open_, key=lambda part: part[1] - part[0])
        tried((widest[0] + widest[1]) / 2)


def best_scaling(M: ComplexArray) -> tuple[float, Array]:
    """The least largest singular value of D M D^{-1} over positive diagonal D, and log D.

    Convex in log D. From Osborne's balancing, which is the least Frobenius norm, by BFGS on
    Schatten norms of growing exponent, which are smooth.
    """
    from scipy.optimize import minimize

    logs = _balanced(M)
    best = (_largest(M, logs), logs)
    if len(M) > 1:
        for exponent in EXPONENTS:
            found = minimize(
                _schatten(M, exponent), logs[1:], jac=True, method="BFGS",
                options={"gtol": 1e-10, "maxiter": 100},
            )  # fmt: skip
            logs = np.concatenate([[0.0], found.x])
            best = min(best, (_largest(M, logs), logs), key=lambda pair: pair[0])
    return best


def _schatten(M: ComplexArray, exponent: int) -> Callable[[Array], tuple[float, Array]]:
    def log_norm(x: Array) -> tuple[float, Array]:
        left, values, right = np.linalg.svd(_scaled(M, np.concatenate([[0.0], x])))
        if values[0] == 0:
            return -np.inf, np.zeros(len(x))
        shares = (values / values[0]) ** exponent
        total = float(shares.sum())
        slope = (np.abs(left) ** 2 @ shares - np.abs(right.T) ** 2 @ shares) / total
        return float(np.log(values[0]) + np.log(total) / exponent), np.asarray(slope[1:])

    return log_norm


def _balanced(M: ComplexArray) -> Array:
    """Log D with rows and columns of D M D^{-1} alike, off the diagonal, by Osborne's sweeps."""
    squares = np.abs(M) ** 2
    np.fill_diagonal(squares, 0.0)
    logs = np.zeros(len(M))
    for _ in range(30):
        before = logs.copy()
        for i in range(len(M)):
            column, row = (
                squares[:, i] @ np.exp(2 * (logs - logs[i])),
                squares[i] @ np.exp(2 * (logs[i] - logs)),
            )
            if column > 0 and row > 0:
                logs[i] += np.log(column / row) / 4
        if np.abs(logs - before).max(initial=0.0) < 1e-3:
            break
    return np.asarray(logs - logs[0])


def _scaled(M: ComplexArray, logs: Array) -> ComplexArray:
    D = np.exp(np.clip(logs - logs.mean(), -200, 200))
    return np.asarray(D[:, None] * M / D)


def _largest(M: ComplexArray, logs: Array) -> float:
    return float(np.linalg.norm(_scaled(M, logs), 2))


def _above(system: Matrices, logs: Array, level: float) -> list[tuple[float, float]]:
    """The intervals of frequency where this scaling leaves a singular value above the level."""
    D = np.exp(np.clip(logs - logs.mean(), -200, 200))
    A, B, C, direct = system
    scaled: Matrices = (A, B / D, D[:, None] * C, D[:, None] * direct / D)
    ends = np.concatenate([[0.0], level_crossings(scaled, level), [np.pi]])
    return [
        (float(a), float(b))
        for a, b in pairwise(ends)
        if b > a and np.linalg.norm(response_of(scaled, (a + b) / 2), 2) > level
    ]


def _overlap(
    first: list[tuple[float, float]], second: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    both = [(max(a, c), min(b, d)) for a, b in first for c, d in second]
    return [(low, high) for low, high in both if low < high]
