"""Parts of a disturbance in a signal: jumps, outliers, the peak of a sinusoid, innovations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.identification._box_jenkins import ONE, later
from rcac_numeric.identification._process_records import JUMP, ROBUST, ProcessRecord

PEAK = 20.0  # of the median of the periodogram: a sinusoid
MOST_JUMPS = 0.02  # of the steps


def differenced(record: ProcessRecord, differences: int) -> tuple[Array, Array]:
    if not differences:
        return record.y, record.u
    y, u = record.y, record.u
    return np.diff(y, prepend=y[0]), np.diff(u, prepend=u[0])


def peak_frequency(v: Array) -> float:
    """That of the peak of a periodogram beside a slope, in rad/step; 0 where it is not high."""
    steps = len(v)
    k = np.arange(steps)
    v = v - np.polyval(np.polyfit(k, v, 1), k)
    power = np.abs(np.fft.rfft(v * np.hanning(steps))) ** 2
    at = int(power[2:].argmax()) + 2
    return 2 * float(np.pi) * at / steps if power[at] >= PEAK * np.median(power[1:]) else 0.0


def student_regression(
    X: Array, y: Array, weights_of: Callable[[Array], Array], weights: Array, rounds: int = 8
) -> tuple[Array, Array]:
    """Coefficients and errors of a regression of y on the rows of X, with weights of its errors.

    It begins with the weights given.
    """
    theta: Array = np.zeros(len(X))
    e = y
    for _ in range(rounds):
        scaled = X * weights
        H = scaled @ scaled.T
        H[np.diag_indices_from(H)] *= 1 + 1e-9
        theta = np.asarray(
            np.linalg.solve(H + 1e-300 * np.eye(len(H)), scaled @ (weights * y)), np.float64
        )
        e = y - theta @ X
        weights = weights_of(e)
    return theta, e


def without_outliers(v: Array, differences: int) -> Array:
    """A disturbance with its values, or its differences, clipped at six robust deviations."""
    w = np.diff(v, prepend=v[0]) if differences else v
    middle = float(np.median(w))
    size = JUMP * ROBUST * float(np.median(np.abs(w - middle)))
    w = np.clip(w, middle - size, middle + size)
    return np.cumsum(w) if differences else w


def without_level_jumps(record: ProcessRecord) -> Array | None:
    """Y without the level jumps in the innovations of its differences.

    A long regression on past y and u, with Student's weights: what u does is no jump. None if there
    are no jumps, or more than accidents.
    """
    y, u = differenced(record, 1)
    steps = len(y)
    p = min(20, steps // 20)
    X = np.stack([*(later(y, k) for k in range(1, p + 1)), *(later(u, k) for k in range(1, p + 1))])
    a, e = student_regression(X, y, record.weights, np.ones(steps))
    size = JUMP * (ROBUST * float(np.median(np.abs(e))) + 1e-12)
    e[:p] = 0.0  # there the past of the record is not known
    response = np.concatenate([ONE, -a[:p]])  # of e to a jump
    jumps = np.zeros(steps)
    for _ in range(int(MOST_JUMPS * steps)):
        late = np.nonzero(np.abs(e) > size)[0]
        if not len(late):
            return np.asarray(record.y - np.cumsum(jumps)) if jumps.any() else None
        k = int(late[0])
        jumps[k] += e[k]
        e[k : k + p + 1] -= e[k] * response[: steps - k]
    return None


def joint_innovations(y: Array, u: Array) -> Array:
    """What a long regression of y on past y and u leaves."""
    p = min(20, len(y) // 20)
    X = np.stack([*(later(y, k) for k in range(p + 1)), *(later(u, k) for k in range(1, p + 1))])
    X = X[:, p:] - X[:, p:].mean(axis=1, keepdims=True)
    H = X[1:] @ X[1:].T
    H[np.diag_indices_from(H)] *= 1 + 1e-9
    a = np.linalg.solve(H + 1e-300 * np.eye(2 * p), X[1:] @ X[0])
    e = np.zeros_like(y)
    e[p:] = X[0] - a @ X[1:]
    return e
