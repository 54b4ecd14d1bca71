"""Box-Jenkins and ARMAX models of a scalar record: prediction errors, gradients, least squares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.compiled._box_jenkins import (
    BoxJenkinsErrors,
    BoxJenkinsStructure,
    box_jenkins_errors,
    confined,
    least_box_jenkins_errors,
)
from rcac_numeric.identification._least_squares import DECREASE, SETTLED, WIDTHS
from rcac_numeric.identification._process_records import ProcessRecord, is_heavy

CIRCLE, OF_C = 0.99999, 0.995  # largest modulus of a pole of the plant or of D, and of a root of C
DIFFERENCE = np.array([1.0, -1.0])
ONE = np.ones(1)
UNSTABLE = 1.001  # modulus of a pole from which a model counts as unstable
ITERATIONS = 25
DEPENDENT = 1e-9  # of a column's norm: the rest of it is rounding
VISIBLE = 1e-12  # of the squares of the errors: what a u before the record makes of them


@dataclass(frozen=True, eq=False)
class NoiseModel:
    """C/(D (1 - q^-1)^i), of a level, or of its differences."""

    C: Array
    D: Array
    differences: int

    @cached_property
    def whitener(self) -> Array:
        """The numerator D (1 - q^-1)^i of the filter that makes the noise white; C is below."""
        return np.convolve(self.D, DIFFERENCE) if self.differences else self.D

    @property
    def orders(self) -> tuple[int, int, int]:
        """The orders of C and D, and i."""
        return len(self.C) - 1, len(self.D) - 1, self.differences


@dataclass(frozen=True, eq=False)
class ProcessFit:
    """y = q^-delay B/A u + level (+ slope, sinusoid) + C/(D (1 - q^-1)^i) e, fitted to a record.

    Attributes
    ----------
    A, B : arrays
        1, a_1, ..., a_n and b_1, ..., b_m; without the pole at 1 where u is summed.
    delay : int
    noise : NoiseModel
    summed : bool
        Whether the plant has a further pole at 1, of u summed.
    slope : bool
        Whether the level of y has a slope.
    armax : bool
        Whether A multiplies y and stands below the noise too, so that its poles may be anywhere.
    sinusoid : float
        Frequency of a sinusoid beside the level, in rad/step; 0 where there is none.
    jump : int
        The row from which the level is another one; 0 where it does not jump.
    e : array
        The prediction errors.
    jacobian : array, shape (parameters, steps)
        Their derivatives by A, B, C, D and the frequency, with level, slope, sinusoid and initial
        state projected out.
    parameters : int
        All that is fitted.
    bic : float
        -2 log likelihood + parameters log N, by the better of Gauss's and Student's.
    heavy : bool
        Whether Student's is the better by 0.02 a step.
    """

    A: Array
    B: Array
    delay: int
    noise: NoiseModel
    summed: bool
    slope: bool
    armax: bool
    sinusoid: float
    jump: int
    e: Array
    jacobian: Array
    parameters: int
    bic: float
    heavy: bool

    @property
    def order(self) -> int:
        """The number of poles that are fitted."""
        return len(self.A) - 1

    @property
    def integrates(self) -> bool:
        """Whether the plant has a pole at 1 that is not fitted."""
        return self.summed

    @property
    def denominator(self) -> Array:
        """A with its pole at 1."""
        return np.convolve(self.A, DIFFERENCE) if self.summed else self.A

    @property
    def key(self) -> tuple[object, ...]:
        """What the model is: its orders, delay and kind."""
        return (
            self.order, self.delay, self.noise.orders, self.armax, self.summed, self.slope,
            self.sinusoid > 0, self.jump,
        )  # fmt: skip

    @cached_property
    def poles(self) -> ComplexArray:
        """All poles of the plant."""
        return np.asarray(np.roots(self.denominator), dtype=np.complex128)

    @property
    def is_unstable(self) -> bool:
        """Whether a pole is outside the unit circle by more than 0.001."""
        return bool((np.abs(self.poles) > UNSTABLE).any())

    def response(self, omega: Array) -> ComplexArray:
        """G(exp(j omega)) in units of the record."""
        return response_of(self.B, self.denominator, self.delay, omega)


@dataclass(frozen=True)
class Start:
    """What a fit begins at."""

    A: Array
    B: Array
    delay: int
    noise: NoiseModel
    summed: bool = False
    slope: bool = False
    armax: bool = False
    sinusoid: float = 0.0
    jump: int = 0

    @property
    def coefficients(self) -> Array:
        """A, B, C and D without their ones, and the frequency of a sinusoid."""
        ends = [self.sinusoid] if self.sinusoid else []
        return np.concatenate([self.A[1:], self.B, self.noise.C[1:], self.noise.D[1:], ends])


def response_of(B: Array, A: Array, delay: int, omega: Array) -> ComplexArray:
    """q^-delay (b_1 q^-1 + ...)/A at exp(j omega)."""
    past = np.exp(-1j * omega)
    top = np.polyval(B[::-1], past) * past ** (delay + 1)
    return np.asarray(top / np.polyval(A[::-1], past))


def start_of(fit: ProcessFit) -> Start:
    """What another fit may begin at, from this one."""
    return Start(
        fit.A, fit.B, fit.delay, fit.noise, fit.summed, fit.slope, fit.armax, fit.sinusoid,
        fit.jump,
    )  # fmt: skip


def later(signal: Array, steps: int) -> Array:
    """The signal some steps later along the last axis, 0 before."""
    if not steps:
        return signal
    moved = np.zeros_like(signal)
    moved[..., steps:] = signal[..., :-steps]
    return moved


class _Errors:
    """The prediction errors of one structure as a function of its coefficients."""

    def __init__(self, record: ProcessRecord, start: Start, weights: Array | None) -> None:
        self.y, self.weights = record.y, weights
        delayed = later(record.u, start.delay)
        self.u = np.cumsum(delayed) if start.summed else delayed
        self.start = start
        self.n, self.m = len(start.A) - 1, len(start.B)
        self.n_C, self.n_D, self.differences = start.noise.orders
        steps = record.steps
        levels = [np.ones(steps)]
        if start.summed or start.slope:
            levels.append(np.linspace(0, 1, steps))
        if start.jump:
            levels.append(np.asarray(np.arange(steps) >= start.jump, dtype=np.float64))
        self.levels = np.stack(levels)
        self.free = len(levels) + 2 * bool(start.sinusoid) + self.n

    def split(self, theta: Array) -> tuple[Array, Array, NoiseModel]:
        """A, B and the noise model of the coefficients."""
        n, m, n_C = self.n, self.m, self.n_C
        C = np.concatenate([ONE, theta[n + m : n + m + n_C]])
        D = np.concatenate([ONE, theta[n + m + n_C : n + m + n_C + self.n_D]])
        return (
            np.concatenate([ONE, theta[:n]]),
            theta[n : n + m],
            NoiseModel(C, D, self.differences),
        )

    @property
    def structure(self) -> BoxJenkinsStructure:
        """The record and the orders, as the kernel reads them."""
        return BoxJenkinsStructure(
            self.y, self.u, self.levels, self.weights, (self.n, self.m, self.n_C, self.n_D),
            bool(self.differences), self.start.armax, self.start.sinusoid > 0, DEPENDENT,
        )  # fmt: skip

    def at(self, theta: Array) -> BoxJenkinsErrors | None:
        """The errors there; None where they leave float64."""
        return box_jenkins_errors(self.structure, theta)

    def minimised(
        self, theta: Array, iterations: int, kept: int = 0
    ) -> tuple[BoxJenkinsErrors, Array] | None:
        """The point of least errors from some coefficients, and its derivatives; None if it fails.

        By Levenberg and Marquardt; the first `kept` coefficients are kept. All filters are stable
        there, and a frequency is below the Nyquist frequency.
        """
        return least_box_jenkins_errors(
            self.structure, theta, kept=kept, iterations=iterations, widths=WIDTHS,
            decrease=DECREASE, settled=SETTLED, circle=CIRCLE, of_C=OF_C,
        )  # fmt: skip


def fitted(
    record: ProcessRecord, start: Start, *, iterations: int = ITERATIONS,
    weights: Array | None = None, is_plant_fixed: bool = False,
) -> ProcessFit | None:  # fmt: skip
    """Minimise the prediction errors from a start by Levenberg and Marquardt; None if it fails.

    Level, slope, sinusoid and initial state are projected out (Golub and Pereyra, with Kaufman's
    gradient).
    """
    errors = _Errors(record, start, weights)
    kept = errors.n + errors.m if is_plant_fixed else 0
    least = errors.minimised(start.coefficients, iterations, kept)
    return None if least is None else _evaluated(record, errors, *least)


def _evaluated(
    record: ProcessRecord, errors: _Errors, point: BoxJenkinsErrors, J: Array
) -> ProcessFit:
    A, B, noise = errors.split(point.theta)
    start, e = errors.start, point.e
    if errors.weights is not None:
        e = np.asarray(lfilter(noise.whitener, noise.C, point.remainder(True)))
    gauss, student, _ = record.likelihood(e)
    parameters = len(point.theta) + errors.free + 1 + bool(start.jump)
    bic = record.steps * min(gauss, student) + parameters * float(np.log(record.steps))
    return ProcessFit(
        A, B, start.delay, noise, start.summed, start.slope, start.armax,
        float(point.theta[-1]) if start.sinusoid else 0.0, start.jump, e, J, parameters, bic,
        is_heavy(gauss, student),
    )  # fmt: skip


def inverse_information(J: Array) -> Array:
    """The covariance of coefficients for errors of variance 1; infinite if it is unknown."""
    size = np.sqrt(np.einsum("ij,ij->i", J, J))
    size[size == 0] = 1.0
    scaled = J / size[:, None]
    try:
        covariance = np.linalg.pinv(scaled @ scaled.T, rcond=1e-12, hermitian=True)
    except np.linalg.LinAlgError:
        return np.full((len(J), len(J)), np.inf)
    return np.asarray(covariance / size / size[:, None])


def sinusoids(omega: float, steps: int) -> tuple[Array, Array]:
    """A cosine and a sine of a frequency in rad/step."""
    phase = omega * np.arange(steps)
    return np.cos(phase), np.sin(phase)


def without_sinusoid(
    v: Array,
    near: float,
    parts: Sequence[slice] | None = None,
    observed: NDArray[np.bool_] | None = None,
) -> tuple[float, Array]:
    """The frequency near one whose sinusoid explains most of v; v less it, level and slope.

    By least squares, which is efficient in coloured noise, too. Each part has its own phase.
    """
    parts = parts or [slice(0, len(v))]
    observed = np.ones(len(v), dtype=bool) if observed is None else observed

    def remainder(omega: float) -> Array:
        rest = v.copy()
        for part in parts:
            steps = part.stop - part.start
            waves = np.stack([np.ones(steps), np.linspace(-1, 1, steps), *sinusoids(omega, steps)])
            seen = observed[part]
            rest[part] -= np.linalg.lstsq(waves[:, seen].T, v[part][seen], rcond=None)[0] @ waves
        return rest

    def square(omega: float) -> float:
        return float(np.sum(remainder(omega)[observed] ** 2))

    width = np.pi / max(part.stop - part.start for part in parts)
    grid = near + np.linspace(-1, 1, 9) * width
    omega = float(min(grid[grid > 0], key=square))
    finer = minimize_scalar(
        square, bounds=(max(omega - width / 4, 0.1 * omega), omega + width / 4), method="bounded",
        options={"xatol": 1e-4 * width},
    )  # fmt: skip
    if finer.fun < square(omega):
        omega = float(finer.x)
    return omega, remainder(omega)


def weighted_fit(record: ProcessRecord, fit: ProcessFit, rounds: int = 4) -> ProcessFit:
    """The fit again by Student's likelihood: least squares with the weights of its errors."""
    for _ in range(rounds):
        again = fitted(record, start_of(fit), weights=record.weights(fit.e), iterations=8)
        if again is None:
            break
        has_settled = abs(again.bic - fit.bic) < 0.01
        fit = again
        if has_settled:
            break
    return fit


