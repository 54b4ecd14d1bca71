"""A scalar record of a process in standard units: no row is dropped, single spikes are replaced."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import median_filter
from scipy.optimize import minimize_scalar
from scipy.special import gammaln, log_ndtr

from compensator_theory.errors import InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.compiled._box_jenkins import student_scale
from rcac_numeric.identification._scalar_record import scalar_signal

LEAST = 30  # steps of a record
REST = 3  # steps of a constant u from which a record begins at rest
SPIKE = 8.0  # robust standard deviations of the second difference
SPAN = 5  # rows, of which the median is no spike: one or two values
SPIKES = 0.02  # of the steps: more of them are no accidents
JUMP = 6.0  # robust standard deviations of a difference: a jump of the level
DEGREES = 4.0  # of Student's t
PASSES = 12  # of reweighted squares, for its scale
HEAVY = 0.02  # of -2 log likelihood a step, by which that is the better
ROBUST = 1.4826  # standard deviations of a Gaussian in a median of absolute values
QUANTUM_SD = 12**-0.5  # standard deviation of rounding, in quanta
SHARPEST = 0.02  # of a quantum: the least scale of the noise before the rounding
ROUNDED = 1 - 1e-15  # a share of 1 within rounding has no logarithm of its complement
T_CONSTANT = -2 * float(
    gammaln((DEGREES + 1) / 2) - gammaln(DEGREES / 2) - 0.5 * np.log(DEGREES * np.pi)
)
GAUSS_CONSTANT = float(np.log(2 * np.pi))


@dataclass(frozen=True, eq=False)
class ProcessRecord:
    """u less its value at rest, y less its first value, in units of a standard deviation.

    Attributes
    ----------
    u, y : arrays, shape (steps,)
        u in units of its standard deviation, y of that of its differences; u is 0 before the
        record.
    units : (float, float)
        Those of u and y.
    quantum : float
        The step by which y is rounded, in units of y; 0 where it is not visible.
    spikes : int
        Values of y that were replaced by the line between those beside.
    rest : float
        The logged u that is 0 here.
    """

    u: Array
    y: Array
    units: tuple[float, float]
    quantum: float
    spikes: int
    rest: float = 0.0

    @property
    def steps(self) -> int:
        """The number of steps."""
        return len(self.u)

    @property
    def moves(self) -> int:
        """The number of steps at which u changes."""
        return int(np.count_nonzero(np.diff(self.u)))

    @property
    def rounding(self) -> float:
        """The standard deviation of the rounding of y."""
        return self.quantum * QUANTUM_SD

    @property
    def repeats(self) -> float:
        """Rows for each value of a rounded y, on average; they have one error. Else 1."""
        changes = np.count_nonzero(np.diff(self.y)) if self.quantum else self.steps - 1
        return self.steps / (changes + 1)

    def clipped(self) -> Array | None:
        """Y with its jumps clipped at six robust standard deviations; None where it has none."""
        dy, middle, size = self._differences()
        if size < JUMP * 1e-6 or not (np.abs(dy - middle) > size).any():
            return None
        return np.cumsum(np.clip(dy, middle - size, middle + size))

    def large_jumps(self, most: int) -> tuple[int, ...]:
        """The steps of its jumps, of six robust standard deviations; none if they are too many."""
        dy, middle, size = self._differences()
        at = np.nonzero(np.abs(dy - middle) > size)[0]
        return tuple(map(int, at)) if size > JUMP * 1e-6 and len(at) <= most else ()

    def without(self, at: tuple[int, ...]) -> Array:
        """Y without its jumps at some steps."""
        dy, middle, _ = self._differences()
        dy[list(at)] = middle
        return np.cumsum(dy)

    def _differences(self) -> tuple[Array, float, float]:
        """The differences of y, their median, and the size of a jump."""
        dy = np.diff(self.y, prepend=self.y[0])
        middle = float(np.median(dy))
        return dy, middle, JUMP * (ROBUST * float(np.median(np.abs(dy - middle))) + 1e-12)

    def counted_from(self, u: float) -> ProcessRecord:
        """The record with another u, in its units, before it."""
        return replace(self, u=self.u - u, rest=self.rest + u * self.units[0])

    def part(self, rows: slice) -> ProcessRecord:
        """Some of the steps as a record."""
        u, y = self.u[rows], self.y[rows]
        return ProcessRecord(u - at_rest(u), y - y[0], self.units, self.quantum, 0)

    def likelihood(self, e: Array) -> tuple[float, float, float]:
        """-2 log likelihood a step, Gaussian and of Student's t, and the scale of the latter.

        Of a rounded y that of its cells; no scale is below that of its rounding.
        """
        return likelihood_of(e, self.quantum)

    def weights(self, e: Array) -> Array:
        """The square roots of the weights by which least squares have Student's likelihood."""
        scale = self.likelihood(e)[2]
        return np.sqrt((DEGREES + 1) / (DEGREES + (e / scale) ** 2))


