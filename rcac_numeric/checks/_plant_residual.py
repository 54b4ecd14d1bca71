"""The one-step prediction error of a plant on a log."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._values import Result
from rcac_numeric.checks._logs import ControllerLog
from rcac_numeric.plants._any_plant import block_start
from rcac_numeric.plants._foreign import linear_plant
from rcac_numeric.plants._linear import Plant

LONGEST, MOST_NUMBERS = 5_000, 1_000_000  # steps that are compared; entries of their windows
FEWEST, LARGEST_ORDER, MOST_COEFFICIENTS = 10, 100, 400  # the last: of the plant that is fitted
# What raises doubt: the plant leaves more than a tenth of how y changes from step to step, and a
# plant fitted to the log leaves so many times less. White noise alone makes the second 1, sensor
# noise 2 or 3; an unlogged signal that is not white, such as a tone, may raise doubt, too.
# However little the plant leaves: white sensor noise of size s makes s norm([1, D]) of it, and no
# fit leaves less than s, so that so many times more than norm([1, D]) of the best fit is no sensor
# noise. Where not all of w was logged it may be a disturbance, unless a fit leaves rounding alone.
UNEXPLAINED, TIMES_WORSE = 0.1, 3.0
ROUNDING = 100 * np.finfo(float).eps  # of the terms that e is the sum of
# There is doubt, too, if y(k) = y(k-1) predicts better, and a fit so many times better.
CONTRADICTED = 2.0
UNDECIDED = 0.5  # a fit that leaves so much of how y changes decides nothing
# Doubt contradicts the plant unless a disturbance may be all of e. A tone, a ramp or coloured noise
# is predicted by its own past, so that an AR model of e leaves no more than a fitted plant does;
# the error of another plant depends on u, and is not.
AR, TONE = 8, 1e-8  # past errors; what the AR model may leave of a tone, of the rms of e


@dataclass(frozen=True, eq=False)
class PlantResidual(Result):
    """The one-step error of the plant on the log, and that of the best plant of its order.

    e(k) = y(k) - y(k | the n steps of u, y and the known w before, and u(k)): zero where nothing
    unknown acts on the loop and the plant is that of the log. For scalar signals it is D(q) y -
    N(q) u.

    Attributes
    ----------
    rms, change : float
        Root mean square of e, about its mean where not all of w was logged, and of y(k) - y(k-1).
    best : float or None
        Of the least-squares fit with as many past steps; None for a log too short to fit one.
    remedy : str
        A simple change of u with which the plant explains the log; empty where none does.
    offset : float
        Length of the mean of e: a constant disturbance that was not logged, or an offset of u or
        y, makes it, and contradicts no plant.
    noise_gain : float
        norm([1, D]): the size of e for white sensor noise of unit size.
    rounding : float
        What e may be by rounding alone.
    is_known : bool
        Whether all of w was logged.
    whitened : float
        Root mean square of e less a constant and its prediction by an AR model of e.
    """

    rms: float
    change: float
    best: float | None
    remedy: str = ""
    offset: float = 0.0
    noise_gain: float = 1.0
    rounding: float = 0.0
    is_known: bool = False
    whitened: float = 0.0

    @property
    def relative(self) -> float:
        """The rms of e relative to the rms of y(k) - y(k-1)."""
        return self.rms / self.change if self.change > 0 else float(self.rms > 0)

    @property
    def is_doubtful(self) -> bool:
        """Whether the log seems to be of another plant."""
        if self.remedy:
            return True
        if self.best is None:
            return self.relative > 1.0
        times = self.rms / max(self.best, self.rounding, np.finfo(float).tiny)
        if self.relative > UNEXPLAINED:
            return bool(times > TIMES_WORSE) or self._is_useless
        is_exact = self.is_known or self.best <= self.rounding
        return bool(is_exact and times > TIMES_WORSE * self.noise_gain)

    @property
    def _is_useless(self) -> bool:
        """Whether y(k) = y(k-1) predicts better, and a fitted plant twice as well."""
        return self.best is not None and self.relative > 1 and self.rms > CONTRADICTED * self.best

    @property
    def is_contradicted(self) -> bool:
        """Whether there is doubt, and a disturbance that was not logged cannot explain the log."""
        if not self.is_doubtful:
            return False
        if self.is_known or self.best is None:
            return self.is_known or bool(self.remedy)
        floor = max(self.best, self.rounding, TONE * self.rms, np.finfo(float).tiny)
        times = CONTRADICTED if self._is_useless else TIMES_WORSE
        return bool(self.whitened > times * floor)

    def __str__(self) -> str:
        fitted = "" if self.best is None else f"{self.best:.3g} for a model fitted to the log; "
        mean = f" about a constant of {self.offset:.3g}" if self.offset > self.rms else ""
        size = f"one-step prediction error of y {self.rms:.3g} rms{mean} "
        size += f"({fitted}y changes by {self.change:.3g} rms per step)"
        if not self.is_doubtful and self.relative <= UNEXPLAINED:
            return f"The plant fits the log: {size}."
        if not self.is_doubtful and self.best is not None and self.best > UNDECIDED * self.change:
            return (
                f"The log neither confirms nor contradicts the plant: {size}. No fixed model of "
                "this order predicts y well: noise or disturbances that were not logged, or "
                "columns or a plant that change on the way."
            )
        if not self.is_doubtful:
            return f"Plant and log agree within the noise: {size}."
        check = f" Check {self.remedy}." if self.remedy else ""
        if not self.is_contradicted:
            return (
                f"Plant and log disagree: {size}. Either the log is of another plant, or "
                f"disturbances act on the loop that were not logged as w.{check}"
            )
        if self.remedy:
            return f"The log is NOT of this plant: {size}.{check}"
        if self._is_useless:
            return (
                f"The log is NOT explained by this plant: {size}; the prediction y(k) = y(k-1) is "
                "better. The log is of another plant, sign or problem."
            )
        why = (
            f"It is of another plant: an AR({AR}) model, which predicts a disturbance, leaves "
            f"{self.whitened:.3g} of that error."
        )
        if self.is_known:
            why = (
                "All of w was logged: the log is of another plant, or a disturbance acts for which "
                "w has no channel."
            )
        return f"The log is NOT explained by this plant: {size}. {why}"


@np.errstate(over="ignore", invalid="ignore")  # an overflow has no residual
def plant_residual(log: ControllerLog, plant: Plant) -> PlantResidual | None:
    """The residual of y for the plant; None if the log is too short or n exceeds 100.

    Of w, what was logged is used; the command r is a part of it.

    Examples
    --------
    >>> from rcac_numeric import ControllerLog, standard_plant
    >>> from rcac_numeric.checks._plant_residual import plant_residual
    >>> u = [(-1.0) ** (k // 3) for k in range(60)]
    >>> y = [0.0]
    >>> for k in range(59):
    ...     y.append(0.5 * y[k] + u[k])
    >>> plant_residual(ControllerLog(u, y), standard_plant("1/(q - 0.5)")).is_doubtful
    False
    >>> plant_residual(ControllerLog(u, y), standard_plant("1/(q + 0.5)")).is_doubtful
    True
    """
    plant = linear_plant(plant)
    widths = log.u.shape[1], log.y.shape[1]
    if (plant.l_u, plant.l_y) != widths:
        raise InputError(
            f"the plant has {plant.l_u} inputs and {plant.l_y} outputs, and the log {widths[0]} "
            f"and {widths[1]}; give the plant of this log."
        )
    B, D, known = inputs(log, plant)
    window = max(plant.n, 1)
    width = (window + 1) * (plant.l_y + B.shape[1])
    steps = min(log.steps, LONGEST, MOST_NUMBERS // width)
    if steps < window + FEWEST or window > LARGEST_ORDER:
        return None
    size = max(np.abs(log.u).max(), np.abs(log.y).max(), np.abs(known).max(initial=0.0)) or 1.0
    u, y, known = log.u[:steps] / size, log.y[:steps] / size, known[:steps] / size
    e = one_step_errors(plant, B, D, np.hstack([u, known]), y)
    is_known = log.w is not None and log.w.shape[1] == plant.l_w > 0
    size_of = _rms if is_known else _about_mean
    rms, offset = size_of(e) * size, float(np.linalg.norm(e.mean(axis=0))) * size
    change = _rms(np.diff(y, axis=0)) * size
    best = _best(u, known, y, window)
    fitted = None if best is None else best * size
    if not np.isfinite(rms) or change == 0:
        return None  # the plant's powers leave float64, or the log shows no movement
    T, M = predictor(plant, B, D)
    gain = float(np.sqrt(1 + np.sum(M**2, axis=0).max()))
    terms = max(np.abs(M).sum(axis=0).max(), 1.0) * max(np.abs(T).sum(axis=1).max(), 1.0)
    residual = PlantResidual(
        float(rms), float(change), fitted, offset=offset, noise_gain=gain,
        rounding=float(ROUNDING * terms * size), is_known=is_known, whitened=_unpredicted(e) * size,
    )  # fmt: skip
    if not residual.is_doubtful and residual.relative <= UNEXPLAINED:
        return residual
    others = {
        "the sign of u or y: this plant fits with -u": -u,
        "the rows of u: this plant fits with u one step later": np.vstack([u[:1] * 0, u[:-1]]),
        "the rows of u: this plant fits with u one step earlier": np.vstack([u[1:], u[-1:]]),
    }
    for words, other in others.items():
        if (
            TIMES_WORSE * size_of(one_step_errors(plant, B, D, np.hstack([other, known]), y)) * size
            < residual.rms
        ):
            return replace(residual, remedy=words)
    return residual


def inputs(log: ControllerLog, plant: Plant) -> tuple[Array, Array, Array]:
    """Return B and D of u and of the known channels of w, and the values of these channels."""
    if log.w is not None and log.w.shape[1] == plant.l_w:
        columns, known = np.arange(plant.l_w), log.w
    elif log.r is not None and plant.blocks.get("r") == log.r.shape[1]:
        start = block_start(plant, "r")
        columns, known = np.arange(start, start + log.r.shape[1]), log.r
    else:
        columns, known = np.arange(0), np.zeros((log.steps, 0))
    B = np.hstack([plant.B, plant.D_1[:, columns]])
    D = np.hstack([plant.D_0, plant.D_2[:, columns]])
    return B, D, known


def _windows(signal: Array, steps: int, count: int) -> Array:
    """Stack the values of `count` successive steps into each row, the first at k."""
    return np.hstack([signal[i : len(signal) - steps + i] for i in range(count)])


def one_step_errors(plant: Plant, B: Array, D: Array, v: Array, y: Array) -> Array:
    """y(k) less its prediction from the n steps before, by the inputs v through B and D."""
    n, l_y = max(plant.n, 1), plant.l_y
    T, M = predictor(plant, B, D)
    if not (np.isfinite(T).all() and np.isfinite(M).all()):
        return np.full((1, l_y), np.nan)  # a plant whose powers leave float64
    free = _windows(y, n, n + 1) - _windows(v, n, n + 1) @ T.T
    past, now = free[:, : n * l_y], free[:, n * l_y :]
    return np.asarray(now - past @ M)


def predictor(plant: Plant, B: Array, D: Array) -> tuple[Array, Array]:
    """Return the forced response over n + 1 steps, and the matrix that predicts y(k) at rest."""
    n, l_y, l_v = max(plant.n, 1), plant.l_y, B.shape[1]
    powers = [plant.C]
    for _ in range(n):
        powers.append(powers[-1] @ plant.A)
    T = np.zeros(((n + 1) * l_y, (n + 1) * l_v))
    for i in range(n + 1):
        for j in range(i + 1):
            block = D if i == j else powers[i - j - 1] @ B
            T[i * l_y : (i + 1) * l_y, j * l_v : (j + 1) * l_v] = block
    if not (np.isfinite(T).all() and np.isfinite(powers[n]).all()):
        return T, np.full((n * l_y, l_y), np.nan)
    return T, np.asarray(np.linalg.lstsq(np.vstack(powers[:n]).T, powers[n].T, rcond=None)[0])


def _best(u: Array, known: Array, y: Array, n: int) -> float | None:
    """The rms error of the least-squares prediction from as many steps.

    u(k) is no part of it: a static controller makes y(k) from it without any plant.
    """
    data = np.hstack([_windows(y, n, n), _windows(u, n, n), _windows(known, n, n + 1)])
    freedom = len(data) - data.shape[1]
    if freedom < 2 * data.shape[1] or data.shape[1] > MOST_COEFFICIENTS:
        return None
    now = y[n:]
    e = now - data @ np.linalg.lstsq(data, now, rcond=None)[0]
    return float(np.sqrt(np.sum(e**2) / (freedom * y.shape[1])))


def whitened(e: Array, order: int = AR) -> Array:
    """The residual of each component after a constant and an AR model."""
    columns = []
    for column in e.T:
        past = [column[order - i - 1 : len(column) - i - 1] for i in range(order)]
        data = np.column_stack([*past, np.ones(len(column) - order)])
        scale = np.linalg.norm(data, axis=0)
        data = data / np.where(scale > 0, scale, 1.0)
        now = column[order:]
        columns.append(now - data @ np.linalg.lstsq(data, now, rcond=1e-10)[0])
    return np.column_stack(columns)


def _unpredicted(e: Array) -> float:
    """The rms of what a constant and the past of e leave of it, per degree of freedom."""
    if not np.isfinite(e).all():
        return float("inf")
    order = min(AR, len(e) // 6)
    rest = whitened(e, order)
    return float(np.sqrt(np.sum(rest**2) / ((len(rest) - order - 1) * e.shape[1])))


def _about_mean(e: Array) -> float:
    return _rms(e - e.mean(axis=0))


def _rms(e: Array) -> float:
    return float(np.sqrt(np.mean(e**2)))