def noise_start(v: Array, orders: tuple[int, int, int]) -> NoiseModel:
    """C and D from two regressions (Hannan and Rissanen) of a disturbance."""
    n_C, n_D, differences = orders
    w = np.diff(v, prepend=v[0]) if differences else v - v.mean()
    if not n_C + n_D:
        return NoiseModel(ONE, ONE, differences)
    p = min(20, len(w) // 10)
    e = _innovations(w, p)
    columns = [-later(w, k) for k in range(1, n_D + 1)] + [later(e, k) for k in range(1, n_C + 1)]
    X = np.stack(columns)[:, p + 3 :]
    H = X @ X.T
    H[np.diag_indices_from(H)] *= 1 + 1e-10
    try:
        theta = np.linalg.solve(H + 1e-300 * np.eye(len(H)), X @ w[p + 3 :])
    except np.linalg.LinAlgError:
        theta = np.zeros(len(H))
    if not np.isfinite(theta).all():
        theta = np.zeros(len(H))
    return NoiseModel(
        confined(np.concatenate([ONE, theta[n_D:]]), 0.98),
        confined(np.concatenate([ONE, theta[:n_D]]), 0.98), differences,
    )  # fmt: skip


def _innovations(w: Array, p: int) -> Array:
    """The innovations of a long autoregression, from covariances."""
    if p < 1:
        return w
    X = np.stack([later(w, k) for k in range(p + 1)])[:, p:]
    H = X[1:] @ X[1:].T
    H[np.diag_indices_from(H)] *= 1 + 1e-9
    try:
        a = np.linalg.solve(H + 1e-300 * np.eye(p), X[1:] @ X[0])
    except np.linalg.LinAlgError:
        return w
    e = np.zeros_like(w)
    e[p:] = X[0] - a @ X[1:]
    return e


def with_noise(start: Start, noise: NoiseModel) -> Start:
    """The start with another noise model."""
    return replace(start, noise=noise)


def disturbance(record: ProcessRecord, start: Start | ProcessFit) -> Array:
    """Y less B/A u; for ARMAX A y less B u."""
    delayed = later(record.u, start.delay)
    u = np.cumsum(delayed) if start.summed else delayed
    B = np.concatenate([[0.0], start.B])
    if start.armax:
        steps = record.steps
        return np.asarray(np.convolve(record.y, start.A)[:steps] - np.convolve(u, B)[:steps])
    return np.asarray(record.y - lfilter(B, confined(start.A, CIRCLE), u))


def value_before(record: ProcessRecord, fit: ProcessFit) -> tuple[float, float]:
    """By how much BIC falls with another constant u before the record, and that u.

    The errors are linear in it, since a level is free: as if all of u were counted from there.
    """
    start, weights = start_of(fit), record.weights(fit.e) if fit.heavy else None
    points = [
        _Errors(record.counted_from(u), start, weights).at(start.coefficients) for u in (0.0, 1.0)
    ]
    if points[0] is None or points[1] is None:
        return 0.0, 0.0
    e = points[0].e
    slope = e - points[1].e
    square, total = float(slope @ slope), float(e @ e)
    if not square > VISIBLE * total:
        return 0.0, 0.0
    value = float(slope @ e) / square
    rest = max(1 - value * float(slope @ e) / total, 1e-12)
    return -record.steps * float(np.log(rest)) - float(np.log(record.steps)), value


def residual_of(record: ProcessRecord, fit: ProcessFit) -> Array:
    """What plant, level, slope and initial state leave of y: noise, and a sinusoid.

    With A in the noise model, C/(D A) e, poles of A outside the circle reflected: noise of the
    spectrum of what the model leaves.
    """
    if fit.armax:
        stable = confined(fit.A, 1.0)
        # Where a root p is reflected the filter is abs(p) times an all-pass.
        size = float(np.prod(np.maximum(np.abs(np.roots(fit.A)), 1.0)))
        D = fit.noise.whitener
        return np.asarray(lfilter(fit.noise.C, np.convolve(D, stable), fit.e) / size)
    start = start_of(fit)
    point = _Errors(record, start, None).at(start.coefficients)
    v = disturbance(record, fit) if point is None else point.remainder(False)
    return np.asarray(v - v.mean())
