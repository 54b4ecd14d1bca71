"""Plants in continuous time with dead time, of first and second order, fitted to a step test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import fftconvolve, lfilter

from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.compiled._box_jenkins import confined
from rcac_numeric.identification._box_jenkins import (
    CIRCLE,
    DEPENDENT,
    DIFFERENCE,
    OF_C,
    ONE,
    NoiseModel,
    later,
    noise_start,
)
from rcac_numeric.identification._delay_scan import delay_scan
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_records import ProcessRecord
from rcac_numeric.identification._process_search import WORSE

SHORTEST, LONGEST = 0.05, 5.0  # time constants: steps, and lengths of the record
GRID = 14  # time constants of the grid of starts
DAMPINGS = (0.15, 0.4, 0.7)  # of the grid
REPEATED = 0.25  # rho of two equal lags; above it the poles are complex
SHIFT, LARGEST = 0.02, 400.0  # of rho in log(rho + SHIFT), and the largest: damping 0.025
SHARE = 2  # a dead time is at most the record over this
NOISES = (((0, 1, 0), (1, 1, 0), (2, 2, 0)), ((1, 0, 1), (2, 1, 1)))  # beside the white ones
SIMPLE = ((0, 1, 0), (1, 0, 1))  # noise models whose roots do not cancel
RICH = 2  # structures with all noise models and variants
JUMP_SHARE = 1e-3  # of a jump's energy that no other column explains
MOST_JUMPS = 3
# Of the noise at rest over that of white noise: with less, level and slope would be the data.
QUIETEST = 0.5
WIDTH = 1e-3  # of the difference by L; at whole steps of L the errors of a lag have kinks
REFITTED = 4  # fits that are repeated by Student's likelihood


@dataclass(frozen=True)
class StepStructure:
    """K e^(-L s)/(rho S^2 s^2 + S s + 1), with 1/s where it integrates.

    Attributes
    ----------
    lags : int
        0, 1 or 2 poles beside the integrator.
    is_equal : bool
        Whether both lags are equal.
    integrates : bool
    """

    lags: int
    is_equal: bool = False
    integrates: bool = False

    @property
    def name(self) -> str:
        """The kind of plant in words."""
        if self.integrates:
            return "integrating with a lag" if self.lags else "integrating"
        return ("", "first order", "second order")[self.lags]

    @property
    def shape(self) -> int:
        """The number of coefficients beside K and L."""
        return 1 if self.is_equal else self.lags

    def lag(self, theta: Array) -> tuple[float, float]:
        """S, the sum of the time constants, and rho."""
        if not self.lags:
            return 0.0, 0.0
        S = float(np.exp(theta[0]))
        if self.lags == 1:
            return S, 0.0
        return S, REPEATED if self.is_equal else float(np.exp(theta[1]) - SHIFT)

    def bounds(self, steps: int) -> tuple[Array, Array]:
        """The least and the largest coefficients."""
        low = [np.log(SHORTEST), np.log(SHIFT)][: self.shape]
        high = [np.log(LONGEST * steps), np.log(LARGEST)][: self.shape]
        return np.array([*low, 0.0]), np.array([*high, steps / SHARE])


FIRST, EQUAL, SECOND = StepStructure(1), StepStructure(2, is_equal=True), StepStructure(2)
INTEGRATING, LAGGED = StepStructure(0, integrates=True), StepStructure(1, integrates=True)
STRUCTURES = (FIRST, EQUAL, SECOND, INTEGRATING, LAGGED)


def lag_poles(S: float, rho: float) -> ComplexArray:
    """The roots of rho S^2 s^2 + S s + 1; one of them where rho is 0."""
    if not S > 0:
        return np.zeros(0, dtype=np.complex128)
    if rho < 1e-6:
        return np.array([-1 / S + 0j])
    root = np.sqrt(1 - 4 * rho + 0j)
    if abs(root) < 1e-3:  # partial fractions need two poles
        root = 1e-3 + 0j
    return np.array([-2 / (S * (1 + root)), -(1 + root) / (2 * rho * S)])


def unit_step(t: Array, S: float, rho: float, integrates: bool) -> Array:
    """The response to a unit step at 0, without gain and dead time."""
    t = np.maximum(t, 0.0)
    poles = lag_poles(S, rho)
    if not len(poles):
        return t
    if len(poles) == 1:
        slow = np.exp(poles[0].real * t)
        return np.asarray(t - S * (1 - slow) if integrates else 1 - slow)
    slow, fast = poles
    return np.asarray(
        np.real(1 - (fast * np.exp(slow * t) - slow * np.exp(fast * t)) / (fast - slow))
    )


def lag_denominator(S: float, rho: float) -> Array:
    """A of the sampled lags."""
    poles = np.exp(lag_poles(S, rho))
    if len(poles) == 2:
        return np.array([1.0, -float((poles[0] + poles[1]).real), float(np.prod(poles).real)])
    return np.array([1.0, *-poles.real])


def sampled(structure: StepStructure, theta: Array) -> tuple[Array, Array, int]:
    """A, B and delay of the plant of gain 1 with a zero-order hold."""
    S, rho = structure.lag(theta)
    A = lag_denominator(S, rho)
    if structure.integrates:
        A = np.convolve(A, DIFFERENCE)
    delay = int(theta[-1])
    t = np.arange(len(A) + 1) - (theta[-1] - delay)
    impulse = np.diff(unit_step(t, S, rho, structure.integrates))
    return A, np.asarray(np.convolve(A, impulse)[: len(A)]), delay


def forced(structure: StepStructure, theta: Array, u: Array) -> Array:
    """The response of the plant of gain 1 to u, which is 0 before."""
    A, B, delay = sampled(structure, theta)
    return np.asarray(lfilter(np.append(0.0, B), A, later(u, delay)))


@dataclass(frozen=True, eq=False)
class StepFit:
    """y = K x + level (+ slope) (+ initial response) + C/(D (1 - q^-1)^i) e, fitted.

    Attributes
    ----------
    structure : StepStructure
    theta : array
        log S and log(rho + 0.02), where the structure has them, and L; in steps.
    noise : NoiseModel
    slope, is_moving : bool
        Whether the level has a slope, and whether the plant moves when the record begins.
    jumps : tuple of int
        Steps at which the level jumps.
    free : array
        Coefficients of level, slope, jumps, initial state and response in units of the record.
    e, jacobian : arrays
        Prediction errors, and their derivatives by theta.
    variance : float
        Of e, not below that of rounding; times the rows that repeat a rounded value.
    parameters : int
    bic : float
    weights : array or None
        Of each equation, by Student's likelihood.
    heavy : bool
    """

    structure: StepStructure
    theta: Array
    noise: NoiseModel
    slope: bool
    is_moving: bool
    jumps: tuple[int, ...]
    free: Array
    e: Array
    jacobian: Array
    variance: float
    parameters: int
    bic: float
    weights: Array | None
    heavy: bool

    @property
    def gain(self) -> float:
        """K in units of the record."""
        return float(self.free[-1])

    @property
    def integrates(self) -> bool:
        """Whether the plant integrates."""
        return self.structure.integrates

    @property
    def weight_criterion(self) -> float:
        """BIC, but 2 for each coefficient of the plant, of a slope and of a noise model of order 1.

        By AIC, noise models whose roots all but cancel and spurious jumps would narrow an interval.
        """
        count = len(self.theta) + 1 + self.slope
        count += sum(self.noise.orders[:2]) if self.noise.orders in SIMPLE else 0
        return self.bic - count * (float(np.log(len(self.e))) - 2)


@dataclass(frozen=True, eq=False)
class ProjectedErrors:
    """Errors at some coefficients, the gain and what is free projected out."""

    e: Array
    free: Array  # of level, slope, jumps, initial state and response; the last is the gain
    deviation: float  # of the gain, where e has variance 1
    basis: Array  # orthonormal, of what is projected out

    @property
    def gain(self) -> float:
        """K in units of the record."""
        return float(self.free[-1])


class StepErrors:
    """The prediction errors of a structure as a function of its coefficients."""

    def __init__(
        self, record: ProcessRecord, structure: StepStructure, *, slope: bool = False,
        is_moving: bool = False, jumps: tuple[int, ...] = (), weights: Array | None = None,
    ) -> None:  # fmt: skip
        self.record, self.structure = record, structure
        # Of an integrating plant the u that holds y at rest is not known: y has a slope.
        self.slope = slope = slope or structure.integrates
        self.is_moving, self.jumps, self.weights = is_moving, jumps, weights
        columns: list[Array] = [record.y, np.ones(record.steps)]
        if slope:
            columns.append(np.linspace(0, 1, record.steps))
        columns += [np.repeat([0.0, 1.0], (k, record.steps - k)) for k in jumps]
        self.known = np.stack(columns)
        self._noise: NoiseModel | None = None
        self._white = self.known

    @property
    def free(self) -> int:
        """The number of free columns beside the gain's."""
        return len(self.known) - 1 + (self.structure.lags if self.is_moving else 0)

    def at(self, theta: Array, noise: NoiseModel) -> ProjectedErrors | None:
        """The errors; None where u has no effect, or they leave float64."""
        if noise is not self._noise:
            known = self._noise
            if known is None or not _equal(known, noise):
                self._white = self._whitened(self.known, noise)
            self._noise = noise
        x = np.stack([*self._initial(theta), forced(self.structure, theta, self.record.u)])
        columns = np.concatenate([self._white[1:], self._whitened(x, noise)])
        size = np.sqrt(np.einsum("ij,ij->i", columns, columns))
        if not np.isfinite(size).all() or not size[-1] > 0:
            return None
        size[size == 0] = 1.0
        Q, R = np.linalg.qr((columns / size[:, None]).T)
        if not abs(R[-1, -1]) > DEPENDENT:
            return None
        is_needed = np.abs(np.diag(R)) > DEPENDENT
        if not is_needed.all():
            Q, R = Q[:, is_needed], R[is_needed][:, is_needed]
        onto = Q.T @ self._white[0]
        free = np.zeros(len(size))
        free[is_needed] = np.linalg.solve(R, onto)
        return ProjectedErrors(
            self._white[0] - Q @ onto, free / size, 1 / (abs(R[-1, -1]) * size[-1]), Q
        )

    def deterministic(self, theta: Array, free: Array) -> Array:
        """What plant, level, slope and initial state make of y."""
        x = forced(self.structure, theta, self.record.u)
        return np.asarray(free @ np.stack([*self.known[1:], *self._initial(theta), x]))

    def _initial(self, theta: Array) -> list[Array]:
        """The responses to the initial states of the lags, where they count."""
        if not self.is_moving or not self.structure.lags:
            return []
        A = lag_denominator(*self.structure.lag(theta))
        start = np.asarray(lfilter(ONE, A, np.eye(1, self.record.steps)[0]))
        return [later(start, k) for k in range(self.structure.lags)]

    def _whitened(self, columns: Array, noise: NoiseModel) -> Array:
        is_white = len(noise.whitener) == len(noise.C) == 1
        white = columns if is_white else lfilter(noise.whitener, noise.C, columns)
        return np.asarray(white if self.weights is None else white * self.weights)

    def split(self, point: Array, orders: tuple[int, int, int]) -> tuple[Array, NoiseModel]:
        """Coefficients of the plant, and the noise model."""
        n_C, n_D, differences = orders
        count = len(point) - n_C - n_D
        if not n_C + n_D:
            return point, _PLAIN[differences]
        C, D = np.append(ONE, point[count : count + n_C]), np.append(ONE, point[count + n_C :])
        return point[:count], NoiseModel(confined(C, OF_C), confined(D, CIRCLE), differences)

    def fit(self, theta: Array, noise: NoiseModel, evaluations: int = 40) -> StepFit | None:
        """Minimise the errors from a start; None if it fails."""
        orders = noise.orders
        low, high = self.structure.bounds(self.record.steps)
        count = len(theta)
        loose = np.full(sum(orders[:2]), 10.0)
        start = np.concatenate([np.clip(theta, low + 1e-6, high - 1e-6), noise.C[1:], noise.D[1:]])
        failed = np.full(self.record.steps, 1e3)

        def errors(point: Array) -> Array:
            errors_there = self.at(*self.split(point, orders))
            return failed if errors_there is None else errors_there.e

        widths = np.full(len(start), 1e-5)
        widths[count - 1] = WIDTH

        def slopes(point: Array) -> Array:
            return self._derivatives(point, errors, widths)

        solution = least_squares(
            errors, start, jac=slopes, bounds=(np.append(low, -loose), np.append(high, loose)),
            x_scale="jac", max_nfev=evaluations, ftol=1e-7, xtol=1e-7, gtol=1e-9,
        )  # fmt: skip
        theta, noise = self.split(solution.x, orders)
        best = self.at(theta, noise)
        if best is None:
            return None
        return self._evaluated(theta, noise, best, np.asarray(solution.jac)[:, :count])

    def _derivatives(self, point: Array, errors: Callable[[Array], Array], widths: Array) -> Array:
        """Differences by the coefficients, into their bounds."""
        base, columns = errors(point), []
        low, high = self.structure.bounds(self.record.steps)
        for i, width in enumerate(widths):
            moved = point.copy()
            is_low = i >= len(low) or point[i] - width > low[i]
            is_high = i >= len(low) or point[i] + width < high[i]
            moved[i] += width if is_high or not is_low else -width
            columns.append((errors(moved) - base) / (moved[i] - point[i]))
        return np.stack(columns, axis=1)

    def _evaluated(
        self, theta: Array, noise: NoiseModel, best: ProjectedErrors, jacobian: Array
    ) -> StepFit:
        steps = self.record.steps
        e = best.e if self.weights is None else best.e / self.weights
        gauss, student, _ = self.record.likelihood(e)
        # Of a jump its time counts beside its size.
        parameters = len(theta) + sum(noise.orders[:2]) + self.free + len(self.jumps) + 2
        floor = self.record.rounding**2
        variance = max(float(best.e @ best.e) / max(steps - parameters, 1), floor, 1e-300)
        variance *= self.record.repeats
        bic = steps * min(gauss, student) + parameters * float(np.log(steps))
        return StepFit(
            self.structure, theta, noise, self.slope, self.is_moving, self.jumps, best.free, e,
            jacobian, variance, parameters, bic, self.weights, student < gauss - 0.02,
        )  # fmt: skip


