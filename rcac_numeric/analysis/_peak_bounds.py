"""Bounds of z and u for bounded w while theta moves in a certified set, proved exactly."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from flint import arb, arb_mat, fmpq, fmpq_mat
from numpy.typing import ArrayLike
from scipy.linalg import solve_discrete_lyapunov
from scipy.optimize import minimize

from compensator_theory._few_lines import in_few_lines
from compensator_theory.errors import InputError, NoSolutionError
from compensator_theory.matrices._definiteness import pivots_are_positive
from compensator_theory.polynomials._ball_precision import ball_precision
from compensator_theory.stability._bounded_real_lemma import BITS, GainBound
from rcac_numeric.analysis._certified_set import (
    CertifiedSet,
    Storage,
    fractions_of,
    matrix_of,
)
from rcac_numeric.analysis._ellipsoids import responses_on_grid
from rcac_numeric.analysis._moving_gains import (
    InputGains,
    actuator_signals,
    perturbed_loop,
)
from rcac_numeric.analysis._regressor_system import (
    Exact,
    array_of,
    exact,
    rational_matrix,
    regressor_system,
    rounded_matrix,
)
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._showing import report_of, summary_of
from rcac_numeric.arrays._validation import instance_of, number, real_array
from rcac_numeric.arrays._values import Result
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._structure import Structure, Tap
from rcac_numeric.plants._linear import Plant

SHARES_OF_RATE = np.array([0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7])
"""Of the way from 1 to the spectral radius: rates that the search begins with."""

SUPPLIES = np.exp2(np.arange(-2.0, 13.0, 1.5))  # of w, in multiples of its squared gain
LARGER = (1.001, 1.01, 1.1, 1.5)  # supplies that are tried until one is proved
SLOWER = 6  # rates, each nearer to 1, that are tried then
DIGITS = 2.0**10  # to which rate and supply are rounded
LEAST = 1e-6  # of the supply of w at which it moves the states as much as v does
MOST_POWERS = 400.0  # of two, of a supply
MOST_STEPS = 200_000  # of an impulse response
DOUBLINGS = 40
EVALUATIONS = 40  # of the search, after the grid


@dataclass(frozen=True, eq=False)
class DrivenLoop:
    """The loop of a center with w; exact rows.

    x(k+1) = A x + B v + E w, (phi, q) = C x + D v + F w, (z, u) = Z_x x + Z_v v + Z_w w; v as in
    `PerturbedLoop`.
    """

    A: Exact
    B: Exact
    E: Exact
    C: Exact
    D: Exact
    F: Exact
    Z_x: Exact
    Z_v: Exact
    Z_w: Exact
    taps: int
    inputs: int


def driven_loop(
    plant: Plant, structure: Structure, fixed: Compensator | None, center: Array, gains: InputGains
) -> DrivenLoop:
    """Return the loop with its exogenous inputs.

    w is a state of a larger plant that has the command as further outputs: what reads that state
    is what w drives.
    """
    l_w, first = plant.l_w, plant.n
    l_r = structure.l_r
    commands = np.zeros((l_r, l_w))
    if l_r:
        names = list(plant.blocks)
        if plant.blocks.get("r") != l_r:
            raise InputError(
                f"the controller reads {l_r} commands, and the blocks of w are "
                f"{dict(plant.blocks)}: name a block 'r' of that width."
            )
        start = sum(plant.blocks[name] for name in names[: names.index("r")])
        commands[:, start : start + l_r] = np.eye(l_r)
    n = first + l_w
    A = np.zeros((n, n))
    A[:first] = np.concatenate([plant.A, plant.D_1], axis=1)
    C = np.concatenate([
        np.concatenate([plant.C, plant.D_2], axis=1),
        np.concatenate([np.zeros((l_r, first)), commands], axis=1),
    ])  # fmt: skip
    B = np.concatenate([plant.B, np.zeros((l_w, plant.l_u))])
    larger = Plant(A=A, B=B, D_1=np.zeros((n, 1)), C=C)
    taps = tuple(
        Tap("y", structure.l_y + tap.component, tap.delay) if tap.signal == "r" else tap
        for tap in structure.taps
    )
    reading = Structure(
        taps, l_u=structure.l_u, l_y=structure.l_y + l_r, n_c=structure.n_c,
        derived=structure.derived,
    )  # fmt: skip
    if fixed is not None and fixed.past_y.shape[2] < structure.l_y + l_r:
        missing = structure.l_y + l_r - fixed.past_y.shape[2]
        fixed = Compensator(fixed.past_u, np.pad(fixed.past_y, ((0, 0), (0, 0), (0, missing))))
    system = regressor_system(larger, reading, fixed)
    loop = perturbed_loop(system, center, gains)
    states = system.A.nrows()
    signals = actuator_signals(system, center, gains)
    of_w = np.arange(first, first + l_w)
    rest = np.setdiff1d(np.arange(states), of_w)
    A, B, C, D = (array_of(part) for part in (loop.A, loop.B, loop.C, loop.D))
    E_2 = exact(plant.E_2)
    z = np.concatenate([E_2 @ signals.received, signals.u])
    z[: plant.l_z, :first] += exact(plant.E_1)
    z[: plant.l_z, of_w] += exact(plant.E_0)
    return DrivenLoop(
        A[np.ix_(rest, rest)], B[rest], A[np.ix_(rest, of_w)], C[:, rest], D, C[:, of_w],
        z[:, rest], z[:, states:], z[:, of_w], loop.taps, loop.inputs,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class ChannelBound(Result):
    """The largest ratio of one signal to one channel of w, with the matrix that proves it.

    Attributes
    ----------
    member : str
        The plant.
    output, channel : int
        Row of (z, u), and entry of w.
    gain : float
        abs(signal(k)) <= gain max abs(w_channel), from rest.
    rate, supply : float
        x(k+1)'P x(k+1) <= rate^2 x'Px + supply w_channel^2 for every motion in the set.
    P : tuple of tuples of Fraction, n x n
    """

    member: str
    output: int
    channel: int
    gain: float
    rate: float
    supply: float
    P: Storage = field(repr=False)


@dataclass(frozen=True, eq=False)
class PeakBounds(Result):
    """Bounds of z and u while theta moves in a share of a certified set, for bounded w.

    abs(z_i(k)) <= z_i and abs(u_i(k)) <= u_i at every step, from rest, on every member, for every
    motion of theta within `share` of the radius and of the gains that the set lets move.

    Attributes
    ----------
    region : CertifiedSet
    share : float
        Of the radius.
    w_peak : array, shape (l_w,)
        abs(w_i(k)) <= w_peak_i.
    z : array, shape (l_z,)
    u : array, shape (l_u,)
        Of the u that the controller requests.
    held : array, shape (l_z,)
        The largest abs(z) with theta = theta_0 and the gains in the middle, in float64: no bound
        can be below it.
    proofs : tuple of ChannelBound
        One for each member, signal and channel of w with a peak above 0.

    Notes
    -----
    Theta may be hostile in such a motion, so that z is far above what a run shows. The loop is
    linear in w for each motion of theta, so that the bounds of the channels add up.
    """

    _REST: ClassVar[str] = "report() has all of it"

    region: CertifiedSet
    share: float
    w_peak: Array
    z: Array
    u: Array
    held: Array
    proofs: tuple[ChannelBound, ...] = field(repr=False)

    @property
    def is_verified(self) -> bool:
        """Whether every P proves its gain, and the gains add up to z and u; exact."""
        loops = _exact_loops(self.region)
        outputs = len(self.z) + len(self.u)
        channels = np.flatnonzero(self.w_peak)
        required = {(name, i, int(j)) for name in loops for i in range(outputs) for j in channels}
        gains = {(p.member, p.output, p.channel): p for p in self.proofs}
        if set(gains) != required or not 0 < self.share <= 1:
            return False
        for (name, _, _), proof in gains.items():
            one = _Channel(loops[name], self.region, name, self.share, proof.channel)
            value = one.proved_gain(proof.output, proof.rate, proof.supply, matrix_of(proof.P))
            if value is None or not value <= proof.gain:
                return False
        return bool(
            (np.concatenate([self.z, self.u]) >= _sums(self.proofs, self.w_peak, outputs)).all()
        )

    def _sheet(self) -> Any:
        from rcac_numeric.reports._certified import peak_sheet

        return peak_sheet(self)

    def report(self) -> str:
        """Return the report: what is bounded, the bounds, and what each channel adds to them."""
        return report_of(self._sheet())

    @in_few_lines
    def __str__(self) -> str:
        return summary_of(self._sheet())

    def __repr__(self) -> str:
        return f"PeakBounds(share={self.share:g}, z={self.z.tolist()}, u={self.u.tolist()})"


def peak_bounds(region: CertifiedSet, w_peak: ArrayLike, *, share: float = 1.0) -> PeakBounds:
    """Bound z and u for bounded w while theta moves in a certified set in any way, proved exactly.

    P > 0 with x(k+1)'P x(k+1) <= a^2 x'Px + m w^2 for every motion keeps x'Px below
    m w_peak^2/(1 - a^2), an ellipsoid on which z has a largest value.

    Parameters
    ----------
    region : CertifiedSet
    w_peak : float or array, shape (l_w,)
        The largest abs(w) of each channel; 0 leaves a channel out.
    share : float
        Theta stays within this share of the radius: `region.radius_of(run.theta).max()` of a run,
        or bounds with the factor scaled by it. Near 1 the bounds are large.

    Returns
    -------
    PeakBounds

    Raises
    ------
    InputError
        Where w_peak has the wrong size or a negative entry, share is not in (0, 1], or the members
        have different numbers of signals.
    NoSolutionError
        Where no proof was found: theta_0 is at the edge of stability, or share is too near 1.

    Notes
    -----
    P is nearly the inverse of the largest solution of the dual Riccati equation of the bounded real
    lemma with w as a further input, so that no semidefinite program is solved; rate a and supply m
    are searched in float64 for each signal and channel. Source: J. Abedor, K. Nagpal, K. Poolla,
    Int. J. Robust Nonlinear Control 6 (1996) 899-927, the star norm.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, TargetModel, certified_set, iir, peak_bounds, standard_plant)
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = ControllerSettings(structure=iir(n_c=1), target=TargetModel([0, 1]),
    ...     update=UD(R_theta=100.0), theta_0=[0.2, -0.3])
    >>> bounds = peak_bounds(certified_set(plant, settings), 0.5, share=0.2)
    >>> bounds.is_verified, bool((bounds.held <= bounds.z).all())
    (True, True)
    """
    instance_of(region, "region", CertifiedSet)
    share = number(share, "share")
    if not 0 < share <= 1:
        raise InputError(f"share = {share:g} of the radius must be positive and at most 1.")
    plants = [member.plant for member in region.members]
    if len({(plant.l_w, plant.l_z) for plant in plants}) > 1:
        raise InputError("the members of the set have different numbers of channels of w or z.")
    l_w, l_z = plants[0].l_w, plants[0].l_z
    peaks = real_array(w_peak, "w_peak")
    if peaks.ndim == 0:
        peaks = np.full(l_w, float(peaks))
    if peaks.shape != (l_w,) or (peaks < 0).any():
        raise InputError(
            f"w_peak = {np.asarray(w_peak).tolist()} must be one number that is not negative, or "
            f"one for each of the {l_w} channels of w ({', '.join(plants[0].channels)})."
        )
    outputs = l_z + region.structure.l_u
    loops = _exact_loops(region)
    proofs = []
    for channel in np.flatnonzero(peaks).tolist():
        starts: list[Array | None] = [None] * outputs
        for name, loop in loops.items():
            one = _Channel(loop, region, name, share, channel)
            for output in range(outputs):
                proof, starts[output] = one.smallest(output, starts[output])
                proofs.append(proof)
    bounds = _sums(tuple(proofs), peaks, outputs)
    held = np.max([_held_peak(loop, peaks)[:l_z] for loop in loops.values()], axis=0)
    return PeakBounds(region, share, peaks, bounds[:l_z], bounds[l_z:], held, tuple(proofs))


def _exact_loops(region: CertifiedSet) -> dict[str, DrivenLoop]:
    gains = InputGains(*region.input_gain, region.limit_share)
    return {
        member.name: driven_loop(member.plant, region.structure, region.fixed, region.center, gains)
        for member in region.members
    }


def _sums(proofs: tuple[ChannelBound, ...], peaks: Array, outputs: int) -> Array:
    """Return the largest sum over the channels of each signal over the members, rounded up."""
    members = {proof.member for proof in proofs}
    sums = {name: [fmpq(0)] * outputs for name in members}
    for proof in proofs:
        peak = fmpq(*float(peaks[proof.channel]).as_integer_ratio())
        sums[proof.member][proof.output] += fmpq(*proof.gain.as_integer_ratio()) * peak
    bounds = np.zeros(outputs)
    for values in sums.values():
        rounded = [np.nextafter(int(v.p) / int(v.q), np.inf) if v else 0.0 for v in values]
        bounds = np.maximum(bounds, rounded)
    return bounds


def _held_peak(loop: DrivenLoop, peaks: Array) -> Array:
    """Return the largest abs(z, u) with theta = theta_0: sums of impulse responses."""
    A, E, Z, direct = (
        rounded_matrix(rational_matrix(part)) for part in (loop.A, loop.E, loop.Z_x, loop.Z_w)
    )
    sums, x = np.abs(direct), E
    for step in range(MOST_STEPS):
        added = np.abs(Z @ x)
        sums += added
        x = A @ x
        if step > len(A) and np.abs(x).max(initial=0.0) <= 1e-14 * np.abs(E).max(initial=1.0):
            break
    return np.asarray(sums @ peaks)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows of signals over (x, v, w of one channel), in float64 or in balls."""

    theta_x: Array  # share K' phi
    theta_w: Array
    gains_x: Array
    gains_v: Array
    gains_w: Array
    signals_x: Array
    signals_v: Array
    signals_w: Array
    scale: Array

    def largest(self, output: int, ellipsoid: _Ellipsoid) -> Any:
        """Return the largest abs of one signal over x in the ellipsoid, v in its blocks, w = 1."""
        bound = ellipsoid.extent(self.signals_x[output]) + abs(self.signals_w[output])
        if not any(self.signals_v[output]):
            return bound
        theta = ellipsoid.norm(self.theta_x) + ellipsoid.root((self.theta_w**2).sum())
        v = [entry * theta for entry in self.scale]
        for x, direct, w in zip(self.gains_x, self.gains_v, self.gains_w, strict=True):
            within = zip(direct[: len(v)], v, strict=True)
            v.append(ellipsoid.extent(x) + abs(w) + sum(abs(d) * size for d, size in within))
        return bound + sum(
            abs(entry) * size for entry, size in zip(self.signals_v[output], v, strict=True)
        )


