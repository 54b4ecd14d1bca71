"""Whether a record of several inputs is of an unstable plant: roots of long autoregressions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.identification._joint_records import JointRecord, inputs_of, joint_record
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_evidence import Gate

ORDERS = (4, 8, 12, 16)
OUTSIDE = 1.001  # least modulus of an unstable root
CONFIRMED = 1.0  # deviations by which a root of another order is outside
NEAR, NEAR_SHARE = 0.01, 0.3  # distance of the two, and its share of that from the circle
STEPS_A_COEFFICIENT = 2.5
LIMIT = float(norm.isf(0.025))  # deviations outside: 95 %, where u responds to y
OPEN_LIMIT = float(norm.isf(1e-4))  # elsewhere: an unstable plant leaves the range of the sensor


def unstable_root(record: JointRecord, limit: float) -> complex | None:
    """The root that is outside the circle by most deviations; None if by fewer than the limit.

    Of y regressed on its past and that of every input, with a level for each part: whatever the
    noise is, a long regression has the unstable poles of the plant among its roots. Those of
    another order have it, too, and an accidental root moves with the order.
    """
    outside: list[tuple[int, complex, float]] = []
    for order in ORDERS:
        # With every past y observed; and with missing ones interpolated, of which there are more.
        for is_whole in {True, bool(record.observed.all())}:
            regression = _regression(record, order, is_whole)
            roots = () if regression is None else regression.roots
            outside += [(order, p, (abs(p) - OUTSIDE) / deviation) for p, deviation in roots]
    confirmed = [
        (value, p) for order, p, value in outside
        if value > limit
        and any(other != order and also > CONFIRMED and _is_near(p, q)
                for other, q, also in outside)
    ]  # fmt: skip
    return max(confirmed, key=lambda one: one[0])[1] if confirmed else None


def _is_near(p: complex, q: complex) -> bool:
    """Whether roots of two regressions may be the same pole."""
    return abs(p - q) < NEAR + NEAR_SHARE * max(abs(p) - 1, abs(q) - 1)


def largest_root(record: JointRecord) -> tuple[float, float]:
    """The largest modulus of a root and its standard deviation, of the order of the least BIC.

    Infinite where no regression is possible.
    """
    known = _regressions(record)
    if not known:
        return np.inf, np.inf
    p, deviation = max(min(known, key=lambda one: one.bic).roots, key=lambda root: abs(root[0]))
    return abs(p), deviation


def open_loop_gate(u: Array, y: Array, delay: int, e: Array, parameters: int) -> Gate:
    """Whether a stable or integrating model is one of the plant, of a record in open loop.

    It is not where long regressions have a root outside the circle, both with u as logged and with
    u later by the dead time of the model, unless the model is better by its errors `e`: the order
    is that of least BIC, and the rise of a stable plant after a long dead time looks like growth.
    """
    record = joint_record(inputs_of(u[:, None], (0,)), y, "y")
    late = replace(record, u=record.later(record.u, delay))
    value, modulus, better = np.inf, 0.0, np.inf
    bic = float(np.log(np.mean(np.square(e / record.unit_y)) + 1e-300))
    bic += parameters * float(np.log(len(e))) / len(e)
    with np.errstate(all="ignore"):
        for one in (record, late):
            regressions = _regressions(one)
            if not regressions:
                continue
            least = min(regressions, key=lambda regression: regression.bic)
            sizes = [((abs(p) - OUTSIDE) / deviation, abs(p)) for p, deviation in least.roots]
            value, modulus = min((value, modulus), max(sizes))
            better = min(better, len(e) * (least.bic - bic))
    if not np.isfinite(value):
        value = 0.0
    return Gate(
        "stability", bool(value < OPEN_LIMIT or better > ODDS), float(value), OPEN_LIMIT,
        f"a long regression of y on its past and that of u has a root of modulus {modulus:.4g}, "
        f"by {value:.3g} standard deviations outside the unit circle, and the BIC of this model, "
        f"which is stable or integrating, is smaller by {better:.3g}; at most {OPEN_LIMIT:.3g} or "
        f"at least {ODDS:.3g} is required",
        "The plant seems unstable: stabilise it by any controller, move the command or add a "
        "dither to u, and record that loop.",
    )  # fmt: skip


def _regressions(record: JointRecord) -> list[_Regression]:
    regressions = [_regression(record, order, bool(record.observed.all())) for order in ORDERS]
    return [one for one in regressions if one is not None]


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