_PLAIN = (NoiseModel(ONE, ONE, 0), NoiseModel(ONE, ONE, 1))


def _equal(one: NoiseModel, other: NoiseModel) -> bool:
    return (
        one.differences == other.differences
        and np.array_equal(one.C, other.C)
        and np.array_equal(one.D, other.D)
    )


def errors_of(record: ProcessRecord, fit: StepFit) -> StepErrors:
    """The prediction errors of the kind of a fit."""
    return StepErrors(
        record, fit.structure, slope=fit.slope, is_moving=fit.is_moving, jumps=fit.jumps,
        weights=fit.weights,
    )  # fmt: skip


def likely_jump(errors: StepErrors, fit: StepFit) -> int | None:
    """The step at which a level jump lowers the sum of squares most, all else linearised."""
    point = errors.at(fit.theta, fit.noise)
    if point is None:
        return None
    steps = len(point.e)
    response = lfilter(fit.noise.whitener, fit.noise.C, np.ones(steps))
    basis, _ = np.linalg.qr(np.column_stack([point.basis, fit.jacobian]))
    if errors.weights is not None:
        e = point.e * errors.weights
        basis = basis * errors.weights[:, None]
        energy = fftconvolve(errors.weights**2, response[::-1] ** 2)[steps - 1 :]
    else:
        e, energy = point.e, np.cumsum(response**2)[::-1]
    match = fftconvolve(e, response[::-1])[steps - 1 :]
    onto = fftconvolve(basis, response[::-1, None], axes=0)[steps - 1 :]
    remainder = energy - np.einsum("ij,ij->i", onto, onto)
    gain = np.where(remainder > JUMP_SHARE * energy, match**2 / np.maximum(remainder, 1e-300), 0.0)
    gain[:2] = gain[-3:] = 0.0
    for k in fit.jumps:
        gain[k] = 0.0
    return int(gain.argmax()) if gain.max() > 0 else None