@dataclass(frozen=True, eq=False)
class _Ellipsoid:
    """The states x with x'Q^-1 x <= level, in float64."""

    Q: Array
    level: float

    root: ClassVar[Any] = staticmethod(np.sqrt)

    def extent(self, row: Array) -> Any:
        """Return the largest abs(row x)."""
        return np.sqrt(max(float(row @ self.Q @ row), 0.0) * self.level)

    def norm(self, rows: Array) -> Any:
        """Return the largest abs(rows x)."""
        values = np.linalg.eigvalsh(rows @ self.Q @ rows.T)
        return np.sqrt(max(float(values[-1]), 0.0) * self.level)


class _BallEllipsoid(_Ellipsoid):
    """The same in balls: Q and level are balls of python-flint."""

    root: ClassVar[Any] = staticmethod(arb.sqrt)

    def extent(self, row: Array) -> Any:
        return arb.sqrt(row @ self.Q @ row * self.level)

    def norm(self, rows: Array) -> Any:
        products = rows @ self.Q @ rows.T
        trace = sum(np.diag(products), arb(0))
        rounded = np.array([[float(e.mid()) for e in row] for row in products])
        largest = arb(float(np.linalg.eigvalsh(rounded)[-1]) * (1 + 1e-9))
        rest = [
            [largest * int(i == j) - e for j, e in enumerate(r)] for i, r in enumerate(products)
        ]
        return arb.sqrt((largest if pivots_are_positive(rest) else trace) * self.level)


