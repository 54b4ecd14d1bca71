"""Box-Jenkins models of one output and several inputs, over experiments and gaps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.compiled._box_jenkins import confined
from rcac_numeric.compiled._gaps import errors_with_gaps
from rcac_numeric.identification._box_jenkins import (
    CIRCLE,
    DEPENDENT,
    DIFFERENCE,
    ITERATIONS,
    OF_C,
    ONE,
    VISIBLE,
    NoiseModel,
    response_of,
    sinusoids,
)
from rcac_numeric.identification._joint_records import JointRecord
from rcac_numeric.identification._least_squares import minimised
from rcac_numeric.identification._prediction_error import ODDS
from rcac_numeric.identification._process_records import DEGREES, is_heavy
from rcac_numeric.identification._process_search import FEW

ROUNDS = 8  # in which a frequency and all else are fitted in turn
STEP = 1e-6  # of a coefficient of the noise, for the derivatives by it


@dataclass(frozen=True, eq=False)
class Channel:
    """q^-delay B/A from one input, with a further pole at 1 where u is summed."""

    input: int
    A: Array
    B: Array
    delay: int
    summed: bool = False

    @property
    def order(self) -> int:
        """The number of poles that are fitted."""
        return len(self.A) - 1

    @property
    def denominator(self) -> Array:
        """A with its pole at 1."""
        return np.convolve(self.A, DIFFERENCE) if self.summed else self.A

    @property
    def key(self) -> tuple[int, int, int, bool]:
        """Input, order, delay and whether u is summed."""
        return self.input, self.order, self.delay, self.summed

    def response(self, omega: Array) -> ComplexArray:
        """The response in units of the record."""
        return response_of(self.B, self.denominator, self.delay, omega)

    def driver(self, record: JointRecord) -> Array:
        """The delayed, and where needed summed, input."""
        u = record.later(record.u[self.input], self.delay)
        return record.summed(u) if self.summed else u


@dataclass(frozen=True, eq=False)
class JointStart:
    """What a fit begins at."""

    channels: tuple[Channel, ...]
    noise: NoiseModel
    slope: bool = False
    sinusoid: float = 0.0


@dataclass(frozen=True, eq=False)
class JointFit:
    """y = sum of channels + level of each part (+ slope, sinusoid) + C/(D (1 - q^-1)^i) e.

    Attributes
    ----------
    channels : tuple of Channel
    noise : NoiseModel
    slope : bool
    sinusoid : float
        Frequency of a sinusoid beside each level, in rad/step; 0 where there is none.
    e : array
        The prediction errors of the observed steps, over the roots of their variances.
    jacobian : array, shape (parameters, steps)
        Their derivatives by A, B of each channel, C and D, with what is free projected out.
    parameters : int
    bic : float
    heavy : bool
        Whether Student's likelihood is the better by 0.02 a step.
    """

    channels: tuple[Channel, ...]
    noise: NoiseModel
    slope: bool
    sinusoid: float
    e: Array
    jacobian: Array
    parameters: int
    bic: float
    heavy: bool

    @property
    def start(self) -> JointStart:
        """What another fit may begin at."""
        return JointStart(self.channels, self.noise, self.slope, self.sinusoid)

    @property
    def key(self) -> tuple[object, ...]:
        """What the model is."""
        return (
            tuple(one.key for one in self.channels), self.noise.differences, self.slope,
            self.sinusoid > 0,
        )  # fmt: skip

    def channel(self, j: int) -> Channel | None:
        """The channel of an input; None where it has no effect."""
        return next((one for one in self.channels if one.input == j), None)

    @cached_property
    def places(self) -> list[slice]:
        """Where the coefficients of each channel stand."""
        ends = np.cumsum([0, *(one.order + len(one.B) for one in self.channels)])
        return [slice(int(a), int(b)) for a, b in pairwise(ends)]


class _JointErrors:
    """The prediction errors of one structure as a function of its coefficients."""

    def __init__(self, record: JointRecord, start: JointStart, weights: Array | None) -> None:
        self.record, self.start, self.weights = record, start, weights
        self.drivers = [one.driver(record) for one in start.channels]
        self.sizes = [(one.order, len(one.B)) for one in start.channels]
        self.n_C, self.n_D, self.differences = start.noise.orders
        self.plant = sum(n + m for n, m in self.sizes)
        self.has_slope = start.slope or any(one.summed for one in start.channels)
        self.whole = [bool(record.observed[part].all()) for part in record.parts]
        self.fixed = 1 + self.has_slope + 2 * bool(start.sinusoid)
        each = self.fixed + sum(n for n, _ in self.sizes)
        self.free = sum(
            min(each, int(np.count_nonzero(record.observed[part]))) for part in record.parts
        )

    def split(self, theta: Array) -> tuple[list[tuple[Array, Array]], NoiseModel]:
        """A and B of each channel, and the noise model, of the coefficients."""
        polynomials, at = [], 0
        for n, m in self.sizes:
            A = np.concatenate([ONE, theta[at : at + n]])
            polynomials.append((A, theta[at + n : at + n + m]))
            at += n + m
        C = np.concatenate([ONE, theta[at : at + self.n_C]])
        D = np.concatenate([ONE, theta[at + self.n_C :]])
        return polynomials, NoiseModel(C, D, self.differences)

    def joined(self, polynomials: list[tuple[Array, Array]], noise: NoiseModel) -> Array:
        """The coefficients of polynomials."""
        parts = [one for A, B in polynomials for one in (A[1:], B)]
        return np.concatenate([*parts, noise.C[1:], noise.D[1:]])

    def confined(self, theta: Array) -> Array:
        """The coefficients with stable filters."""
        polynomials, noise = self.split(theta)
        C, D = confined(noise.C, OF_C), confined(noise.D, CIRCLE)
        stable = [(confined(A, CIRCLE), B) for A, B in polynomials]
        return self.joined(stable, NoiseModel(C, D, noise.differences))

    def whitened(self, noise: NoiseModel, rows: Array, i: int) -> tuple[Array, float]:
        """The errors of rows of a part, and the logarithm of the determinant."""
        part = self.record.parts[i]
        if self.whole[i]:
            return np.asarray(lfilter(noise.whitener, noise.C, rows)), 0.0
        return errors_with_gaps(rows, noise.whitener, noise.C, self.record.observed[part])

    def at(self, theta: Array) -> _JointPoint | None:
        """The errors there; None where they leave float64."""
        record = self.record
        polynomials, noise = self.split(theta)
        x = [record.filtered(np.concatenate([[0.0], B]), A, u)
             for (A, B), u in zip(polynomials, self.drivers, strict=True)]  # fmt: skip
        v = record.y - sum(x)
        impulse = np.zeros(record.longest)
        impulse[0] = 1.0
        responses = [lfilter(ONE, A, impulse) for A, _ in polynomials]
        pieces, total = [], 0.0
        e = np.empty(record.steps)
        for i, part in enumerate(record.parts):
            steps = part.stop - part.start
            known = [np.ones(steps)]
            if self.has_slope:
                known.append(np.linspace(0, 1, steps))
            if self.start.sinusoid:
                known += sinusoids(self.start.sinusoid, steps)
            known += [
                np.concatenate([np.zeros(k), response[: steps - k]])
                for response, (n, _) in zip(responses, self.sizes, strict=True)
                for k in range(min(n, steps))
            ]
            raw = np.stack([v[part], *known])
            white, logarithm = self.whitened(noise, raw, i)
            total += logarithm
            if not np.isfinite(white[0]).all() or not np.isfinite(white[-1]).all():
                return None
            if self.weights is not None:
                white = white * self.weights[part]
            piece = _FreePart.of(raw, white)
            pieces.append(piece)
            e[part] = white[0] - piece.Q @ piece.coefficients
        scale = float(np.exp(total / (2 * record.count)))
        return _JointPoint(self, theta, x, v, pieces, scale * e, scale)


@dataclass(frozen=True, eq=False)
class _FreePart:
    """What is free in a part: its rows, and an orthonormal basis of them when they are white."""

    raw: Array
    Q: Array
    R: Array
    size: Array
    coefficients: Array

    @classmethod
    def of(cls, raw: Array, white: Array) -> _FreePart:
        """The basis, and its share in the errors."""
        F = white[1:]
        size = np.sqrt(np.einsum("ij,ij->i", F, F))
        size[size == 0] = 1.0
        Q, R = np.linalg.qr((F / size[:, None]).T)
        is_needed = np.abs(np.diag(R)) > DEPENDENT
        if len(is_needed) < len(F) or not is_needed.all():
            Q, R = Q[:, is_needed], np.zeros((0, 0))
        return cls(raw, Q, R, size, Q.T @ white[0])

    def remainder(self) -> tuple[Array, Array | None]:
        """The errors less what is free, and the coefficients of the latter."""
        if not len(self.R):
            return self.raw[0], None
        free = np.linalg.solve(self.R, self.coefficients) / self.size
        return self.raw[0] - free @ self.raw[1:], free

    def remainder_with(self, kept: slice) -> Array:
        """The errors less what is free but for some rows."""
        v, free = self.remainder()
        return v if free is None else v + free[kept] @ self.raw[1:][kept]


@dataclass(eq=False)
class _JointPoint:
    """The errors at some coefficients, and their derivatives where they are needed."""

    errors: _JointErrors
    theta: Array
    x: list[Array]
    v: Array
    pieces: list[_FreePart]
    e: Array
    scale: float

    @property
    def square(self) -> float:
        """The sum of squares."""
        return float(self.e @ self.e)

    def jacobian(self) -> Array | None:
        """The derivatives of e, less their projection on what is free (Kaufman)."""
        errors, record = self.errors, self.errors.record
        polynomials, noise = errors.split(self.theta)
        v, x = self.v.copy(), [one.copy() for one in self.x]
        first = errors.fixed
        for piece, part in zip(self.pieces, record.parts, strict=True):
            v[part], free = piece.remainder()
            if free is None:
                continue
            at = first
            for one, (n, _) in zip(x, errors.sizes, strict=True):
                one[part] += free[at : at + n] @ piece.raw[1 + at : 1 + at + n]
                at += n
        rows = []
        for (A, _), u, state, (n, m) in zip(
            polynomials, errors.drivers, x, errors.sizes, strict=True
        ):
            by_A, by_B = record.filtered(ONE, A, np.stack([state, -u]))
            rows += [record.later(by_A, k) for k in range(1, n + 1)]
            rows += [record.later(by_B, k) for k in range(1, m + 1)]
        J = np.zeros((len(self.theta), record.steps))
        logarithms = np.zeros((len(self.theta), 2))
        for i, part in enumerate(record.parts):
            white = []
            if rows:
                white.append(errors.whitened(noise, np.stack(rows)[:, part], i)[0])
            for k in range(errors.plant, len(self.theta)):
                sides = []
                for side, sign in enumerate((1, -1)):
                    moved = self.theta.copy()
                    moved[k] += sign * STEP
                    e, logarithm = errors.whitened(errors.split(moved)[1], v[None, part], i)
                    logarithms[k, side] += logarithm
                    sides.append(e)
                white.append((sides[0] - sides[1]) / (2 * STEP))
            J[:, part] = np.concatenate(white) if white else 0.0
            if errors.weights is not None:
                J[:, part] *= errors.weights[part]
            Q = self.pieces[i].Q
            J[:, part] -= (J[:, part] @ Q) @ Q.T
        slopes = (logarithms[:, 0] - logarithms[:, 1]) / (2 * STEP) / (2 * record.count)
        J = self.scale * J + slopes[:, None] * self.e
        return J if np.isfinite(J).all() else None


def with_values_before(record: JointRecord, fit: JointFit) -> tuple[float, JointRecord]:
    """By how much BIC falls with other constants of u before each part; u counted from there.

    Inputs of few moves keep theirs: beside one move any disturbance of the first rows is another.
    """

    def errors(u: Array) -> Array | None:
        of_u = _JointErrors(replace(record, u=u), fit.start, None)
        point = of_u.at(of_u.joined([(one.A, one.B) for one in fit.channels], fit.noise))
        return None if point is None else point.e[record.observed]

    e, places, slopes = errors(record.u), list[tuple[int, slice]](), list[Array]()
    if e is None:
        return 0.0, record
    for j in sorted({one.input for one in fit.channels if record.moves(one.input) > FEW}):
        for part in record.parts:
            u = record.u.copy()
            u[j, part] -= 1.0
            moved = errors(u)
            if moved is not None and np.sum((e - moved) ** 2) > VISIBLE * float(e @ e):
                places.append((j, part))
                slopes.append(e - moved)
    if not places:
        return 0.0, record
    X = np.stack(slopes, axis=1)
    values = np.linalg.lstsq(X, e, rcond=DEPENDENT)[0]
    rest, u = e - X @ values, record.u.copy()
    for (j, part), value in zip(places, values, strict=True):
        u[j, part] -= value
    ratio = max(float(rest @ rest) / float(e @ e), 1e-12)
    pays = -record.count * np.log(ratio) - len(values) * np.log(record.count)
    return float(pays), replace(record, u=u)


def joint_fit(
    record: JointRecord, start: JointStart, *, iterations: int = ITERATIONS,
    weights: Array | None = None,
) -> JointFit | None:  # fmt: skip
    """Minimise the prediction errors from a start; None if it fails.

    Levels, slopes and initial states of each part are projected out. Where steps are missing the
    errors are those of the Kalman filter of the noise, and the sum of squares is that of the
    likelihood, det^(1/N) e'e.
    """
    errors = _JointErrors(record, start, weights)
    theta = errors.joined([(one.A, one.B) for one in start.channels], start.noise)
    least = minimised(errors, theta, record.count, iterations)
    if least is None:
        return None
    point, J = least
    if weights is not None:
        plain = _JointErrors(record, start, None)
        v = [piece.remainder()[0] for piece in point.pieces]
        noise = plain.split(point.theta)[1]
        whitened = [plain.whitened(noise, one[None], i) for i, one in enumerate(v)]
        total = sum(logarithm for _, logarithm in whitened)
        e = np.concatenate([white[0] for white, _ in whitened])
        e = e * float(np.exp(total / (2 * record.count)))
    else:
        e = point.e
    polynomials, noise = errors.split(point.theta)
    e = e[record.observed]
    gauss, student, _ = record.likelihood(e)
    parameters = len(point.theta) + errors.free + 1 + bool(start.sinusoid)
    bic = record.count * min(gauss, student) + parameters * float(np.log(record.count))
    bic += ODDS * bool(start.sinusoid)  # a random walk looks like two periods of one
    channels = tuple(
        replace(one, A=A, B=B) for one, (A, B) in zip(start.channels, polynomials, strict=True)
    )
    return JointFit(
        channels, noise, start.slope, start.sinusoid, e, J[:, record.observed], parameters, bic,
        is_heavy(gauss, student),
    )  # fmt: skip


def tuned(record: JointRecord, fit: JointFit) -> JointFit:
    """The fit with the frequency of its sinusoid fitted in turn with all else, until it settles."""
    width = np.pi / record.longest / 4
    for _ in range(ROUNDS):
        start = fit.start

        def square(omega: float, start: JointStart = start) -> float:
            errors = _JointErrors(record, replace(start, sinusoid=float(omega)), None)
            theta = errors.joined([(one.A, one.B) for one in start.channels], start.noise)
            point = errors.at(theta)
            return np.inf if point is None else point.square

        near = start.sinusoid
        best = minimize_scalar(
            square, bounds=(max(near - width, 0.1 * near), near + width), method="bounded",
            options={"xatol": 1e-5 * width},
        )  # fmt: skip
        again = joint_fit(record, replace(start, sinusoid=float(best.x)))
        if again is None or again.bic >= fit.bic:
            break
        has_settled = again.bic > fit.bic - 0.1
        fit = again
        if has_settled:
            break
        width = max(4 * abs(fit.sinusoid - near), 0.01 * width)
    return fit


def student_weights(record: JointRecord, fit: JointFit) -> Array:
    """The square roots of the weights by which least squares have Student's likelihood."""
    scale = record.likelihood(fit.e)[2]
    weights = np.zeros(record.steps)
    weights[record.observed] = np.sqrt((DEGREES + 1) / (DEGREES + (fit.e / scale) ** 2))
    return weights