class StepSearch:
    """The fits of all structures and noise models, the best first.

    Parameters
    ----------
    record : ProcessRecord
        With u = 0 at rest.
    noises : sequence of NoiseModel
        More noise models, of Box-Jenkins fits.
    """

    def __init__(self, record: ProcessRecord, noises: tuple[NoiseModel, ...] = ()) -> None:
        self.record = record
        self.fits: list[StepFit] = []
        starts = [self._starts(differences) for differences in (0, 1)]
        short: dict[tuple[StepStructure, int], StepFit] = {}
        for differences in (0, 1):
            for structure, theta in starts[differences]:
                fit = self._plain(structure, theta, _PLAIN[differences])
                known = short.get((structure, differences))
                if fit is not None and (known is None or fit.bic < known.bic):
                    short[structure, differences] = fit
        self._noisy(short, noises)
        self._varied()
        self._jumping()
        self._heavy()
        self.fits.sort(key=lambda one: one.bic)
        self._unsettled()

    def best(self, count: int, *, distinct: bool = False) -> list[StepFit]:
        """The best fits so far; of each structure the best one."""
        ranked = sorted(self.fits, key=lambda one: one.bic)
        if distinct:
            ranked = list({one.structure: one for one in reversed(ranked)}.values())
            ranked.sort(key=lambda one: one.bic)
        return ranked[:count]

    def _fit(self, errors: StepErrors, theta: Array, noise: NoiseModel) -> StepFit | None:
        """A fit, which is kept."""
        fit = errors.fit(theta, noise)
        if fit is None or abs(fit.noise.C.sum()) < QUIETEST * abs(fit.noise.D.sum()):
            return None
        self.fits.append(fit)
        return fit

    def _plain(self, structure: StepStructure, theta: Array, noise: NoiseModel) -> StepFit | None:
        """A fit with a level alone."""
        return self._fit(StepErrors(self.record, structure), theta, noise)

    def _changed(self, fit: StepFit, **changes: Any) -> StepFit | None:
        """The fit with other columns beside the plant."""
        return self._fit(errors_of(self.record, replace(fit, **changes)), fit.theta, fit.noise)

    def _starts(self, differences: int) -> Iterator[tuple[StepStructure, Array]]:
        """Of each structure the coefficients of the grid, at the best whole dead time."""
        record = self.record
        T = np.geomspace(0.5, record.steps, GRID)
        grids: dict[StepStructure, list[Array]] = {
            FIRST: [np.array([np.log(one)]) for one in T],
            EQUAL: [np.array([np.log(2 * one)]) for one in T],
            SECOND: [
                np.array([np.log(2 * zeta * one), np.log(SHIFT + 1 / (4 * zeta**2))])
                for zeta in DAMPINGS for one in T
            ],
            INTEGRATING: [np.zeros(0)],
            LAGGED: [np.array([np.log(one)]) for one in T[::2]],
        }  # fmt: skip
        whitener = _PLAIN[differences].whitener
        level, slope = np.ones(record.steps), np.linspace(0, 1, record.steps)
        y, level, slope = lfilter(whitener, ONE, np.stack([record.y, level, slope]))
        delays = max(record.steps // SHARE, 2)
        for structure, grid in grids.items():
            thetas = [np.append(one, 0.0) for one in grid]
            x = np.stack([forced(structure, theta, record.u) for theta in thetas])
            # A column of `delay_scan` is one step late.
            u = lfilter(whitener, ONE, np.append(x[:, 1:], x[:, -1:], axis=1))
            free = np.stack([level, slope] if structure.integrates else [level])
            free = np.broadcast_to(free, (len(u), *free.shape))
            squares = delay_scan(y, u, free, 1, delays).squares
            best = squares.argmin(axis=1)
            order = squares.min(axis=1).argsort()
            for j in order[: 2 if structure is SECOND else 1]:
                yield structure, np.append(grid[j], float(best[j]))

    def _noisy(
        self, short: dict[tuple[StepStructure, int], StepFit], noises: tuple[NoiseModel, ...]
    ) -> None:
        """Noise models for the structures that are not far behind."""
        if not short:
            return
        for structure, differences in list(short):
            # A second order near the first: where the grid of equal lags is too coarse.
            if structure is FIRST:
                one = short[structure, differences]
                theta = np.array([one.theta[0], np.log(SHIFT + 0.08), 0.9 * one.theta[-1]])
                fit = self._plain(SECOND, theta, one.noise)
                known = short.get((SECOND, differences))
                if fit is not None and (known is None or fit.bic < known.bic):
                    short[SECOND, differences] = fit
        for differences in (0, 1):
            alike = [one for (_, i), one in short.items() if i == differences]
            alike.sort(key=lambda one: one.bic)
            for rank, one in enumerate(alike):
                if one.bic > alike[0].bic + 2 * WORSE:
                    break
                self._coloured(one, NOISES[differences] if rank < RICH else NOISES[differences][:1])
                for noise in noises:
                    is_new = all(noise.orders not in orders for orders in NOISES)
                    if rank < RICH and is_new and noise.differences == differences:
                        self._plain(one.structure, one.theta, noise)

    def _coloured(self, fit: StepFit, noises: tuple[tuple[int, int, int], ...]) -> None:
        """The fit with noise models of some orders, each from the one before."""
        v = self.disturbance(fit)
        for orders in noises:
            fit = self._plain(fit.structure, fit.theta, noise_start(v, orders)) or fit

    def disturbance(self, fit: StepFit) -> Array:
        """What the plant leaves of y."""
        errors = errors_of(self.record, fit)
        return np.asarray(self.record.y - errors.deterministic(fit.theta, fit.free))

    def _of_each_structure(self) -> list[StepFit]:
        """The best fit of every structure, and the best with white noise."""
        white = [one for one in self.fits if not sum(one.noise.orders)]
        white.sort(key=lambda one: one.bic)
        first = {one.structure: one for one in reversed(white)}
        best = self.best(len(STRUCTURES), distinct=True)
        return best + [one for one in first.values() if not any(one is other for other in best)]

    def _varied(self) -> None:
        """A slope of the level, and a plant that moves when the record begins."""
        rich = {one.structure for one in self.best(RICH, distinct=True)}
        for one in self._of_each_structure():
            sloped = None if one.structure.integrates else self._changed(one, slope=True)
            if sloped is not None and not sum(one.noise.orders):
                again = noise_start(self.disturbance(sloped), SIMPLE[0])
                self._changed(replace(sloped, noise=again))
            if one.structure in rich and one.structure.lags:
                self._changed(one, is_moving=True)
                if sloped is not None:
                    self._changed(sloped, is_moving=True)

    def _jumping(self) -> None:
        """Level jumps beside the plant, one after the other where they pay."""
        if not self.fits:
            return
        starts = self._of_each_structure()
        at = self.record.large_jumps(MOST_JUMPS)
        if at:
            starts += self._without(at)
        for one in starts:
            self._with_jumps(one)
        self._restarted()
        without = min((one.bic for one in self.fits if not one.jumps), default=np.inf)
        if self.best(1)[0].bic > without - ODDS:
            self.fits = [one for one in self.fits if not one.jumps]

    def _restarted(self) -> None:
        """Every structure from its own start beside the jumps of the best fit."""
        best = self.best(1)[0]
        if not best.jumps:
            return
        record, first = self.record, 1 + best.slope
        sizes = best.free[first : first + len(best.jumps)]
        steps = [size * (np.arange(record.steps) >= k)
                 for size, k in zip(sizes, best.jumps, strict=True)]  # fmt: skip
        self.record = replace(record, y=record.y - np.sum(steps, axis=0))
        starts = list(self._starts(0))
        self.record = record
        for structure, theta in starts:
            columns = StepErrors(record, structure, slope=best.slope, jumps=best.jumps)
            self._fit(columns, theta, best.noise)

    def _with_jumps(self, fit: StepFit) -> None:
        for _ in range(MOST_JUMPS - len(fit.jumps)):
            k = likely_jump(errors_of(self.record, fit), fit)
            again = None if k is None else self._changed(fit, jumps=(*fit.jumps, k))
            if again is None or again.bic > fit.bic - ODDS:
                break
            fit = again

    def _without(self, at: tuple[int, ...]) -> list[StepFit]:
        """Fits with jumps at the large differences, from every structure's start without them."""
        record, first = self.record, len(self.fits)
        self.record = replace(record, y=record.without(at))
        starts = list(self._starts(0))
        self.record = record
        for structure, theta in starts:
            self._fit(StepErrors(record, structure, jumps=at), theta, _PLAIN[0])
        best = sorted(self.fits[first:], key=lambda one: one.bic)[:1]
        for one in best:
            noise = noise_start(self.disturbance(one), NOISES[0][0])
            self._fit(errors_of(record, one), one.theta, noise)
        return sorted(self.fits[first:], key=lambda one: one.bic)[:1]

    def _unsettled(self) -> None:
        """An integrating plant where the lags are longer than the record and BIC leaves both."""
        if not self.fits or self.fits[0].integrates:
            return
        moved = np.nonzero(np.diff(self.record.u))[0]
        S, _ = self.fits[0].structure.lag(self.fits[0].theta)
        if self.record.steps - moved[0] > S:
            return
        alike = [i for i, one in enumerate(self.fits) if one.integrates]
        if alike and self.fits[alike[0]].bic < self.fits[0].bic + ODDS:
            self.fits.insert(0, self.fits.pop(alike[0]))

    def _heavy(self) -> None:
        """The best by Student's likelihood, where its tails are heavy."""
        best = self.best(REFITTED)
        if not best or not best[0].heavy:
            return
        for one in best:
            fit: StepFit | None = one
            for _ in range(3):
                if fit is not None:
                    fit = self._changed(fit, weights=self.record.weights(fit.e))
