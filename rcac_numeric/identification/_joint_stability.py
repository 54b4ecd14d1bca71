"""Whether a record of several inputs is of an unstable plant: roots of long autoregressions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.identification._joint_records import JointRecord

ORDERS = (4, 8, 12, 16)
OUTSIDE = 1.001  # least modulus of an unstable root
STEPS_A_COEFFICIENT = 2.5
LIMIT = float(norm.isf(0.025))  # deviations outside: 95 %, where u responds to y
OPEN_LIMIT = float(norm.isf(1e-4))  # elsewhere: an unstable plant leaves the range of the sensor


def unstable_root(record: JointRecord, limit: float) -> complex | None:
    """The root that is outside the circle by most deviations; None if by fewer than the limit.

    Of y regressed on its past and that of every input, with a level for each part: whatever the
    noise is, a long regression has the unstable poles of the plant among its roots.
    """
    worst, root = limit, None
    for order in ORDERS:
        # With every past y observed; and with missing ones interpolated, of which there are more.
        for is_whole in {True, bool(record.observed.all())}:
            regression = _regression(record, order, is_whole)
            for p, deviation in () if regression is None else regression.roots:
                if (abs(p) - OUTSIDE) / deviation > worst and abs(p) > OUTSIDE:
                    worst, root = (abs(p) - OUTSIDE) / deviation, p
    return root


def largest_root(record: JointRecord) -> tuple[float, float]:
    """The largest modulus of a root and its standard deviation, of the order of the least BIC.

    Infinite where no regression is possible.
    """
    regressions = [_regression(record, order, bool(record.observed.all())) for order in ORDERS]
    known = [one for one in regressions if one is not None]
    if not known:
        return np.inf, np.inf
    p, deviation = max(min(known, key=lambda one: one.bic).roots, key=lambda root: abs(root[0]))
    return abs(p), deviation


@dataclass(frozen=True)
class _Regression:
    """BIC a row of a long regression, and its roots with the standard deviations of the moduli."""

    bic: float
    roots: list[tuple[complex, float]]


def _regression(record: JointRecord, order: int, is_whole: bool) -> _Regression | None:
    """Y regressed on its past and that of every input; None where the rows are too few."""
    lags = range(1, order + 1)
    counts = record.observed.copy()
    for part in record.parts:
        counts[part.start : part.start + order] = False
    if is_whole:
        there = record.observed.astype(np.float64)
        for k in lags:
            counts &= record.later(there, k) > 0
    levels = np.zeros((len(record.starts), record.steps))
    for level, part in zip(levels, record.parts, strict=True):
        level[part] = 1.0
    past = [-record.later(record.y, k) for k in lags]
    past += [record.later(u, k) for u in record.u for k in lags]
    X = np.concatenate([np.stack(past), levels])[:, counts]
    if X.shape[1] < STEPS_A_COEFFICIENT * len(X):
        return None
    size = np.sqrt(np.einsum("ij,ij->i", X, X))
    size[size == 0] = 1.0
    X = X / size[:, None]
    y = record.y[counts]
    inverse = np.linalg.pinv(X @ X.T, rcond=1e-12, hermitian=True)
    theta = inverse @ (X @ y)
    e = y - theta @ X
    variance = float(e @ e) / (len(y) - len(theta))
    covariance = (inverse / size / size[:, None])[:order, :order] * variance
    A = np.concatenate([[1.0], (theta / size)[:order]])
    slope = np.polyder(A)
    roots = []
    for p in np.roots(A):
        by = -(p ** (order - np.arange(1, order + 1))) / np.polyval(slope, p)
        of_modulus: Array = np.real(np.conj(p) / max(abs(p), 1e-300) * by)
        deviation = float(np.sqrt(max(of_modulus @ covariance @ of_modulus, 1e-300)))
        roots.append((complex(p), deviation))
    power = max(float(e @ e) / len(y), 1e-300)
    return _Regression(float(np.log(power)) + len(theta) * float(np.log(len(y))) / len(y), roots)
