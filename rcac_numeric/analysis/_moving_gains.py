"""Gains that move beside theta: at the input of the plant, and where a limit cuts u."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import fmpq, fmpq_mat

from compensator_theory.errors import InputError
from compensator_theory.stability._bounded_real_lemma import GainBound
from rcac_numeric.analysis._ellipsoids import responses_on_grid
from rcac_numeric.analysis._peaks import hinf_norm
from rcac_numeric.analysis._regressor_system import (
    Exact,
    RegressorSystem,
    array_of,
    exact,
    rational_matrix,
    rounded_matrix,
)
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._validation import number

SPAN = 12.0  # powers of two of the multipliers that the search may reach, on either side
DIGITS = 2.0**12  # a multiplier is rounded to this share of its power of two


@dataclass(frozen=True)
class InputGains:
    """Ranges in which the gains at the inputs may move from step to step.

    u_a(k) = s(k) u(k) with s in [share, 1] is what the limits pass, to the plant and to the memory
    of the controller; the plant receives g(k) u_a(k) with g in [low, high]. Each input has an s and
    a g of its own.
    """

    low: float = 1.0
    high: float = 1.0
    share: float = 1.0

    def moving(self) -> tuple[tuple[Fraction, Fraction] | None, ...]:
        """Return center and half width of s and of g; None where it does not move."""
        ends = ((Fraction(self.share), Fraction(1)), (Fraction(self.low), Fraction(self.high)))
        return tuple(
            None if low == high == 1 else ((low + high) / 2, (high - low) / 2) for low, high in ends
        )

    @property
    def is_fixed(self) -> bool:
        """Whether every gain is 1."""
        return not any(self.moving())

    def corners(self, inputs: int) -> list[tuple[str, list[float]]]:
        """Return constant gains, their words and deltas: in the middle, then at the ends."""
        limited, amplified = self.moving()
        shares, gains = [(0.0, "")], [(0.0, "")]
        if limited is not None:
            shares += [(-1.0, f"limits that pass {self.share:g} of u"), (1.0, "u without limits")]
        if amplified is not None:
            gains += [(-1.0, f"input gain {self.low:g}"), (1.0, f"input gain {self.high:g}")]
        corners = []
        for s, of_share in shares:
            for g, of_gain in gains:
                kinds = [d for d, kind in ((s, limited), (g, amplified)) if kind is not None]
                words = [word for word in (of_share, of_gain) if word]
                middle = "gains in the middle" if kinds else ""
                deltas = [d for d in kinds for _ in range(inputs)]
                corners.append((" and ".join(words) or middle, deltas))
        return corners


FIXED = InputGains()


def input_gains(input_gain: object, limit_share: object) -> InputGains:
    """Return the gains that two options of `certified_set` say."""
    ends = np.ravel(np.asarray(input_gain, dtype=object)).tolist()
    if len(ends) != 2:
        raise InputError(
            f"input_gain = {input_gain!r} must be (low, high), the ends between which the gain at "
            "the input of the plant moves."
        )
    low, high = (number(end, "input_gain") for end in ends)
    if not 0 <= low <= high:
        raise InputError(
            f"input_gain = ({low:g}, {high:g}) must have 0 <= low <= high. For a gain of the other "
            "sign give the plant with -B."
        )
    share = number(limit_share, "limit_share")
    if not 0 <= share <= 1:
        raise InputError(
            f"limit_share = {share:g} must lie between 0 and 1: it is the least u_applied / u, the "
            "limit of u over the largest abs(u) that the controller requests."
        )
    return InputGains(low, high, share)


@dataclass(frozen=True, eq=False)
class PerturbedLoop:
    """The loop of a center, exact: the moving gains are cut out as inputs and outputs.

    x(k+1) = A x + B v, (phi, q) = C x + D v: v is Delta phi of theta, then delta q for each gain
    with abs(delta) <= 1.
    """

    A: fmpq_mat
    B: fmpq_mat
    C: fmpq_mat
    D: fmpq_mat
    taps: int
    inputs: int

    @property
    def gains(self) -> int:
        """The number of scalar gains beside theta."""
        return int(self.C.nrows()) - self.taps

    def bound(self, K: Array, scale: Array, multipliers: Array, rate: float) -> GainBound:
        """Return the scaled small-gain condition, exact."""
        weights = fmpq_mat(K.shape[1] + self.gains, self.C.nrows())
        for i, row in enumerate(exact(K.T).tolist()):
            for j, entry in enumerate(row):
                weights[i, j] = entry
        R = fmpq_mat(self.B.ncols(), self.B.ncols())
        for i, entry in enumerate(exact(scale).tolist()):
            R[i, i] = 1 / entry**2
        for i, entry in enumerate(exact(multipliers).tolist()):
            weights[K.shape[1] + i, self.taps + i] = entry
            R[self.inputs + i, self.inputs + i] = entry**2
        D = weights * self.D if self.gains else None
        return GainBound(self.A, self.B, weights * self.C, R, fmpq(*rate.as_integer_ratio()), D)


def perturbed_loop(
    system: RegressorSystem, center: Array, gains: InputGains = FIXED
) -> PerturbedLoop:
    """Return the loop of `center` with every gain in the middle of where it moves."""
    taps, m = system.C.nrows(), system.B.ncols()
    if gains.is_fixed:
        return PerturbedLoop(system.loop(center), system.B, system.C, fmpq_mat(taps, m), taps, m)
    n, signals = system.A.nrows(), actuator_signals(system, center, gains)
    # the memory of the controller holds u_a without the fixed compensator
    memory = array_of(system.B - system.plant_inputs) @ (signals.applied - signals.parallel)
    whole = memory + array_of(system.plant_inputs) @ signals.received
    whole[:, :n] += array_of(system.A - system.plant_inputs * system.parallel)
    regressor = exact(np.zeros((taps, whole.shape[1])))
    regressor[:, :n] = array_of(system.C)
    outputs = np.concatenate([regressor, *signals.multiplied])
    A, B = rational_matrix(whole[:, :n]), rational_matrix(whole[:, n:])
    C, D = rational_matrix(outputs[:, :n]), rational_matrix(outputs[:, n:])
    return PerturbedLoop(A, B, C, D, taps, m)


@dataclass(frozen=True, eq=False)
class ActuatorSignals:
    """Rows over (x, v) of u, of u after its limits, and of the input of the plant.

    `multiplied` are the signals that the gains multiply, times the half width of each.
    """

    parallel: Exact
    u: Exact
    applied: Exact
    received: Exact
    multiplied: tuple[Exact, ...]


def actuator_signals(system: RegressorSystem, center: Array, gains: InputGains) -> ActuatorSignals:
    """Return the signals from the controller to the plant, exact."""
    n, taps, m = system.A.nrows(), system.C.nrows(), system.B.ncols()
    moving = [kind for kind in gains.moving() if kind is not None]

    def rows(x: fmpq_mat | None = None, block: int | None = None) -> Exact:
        signal = exact(np.zeros((m, n + (1 + len(moving)) * m)))
        if x is not None:
            signal[:, :n] = array_of(x)
        if block is not None:
            signal[:, n + block * m : n + (block + 1) * m] = exact(np.eye(m))
        return signal

    Theta = rational_matrix(exact(center.reshape(taps, m).T))
    parallel = rows(system.parallel)
    u = rows(Theta * system.C, 0) + parallel
    stages, multiplied = [u], []
    for kind in gains.moving():
        signal = stages[-1]
        if kind is not None:
            middle, half = (fmpq(part.numerator, part.denominator) for part in kind)
            multiplied.append(half * signal)
            signal = middle * signal + rows(block=len(multiplied))
        stages.append(signal)
    _, applied, received = stages
    return ActuatorSignals(parallel, u, applied, received, tuple(multiplied))


@dataclass(frozen=True, eq=False)
class RoundedLoop:
    """A perturbed loop in float64."""

    A: Array
    B: Array
    C: Array
    D: Array
    taps: int
    inputs: int

    @property
    def spectral_radius(self) -> float:
        """Largest modulus of a computed pole."""
        return float(np.abs(np.linalg.eigvals(self.A)).max(initial=0.0))

    @property
    def gains(self) -> int:
        """The number of scalar gains beside theta."""
        return len(self.C) - self.taps

    def peak(self, K: Array, scale: Array, rate: float, multipliers: Array | None = None) -> float:
        """Return the norm of the scaled loop on abs(z) = rate; infinite with a pole outside.

        Without gains it is sup abs(K' T R^-1/2).
        """
        if not self.spectral_radius < rate:
            return np.inf
        s = np.ones(self.gains) if multipliers is None else multipliers
        columns = np.concatenate([scale, 1 / s])
        C = np.concatenate([K.T @ self.C[: self.taps], s[:, None] * self.C[self.taps :]])
        D = np.concatenate([K.T @ self.D[: self.taps], s[:, None] * self.D[self.taps :]])
        return hinf_norm((self.A / rate, self.B * columns / rate, C, D * columns))[0]

    def radius(self, K: Array, scale: Array, rate: float, multipliers: Array) -> float:
        """Return the factor of K that the bound allows; 0 where a pole is outside."""
        if not self.spectral_radius < rate:
            return 0.0
        if not self.gains:
            return 1 / max(self.peak(K, scale, rate), 1e-300)
        return self.allowance(scale, rate).radius(K, multipliers)

    def responses(self, rate: float) -> ComplexArray:
        """Return C (zI - A)^-1 B + D on a grid of abs(z) = rate."""
        return responses_on_grid(self.A / rate, self.B / rate, self.C) + self.D

    def held(self, deltas: Sequence[float]) -> RoundedLoop:
        """Return the loop in which the gains beside theta stay where they are."""
        m, taps = self.inputs, self.taps
        inner = np.diag(np.asarray(deltas, dtype=np.float64))
        back = inner @ np.linalg.inv(np.eye(len(inner)) - self.D[taps:, m:] @ inner)
        A = self.A + self.B[:, m:] @ back @ self.C[taps:]
        B = self.B[:, :m] + self.B[:, m:] @ back @ self.D[taps:, :m]
        return RoundedLoop(A, B, self.C[:taps], np.zeros((taps, m)), taps, m)

    def allowance(self, scale: Array, rate: float) -> Allowance:
        """Return the bound on theta beside the moving gains."""
        return Allowance(self.responses(rate) * np.concatenate([scale, np.ones(self.gains)]),
                         self.taps, self.inputs)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Allowance:
    """The bound on theta beside moving gains: the scaled bound on a grid, as one on theta alone.

    Attributes
    ----------
    responses : array, shape (points, rows, columns)
        From v to (phi, q).
    taps, inputs : int
    """

    responses: ComplexArray
    taps: int
    inputs: int

    def effective(self, multipliers: Array) -> ComplexArray | None:
        """Return T with abs(K'T) < 1 if and only if K has the scaled bound, on the grid.

        T is the rows of the regressor times (I - N*N)^-1/2, N the scaled rows that the gains
        multiply. None where N*N is not below I.
        """
        whole = self.responses / np.concatenate([np.ones(self.inputs), multipliers])
        N = whole[:, self.taps :] * multipliers[:, None]
        values, vectors = np.linalg.eigh(np.eye(whole.shape[2]) - N.conj().transpose(0, 2, 1) @ N)
        if not values.min() > 0:
            return None
        roots = vectors * (values**-0.5)[:, None, :]
        return np.asarray(whole[:, : self.taps] @ roots, dtype=np.complex128)

    def radius(self, K: Array, multipliers: Array) -> float:
        """Return the factor of K that the bound allows, on the grid; 0 where there is none."""
        T = self.effective(multipliers)
        if T is None:
            return 0.0
        scaled = K.T @ T
        squares = np.linalg.eigvalsh(scaled.conj().transpose(0, 2, 1) @ scaled)[:, -1]
        return float(max(squares.max(), 1e-300) ** -0.5)

    def best_multipliers(self, K: Array) -> Array | None:
        """Return the multipliers that allow the largest factor of K; None where none allow any.

        At each radius the condition is convex in their logarithms (Sezginer and Overton, 1990), so
        that the radius has no second maximum.
        """
        count = self.responses.shape[1] - self.taps
        if not count:
            return np.zeros(0)
        sizes = np.linalg.norm(self.responses[:, self.taps :, : self.inputs], axis=2)
        start = -np.log2(np.maximum(sizes.max(axis=0), 1e-100))

        def lost(logarithms: Array) -> float:
            if np.abs(logarithms - start).max() > SPAN:
                return np.inf
            return -self.radius(K, np.exp2(logarithms))

        grid = np.arange(-SPAN + 1, SPAN, 1.0)
        first = min((start + shift for shift in grid), key=lost)
        if not lost(first) < 0:
            return None
        simplex = np.vstack([first, first + 0.5 * np.eye(count)])
        options = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-4, "maxfev": 60 * count}
        from scipy.optimize import minimize  # slow to import, for several gains alone

        logarithms = minimize(lost, first, method="Nelder-Mead", options=options).x
        powers = np.exp2(np.floor(logarithms))
        return np.asarray(np.round(np.exp2(logarithms) / powers * DIGITS) / DIGITS * powers)


def centered_loop(system: RegressorSystem, center: Array, gains: InputGains = FIXED) -> RoundedLoop:
    """Return the perturbed loop of `center` in float64, each entry rounded once."""
    loop = perturbed_loop(system, center, gains)
    A, B, C, D = (rounded_matrix(part) for part in (loop.A, loop.B, loop.C, loop.D))
    return RoundedLoop(A, B, C, D, loop.taps, loop.inputs)