class _Channel:
    """One channel of w of one member: the search in float64, and the exact check."""

    def __init__(
        self, loop: DrivenLoop, region: CertifiedSet, name: str, share: float, channel: int
    ) -> None:
        self.loop, self.name, self.channel = loop, name, channel
        taps, of_w = loop.taps, [channel]
        K = exact(region.regressor_factor.T) * fmpq(*share.as_integer_ratio())
        (s,) = (exact(m.multipliers) for m in region.members if m.name == name)
        scale = exact(region.input_scale)
        C, D, F = (
            np.concatenate([K @ part[:taps], s[:, None] * part[taps:]])
            for part in (loop.C, loop.D, loop.F[:, of_w])
        )
        inputs = np.concatenate([loop.B, loop.E[:, of_w]], axis=1)
        self.system = (loop.A, inputs, C, np.concatenate([D, F], axis=1))
        self.weights = np.concatenate([1 / scale**2, s**2])  # the diagonal of R
        m = loop.inputs + len(s)
        self.rows = (
            K @ loop.C[:taps], K @ loop.F[:taps, channel], loop.C[taps:], loop.D[taps:, :m],
            loop.F[taps:, channel], loop.Z_x, loop.Z_v, loop.Z_w[:, channel], scale,
        )  # fmt: skip
        A, B, C, D = (_rounded(part) for part in self.system)
        W_v, W_w = (
            np.diag(solve_discrete_lyapunov(A, part @ part.T)) if len(A) else np.zeros(0)
            for part in (B[:, :-1], B[:, -1:])
        )
        W = W_v + W_w
        sizes = np.sqrt(np.maximum(W, 1e-30 * max(W.sum(), 1e-300)))
        # a supply below this makes what w moves no smaller: v moves far less
        ratio = (W_w / sizes**2).sum() / max((W_v / sizes**2).sum(), 1e-300)
        self.least = np.log2(LEAST * ratio) if ratio else 0.0
        self.radius = float(np.abs(np.linalg.eigvals(A)).max(initial=0.0))
        self.scaled = (A * sizes / sizes[:, None], B / sizes[:, None], C * sizes, D)
        self.R = _rounded(self.weights)
        rounded = [_rounded(part) for part in self.rows]
        for i in (0, 2, 5):
            rounded[i] = rounded[i] * sizes
        self.rounded = _Rows(*rounded)

    def bound(self, rate: float, supply: float) -> GainBound:
        """Return the bound that x'Px rises by at most supply w^2 beside the decay, exact."""
        a = fmpq(*rate.as_integer_ratio())
        A, B, C, D = (rational_matrix(part) for part in self.system)
        R = fmpq_mat(B.ncols(), B.ncols())
        diagonal = [*self.weights, fmpq(*supply.as_integer_ratio())]
        for i, entry in enumerate(diagonal):
            R[i, i] = entry / a**2
        return GainBound(A, B, C / a, R, a, D / a)

    def proved_gain(self, output: int, rate: float, supply: float, P: fmpq_mat) -> float | None:
        """Return the bound that P proves, rounded up; None where it proves none."""
        if not (0 < rate < 1 and 0 < supply < np.inf):
            return None
        if not self.bound(rate, supply).is_proved_by(P):
            return None
        with ball_precision(BITS):
            try:
                inverse = arb_mat(P).inv()
            except ZeroDivisionError:
                return None
            n = P.nrows()
            Q = np.array([inverse[i, j] for i in range(n) for j in range(n)], dtype=object)
            a, level = arb(fmpq(*rate.as_integer_ratio())), arb(supply)
            ellipsoid = _BallEllipsoid(Q.reshape(n, n), level / (1 - a * a))
            rows = _Rows(*(_balls(part) for part in self.rows))
            upper = rows.largest(output, ellipsoid).upper()
            return float(np.nextafter(float(upper), np.inf)) if upper.is_finite() else None

    def smallest(self, output: int, start: Array | None) -> tuple[ChannelBound, Array]:
        """Return the smallest proved gain, and its point of the search."""
        point = self._searched(output, start)
        for _ in range(SLOWER):
            rate, supply = self._parameters(point)
            for factor in LARGER:
                mantissa, power = np.frexp(supply * factor)
                larger = float(np.ldexp(np.ceil(mantissa * DIGITS) / DIGITS, power))
                P = self.bound(rate, larger).largest_certificate()
                gain = None if P is None else self.proved_gain(output, rate, larger, P)
                if P is not None and gain is not None:
                    proof = (rate, larger, fractions_of(P))
                    return ChannelBound(self.name, output, self.channel, gain, *proof), point
            point = point - np.array([1.0, -1.0])  # float64 was too hopeful
        raise self._unproved()

    def _unproved(self) -> NoSolutionError:
        return NoSolutionError(
            f"no bound was proved for channel {self.channel + 1} of w on {self.name}: theta_0 is "
            "at the edge of stability, or share is too near 1. Use a smaller share."
        )

    def _parameters(self, point: Array) -> tuple[float, float]:
        """Return rate and supply of a point of the search, the rate of few digits."""
        gap = (1 - self.radius) / (1 + np.exp(-point[0]))  # 1 - rate
        digits = np.exp2(np.ceil(np.log2(DIGITS / gap)))
        return float(1 - np.ceil(gap * digits) / digits), float(np.exp2(point[1]))

    def _searched(self, output: int, start: Array | None) -> Array:
        """Return the point of the smallest gain in float64."""

        def gain(point: Array) -> float:
            if not self.least <= point[1] <= MOST_POWERS:
                return np.inf
            rate, supply = self._parameters(point)
            if not self.radius < rate < 1:
                return np.inf
            Q = self._reached(rate, supply)
            if Q is None:
                return np.inf
            return float(self.rounded.largest(output, _Ellipsoid(Q, supply / (1 - rate**2))))

        candidates = [] if start is None else [start]
        if start is None or not np.isfinite(gain(start)):
            A, B, C, D = self.scaled
            for share in SHARES_OF_RATE:
                logit = np.log(share / (1 - share))
                rate = self._parameters(np.array([logit, 0.0]))[0]
                whole = responses_on_grid(A / rate, B[:, -1:] / rate, C) + D[:, -1:]
                peak = np.linalg.norm(whole, axis=(1, 2)).max(initial=0.0) / rate
                size = max(2 * np.log2(max(peak, 1e-150)), self.least)
                candidates += [np.array([logit, size + power]) for power in SUPPLIES]
        first = min(candidates, key=gain)
        if not np.isfinite(gain(first)):
            raise self._unproved()
        simplex = first + np.array([[0.0, 0.0], [0.4, 0.0], [0.0, 0.7]])
        options = {"initial_simplex": simplex, "xatol": 1e-2, "fatol": 1e-4 * gain(first),
                   "maxfev": EVALUATIONS}  # fmt: skip
        return np.asarray(minimize(gain, first, method="Nelder-Mead", options=options).x)

    def _reached(self, rate: float, supply: float) -> Array | None:
        """Return Q, the inverse of the largest P, in scaled states; None where there is none."""
        A, B, C, D = self.scaled
        R = np.diag(np.append(self.R, supply)) - D.T @ D
        try:
            np.linalg.cholesky(R)
            inverse = np.linalg.inv(R)
            cross = D.T @ C
            H = (C.T @ C + cross.T @ inverse @ cross) / rate**2
            G = -B @ inverse @ B.T
            A = (A + B @ inverse @ cross) / rate
            for _ in range(DOUBLINGS):
                within = np.linalg.inv(np.eye(len(A)) + G @ H)
                forward = within @ A
                reached, added = A @ within @ G @ A.T, A.T @ H @ forward
                G, H, A = G + (reached + reached.T) / 2, H + (added + added.T) / 2, A @ forward
                if not (np.diag(G).max() <= 0 and np.diag(H).min() >= -1e-12 * np.trace(H)):
                    return None
                if (np.abs(np.diag(reached)) <= 1e-10 * np.abs(np.diag(G))).all():
                    return np.asarray(-G)
        except np.linalg.LinAlgError:
            return None
        return None


def _rounded(part: Exact) -> Array:
    values = [int(e.p) / int(e.q) if e else 0.0 for e in part.ravel().tolist()]
    return np.array(values, dtype=np.float64).reshape(part.shape)


def _balls(part: Exact) -> Array:
    balls = np.empty(part.size, dtype=object)
    balls[:] = [arb(e) for e in part.ravel().tolist()]
    return balls.reshape(part.shape)
