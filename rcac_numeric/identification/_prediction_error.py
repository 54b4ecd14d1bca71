"""Prediction-error models of scalar closed-loop data, with a stable predictor."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares
from scipy.signal import lfilter
from scipy.special import gammaln

from compensator_theory._truth import Truth
from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.identification._regressors import lagged
from rcac_numeric.identification._scalar_record import (
    SHARE,
    ScalarModel,
    ScalarRecord,
    Shape,
    information_criterion,
    inside,
    integrated_share,
    late,
    scalar_record,
    scalar_signal,
    shapes,
)

LONG = (10, 20, 40)  # orders of the ARX model that the innovations are first taken from
REFINED = 6  # of the best, for each number of integrators, by the prediction error itself
PENALTY = 1.5  # times that of BIC
PAST_U, PAST_Y = 20, 4  # lags by which u is told from its past, and from what it answers to
FEEDBACK = 3.0  # times the penalty of BIC: u that is held or filtered is no answer to y
ODDS = 2 * float(np.log(1e4))  # -2 log of the odds of one in ten thousand
SHAPES = np.geomspace(0.5, 20.0, 25)  # exponents of a density: 1 Laplace, 2 Gauss, 20 two values
FOLLOWED = 0.2  # median over standard deviation of what of u moves a few times; Gaussian: 0.67
STIRRED = 1e-3  # of u: what of it must not follow from y, or from its own past
EXACT = 1e-7  # of y: prediction errors that are rounding, and correlated with anything
TESTED = 20  # lags of the cross-correlation of innovations and excitation


@dataclass(frozen=True, eq=False)
class PredictionErrorModel(ScalarModel, Truth):
    """A(q) y(k) = q^-delay B(q) u(k) + c + C(q)/D(q) e(k), strictly proper, A of any poles.

    Attributes
    ----------
    numerator : array, shape (n,)
        b_1, ..., b_n of B = b_1 q^-1 + ... + b_n q^-n.
    denominator : array, shape (n + 1,)
        1, a_1, ..., a_n of A = 1 + a_1 q^-1 + ... + a_n q^-n.
    delay : int
        Steps beside the one that every strictly proper model has.
    noise : pair of arrays
        C and D, in powers of q^-1 from 1 on, with their roots inside the unit circle: the predictor
        is stable whatever the plant is.
    innovation : array
        e, what the predictor leaves of y.
    residual : array
        C/(D A) e with the poles of A outside the circle reflected: noise of the size and spectrum
        of what the model leaves of y.
    criterion : float
        N log(mean e^2) + 1.5 x parameters x log N: the smallest is the best.
    explained : float
        1 - var(e)/var(y).
    correlation : float
        The largest correlation of e with an earlier value of what of u does not follow from y,
        over its standard error: what is left of the plant in e, whatever the noise is.
    integrators : int
        Poles of A that are 1 exactly.
    """

    noise: tuple[Array, Array]
    innovation: Array
    residual: Array
    criterion: float
    explained: float
    correlation: float
    integrators: int = 0

    def errors(self, u: ArrayLike, y: ArrayLike) -> Array:
        """The prediction errors on another record, less their mean."""
        record = scalar_record(u, y, self.order + self.delay)
        scaled = self.numerator * record.units[0] / record.units[1]
        A_y = lfilter(self.denominator, [1.0], record.y)
        w = A_y - late(lfilter(np.r_[0.0, scaled], [1.0], record.u), self.delay)
        e = lfilter(self.noise[1], self.noise[0], w[record.first :])
        return np.asarray(record.units[1] * (e - e.mean()))

    def __str__(self) -> str:
        pole = " with a pole at 1" if self.integrators else ""
        return (
            f"order {self.order}{pole}, delay {self.delay}, predicts "
            f"{100 * self.explained:.4g} % of the variance of y one step ahead in "
            f"{len(self.innovation)} steps of a closed loop"
        )


def identify_in_closed_loop(
    u: ArrayLike, y: ArrayLike, *, orders: Iterable[int] = range(1, 6),
    delays: Iterable[int] = range(12), integrators: Iterable[int] = (0,),
) -> PredictionErrorModel:  # fmt: skip
    """Identify a plant, stable or not, from a record of a closed loop.

    The direct method: e = (D/C)(A y - q^-delay B u - c) is the error of a predictor that is stable
    for every A, since A and B only multiply; the smallest mean square of e is the plant itself as
    long as C/D can be the noise, with u from y or not. It begins at regressions on the innovations
    of a long ARX model. Of all orders and delays the smallest N log(mean e^2) + 1.5 p log N, with p
    parameters.

    Parameters
    ----------
    u, y : arrays of shape (steps,) or (steps, 1)
        Something beside y must move u: a command, a dither, a change of the controller.
    orders, delays, integrators : iterables of int
        What is tried; 0 or 1 of the poles is 1 exactly.

    Raises
    ------
    InputError
        Where u follows from y alone, there are too few steps, or y does not answer to u.

    Notes
    -----
    Sources: L. Ljung, System Identification (2nd ed. 1999), sections 4.2 and 13.4 to 13.5;
    U. Forssell and L. Ljung, Automatica 35 (1999) 1215-1241, and IEEE Transactions on Automatic
    Control 45 (2000) 137-141, for unstable plants; E. J. Hannan and J. Rissanen, Biometrika 69
    (1982) 81-94, for the start.

    Examples
    --------
    >>> import numpy as np
    >>> from rcac_numeric.identification import identify_in_closed_loop
    >>> rng = np.random.default_rng(1)
    >>> r, v = rng.standard_normal((2, 1000))
    >>> u, y, x = np.zeros(1000), np.zeros(1000), 0.0
    >>> for k in range(1000):  # x(k+1) = 1.1 x(k) + 0.5 u(k), y = x + v, u = r - 0.6 y
    ...     y[k] = x + 0.1 * v[k]
    ...     u[k] = r[k] - 0.6 * y[k]
    ...     x = 1.1 * x + 0.5 * u[k]
    >>> model = identify_in_closed_loop(u, y)
    >>> model.order, model.delay, model.denominator.round(2), model.numerator.round(2)
    (1, 0, array([ 1. , -1.1]), array([0.5]))
    """
    candidates = shapes(orders, delays, integrators)
    record = scalar_record(u, y, max(n + d for n, d, _ in candidates))
    alone, stirring = _regressed(scalar_signal(u, "u"), scalar_signal(y, "y"), PAST_U + 1)
    if not np.std(alone) > STIRRED * record.units[0]:
        raise InputError(
            f"u is determined by its own past from step {PAST_U} on, as a sinusoid is, or a "
            "constant: "
            "the record does not show how u depends on y. If the loop was "
            "open, use identify_output_error; if it was closed, add a dither to u, or move the "
            "command, and record again."
        )
    if not np.std(stirring) > STIRRED * record.units[0]:
        raise InputError(
            "u is determined by y: the record shows the controller, not the plant. Add a dither "
            "to u, or move the command, and record again."
        )
    best = None
    for sums in sorted({sums for *_, sums in candidates}):
        fit = _best(_Differenced(record, sums), [one for one in candidates if one[-1] == sums])
        if best is None or (fit.value < best.value and fit.share > SHARE):
            best = fit
    assert best is not None
    if not best.value < _least(_Differenced(record, best.shape[-1]), best.shape):
        raise InputError(
            "the record shows no effect of u on y: y is predicted as well without u. "
            "Excite u more, record longer, or try longer delays."
        )
    return _model(best, record, stirring)


def excitation(u: ArrayLike, y: ArrayLike) -> Array:
    """The part of u that its past and y do not determine: a dither or a command.

    u(k) less its regression on u(k-1), ..., u(k-20) and y(k), ..., y(k-20).
    """
    return _regressed(scalar_signal(u, "u"), scalar_signal(y, "y"), PAST_U + 1)[1]


def answers(u: ArrayLike, y: ArrayLike) -> bool:
    """Whether y improves the prediction of u: a closed loop.

    By BIC with three times its penalty: u on u(k-1), ..., u(k-20), and on y(k), ..., y(k-3) beside.

    Notes
    -----
    Source: P. E. Caines and C. W. Chan, IEEE Transactions on Automatic Control 20 (1975) 498-508.
    """
    control = scalar_signal(u, "u")
    alone, beside = _regressed(control, scalar_signal(y, "y"), PAST_Y)
    if not np.std(alone) > STIRRED * np.std(control):
        return False  # sinusoids and steps follow from their own past
    open_loop = information_criterion(alone, 0, FEEDBACK)
    return information_criterion(beside, PAST_Y, FEEDBACK) < open_loop


def leads(u: Array, y: Array) -> bool | None:
    """Whether y(k) predicts u(k) because it responds to u(k), in an open loop; None if undecided.

    Second moments have no direction in time of one step: u(k) on y(k) fits as well as y(k) on u(k).
    What has one is past y. A controller that reads y(k) has a u(k) that past y predicts beside past
    u, and then this is False; or its dither or command hardly moves, past u determines past y, and
    u(k) follows from y(k) and the past exactly but at a few steps. Else the distributions decide,
    if they are not Gaussian: of two values, of which one is a multiple of the other and something
    independent, only the right order leaves them independent (A. Hyvarinen and S. M. Smith, Journal
    of Machine Learning Research 14 (2013) 111-152). Where both are Gaussian, an open loop is shown
    only by a white u to whose past y responds: a controller that reads y(k) repeats that response.
    (A proportional controller makes of white noise a white u, but then y is white, too.)
    """
    steps = len(u)
    now = _unit(lagged((u - u.mean())[:, None], PAST_U + 1))
    past = _unit(lagged(y[:, None], PAST_U + 1)[:, : PAST_Y + 1])
    u_now, past_u, y_now, past_y = now[:, :1], now[:, 1:], past[:, :1], past[:, 1:]
    if steps < 5 * PAST_U or not np.std(now[:, 0] - _fitted(past_u, u_now[:, 0])) > STIRRED:
        return False
    criteria = [
        information_criterion(u_now[:, 0] - _fitted(columns, u_now[:, 0]), columns.shape[1], 1.0)
        for columns in (
            past_u, np.hstack([past_u, past_y]), y_now, np.hstack([y_now, past_u, past_y]),
        )
    ]  # fmt: skip
    rest = u_now[:, 0] - _fitted(np.hstack([y_now, past_u, past_y]), u_now[:, 0])
    is_followed = float(np.median(np.abs(rest))) < FOLLOWED * float(np.std(rest))
    if not (criteria[0] < criteria[1] and criteria[3] < criteria[2]) or is_followed:
        return False
    odds = _odds_of_cause(y_now[:, 0], u_now[:, 0], np.hstack([past_u, past_y]))
    if abs(odds) >= ODDS:
        return odds < 0
    is_shown = _is_white(u_now[:, 0], past_u) and not _is_white(y_now[:, 0], past_u)
    return True if is_shown else None


def _odds_of_cause(first: Array, second: Array, past: Array) -> float:
    """2 log of the odds that the first signal moves the second, not the second the first.

    0 where a part of them is rounding: its distribution is none of the signals'.
    """
    Q, _ = np.linalg.qr(past)
    a, b = first - Q @ (Q.T @ first), second - Q @ (Q.T @ second)
    least = EXACT**2 * min(float(first @ first), float(second @ second))
    if not min(float(a @ a), float(b @ b)) > least:
        return 0.0
    rest_b, rest_a = b - a * (a @ b) / (a @ a), a - b * (a @ b) / (b @ b)
    if not min(float(rest_a @ rest_a), float(rest_b @ rest_b)) > least:
        return 0.0
    less = _description(b) + _description(rest_a) - _description(a) - _description(rest_b)
    return 2 * len(a) * less


def _description(e: Array) -> float:
    """-log likelihood a step of e over its standard deviation, generalised Gaussian.

    The density is proportional to exp(-abs(e/s)^p), with the best s and p.
    """
    size = np.abs(e) / np.std(e)
    scales = np.array([(p * np.mean(size**p)) ** (1 / p) for p in SHAPES])
    return float(np.min(np.log(2 * scales / SHAPES) + gammaln(1 / SHAPES) + 1 / SHAPES))


def _is_white(now: Array, past: Array) -> bool:
    """Whether of all autoregressions, by BIC, that of order 0 is the best."""
    Q, _ = np.linalg.qr(past)
    rest = float(now @ now) - np.cumsum((Q.T @ now) ** 2)
    orders = np.arange(1, len(rest) + 1)
    gains = len(now) * np.log(np.maximum(rest, 1e-300) / float(now @ now))
    return bool((gains + orders * np.log(len(now)) > 0).all())


def _fitted(columns: Array, target: Array) -> Array:
    return np.asarray(columns @ np.linalg.lstsq(columns, target, rcond=None)[0])


def _regressed(u: Array, y: Array, count: int) -> tuple[Array, Array]:
    """The residuals of u after its own past, and after past y too."""
    if len(u) != len(y):
        raise InputError(f"u has {len(u)} steps and y {len(y)}; they must be equally long.")
    if len(u) < 5 * PAST_U:
        raise InputError(f"there are {len(u)} steps; at least {5 * PAST_U} are needed.")
    now = _unit(lagged(u[:, None], PAST_U + 1))
    past = _unit(lagged(y[:, None], PAST_U + 1)[:, :count])
    scale = float(np.std(u))
    innovations = []
    for columns in (now[:, 1:], np.hstack([now[:, 1:], past])):
        fitted = np.linalg.lstsq(columns, now[:, 0], rcond=None)[0]
        innovations.append(scale * (now[:, 0] - columns @ fitted))
    return innovations[0], innovations[1]


def _unit(columns: Array) -> Array:
    """Centre the columns and scale them by one factor."""
    moved = columns - columns.mean(axis=0)
    return np.asarray(moved / (float(np.std(moved)) or 1.0))


@dataclass(frozen=True)
class _Differenced:
    """A record with y differenced once for a pole at 1, which the noise model compensates."""

    record: ScalarRecord
    sums: int

    @property
    def y(self) -> Array:
        y = self.record.y
        return np.diff(y, prepend=y[0]) if self.sums else y

    def rows(self, n: int, d: int) -> tuple[Array, Array]:
        """The equations y(k) = [-y(k-1), ..., u(k-d-1), ..., 1] theta, for the k of all models."""
        poles, first, y = n - self.sums, self.record.first + 1, self.y
        columns = [-late(y, i) for i in range(1, poles + 1)]
        columns += [late(self.record.u, d + i) for i in range(1, n + 1)]
        return y[first:], np.stack([*columns, np.ones_like(y)], axis=1)[first:]


@dataclass(frozen=True)
class _Candidate:
    """A candidate model: coefficients of A, B and c, of C and of D; its residual and criterion."""

    shape: Shape
    linear: Array
    C: Array
    D: Array
    e: Array
    value: float

    @property
    def share(self) -> float:
        """The share of the gain that comes from a pole at 1."""
        n, _, sums = self.shape
        A, B, _ = np.split(self.linear, [n - sums, 2 * n - sums])
        return integrated_share(np.r_[1.0, A], B)


def _best(data: _Differenced, candidates: list[Shape]) -> _Candidate:
    e = _innovations(data)
    fits = [_started(data, shape, e) for shape in candidates]
    fits.sort(key=lambda one: one.value)
    refined = [
        _refined(data, one, D) for one in fits[:REFINED] for D in (np.ones(1), np.array([1.0, 0]))
    ]
    return min(refined, key=lambda one: one.value)


def _innovations(data: _Differenced) -> Array:
    """The innovations of the long ARX model that BIC selects, as long as y, zero at the start."""
    y, u = data.y, data.record.u
    innovations = None
    for p in [p for p in LONG if 10 * p <= len(y)]:
        start = max(p for p in LONG if 10 * p <= len(y))
        columns = [*(late(y, i) for i in range(1, p + 1)), *(late(u, i) for i in range(1, p + 1))]
        rows = np.stack([*columns, np.ones_like(y)], axis=1)[start:]
        e = y[start:] - rows @ np.linalg.lstsq(rows, y[start:], rcond=None)[0]
        value = information_criterion(e, 2 * p + 1, 1.0)
        if innovations is None or value < innovations[0]:
            innovations = value, np.r_[np.zeros(start), e]
    return np.zeros_like(y) if innovations is None else innovations[1]


def _started(data: _Differenced, shape: Shape, e: Array) -> _Candidate:
    """Estimate A, B and C by one regression on the innovations of the long model."""
    n, d, _ = shape
    y, rows = data.rows(n, d)
    past = np.stack([late(e, i)[-len(y) :] for i in range(1, n + 1)], axis=1)
    fitted = np.asarray(np.linalg.lstsq(np.hstack([rows, past]), y, rcond=None)[0], np.float64)
    C = inside(np.r_[1.0, fitted[rows.shape[1] :]])
    return _evaluated(data, shape, fitted[: rows.shape[1]], C, np.ones(1))


def _evaluated(data: _Differenced, shape: Shape, linear: Array, C: Array, D: Array) -> _Candidate:
    y, rows = data.rows(*shape[:2])
    e = lfilter(D, C, y - rows @ linear)
    parameters = len(linear) + len(C) + len(D) - 2
    return _Candidate(shape, linear, C, D, e, information_criterion(e, parameters, PENALTY))


def _refined(data: _Differenced, start: _Candidate, D: Array) -> _Candidate:
    """Minimise the prediction error from a start, by gradients."""
    y, rows = data.rows(*start.shape[:2])
    n_l, n_C = rows.shape[1], len(start.C) - 1

    def parts(theta: Array) -> tuple[Array, Array, Array]:
        C = inside(np.r_[1.0, theta[n_l : n_l + n_C]])
        return theta[:n_l], C, np.r_[1.0, theta[n_l + n_C :]]

    def errors(theta: Array) -> Array:
        linear, C, D = parts(theta)
        return np.asarray(lfilter(D, C, y - rows @ linear))

    def slopes(theta: Array) -> Array:
        linear, C, D = parts(theta)
        w = y - rows @ linear
        by_linear = -lfilter(D, C, rows, axis=0)
        of_e, of_w = lfilter(D, np.convolve(C, C), w), lfilter([1.0], C, w)
        by_C = [-late(of_e, i) for i in range(1, n_C + 1)]
        by_D = [late(of_w, i) for i in range(1, len(D))]
        return np.stack([*by_linear.T, *by_C, *by_D], axis=1)

    theta = np.r_[start.linear, start.C[1:], D[1:]]
    optimum = least_squares(
        errors, theta, slopes, x_scale="jac", max_nfev=40, ftol=1e-10, xtol=1e-10, gtol=1e-12
    ).x  # fmt: skip
    linear, C, D = parts(np.asarray(optimum))
    return _evaluated(data, start.shape, linear, C, inside(D))


def _least(data: _Differenced, shape: Shape) -> float:
    """The criterion of the prediction of y from its own past alone."""
    n, d, sums = shape
    y, rows = data.rows(n, d)
    local_rows = np.hstack([rows[:, : n - sums], rows[:, -1:]])
    start = np.linalg.lstsq(local_rows, y, rcond=None)[0]
    C = np.concatenate([[1.0], np.zeros(n)])
    alone = _Differenced(ScalarRecord(0 * data.record.u, data.record.y, (1, 1), data.record.first),
                         sums)  # fmt: skip
    linear = np.concatenate([start[:-1], np.zeros(n), start[-1:]])
    refined = _refined(
        alone, _evaluated(alone, shape, np.asarray(linear), C, np.ones(1)), np.array([1.0, 0])
    )
    return information_criterion(refined.e, 2 * n + 1 - sums, PENALTY)


def _model(best: _Candidate, record: ScalarRecord, stirring: Array) -> PredictionErrorModel:
    n, d, sums = best.shape
    A = np.r_[1.0, best.linear[: n - sums]]
    for _ in range(sums):
        A = np.convolve(A, [1.0, -1.0])
    stable = inside(A)
    # Where a root p is reflected the filter is abs(p) times an all-pass.
    size = float(np.prod(np.maximum(np.abs(np.roots(A)), 1.0)))
    unit_u, unit_y = record.units
    residual = lfilter(best.C, np.convolve(best.D, stable), best.e) / size
    return PredictionErrorModel(
        best.linear[n - sums : 2 * n - sums] * unit_y / unit_u, A, d, (best.C, best.D),
        best.e * unit_y, np.asarray(residual * unit_y), best.value,
        1 - float(np.mean(best.e**2)) / float(np.var(record.last_y)),
        _correlation(best.e, stirring), sums,
    )  # fmt: skip


def _correlation(e: Array, stirring: Array) -> float:
    """The largest correlation of e with the past excitation of u, over 1/sqrt(N)."""
    if not np.std(e) > EXACT:
        return 0.0
    steps = min(len(e), len(stirring))
    e, s = e[-steps:], stirring[-steps:]
    e, s = (e - e.mean()) / np.std(e), (s - s.mean()) / np.std(s)
    correlations = [float(np.mean(e * late(s, i))) for i in range(1, TESTED + 1)]
    return float(np.abs(correlations).max() * np.sqrt(steps))
