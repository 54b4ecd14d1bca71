"""Intervals of gain, lags and dead time: samples of the likelihood, over credible structures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import chdtri, ndtr, ndtri
from scipy.stats import qmc
from scipy.stats import t as student_t

from rcac_numeric.arrays._array_types import Array
from rcac_numeric.identification._process_records import ProcessRecord
from rcac_numeric.identification._step_models import StepFit, errors_of

LEVEL = 0.95
TAIL = (1 - LEVEL) / 2
BATCHES = (64, 96, 128)  # samples of each proposal; the first only adapts it
FREEDOM = 4.0  # of the proposal, Student's t
WIDER = 1.3  # times the standard deviations of what it is adapted to
CREDIBLE = 8.0  # of AIC: odds of 1 to 55, below which a model does not reach an interval
MOST_MODELS = 6


@dataclass(frozen=True, eq=False)
class StepSamples:
    """Weighted samples of the coefficients of all credible models, in record units and steps.

    Attributes
    ----------
    weights : array, shape (samples,)
        Their sum is 1.
    gains, deviations : arrays
        The gain of each sample is Gaussian.
    dead_times, sums, rhos : arrays
        L, S and rho of each.
    orders : array
        Lags of each.
    integrates : array of bool
    """

    weights: Array
    gains: Array
    deviations: Array
    dead_times: Array
    sums: Array
    rhos: Array
    orders: Array
    integrates: Array

    @property
    def lags(self) -> tuple[Array, Array]:
        """Both time constants of each sample, the longer one first; of complex poles S/2 each."""
        root = np.sqrt(np.maximum(1 - 4 * self.rhos, 0.0))
        return self.sums * (1 + root) / 2, self.sums * (1 - root) / 2

    def among(self, is_chosen: Array) -> StepSamples:
        """Some of the samples, with weights of sum 1."""
        weights = self.weights[is_chosen]
        return StepSamples(
            weights / weights.sum(), self.gains[is_chosen], self.deviations[is_chosen],
            self.dead_times[is_chosen], self.sums[is_chosen], self.rhos[is_chosen],
            self.orders[is_chosen], self.integrates[is_chosen],
        )  # fmt: skip

    def interval(self, values: Array) -> tuple[float, float]:
        """The 95 % interval of a function of the samples."""
        order = np.argsort(values, kind="stable")
        total = np.cumsum(self.weights[order]) - self.weights[order] / 2
        low, high = np.interp([TAIL, 1 - TAIL], total, values[order])
        return float(low), float(high)

    def gain_interval(self) -> tuple[float, float]:
        """The 95 % interval of the gain, over the Gaussian of each sample."""
        low = float(np.min(self.gains - 8 * self.deviations))
        high = float(np.max(self.gains + 8 * self.deviations))
        width = np.maximum(self.deviations, 1e-12 * np.abs(self.gains) + 1e-300)

        def beyond(probability: float) -> Callable[[float], float]:
            return lambda K: float(self.weights @ ndtr((K - self.gains) / width)) - probability

        if not high > low:
            return low, high
        return tuple(  # type: ignore[return-value]
            float(brentq(beyond(p), low, high, xtol=1e-9 * (high - low))) for p in (TAIL, 1 - TAIL)
        )


def step_samples(record: ProcessRecord, fits: list[StepFit]) -> StepSamples:
    """Samples of the credible models and of the first, each weighted by exp(-AIC/2)."""
    best = min(one.weight_criterion for one in fits)
    kinds: dict[object, StepFit] = {}
    for one in sorted(fits, key=lambda one: one.weight_criterion):
        if one.weight_criterion < best + CREDIBLE:
            kinds.setdefault(
                (one.structure, one.noise.orders, one.slope, one.is_moving, one.jumps), one
            )  # fmt: skip
    chosen = list(kinds.values())[:MOST_MODELS]
    if all(one.structure != fits[0].structure for one in chosen):
        chosen.append(fits[0])  # the model that is handed out, whose coefficients have intervals
    columns: list[Array] = []
    for one in chosen:
        rows = _samples(record, one)
        rows[0] *= np.exp((best - one.weight_criterion) / 2)
        columns.append(rows)
    table = np.concatenate(columns, axis=1)
    table = table[:, table[0] > 0]
    table[0] /= table[0].sum()
    weights, gains, deviations, L, S, rho, order, integrates = table
    return StepSamples(weights, gains, deviations, L, S, rho, order, integrates > 0)


def _samples(record: ProcessRecord, fit: StepFit) -> Array:
    """Weights, gains, their deviations, L, S, rho, order, integrator; shape (8, samples).

    The likelihood of Gaussian errors, the gain and what is free at their best, the noise model as
    fitted, by adaptive importance sampling.
    """
    errors, structure = errors_of(record, fit), fit.structure
    low, high = structure.bounds(record.steps)
    freedom = max(record.steps - fit.parameters, 1)
    # Few steps: Student's quantile in place of Gauss's.
    variance = fit.variance * (student_t.ppf(1 - TAIL, freedom) / student_t.ppf(1 - TAIL, 1e9)) ** 2
    least = errors.at(fit.theta, fit.noise)
    base = float(least.e @ least.e) if least is not None else 0.0
    center, covariance = fit.theta, _covariance(fit, variance, high - low)
    thetas, values, rows = [], [], []
    sampler = qmc.Sobol(len(center) + 1, scramble=True, seed=1)
    for count, last in zip(BATCHES, (False, False, True), strict=True):
        points = student_points(sampler.random(count), center, covariance)
        inside = ((points > low) & (points < high)).all(axis=1)
        density = student_density(points, center, covariance)
        weights = np.zeros(count)
        responses = np.zeros((2, count))
        for i in np.nonzero(inside)[0]:
            there = errors.at(points[i], fit.noise)
            if there is None:
                continue
            square = float(there.e @ there.e) - base
            weights[i] = np.exp(-0.5 * square / variance - density[i])
            responses[:, i] = there.gain, there.deviation * np.sqrt(variance)
        if not weights.sum() > 0:  # as sharp as the arithmetic: the estimate alone
            break
        share = weights / weights.sum()
        if not last:
            center = share @ points
            moved = points - center
            spread = (share * moved.T) @ moved
            covariance = spread + 1e-3 * np.diag(np.diag(spread)) + 1e-18 * np.diag(high - low)
        if count != BATCHES[0] or last:
            thetas.append(points)
            values.append(weights / count)
            rows.append(responses)
    if not thetas:
        gain = np.array([[fit.gain], [0.0 if least is None else least.deviation]])
        thetas, values, rows = [fit.theta[None]], [np.ones(1)], [gain]
    theta, weight = np.concatenate(thetas), np.concatenate(values)
    lag = np.array([structure.lag(one) for one in theta]).T
    weight = weight / weight.sum()
    ones = np.ones(len(theta))
    return np.stack([
        weight, *np.concatenate(rows, axis=1), theta[:, -1], *lag,
        structure.lags * ones, structure.integrates * ones,
    ])  # fmt: skip


def _covariance(fit: StepFit, variance: float, width: Array) -> Array:
    """That of theta from the derivatives, at most a tenth of the bounds wide."""
    H = fit.jacobian.T @ fit.jacobian / max(variance, 1e-300)
    H[np.diag_indices_from(H)] += 1 / (0.1 * width) ** 2
    return np.asarray(np.linalg.inv(H))


def student_points(uniform: Array, center: Array, covariance: Array) -> Array:
    """Points of a multivariate t distribution from uniform ones, one column more."""
    clipped = np.clip(uniform, 1e-9, 1 - 1e-9)
    gauss = ndtri(clipped[:, :-1])
    scale = np.sqrt(FREEDOM / chdtri(FREEDOM, clipped[:, -1]))
    root = np.linalg.cholesky(WIDER**2 * covariance)
    return np.asarray(center + scale[:, None] * (gauss @ root.T))


def student_density(points: Array, center: Array, covariance: Array) -> Array:
    """The logarithm of its density, but for a constant of the dimension."""
    n = len(center)
    root = np.linalg.cholesky(WIDER**2 * covariance)
    z = np.linalg.solve(root, (points - center).T)
    square = np.einsum("ij,ij->j", z, z)
    return np.asarray(
        -(FREEDOM + n) / 2 * np.log1p(square / FREEDOM) - np.sum(np.log(np.diag(root)))
    )