def reweighted(record: JointRecord, fit: JointFit, rounds: int = 4) -> JointFit:
    """The fit again by Student's likelihood: least squares with the weights of its errors."""
    for _ in range(rounds):
        weights = student_weights(record, fit)
        again = joint_fit(record, fit.start, weights=weights, iterations=8)
        if again is None:
            break
        has_settled = abs(again.bic - fit.bic) < 0.01
        fit = again
        if has_settled:
            break
    return fit


def joint_disturbance(record: JointRecord, channels: tuple[Channel, ...]) -> Array:
    """Y less what the channels make of u."""
    v = record.y.copy()
    for one in channels:
        A = confined(one.A, CIRCLE)
        v -= record.filtered(np.concatenate([[0.0], one.B]), A, one.driver(record))
    return v


def joint_residual(record: JointRecord, fit: JointFit) -> Array:
    """What plant, levels and slopes leave of y at the observed steps: noise, and a sinusoid."""
    errors = _JointErrors(record, fit.start, None)
    theta = errors.joined([(one.A, one.B) for one in fit.channels], fit.noise)
    point = errors.at(theta)
    v = joint_disturbance(record, fit.channels)
    if point is not None:
        waves = slice(1 + errors.has_slope, errors.fixed)
        v = np.concatenate([piece.remainder_with(waves) for piece in point.pieces])
    rest = [v[part][record.observed[part]] for part in record.parts]
    return np.concatenate([one - one.mean() for one in rest if len(one)])


def joint_covariance(record: JointRecord, fit: JointFit) -> Array:
    """The covariance of the coefficients of all channels in record units; infinite if unknown."""
    J = fit.jacobian
    size = np.sqrt(np.einsum("ij,ij->i", J, J))
    size[size == 0] = 1.0
    scaled = J / size[:, None]
    count = sum(one.order + len(one.B) for one in fit.channels)
    try:
        covariance = np.linalg.pinv(scaled @ scaled.T, rcond=1e-12, hermitian=True)
    except np.linalg.LinAlgError:
        return np.full((count, count), np.inf)
    variance = float(np.mean(fit.e**2))
    if fit.heavy:
        variance = record.likelihood(fit.e)[2] ** 2 * (DEGREES + 3) / (DEGREES + 1)
    return np.asarray((covariance / size / size[:, None])[:count, :count] * variance)
