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
from rcac_numeric.identification._process_records import ProcessRecord

LONG, ROUNDING = 40, 1e-10  # lags of a long regression; singular values over the largest
RIDGE = 1e-10  # of the mean square of a column
TIME_CONSTANTS = 9  # of the grid
SHORTEST, LONGEST = 0.7, 500.0  # steps, of its time constants
UNSTABLE = 3.0, 100.0, 6  # steps of time constant, and how many
NEAR = 2  # poles of that grid of which the best is a start
WHITENERS = ((ONE, 0), (ONE, 1), (np.array([1.0, -0.8]), 1))  # D and i, with C = 1


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
    steps, delays = record.steps, len(cost)
    longest = max(10.0, min(steps / 4, LONGEST))
    one_poles = np.exp(-1 / np.geomspace(SHORTEST, longest, TIME_CONSTANTS))
    impulse = np.zeros(steps)
    impulse[0] = 1.0
    results = []
    for D, differences in WHITENERS:
        top = np.convolve(D, DIFFERENCE) if differences else D
        rows = [y, u, impulse, np.ones(steps), *beside]
        y_f, u_f, h, *levels = lfilter(top, ONE, np.stack(rows))
        filtered, denominators = [], []
        for a in one_poles:
            first = lfilter(ONE, [1.0, -a], np.stack([u_f, h]))
            filtered += [first, lfilter(ONE, [1.0, -(a**2)], first)]
            denominators += [np.array([1.0, -a]), np.poly([a, a**2])]
        both = np.stack(filtered)
        free = np.stack(
            [*(np.broadcast_to(one, both[:, 1].shape) for one in levels), both[:, 1]], axis=1
        )
        scan = delay_scan(y_f, both[:, 0], free, 2, delays)
        value = steps * np.log(scan.squares) + cost
        at = value.argmin(axis=1)
        least = value[np.arange(len(at)), at]
        best = []
        for parity in (0, 1):
            j = parity + 2 * int(least[parity::2].argmin())
            best.append(ScanStart(
                denominators[j], scan.numerators[j, at[j]], int(at[j]), float(least[j])
            ))  # fmt: skip
        results.append(tuple(sorted(best, key=lambda one: one.square)))
    return results


def unstable_starts(
    record: ProcessRecord, cost: Array, beside: Sequence[Array] = ()
) -> list[tuple[ScanStart, int]]:
    """The best models with a pole outside the circle, and the differences of their noise.

    Of each two neighbours of a grid of poles, at the best delay, where C is A with that pole
    reflected: then y goes through an all-pass, and the errors are those of the output (Forssell and
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
    for differences in (0, 1):
        top = DIFFERENCE if differences else ONE
        ys, us, free, denominators = [], [], [], []
        for poles in grid:
            A = np.asarray(np.poly(poles), dtype=np.float64)
            C = np.poly([1 / poles[0], *poles[1:]])
            u = lfilter(top, C, u_y[0])
            ys.append(lfilter(np.convolve(top, A), C, u_y[1]))
            us.append(u)
            start, *levels = lfilter(top, C, np.stack([impulse, np.ones(steps), *beside]))
            free.append(np.stack([*levels, start, later(start, 1)]))
            denominators.append(A)
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
                (ScanStart(denominators[j], B, int(at[j]), float(least[j])), differences)
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