def likelihood_of(e: Array, quantum: float) -> tuple[float, float, float]:
    """-2 log likelihood a step, Gaussian and of Student's t, and the scale of the latter.

    Of a rounded y the likelihood is that of its cell: the probability that prediction and noise are
    rounded to y, over the width of the cell. No scale is below the deviation of a rounding.
    """
    squares, floor = e * e, quantum * QUANTUM_SD
    mean = float(np.mean(squares))
    scale = student_scale(e, DEGREES, max(floor, 1e-150), PASSES)
    if quantum:
        size = np.abs(e)
        return _of_cells(size, quantum, _gauss), _of_cells(size, quantum, _student), scale
    variance = max(mean, 1e-300)
    gauss = float(np.log(variance) + mean / variance + GAUSS_CONSTANT)
    tails = (DEGREES + 1) * float(np.mean(np.log1p(squares / (DEGREES * scale**2))))
    return gauss, 2 * float(np.log(scale)) + tails + T_CONSTANT, scale


def is_heavy(gauss: float, student: float) -> bool:
    """Whether Student's likelihood is the better by 0.02 a step."""
    return student < gauss - HEAVY


def _of_cells(size: Array, quantum: float, log_share: Callable[[Array, Array], Array]) -> float:
    """-2 log likelihood a step of errors of a rounded y, by the best scale of the noise."""
    low, high = size - quantum / 2, size + quantum / 2

    def value(log_scale: float) -> float:
        scale = np.exp(log_scale)
        return -2 * float(np.mean(log_share(low / scale, high / scale)))

    most = float(np.sqrt(np.mean(size**2))) + quantum
    ends = float(np.log(quantum * SHARPEST)), float(np.log(2 * most))
    best = minimize_scalar(value, bounds=ends, method="bounded", options={"xatol": 0.02})
    return float(best.fun) + 2 * float(np.log(quantum))


def _gauss(low: Array, high: Array) -> Array:
    """The logarithm of the probability between two values, the lower the nearer to 0."""
    above = log_ndtr(-low)
    return np.asarray(above + np.log1p(-np.exp(log_ndtr(-high) - above) * ROUNDED))


def _student(low: Array, high: Array) -> Array:
    """The same for Student's t of four degrees.

    P(x > a) = (1 - t)^2 (2 + t)/4 with t = a/sqrt(4 + a^2).
    """
    shares = []
    for a in (low, high):
        root = np.sqrt(DEGREES + a * a)
        rest = np.where(a > 0, DEGREES / (root * (root + np.abs(a))), 1 - a / root)  # 1 - t
        shares.append(rest**2 * (3 - rest) / 4)
    return np.asarray(np.log(np.maximum(shares[0] - shares[1], 1e-300)))


def process_record(u: ArrayLike, y: ArrayLike) -> ProcessRecord:
    """The record of one u and one y; raise an error where it cannot show a plant."""
    control, output = scalar_signal(u, "u"), scalar_signal(y, "y")
    if len(control) != len(output):
        raise InputError(
            f"u has {len(control)} steps and y {len(output)}; they must be equally long."
        )
    if len(control) < LEAST:
        raise InputError(f"there are {len(control)} steps; at least {LEAST} are needed.")
    if not np.ptp(control) > 0:
        raise InputError(
            "u is constant: the record does not show the plant. If u was stepped, the record must "
            "begin before the step."
        )
    if not np.ptp(output) > 0:
        raise InputError("y is constant: the record does not show the plant.")
    cleaned, spikes = without_spikes(output)
    rest = at_rest(control)
    moved = control - rest
    unit_u = float(np.std(moved))
    unit_y = float(np.std(np.diff(cleaned))) or float(np.std(cleaned))
    scaled = (cleaned - cleaned[0]) / unit_y
    return ProcessRecord(moved / unit_u, scaled, (unit_u, unit_y), quantum_of(scaled), spikes, rest)


def at_rest(u: Array) -> float:
    """The value of u from which it is counted: its first ones if they are equal, else the mean."""
    return float(u[0] if np.ptp(u[:REST]) == 0 else u.mean())


def quantum_of(y: Array) -> float:
    """The step by which y is rounded; 0 where it is not visible."""
    sizes = np.unique(np.round(np.abs(np.diff(y)), 9))
    return float(sizes[sizes > 0][0]) if 1 < len(sizes) < len(y) / 6 else 0.0


def without_spikes(y: Array) -> tuple[Array, int]:
    """Y with spikes of one or two rows replaced from the rows beside, and how many values."""
    size = float(np.std(y))
    bend = np.zeros(len(y))
    bend[1:-1] = y[1:-1] - (y[:-2] + y[2:]) / 2
    spread = ROBUST * float(np.median(np.abs(bend)))
    moves = np.abs(np.diff(y))
    moves = moves[moves > 1e-9 * size]
    spread = max(spread, 0.6 * float(moves.min()) if len(moves) else 0.0)
    if spread < 1e-9 * size:
        most = float(np.quantile(np.abs(bend), 0.99))
        spread = max(spread, float(np.sqrt(np.mean(np.clip(bend, -most, most) ** 2))))
    far = np.abs(y - median_filter(y, SPAN, mode="nearest")) > SPIKE * spread
    at = np.nonzero(far & (np.abs(bend) > SPIKE * spread / 2))[0]
    quiet = np.setdiff1d(np.arange(len(y)), at)
    line = np.interp(at, quiet, y[quiet])
    cleaned, count = y.copy(), 0
    for k, value in zip(at, line, strict=True):
        near = int(np.searchsorted(quiet, k))
        moves = np.abs(np.diff(y[quiet[max(near - 2, 0) : near + 2]]))
        if moves.max() < 0.5 * abs(y[k] - value):  # a peak of the response is no spike
            cleaned[k] = value
            count += 1
    return (cleaned, count) if count <= SPIKES * len(y) else (y, 0)
