"""The best delay and numerator for given poles and noise: every delay by correlations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.signal import lfilter

from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.identification._box_jenkins import (
    DEPENDENT,
    DIFFERENCE,
    ONE,
    later,
    sinusoids,
)
from rcac_numeric.identification._disturbance_parts import student_regression
from rcac_numeric.identification._process_records import ProcessRecord, is_heavy

LONG, ROUNDING = 40, 1e-10  # lags of a long regression; singular values over the largest
RIDGE = 1e-10  # of the mean square of a column
TIME_CONSTANTS = 9  # of the grid
SHORTEST, LONGEST = 0.7, 500.0  # steps, of its time constants
UNSTABLE = 3.0, 100.0, 6  # steps of time constant, and how many
ROBUST_ROUNDS = 3  # of Student's weights
NEAR = 2  # poles of that grid of which the best is a start
WHITENERS = ((ONE, 0), (ONE, 1), (np.array([1.0, -0.8]), 1))  # D and i, with C = 1
# C beside A of an unstable plant, and i: white noise, a random walk, white noise beside rare jumps
UNSTABLE_NOISES = ((ONE, 0), (ONE, 1), (np.array([1.0, -0.9]), 1))


@dataclass(frozen=True, eq=False)
class DelayScan:
    """Sums of squares and numerators, for each candidate filter of u and each delay.

    Attributes
    ----------
    squares : array, shape (candidates, delays)
    numerators : array, shape (candidates, delays, m)
    """

    squares: Array
    numerators: Array


def delay_scan(
    y: Array, u: Array, free: Array, count: int, delays: int, weights: Array | None = None
) -> DelayScan:
    """Regress y on u(k-d-1), ..., u(k-d-m) and on what is free, for every delay d.

    All sums over time are correlations: of u with y and the free columns, and, for the products of
    two columns, of u(k) u(k-i) with the weights.

    Parameters
    ----------
    y : array, shape (steps,) or (candidates, steps)
    u : array, shape (candidates, steps)
    free : array, shape (candidates or 1, columns, steps)
    count : int
        m, coefficients of the numerator.
    delays : int
        0, ..., delays - 1 are tried.
    weights : array, shape (steps,), optional
        By which every equation is multiplied; y and free are multiplied already.
    """
    candidates, steps = u.shape
    lags = delays + count
    Q, y = _orthogonal(y, free)
    right = np.concatenate([y[:, None], Q], axis=1)
    squared = np.ones(steps) if weights is None else weights**2
    if weights is not None:
        right = right * weights
    size = next_fast_len(steps + lags + 1, real=True)
    of_u = rfft(u, size, axis=-1)
    shifted = slice(1, lags + 1)  # column j is u(k - 1 - j)
    across = irfft(of_u.conj()[:, None] * rfft(right, size, axis=-1), size, axis=-1)[..., shifted]
    b, onto = across[:, 0], across[:, 1:]
    G = np.empty((candidates, delays, count, count))
    for i in range(count):
        products = u * later(u, i)
        if weights is None:
            sums = np.cumsum(products, axis=-1)
            # sum over k of u(k-1-j) u(k-1-j-i), j = 0, ..., lags - 1
            index = steps - 2 - np.arange(lags)
            of_products = np.where(index >= 0, sums[:, np.maximum(index, 0)], 0.0)
        else:
            spectrum = rfft(products, size, axis=-1).conj() * rfft(squared, size)
            of_products = irfft(spectrum, size, axis=-1)[:, shifted]
        band = of_products[:, : lags - i] - np.einsum(
            "pqj,pqj->pj", onto[..., : lags - i], onto[..., i:lags]
        )
        for row in range(count - i):
            G[:, :, row, row + i] = G[:, :, row + i, row] = band[:, row : row + delays]
    columns = np.arange(delays)[:, None] + np.arange(count)
    b = b[:, columns]
    ridge = RIDGE * np.abs(np.einsum("pdii->p", G)) / (delays * count) + 1e-300
    G[..., np.arange(count), np.arange(count)] += ridge[:, None, None]
    theta = np.linalg.solve(G, b[..., None])[..., 0]
    total = np.einsum("pk,pk->p", y, y)
    squares = total[:, None] - 2 * np.einsum("pdi,pdi->pd", theta, b)
    squares = squares + np.einsum("pdi,pdij,pdj->pd", theta, G, theta)
    return DelayScan(np.maximum(squares, 1e-14 * total[:, None] + 1e-300), theta)


def _orthogonal(y: Array, free: Array) -> tuple[Array, Array]:
    """An orthonormal basis of the free columns of each candidate, and y without its part there."""
    size = np.sqrt(np.einsum("pqk,pqk->pq", free, free))
    size[size == 0] = 1.0
    Q, R = np.linalg.qr(np.swapaxes(free / size[..., None], 1, 2))
    Q = np.swapaxes(Q, 1, 2) * (np.abs(np.einsum("pqq->pq", R)) > DEPENDENT)[..., None]
    y = np.broadcast_to(y, (len(Q), y.shape[-1]))
    return Q, y - np.einsum("pq,pqk->pk", np.einsum("pqk,pk->pq", Q, y), Q)


@dataclass(frozen=True, eq=False)
class ScanStart:
    """Poles, numerator and delay of the least sum of squares, and that sum."""

    A: Array
    B: Array
    delay: int
    square: float


def pole_starts(
    record: ProcessRecord, y: Array, u: Array, cost: Array, beside: Sequence[Array] = ()
) -> list[tuple[ScanStart, ...]]:
    """For each whitener the best one and two real poles of a grid, at the best delay.

    `cost` is what each delay adds to N log(sum of squares), `beside` further parts of
    the level, in rows.
    """
    scans = [_GridScan(record, y, u, whitener, beside) for whitener in WHITENERS]
    return [scan.best(cost) for scan in scans]


def robust_starts(record: ProcessRecord, cost: Array) -> list[tuple[ScanStart, Array, int]]:
    """Starts of the least errors with Student's weights, those weights, and the differences.

    Spikes and jumps draw least squares away from the plant, in a loop also in u. The weights are
    first those of a long regression on u, then those of the best start. None where that regression
    has errors without heavy tails.
    """
    starts: list[tuple[ScanStart, Array, int]] = []
    for whitener in WHITENERS[:2]:
        scan = _GridScan(record, record.y, record.u, whitener)
        past = np.stack([*(later(scan.u, k) for k in range(1, LONG // 2 + 1)), *scan.levels])
        _, e = student_regression(past, scan.y, record.weights, np.ones(record.steps))
        if not is_heavy(*record.likelihood(e)[:2]):
            continue
        for _ in range(ROBUST_ROUNDS):
            weights = record.weights(e)
            best = scan.best(cost, weights)
            columns = scan.columns_of(best[0])
            _, e = student_regression(columns, scan.y, record.weights, weights, 1)
        starts += [(one, weights, whitener[1]) for one in best]
    return starts


class _GridScan:
    """A whitened record, and u and the initial state behind one and two real poles of a grid."""

    def __init__(
        self, record: ProcessRecord, y: Array, u: Array, whitener: tuple[Array, int],
        beside: Sequence[Array] = (),
    ) -> None:  # fmt: skip
        steps = self.steps = record.steps
        longest = max(10.0, min(steps / 4, LONGEST))
        D, differences = whitener
        top = np.convolve(D, DIFFERENCE) if differences else D
        rows = [y, u, np.eye(1, steps)[0], np.ones(steps), *beside]
        self.y, self.u, h, *self.levels = lfilter(top, ONE, np.stack(rows))
        filtered, self.denominators = [], list[Array]()
        for a in np.exp(-1 / np.geomspace(SHORTEST, longest, TIME_CONSTANTS)):
            first = lfilter(ONE, [1.0, -a], np.stack([self.u, h]))
            filtered += [first, lfilter(ONE, [1.0, -(a**2)], first)]
            self.denominators += [np.array([1.0, -a]), np.array([1.0, -a - a**2, a**3])]
        both = np.stack(filtered)
        self.driven, states = both[:, 0], both[:, 1]
        levels = (np.broadcast_to(one, states.shape) for one in self.levels)
        self.free = np.stack([*levels, states], axis=1)

    def best(self, cost: Array, weights: Array | None = None) -> tuple[ScanStart, ...]:
        """The best one and two poles, the better first."""
        y, free = self.y, self.free
        if weights is not None:
            y, free = y * weights, free * weights
        scan = delay_scan(y, self.driven, free, 2, len(cost), weights)
        value = self.steps * np.log(scan.squares) + cost
        at = value.argmin(axis=1)
        least = value[np.arange(len(at)), at]
        best = []
        for parity in (0, 1):
            j = parity + 2 * int(least[parity::2].argmin())
            best.append(ScanStart(
                self.denominators[j], scan.numerators[j, at[j]], int(at[j]), float(least[j])
            ))  # fmt: skip
        return tuple(sorted(best, key=lambda one: one.square))

    def columns_of(self, start: ScanStart) -> Array:
        """What y is regressed on for the poles and the delay of a start."""
        j = next(k for k, A in enumerate(self.denominators) if A is start.A)
        u = [later(self.driven[j], start.delay + k) for k in (1, 2)]
        return np.stack([*u, *self.free[j]])


def unstable_starts(
    record: ProcessRecord, cost: Array, beside: Sequence[Array] = ()
) -> list[tuple[ScanStart, Array, int]]:
    """The best models with a pole outside the circle, with C and the differences of their noise.

    Of each two neighbours of a grid of poles, at the best delay, where A with that pole reflected
    is in C: then y goes through an all-pass, and the errors are those of the output (Forssell and
    Ljung).
    """
    steps, results = record.steps, []
    u_y = np.stack([record.u, record.y])
    impulse = np.eye(1, steps)[0]
    grid = []
    pole_of: list[int] = []
    for k, p in enumerate(np.exp(1 / np.geomspace(*UNSTABLE))):
        grid += [(p,), (p, 0.5), (p, 0.9), (p, 1 / p)]
        pole_of += [k] * 4
    for of_level, differences in UNSTABLE_NOISES:
        top = DIFFERENCE if differences else ONE
        ys, us, free, denominators, noises = [], [], [], [], []
        for poles in grid:
            A = np.asarray(np.poly(poles), dtype=np.float64)
            C = np.convolve(np.poly([1 / poles[0], *poles[1:]]), of_level)
            u = lfilter(top, C, u_y[0])
            ys.append(lfilter(np.convolve(top, A), C, u_y[1]))
            us.append(u)
            start, *levels = lfilter(top, C, np.stack([impulse, np.ones(steps), *beside]))
            free.append(np.stack([*levels, start, later(start, 1)]))
            denominators.append(A)
            noises.append(C)
        scan = delay_scan(np.stack(ys), np.stack(us), np.stack(free), 2, len(cost))
        value = steps * np.log(scan.squares) + cost
        at = value.argmin(axis=1)
        least = value[np.arange(len(at)), at]
        # Of each pole's distance from the circle the best: the errors of a start far from the
        # optimum do not rank them.
        kinds = np.array(
            [(len(A) - 1, k // NEAR) for k, A in zip(pole_of, denominators, strict=True)]
        )
        for kind in np.unique(kinds, axis=0):
            j = int(np.where((kinds == kind).all(axis=1), least, np.inf).argmin())
            B = scan.numerators[j, at[j]]
            results.append(
                (ScanStart(denominators[j], B, int(at[j]), float(least[j])), noises[j], differences)
            )
    return results


def regression_start(
    y: Array, u: Array, columns: Sequence[Array], order: int, cost: Array
) -> tuple[Array, Array, int, float]:
    """Least squares of y on its past, columns and u, at the best delay.

    Returns the coefficients of past y and the columns, those of u, the delay, and the criterion
    N log(mean square) + parameters log N.
    """
    steps = len(y)
    past = [-later(y, k) for k in range(1, order + 1)]
    free = np.stack([np.ones(steps), *past, *columns])
    scan = delay_scan(y, u[None], free[None], order, len(cost))
    value = steps * np.log(scan.squares[0] / steps) + cost
    delay = int(value.argmin())
    forced = np.stack([later(u, delay + k) for k in range(1, order + 1)])
    X = np.concatenate([free[1:], forced, free[:1]])
    theta = np.linalg.lstsq(X.T, y, rcond=None)[0]
    known = len(free) - 1
    criterion = float(value[delay]) + len(theta) * float(np.log(steps))
    return theta[:known], theta[known : known + order], delay, criterion


def regression_roots(y: Array, inputs: Array, counts: NDArray[np.bool_]) -> ComplexArray:
    """The roots of the polynomial of y in a long regression on its past and that of the inputs.

    Of the rows that count. A sinusoid of the disturbance is a root on the circle, whatever the
    plant; which of them are its poles the regression does not tell.
    """
    p = min(LONG, int(np.count_nonzero(counts)) // (3 * (1 + len(inputs))))
    rows = np.flatnonzero(counts)
    rows = rows[rows >= p]
    past = [one[rows - k] for one in (y, *inputs) for k in range(1, p + 1)]
    X = np.stack([*past, np.ones(len(rows))])
    of_y = np.linalg.lstsq(X.T, y[rows], rcond=ROUNDING)[0][:p]
    return np.asarray(np.roots(np.concatenate([ONE, -of_y])), dtype=np.complex128)


def scanned_again(
    record: ProcessRecord, A: Array, noise_C: Array, whitener: Array, *, slope: bool, summed: bool,
    count: int, delays: int, weights: Array | None = None, sinusoid: float = 0.0,
) -> DelayScan:  # fmt: skip
    """All delays for the poles and the noise of one model."""
    steps = record.steps
    impulse = np.zeros(steps)
    impulse[0] = 1.0
    u = np.cumsum(record.u) if summed else record.u
    waves = sinusoids(sinusoid, steps) if sinusoid else ()
    level = np.stack([record.y, np.ones(steps), np.linspace(0, 1, steps), *waves])
    y, *levels = lfilter(whitener, noise_C, level)
    driven, state = lfilter(whitener, np.convolve(noise_C, A), np.stack([u, impulse]))
    free = [levels[0], *([levels[1]] if slope or summed else []), *levels[2:]]
    free += [later(state, k) for k in range(len(A) - 1)]
    rows = np.stack(free)
    if weights is not None:
        y, rows = y * weights, rows * weights
    return delay_scan(y, driven[None], rows[None], count, delays, weights)
